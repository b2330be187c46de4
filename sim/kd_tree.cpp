#include "sim/kd_tree.h"

#include <algorithm>
#include <limits>
#include <numeric>

namespace scslam::sim {

KdTree::KdTree(const std::vector<Eigen::Vector3d>& points)
    : points_(points), order_(points.size()), axis_(points.size(), 0) {
  std::iota(order_.begin(), order_.end(), 0u);
  build(0, order_.size());
}

void KdTree::build(std::size_t begin, std::size_t end) {
  if (end - begin < 2) return;
  Eigen::Vector3d lo = points_[order_[begin]], hi = lo;
  for (std::size_t i = begin; i < end; ++i) {
    lo = lo.cwiseMin(points_[order_[i]]);
    hi = hi.cwiseMax(points_[order_[i]]);
  }
  int axis = 0;
  (hi - lo).maxCoeff(&axis);
  const std::size_t middle = begin + (end - begin) / 2;
  const auto at = [this](std::size_t i) { return order_.begin() + static_cast<std::ptrdiff_t>(i); };
  std::nth_element(at(begin), at(middle), at(end),
                   [&](std::uint32_t a, std::uint32_t b) { return points_[a][axis] < points_[b][axis]; });
  axis_[middle] = static_cast<std::uint8_t>(axis);
  build(begin, middle);
  build(middle + 1, end);
}

/// Visits the points that may lie within sqrt(radius2), nearer side first; `visit` may shrink radius2.
template <class Visit>
void KdTree::walk(std::size_t begin, std::size_t end, const Eigen::Vector3d& centre, double& radius2,
                  Visit&& visit) const {
  if (begin >= end) return;
  const std::size_t middle = begin + (end - begin) / 2;
  const std::uint32_t index = order_[middle];
  const int axis = axis_[middle];
  const double offset = centre[axis] - points_[index][axis];
  if (offset < 0)
    walk(begin, middle, centre, radius2, visit);
  else
    walk(middle + 1, end, centre, radius2, visit);
  visit(index, (points_[index] - centre).squaredNorm());
  if (offset * offset > radius2) return;
  if (offset < 0)
    walk(middle + 1, end, centre, radius2, visit);
  else
    walk(begin, middle, centre, radius2, visit);
}

double KdTree::nearestOther(std::size_t i) const {
  double nearest2 = std::numeric_limits<double>::infinity();
  walk(0, order_.size(), points_[i], nearest2, [&](std::uint32_t index, double distance2) {
    if (index != i) nearest2 = std::min(nearest2, distance2);
  });
  return std::sqrt(nearest2);
}

void KdTree::within(const Eigen::Vector3d& centre, double radius, std::vector<std::uint32_t>& found) const {
  found.clear();
  double radius2 = radius * radius;
  walk(0, order_.size(), centre, radius2, [&](std::uint32_t index, double distance2) {
    if (distance2 <= radius2) found.push_back(index);
  });
}

}  // namespace scslam::sim
