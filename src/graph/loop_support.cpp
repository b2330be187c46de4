#include "scslam/graph/loop_support.h"

#include <algorithm>
#include <tuple>

namespace scslam {
namespace {

/// A loop with its ends in order, i < j.
struct Loop {
  std::uint32_t i, j, factor;
  bool operator<(const Loop& other) const { return std::tie(i, j, factor) < std::tie(other.i, other.j, other.factor); }
};

std::vector<Loop> loopsByEnds(const PoseGraph& graph) {
  std::vector<Loop> loops;
  for (std::uint32_t f = 0; f < graph.factors.size(); ++f) {
    const Factor& factor = graph.factors[f];
    if (factor.kind != FactorKind::kLoop) continue;
    const auto [low, high] = std::minmax(factor.i, factor.j);
    loops.push_back({low, high, f});
  }
  std::sort(loops.begin(), loops.end());
  return loops;
}

UncertainPose measured(const Factor& factor, const Matrix6d& covariance) {
  const UncertainPose T_i_j{factor.T_i_j, covariance};
  return factor.i < factor.j ? T_i_j : inverted(T_i_j);
}

std::uint32_t distance(std::uint32_t a, std::uint32_t b) { return a < b ? b - a : a - b; }

/// 99.9 % quantile of the chi-square distribution for 6 and 3 degrees of freedom.
double cycleGate(bool planar) { return planar ? 16.27 : 22.46; }

struct Cycle {
  std::uint32_t a, b;  ///< factors
  double chi2;
};

std::vector<Cycle> cyclesOfNeighbours(const PoseGraph& graph, const OdometryChain& chain) {
  constexpr std::uint32_t kWindow = 10;
  constexpr std::size_t kMost = 16;
  const std::vector<Loop> loops = loopsByEnds(graph);
  std::vector<UncertainPose> measurements;
  measurements.reserve(loops.size());
  for (const Loop& loop : loops)
    measurements.push_back(measured(graph.factors[loop.factor], covarianceOf(graph.factors[loop.factor].information)));
  std::vector<std::size_t> asked(loops.size(), 0);
  std::vector<Cycle> cycles;
  for (std::size_t a = 0; a < loops.size(); ++a)
    for (std::size_t b = a + 1; b < loops.size() && loops[b].i - loops[a].i <= kWindow && asked[a] < kMost; ++b) {
      const std::uint32_t steps = loops[b].i - loops[a].i, others = distance(loops[a].j, loops[b].j);
      const std::uint32_t shorter = std::min(loops[a].j - loops[a].i, loops[b].j - loops[b].i);
      if (others > kWindow || 4 * (steps + others) > shorter || asked[b] >= 2 * kMost) continue;
      if (!chain.joined(loops[a].i, loops[b].i) || !chain.joined(loops[a].j, loops[b].j)) continue;
      ++asked[a], ++asked[b];
      const double chi2 = cycleChi2(measurements[a], chain.way(loops[a].j, loops[b].j), measurements[b],
                                    chain.way(loops[b].i, loops[a].i), graph.planar);
      cycles.push_back({loops[a].factor, loops[b].factor, chi2});
    }
  return cycles;
}

/// From the upper end of what closes: groups of false loops that agree all too well do not pull it down.
double varianceFactor(const std::vector<Cycle>& cycles, bool planar) {
  std::vector<double> closing;
  for (const Cycle& cycle : cycles)
    if (cycle.chi2 <= cycleGate(planar)) closing.push_back(cycle.chi2);
  if (closing.size() < 10) return 1;
  return std::min(1.0, upperDecile(closing) / ninetyPercent(planar));
}

}  // namespace

double ninetyPercent(bool planar) { return planar ? 6.25 : 10.64; }

double upperDecile(std::vector<double> values) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(values.size() * 9 / 10);
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

LoopSupport loopSupport(const PoseGraph& graph, const OdometryChain& chain) {
  const std::vector<Cycle> cycles = cyclesOfNeighbours(graph, chain);
  LoopSupport support;
  support.variance_factor = varianceFactor(cycles, graph.planar);
  const double gate = cycleGate(graph.planar) * std::min(1.0, kVarianceMargin * support.variance_factor);
  std::vector<std::uint32_t> agree(graph.factors.size(), 0), contradict(graph.factors.size(), 0);
  for (const Cycle& cycle : cycles)
    for (const std::uint32_t f : {cycle.a, cycle.b}) ++(cycle.chi2 <= gate ? agree : contradict)[f];
  for (std::size_t f = 0; f < graph.factors.size(); ++f)
    support.trusted.push_back(agree[f] > 0 && agree[f] >= contradict[f]);
  return support;
}

}  // namespace scslam
