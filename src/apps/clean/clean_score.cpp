#include "scslam/apps/clean/clean_score.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "scslam/core/error.h"
#include "scslam/core/file.h"

namespace scslam {
namespace fs = std::filesystem;
namespace {

constexpr float kVoxel_m = 0.2F;  // ERASOR's

TrueLabels::Kind kindOf(std::uint32_t label, LabelStyle style) {
  const std::uint32_t semantic = label & 0xFFFF, upper = label >> 16;
  if (style == LabelStyle::kPandaSet) return upper == 1 ? TrueLabels::kDynamic : TrueLabels::kStatic;
  if (semantic <= 1) return TrueLabels::kUnlabelled;
  return semantic >= 252 && semantic <= 259 ? TrueLabels::kDynamic : TrueLabels::kStatic;
}

}  // namespace

double CleanScore::aa() const { return std::sqrt(sa() * da()); }

TrueLabels::TrueLabels(const fs::path& folder, LabelStyle style) : style_(style) {
  if (!fs::is_directory(folder)) throw inputError("{} is no folder of label files", folder.string());
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".label") files_.push_back(entry.path());
  if (files_.empty()) throw inputError("{} holds no .label file", folder.string());
  std::sort(files_.begin(), files_.end());
}

std::vector<std::uint8_t> TrueLabels::of(std::size_t scan_index, std::size_t points) const {
  if (scan_index >= files_.size())
    throw inputError("scan {} has no labels: {} holds {} files", scan_index, files_.front().parent_path().string(),
                     files_.size());
  const std::string bytes = readFile(files_[scan_index]);
  if (bytes.size() != 4 * points)
    throw inputError(
        "{} holds {} labels but the session has {} points of that scan; make the session without dropping any "
        "(--set preprocess.min_range_m=0 --set preprocess.max_range_m=1000)",
        files_[scan_index].string(), bytes.size() / 4, points);
  std::vector<std::uint8_t> kinds(points);
  for (std::size_t i = 0; i < points; ++i) {
    std::uint32_t label = 0;
    std::memcpy(&label, &bytes[4 * i], 4);
    kinds[i] = kindOf(label, style_);
  }
  return kinds;
}

void CleanScorer::add(const Cloud& cloud_map, const std::vector<std::uint8_t>& labels,
                      const std::vector<std::uint8_t>& dynamic) {
  for (std::size_t i = 0; i < cloud_map.size(); ++i) {
    const Eigen::Vector3f p = cloud_map.point(i);
    if (labels[i] == TrueLabels::kUnlabelled || !p.allFinite()) continue;
    const Eigen::Vector3f cell = p / kVoxel_m;
    const std::uint32_t at =
        index_.findOrInsert(packVoxel(floorToInt(cell.x()), floorToInt(cell.y()), floorToInt(cell.z())));
    if (at == voxels_.size()) voxels_.emplace_back();
    Voxel& voxel = voxels_[at];
    const bool kept = dynamic[i] == 0;
    if (labels[i] == TrueLabels::kStatic) {
      ++points_.static_points, ++voxel.static_points;
      points_.static_kept += kept, voxel.static_kept |= kept;
    } else {
      ++points_.dynamic_points, ++voxel.dynamic_points;
      points_.dynamic_removed += !kept, voxel.dynamic_kept |= kept;
    }
  }
}

CleanScore CleanScorer::score() const {
  CleanScore score = points_;
  for (const Voxel& voxel : voxels_)
    if (voxel.static_points >= voxel.dynamic_points)
      ++score.static_voxels, score.static_voxels_kept += voxel.static_kept;
    else
      ++score.dynamic_voxels, score.dynamic_voxels_removed += !voxel.dynamic_kept;
  return score;
}

}  // namespace scslam
