#include "scslam/graph/false_loops.h"

#include <algorithm>
#include <cmath>

#include "scslam/core/counter_random.h"

namespace scslam {
namespace {

constexpr double kNear_rad = 20 * M_PI / 180;

double medianStep(const PoseGraph& graph) {
  std::vector<double> steps;
  for (const Factor& factor : graph.factors)
    if (factor.kind == FactorKind::kOdometry) steps.push_back(factor.T_i_j.translation().norm());
  if (steps.empty()) return 0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

/// What look-alike places claim.
std::vector<Factor> templatesOf(const PoseGraph& graph) {
  std::vector<Factor> loops;
  for (const Factor& factor : graph.factors)
    if (factor.kind == FactorKind::kLoop) loops.push_back(factor);
  if (!loops.empty()) return loops;
  Factor same_place;
  for (const Factor& factor : graph.factors)
    if (factor.kind == FactorKind::kOdometry) same_place.information = factor.information;
  same_place.kind = FactorKind::kLoop;
  return {same_place};
}

}  // namespace

std::vector<std::uint32_t> addFalseLoops(PoseGraph& graph, const FalseLoopOptions& options) {
  std::vector<std::uint32_t> added;
  const auto n = static_cast<std::uint32_t>(graph.poses.size());
  const auto group = static_cast<std::uint32_t>(std::max<std::size_t>(1, options.group));
  if (n < 20 || group > n / 4) return added;
  const std::vector<Factor> templates = templatesOf(graph);
  const double near_m = medianStep(graph);
  RandomSequence random(CounterRandom(options.seed, RandomStream::kFaults));
  const auto T_between = [&](std::uint32_t a, std::uint32_t b) { return graph.poses[a].inverse() * graph.poses[b]; };
  for (std::size_t draw = 0; added.size() < options.count && draw < 100 * options.count; ++draw) {
    const auto i = static_cast<std::uint32_t>(random.below(static_cast<int>(n - group + 1)));
    const auto j = static_cast<std::uint32_t>(random.below(static_cast<int>(n - group + 1)));
    Factor loop = templates[static_cast<std::size_t>(random.below(static_cast<int>(templates.size())))];
    const Pose T_claimed = loop.T_i_j;
    const Pose error = T_claimed.inverse() * T_between(i, j);
    if (std::max(i, j) - std::min(i, j) < n / 10) continue;
    if (error.translation().norm() < near_m && rotationAngle(error) < kNear_rad) continue;
    for (std::uint32_t k = 0; k < group && added.size() < options.count; ++k) {
      loop.i = i + k;
      loop.j = j + k;
      loop.T_i_j = T_between(i + k, i) * T_claimed * T_between(j, j + k);
      added.push_back(static_cast<std::uint32_t>(graph.factors.size()));
      graph.factors.push_back(loop);
    }
  }
  return added;
}

}  // namespace scslam
