#include "scslam/apps/clean/scan_judge.h"

#include <cmath>
#include <set>
#include <utility>

namespace scslam {
namespace {

enum class Say : std::uint8_t { kNothing, kStood, kMoved, kSurelyMoved };

/// Points that stood and that moved, of a cell, a group or an object.
struct Tally {
  std::size_t stood = 0, moved = 0;
  void add(Say say) { stood += say == Say::kStood, moved += say >= Say::kMoved; }
  void add(const Tally& other) { stood += other.stood, moved += other.moved; }
  double share() const { return moved == 0 ? 0 : static_cast<double>(moved) / static_cast<double>(moved + stood); }
};

/// A point moved when most scans around it in time looked through it, whatever came there later; or most of all scans.
std::vector<Say> whatViewsSay(const SightVotes& soon, const SightVotes& later, const CleanParams& params) {
  std::vector<Say> says(soon.free.size(), Say::kNothing);
  const auto moved = [&params](int free, int surface) {
    return free >= params.min_free && free > params.free_share * (free + surface);
  };
  for (std::size_t i = 0; i < says.size(); ++i) {
    const int free = soon.free[i] + later.free[i], surface = soon.surface[i] + later.surface[i];
    says[i] = surface == 0 && free >= params.sure_free                       ? Say::kSurelyMoved
              : moved(soon.free[i], soon.surface[i]) || moved(free, surface) ? Say::kMoved
              : surface > 0                                                  ? Say::kStood
                                                                             : Say::kNothing;
  }
  return says;
}

class Judge {
 public:
  Judge(const Cloud& cloud, const std::vector<float>& height, std::vector<Say> says, const CleanParams& params)
      : cloud_(cloud),
        height_(height),
        params_(params),
        says_(std::move(says)),
        upright_(cloud.size()),
        result_{std::vector<std::uint8_t>(cloud.size()), 0, 0, 0} {
    for (std::size_t i = 0; i < cloud.size(); ++i) upright_[i] = height[i] >= params.object_height_m ? 1 : 0;
  }

  ScanVerdict operator()(const Pose& T_level_sensor) {
    const ScanCells cells(cloud_, upright_, params_.gap_m);
    std::vector<Tally> tallies(cells.size());
    for (std::size_t i = 0; i < cloud_.size(); ++i)
      if (upright_[i] != 0) tallies[cells.cellOf(i)].add(says_[i]);
    wholeObjects(cells, tallies);
    partsOfObjects(cells, tallies);
    for (std::size_t i = 0; i < cloud_.size(); ++i)
      if (upright_[i] != 0) decide(i, cells.cellOf(i));
    belowObjects(T_level_sensor);
    return std::move(result_);
  }

 private:
  enum class Cell : std::uint8_t { kStays, kPart, kWhole };

  /// Things most of whose points moved go as a whole, points of unknown fate included.
  void wholeObjects(const ScanCells& cells, const std::vector<Tally>& tallies) {
    fate_.assign(cells.size(), Cell::kStays);
    std::size_t objects = 0;
    const std::vector<std::uint32_t> object = cells.groups(std::vector<std::uint8_t>(cells.size(), 1), objects);
    std::vector<Tally> of_object(objects);
    for (std::size_t cell = 0; cell < cells.size(); ++cell) of_object[object[cell]].add(tallies[cell]);
    for (std::size_t cell = 0; cell < cells.size(); ++cell) {
      const Tally& all = of_object[object[cell]];
      if (isObject(all) && all.share() > params_.whole_share) fate_[cell] = Cell::kWhole;
    }
    for (const Tally& all : of_object) result_.objects += isObject(all) && all.share() > params_.whole_share;
  }

  /// What moved beside something that stands: groups of cells that most views refuse.
  void partsOfObjects(const ScanCells& cells, const std::vector<Tally>& tallies) {
    std::vector<std::uint8_t> moved(cells.size());
    for (std::size_t cell = 0; cell < cells.size(); ++cell)
      moved[cell] = fate_[cell] == Cell::kStays && tallies[cell].share() > 0.5 ? 1 : 0;
    std::size_t parts = 0;
    const std::vector<std::uint32_t> part = cells.groups(moved, parts);
    std::vector<Tally> of_part(parts);
    for (std::size_t cell = 0; cell < cells.size(); ++cell)
      if (moved[cell] != 0) of_part[part[cell]].add(tallies[cell]);
    const auto goes = [this](const Tally& all) {
      return all.moved >= static_cast<std::size_t>(params_.min_part_points) && all.share() > params_.part_share;
    };
    for (std::size_t cell = 0; cell < cells.size(); ++cell)
      if (moved[cell] != 0 && goes(of_part[part[cell]])) fate_[cell] = Cell::kPart;
    for (const Tally& all : of_part) result_.objects += goes(all);
  }

  bool isObject(const Tally& all) const { return all.moved >= static_cast<std::size_t>(params_.min_object_points); }

  void decide(std::size_t point, std::uint32_t cell) {
    const Say say = says_[point];
    const bool goes = cell != ScanCells::kNone && (say == Say::kSurelyMoved || fate_[cell] == Cell::kWhole ||
                                                   (fate_[cell] == Cell::kPart && say != Say::kStood));
    result_.dynamic[point] = goes ? 1 : 0;
    result_.completed += goes && say < Say::kMoved;
    result_.reverted += !goes && say == Say::kMoved;
  }

  /// Wheels and feet: what lies low goes where something above it went (views cannot tell it from the ground behind
  /// it); the ground itself only where they say that it moved.
  void belowObjects(const Pose& T_level_sensor) {
    constexpr double kFoot_m = 0.25;
    const auto footOf = [&](std::size_t i) {
      const Eigen::Vector3d p = T_level_sensor * cloud_.point(i).cast<double>();
      return std::pair(static_cast<int>(std::floor(p.x() / kFoot_m)), static_cast<int>(std::floor(p.y() / kFoot_m)));
    };
    std::set<std::pair<int, int>> feet;
    for (std::size_t i = 0; i < cloud_.size(); ++i)
      if (result_.dynamic[i] != 0) {
        const auto [x, y] = footOf(i);
        for (int d = 0; d < 9; ++d) feet.emplace(x + d % 3 - 1, y + d / 3 - 1);
      }
    if (feet.empty()) return;
    for (std::size_t i = 0; i < cloud_.size(); ++i) {
      if (upright_[i] != 0 || !cloud_.point(i).allFinite() || !feet.contains(footOf(i))) continue;
      const bool goes = height_[i] >= params_.ground_height_m || says_[i] >= Say::kMoved;
      if (!goes) continue;
      result_.dynamic[i] = 1;
      result_.completed += says_[i] < Say::kMoved;
    }
  }

  const Cloud& cloud_;
  const std::vector<float>& height_;
  const CleanParams& params_;
  std::vector<Say> says_;
  std::vector<std::uint8_t> upright_;
  std::vector<Cell> fate_;
  ScanVerdict result_;
};

}  // namespace

ScanVerdict judgeScan(const Cloud& cloud_sensor, const std::vector<float>& height, const SightVotes& soon,
                      const SightVotes& later, const Pose& T_level_sensor, const CleanParams& params) {
  return Judge(cloud_sensor, height, whatViewsSay(soon, later, params), params)(T_level_sensor);
}

}  // namespace scslam
