#include "sim/polygon_mesh.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>

#include "scslam/core/counter_random.h"

namespace scslam::sim {
namespace {

using Eigen::Vector3d;

/// Sum of the triangles' vector areas and of their absolute areas.
struct Areas {
  Vector3d vector = Vector3d::Zero();
  double absolute = 0;
};
Areas areasOf(const std::vector<Vector3d>& polygon) {
  Areas sum;
  for (const auto& t : cutPolygon(polygon)) {
    const Vector3d a = 0.5 * (polygon.at(t[1]) - polygon.at(t[0])).cross(polygon.at(t[2]) - polygon.at(t[0]));
    sum.vector += a;
    sum.absolute += a.norm();
  }
  return sum;
}

TEST(CutPolygon, FillsStarsExactlyInEveryAttitude) {
  RandomSequence random(CounterRandom(1, RandomStream::kWorld));
  for (int trial = 0; trial < 50; ++trial) {
    const Eigen::Matrix3d R = Eigen::Quaterniond(random.normal(), random.normal(), random.normal(), random.normal())
                                  .normalized()
                                  .toRotationMatrix();
    std::vector<Vector3d> star;
    double expected = 0;
    const int n = 5 + random.below(30);
    std::vector<Vector3d> flat;
    for (int i = 0; i < n; ++i) {
      const double angle = 2 * M_PI * i / n, r = random.uniform(0.2, 5);
      flat.emplace_back(r * std::cos(angle), r * std::sin(angle), 0);
    }
    for (int i = 0; i < n; ++i) expected += 0.5 * flat[i].cross(flat[(i + 1) % n]).z();
    for (const Vector3d& p : flat) star.push_back(R * p + Vector3d(100, -50, 7));
    const Areas areas = areasOf(star);
    EXPECT_EQ(cutPolygon(star).size(), static_cast<std::size_t>(n - 2));
    EXPECT_NEAR(areas.absolute, expected, 1e-9 * expected) << "triangles overlap or leave the polygon, trial " << trial;
    EXPECT_LT((areas.vector - expected * R.col(2)).norm(), 1e-9 * expected) << "sense of rotation";
  }
}

TEST(CutPolygon, EndsOnPolygonsThatAreNone) {
  EXPECT_TRUE(cutPolygon(std::vector<Vector3d>{{0, 0, 0}, {1, 0, 0}}).empty());
  EXPECT_EQ(cutPolygon(std::vector<Vector3d>(7, Vector3d(1, 2, 3))).size(), 5U);
  EXPECT_EQ(cutPolygon(std::vector<Vector3d>{{0, 0, 0}, {1, 0, 0}, {2, 0, 0}, {3, 0, 0}}).size(), 2U);
  EXPECT_EQ(cutPolygon(std::vector<Vector3d>{{0, 0, 0}, {1, 1, 0}, {1, 0, 0}, {0, 1, 0}}).size(), 2U) << "a bow tie";
}

TEST(CutPolygon, FillsARingThatIsCutOpen) {
  // A square with a square hole, joined by a cut that is walked twice: the usual form of holes in mesh files.
  const std::vector<Vector3d> ring = {{0, 0, 0}, {4, 0, 0}, {4, 4, 0}, {0, 4, 0}, {0, 0, 0},
                                      {1, 1, 0}, {1, 3, 0}, {3, 3, 0}, {3, 1, 0}, {1, 1, 0}};
  const Areas areas = areasOf(ring);
  EXPECT_NEAR(areas.absolute, 12, 1e-12);
  EXPECT_NEAR(areas.vector.z(), 12, 1e-12);
}

}  // namespace
}  // namespace scslam::sim
