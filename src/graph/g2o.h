// g2o text files, 3-D and 2-D.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "scslam/graph/pose_graph.h"

namespace scslam {

/// VERTEX_SE3:QUAT, EDGE_SE3:QUAT (with or without the 21 information numbers), VERTEX_SE2, EDGE_SE2, FIX; edges-only
/// files get identity vertices and `poses_known = false`. Unknown tags are reported once each in `warnings`.
/// Information matrices that are not positive semidefinite (public graphs have them) are replaced by the nearest that
/// are, with one warning. @throw inputError file:line for malformed lines, unknown vertices, NaN, information that is
/// negative on its diagonal.
struct G2oFile {
  PoseGraph graph;
  bool poses_known = true;
  std::vector<std::string> warnings;
};
G2oFile readG2o(const std::filesystem::path& file);

/// Vertices then edges, 17 significant digits, with the information block; SE2 tags when graph.planar and `as_se2`.
std::string formatG2o(const PoseGraph& graph, bool as_se2 = false);

}  // namespace scslam
