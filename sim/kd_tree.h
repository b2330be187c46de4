// Neighbours of points in space: a balanced k-d tree over an array that outlives it.
#pragma once
#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace scslam::sim {

class KdTree {
 public:
  /// @param points kept by reference; order unchanged.
  explicit KdTree(const std::vector<Eigen::Vector3d>& points);

  /// Distance from point i to the nearest other point; infinite when it is alone.
  double nearestOther(std::size_t i) const;
  /// Indices of all points within `radius` of `centre`, itself included, into `found` (cleared first).
  void within(const Eigen::Vector3d& centre, double radius, std::vector<std::uint32_t>& found) const;

 private:
  void build(std::size_t begin, std::size_t end);
  template <class Visit>
  void walk(std::size_t begin, std::size_t end, const Eigen::Vector3d& centre, double& radius2, Visit&& visit) const;

  const std::vector<Eigen::Vector3d>& points_;
  std::vector<std::uint32_t> order_;  ///< node [begin, end): its point is the middle one, children left and right of it
  std::vector<std::uint8_t> axis_;    ///< split axis, at the node's middle
};

}  // namespace scslam::sim
