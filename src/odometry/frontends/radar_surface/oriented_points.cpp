#include "scslam/odometry/frontends/radar_surface/oriented_points.h"

#include <algorithm>
#include <cmath>

namespace scslam::radar_surface {
namespace {

constexpr int kRounds = 3;  // of moving a group to where its points are dense

/// Weighted sums of points about a place near them.
struct Moments {
  int count = 0;
  double w = 0, x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  void add(double weight, double px, double py) {
    ++count;
    w += weight, x += weight * px, y += weight * py;
    xx += weight * px * px, xy += weight * px * py, yy += weight * py * py;
  }
};

void pushGroup(const Moments& m, double x0, double y0, OrientedPoints& out) {
  const double mx = m.x / m.w, my = m.y / m.w;
  const double xx = m.xx / m.w - mx * mx, xy = m.xy / m.w - mx * my, yy = m.yy / m.w - my * my;
  // The eigenvalues of a symmetric 2 x 2 matrix are its mean diagonal less and plus `radius`.
  const double mean = 0.5 * (xx + yy), radius = std::hypot(0.5 * (xx - yy), xy);
  const double direction = 0.5 * std::atan2(2 * xy, xx - yy);  // of the greater one
  out.x.push_back(static_cast<float>(x0 + mx)), out.y.push_back(static_cast<float>(y0 + my));
  out.nx.push_back(static_cast<float>(-std::sin(direction))), out.ny.push_back(static_cast<float>(std::cos(direction)));
  out.across.push_back(static_cast<float>(std::max(mean - radius, 0.0)));
  out.along.push_back(static_cast<float>(mean + radius));
  out.count.push_back(static_cast<float>(m.count));
}

}  // namespace

void OrientedPoints::save(ByteWriter& state) const {
  for (const auto* values : {&x, &y, &nx, &ny, &across, &along, &count}) state.put(*values);
}

void OrientedPoints::load(ByteReader& state) {
  for (auto* values : {&x, &y, &nx, &ny, &across, &along, &count}) {
    state.get(*values);
    if (values->size() != x.size()) throw inputError("odometry: a saved keyframe with arrays of different lengths");
  }
}

PointGrid::PointGrid(const std::vector<float>& x, const std::vector<float>& y, double cell_m)
    : per_cell_(static_cast<float>(1 / cell_m)), index_(x.size()) {
  std::vector<std::uint32_t> cell_of(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) cell_of[i] = index_.findOrInsert(packVoxel(cell(x[i]), cell(y[i]), 0));
  begin_.assign(index_.size() + 1, 0);
  for (const std::uint32_t number : cell_of) ++begin_[number + 1];
  for (std::size_t number = 0; number < index_.size(); ++number) begin_[number + 1] += begin_[number];
  members_.resize(x.size());
  std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
  for (std::size_t i = 0; i < x.size(); ++i) members_[next[cell_of[i]]++] = static_cast<std::uint32_t>(i);
}

OrientedPoints orientedPoints(const Cloud& cloud, const GroupRules& rules) {
  OrientedPoints out;
  if (cloud.empty()) return out;
  const PointGrid grid(cloud.x, cloud.y, rules.radius_m);
  float weakest = 0;
  if (cloud.hasIntensity()) weakest = *std::min_element(cloud.intensity.begin(), cloud.intensity.end());
  const auto weightOf = [&](std::size_t i) {
    return cloud.hasIntensity() ? 1.0 + static_cast<double>(cloud.intensity[i] - weakest) : 1.0;
  };
  const auto radius2 = static_cast<float>(rules.radius_m * rules.radius_m);
  const auto around = [&](float cx, float cy) {
    Moments moments;
    grid.near(cx, cy, [&](std::uint32_t i) {
      const float dx = cloud.x[i] - cx, dy = cloud.y[i] - cy;
      if (dx * dx + dy * dy <= radius2) moments.add(weightOf(i), static_cast<double>(dx), static_cast<double>(dy));
    });
    return moments;
  };
  for (std::size_t number = 0; number < grid.cells(); ++number) {
    float cx = 0, cy = 0;
    const auto members = grid.members(number);
    for (const std::uint32_t i : members) cx += cloud.x[i], cy += cloud.y[i];
    cx /= static_cast<float>(members.size()), cy /= static_cast<float>(members.size());
    Moments moments = around(cx, cy);
    for (int round = 1; round < kRounds && moments.count > 0; ++round) {
      cx += static_cast<float>(moments.x / moments.w), cy += static_cast<float>(moments.y / moments.w);
      moments = around(cx, cy);
    }
    if (moments.count >= rules.min_points) pushGroup(moments, static_cast<double>(cx), static_cast<double>(cy), out);
  }
  return out;
}

}  // namespace scslam::radar_surface
