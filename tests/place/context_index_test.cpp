#include "scslam/place/context_index.h"

#include <gtest/gtest.h>

#include <random>

namespace scslam {
namespace {

constexpr int kRows = 7;

/// Random heights; the columns of `blind` are empty.
Descriptor randomImage(std::mt19937& random, int columns, int blind_from, int blind) {
  Descriptor image(kRows, columns);
  for (int j = 0; j < columns; ++j)
    for (int r = 0; r < kRows; ++r)
      image(r, j) = j >= blind_from && j < blind_from + blind ? 0.0f : static_cast<float>(random() % 1000) / 100;
  return image;
}

/// The definition: each column divided by its length to the power 1 - weight, then 1 - cosine over the columns both
/// saw.
double distanceAt(const Descriptor& a, const Descriptor& b, int shift, const ContextLayout& layout) {
  const auto columns = static_cast<int>(layout.columns);
  const auto seen = [](const Descriptor& image) { return (image.colwise().norm().array() > 0).count(); };
  double product = 0, a2 = 0, b2 = 0;
  int common = 0;
  for (int j = 0; j < columns; ++j) {
    const int k = layout.circular ? (j + shift + columns) % columns : j + shift;
    if (k < 0 || k >= columns || a.col(j).norm() == 0 || b.col(k).norm() == 0) continue;
    const Eigen::VectorXd u = a.col(j).cast<double>(), v = b.col(k).cast<double>();
    const Eigen::VectorXd weighted_u = u * std::pow(u.norm(), layout.column_weight - 1);
    const Eigen::VectorXd weighted_v = v * std::pow(v.norm(), layout.column_weight - 1);
    product += weighted_u.dot(weighted_v);
    a2 += weighted_u.squaredNorm(), b2 += weighted_v.squaredNorm();
    ++common;
  }
  const double enough = layout.min_common * static_cast<double>(std::min(seen(a), seen(b)));
  return common < enough ? 1 : 1 - product / std::sqrt(a2 * b2);
}

void expectDefinition(ContextLayout layout, int blind) {
  std::mt19937 random(3);
  const auto columns = static_cast<int>(layout.columns);
  const int reach = layout.circular ? columns / 2 : static_cast<int>(layout.max_shift);
  for (const double weight : {0.0, 0.5, 1.0}) {
    layout.column_weight = weight;
    ContextIndex index(layout);
    const Descriptor a = randomImage(random, columns, 5, blind), b = randomImage(random, columns, 20, blind);
    index.add(index.probe(b));
    double best = 1;
    for (int shift = -reach; shift <= reach; ++shift) best = std::min(best, distanceAt(a, b, shift, layout));
    const auto match = index.compare(index.probe(a), 0);
    EXPECT_NEAR(match.distance, best, 1e-5) << "weight " << weight;
    EXPECT_NEAR(distanceAt(a, b, static_cast<int>(std::lround(match.shift)), layout), best, 0.02);
  }
}

TEST(ContextIndex, DistanceIsTheCosineOfWeightedColumnsAtTheBestShift) {
  expectDefinition({.rows = kRows, .columns = 60}, 0);
  expectDefinition({.rows = kRows, .columns = 40, .circular = false, .max_shift = 6}, 0);
}

TEST(ContextIndex, ColumnsThatOneOfBothDidNotSeeDoNotCount) {
  expectDefinition({.rows = kRows, .columns = 60}, 13);
  expectDefinition({.rows = kRows, .columns = 64, .min_common = 0.9}, 20);
  expectDefinition({.rows = kRows, .columns = 40, .circular = false, .max_shift = 6}, 9);
}

}  // namespace
}  // namespace scslam
