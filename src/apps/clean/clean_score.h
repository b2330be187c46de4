// Cleaning against true labels.
#pragma once
#include <filesystem>
#include <vector>

#include "scslam/apps/clean/clean.h"
#include "scslam/core/voxel_index.h"

namespace scslam {

/// True labels of scans: files in a folder, sorted by name, one for each scan of the input.
class TrueLabels {
 public:
  enum Kind : std::uint8_t { kUnlabelled, kStatic, kDynamic };

  /// @throw inputError when there is no label file in the folder.
  TrueLabels(const std::filesystem::path& folder, LabelStyle style);
  /// One per point of the scan. @throw inputError when there is no such file or it holds another number of labels.
  std::vector<std::uint8_t> of(std::size_t scan_index, std::size_t points) const;

 private:
  std::vector<std::filesystem::path> files_;
  LabelStyle style_;
};

/// Adds up the score; memory grows with the map (16 bytes a voxel).
class CleanScorer {
 public:
  void add(const Cloud& cloud_map, const std::vector<std::uint8_t>& labels, const std::vector<std::uint8_t>& dynamic);
  CleanScore score() const;

 private:
  struct Voxel {
    std::uint32_t static_points = 0, dynamic_points = 0;
    bool static_kept = false, dynamic_kept = false;
  };
  CleanScore points_;
  VoxelIndex index_;
  std::vector<Voxel> voxels_;
};

}  // namespace scslam
