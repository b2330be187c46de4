#include "scslam/apps/learn/logistic.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "scslam/core/error.h"

namespace scslam {
namespace {

constexpr double kRidge = 1e-3;  // per example, of standardised weights

double logistic(double score) { return 1 / (1 + std::exp(-score)); }

}  // namespace

Eigen::VectorXd logisticWeights(const Examples& examples) {
  const auto n = static_cast<Eigen::Index>(examples.features.size());
  const auto yes = std::count(examples.yes.begin(), examples.yes.end(), true);
  if (yes == 0 || yes == n)
    throw inputError("{} of {} examples are right: both right and wrong ones are needed", yes, n);
  const Eigen::Index d = examples.features.front().size();
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(d), sigma = Eigen::VectorXd::Zero(d);
  for (const Eigen::VectorXd& x : examples.features) mean += x / static_cast<double>(n);
  for (const Eigen::VectorXd& x : examples.features) sigma += (x - mean).cwiseAbs2() / static_cast<double>(n);
  sigma = sigma.cwiseSqrt().cwiseMax(1e-9);

  Eigen::VectorXd w = Eigen::VectorXd::Zero(d + 1);
  for (int iteration = 0; iteration < 50; ++iteration) {
    Eigen::MatrixXd H = kRidge * Eigen::MatrixXd::Identity(d + 1, d + 1);
    Eigen::VectorXd g = kRidge * w;
    H(0, 0) = 1e-9, g(0) = 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const auto at = static_cast<std::size_t>(i);
      Eigen::VectorXd x(d + 1);
      x << 1, (examples.features[at] - mean).cwiseQuotient(sigma);
      const double p = logistic(w.dot(x)), y = examples.yes[at] ? 1 : 0;
      const double share = 0.5 / static_cast<double>(examples.yes[at] ? yes : n - yes);
      g += share * (p - y) * x;
      H += share * std::max(p * (1 - p), 1e-9) * x * x.transpose();
    }
    const Eigen::VectorXd step = H.ldlt().solve(g);
    w -= step;
    if (step.cwiseAbs().maxCoeff() < 1e-9) break;
  }
  Eigen::VectorXd weights(d + 1);
  weights.tail(d) = w.tail(d).cwiseQuotient(sigma);
  weights(0) = w(0) - weights.tail(d).dot(mean);
  return weights;
}

double logisticProbability(const Eigen::VectorXd& weights, const Eigen::VectorXd& features) {
  return logistic(weights(0) + weights.tail(features.size()).dot(features));
}

double areaUnderRoc(const Eigen::VectorXd& weights, const Examples& examples) {
  double above = 0, pairs = 0;
  for (std::size_t i = 0; i < examples.yes.size(); ++i)
    for (std::size_t k = 0; k < examples.yes.size(); ++k) {
      if (!examples.yes[i] || examples.yes[k]) continue;
      const double p = weights.tail(examples.features[i].size()).dot(examples.features[i] - examples.features[k]);
      above += p > 0 ? 1 : p == 0 ? 0.5 : 0, ++pairs;
    }
  return pairs > 0 ? above / pairs : 0;
}

}  // namespace scslam
