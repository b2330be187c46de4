// The connected parts of a pose graph and what holds each of them in place.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

#include "scslam/graph/pose_graph.h"

namespace scslam {

struct GraphParts {
  std::vector<std::uint32_t> part_of;             ///< by node; parts are numbered by their first node
  std::vector<std::vector<std::uint32_t>> nodes;  ///< by part, increasing
  std::vector<std::uint32_t> anchor;  ///< by part: a fixed node, else the node of a full-rank prior, else the first
  std::vector<std::uint8_t> held;     ///< by node: not a variable of the optimisation
};

/// Each part has its own gauge: its fixed nodes; without any its priors, if one of them determines a pose by itself;
/// without that its first node.
GraphParts graphParts(const PoseGraph& graph);

/// Empty when the graph is connected; else one line that says how many parts there are and what floats, by vertex id.
std::string describeParts(const PoseGraph& graph, const GraphParts& parts);

}  // namespace scslam
