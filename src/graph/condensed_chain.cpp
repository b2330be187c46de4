#include "scslam/graph/condensed_chain.h"

#include <Eigen/LU>
#include <algorithm>

#include "scslam/graph/factor_error.h"

namespace scslam::detail {
namespace {

Matrix6d informationOf(const Matrix6d& covariance, bool planar) {
  if (!planar) return symmetric(covariance.inverse());
  Eigen::Matrix3d small;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) small(r, c) = covariance(kPlanarAxes[r], kPlanarAxes[c]);
  const Eigen::Matrix3d inverse = small.inverse();
  Matrix6d information = Matrix6d::Zero();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) information(kPlanarAxes[r], kPlanarAxes[c]) = inverse(r, c);
  return symmetric(information);
}

}  // namespace

Vector6d ChainSegment::error(const std::vector<Pose>& poses) const {
  return local(poses[begin] * T_begin_end, poses[end]);
}

void ChainSegment::placeInner(std::vector<Pose>& poses) const {
  if (inner.empty()) return;
  const Vector6d e = error(poses);
  for (std::size_t k = 0; k < inner.size(); ++k)
    poses[begin + 1 + k] = retract(poses[begin] * inner[k].T_begin_this, inner[k].gain * e);
}

void CondensedChain::takeSteps(const PoseGraph& graph, std::vector<std::uint8_t>& is_step) {
  steps_.resize(graph.poses.size());
  if (is_step.empty())
    for (Step& step : steps_) step.present = false;
  for (std::size_t f = is_step.size(); f < graph.factors.size(); ++f) {
    const Factor& factor = graph.factors[f];
    const auto [low, high] = std::minmax(factor.i, factor.j);
    Step& step = steps_[high];
    is_step.push_back(factor.kind == FactorKind::kOdometry && high == low + 1 && !step.present);
    if (is_step.back() == 0) continue;
    step.present = true;
    if (step.known) continue;
    const UncertainPose way{factor.T_i_j, covarianceOf(factor.information)};
    step.known = true;
    step.way = factor.i < factor.j ? way : inverted(way);
    step.information = factor.i < factor.j ? factor.information : informationOf(step.way.covariance, graph.planar);
  }
}

ChainSegment CondensedChain::condensed(std::uint32_t begin, std::uint32_t end, bool planar) const {
  std::vector<UncertainPose> ways{steps_[begin + 1].way};  // from begin
  for (std::uint32_t k = begin + 2; k <= end; ++k) ways.push_back(ways.back() * steps_[k].way);
  ChainSegment segment{begin, end, ways.back().T_a_b, {}, {}};
  segment.information = ways.size() == 1 ? steps_[end].information : informationOf(ways.back().covariance, planar);
  const Pose T_end_begin = segment.T_begin_end.inverse();
  for (std::size_t k = 0; k + 1 < ways.size(); ++k) {
    // Errors of this pose move the end by the adjoint; hence its covariance with the end's error, over that one's own.
    const Matrix6d moves_end = adjoint(T_end_begin * ways[k].T_a_b);
    segment.inner.push_back({ways[k].T_a_b, ways[k].covariance * moves_end.transpose() * segment.information});
  }
  return segment;
}

const std::vector<ChainSegment>& CondensedChain::segmentsBetween(const std::vector<std::uint32_t>& keys, bool planar) {
  std::vector<ChainSegment> segments;
  segments.reserve(keys.size());
  auto known = segments_.begin();
  for (std::size_t k = 1; k < keys.size(); ++k) {
    const std::uint32_t begin = keys[k - 1], end = keys[k];
    const auto is_joined = [](const Step& step) { return step.present; };
    if (!std::all_of(steps_.begin() + begin + 1, steps_.begin() + end + 1, is_joined)) continue;
    while (known != segments_.end() && known->begin < begin) ++known;
    const bool same = known != segments_.end() && known->begin == begin && known->end == end;
    segments.push_back(same ? std::move(*known) : condensed(begin, end, planar));
  }
  segments_ = std::move(segments);
  return segments_;
}

}  // namespace scslam::detail
