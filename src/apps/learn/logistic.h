// Logistic regression.
#pragma once
#include <vector>

#include <Eigen/Core>

namespace scslam {

/// Examples: a row of features each, and whether it is one of what is looked for.
struct Examples {
  std::vector<Eigen::VectorXd> features;
  std::vector<bool> yes;
};

/// Weights w, bias first, that make 1 / (1 + exp(-w . (1, x))) most likely; both classes count the same however many
/// examples they have, and weights are held small (ridge) where examples say little. Newton's method.
/// @throw inputError unless there are examples of both classes.
Eigen::VectorXd logisticWeights(const Examples& examples);
double logisticProbability(const Eigen::VectorXd& weights, const Eigen::VectorXd& features);
/// Share of pairs (yes, no) of which the yes is given the higher probability; ties count half.
double areaUnderRoc(const Eigen::VectorXd& weights, const Examples& examples);

}  // namespace scslam
