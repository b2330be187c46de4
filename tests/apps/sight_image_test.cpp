// One scan's testimony, in a cube: nearer than the wall was looked through, at the wall something was seen, beyond it
// nothing is known.
#include "scslam/apps/clean/sight_image.h"

#include "odometry/spinning.h"

namespace scslam::test {
namespace {

Cloud cube(bool roof = true) {
  const BoxWorld world{{{{-10, -10, -10}, {10, 10, roof ? 10.0 : 1000.0}}}};
  Cloud cloud;
  for (int row = 0; row < 64; ++row)
    for (int column = 0; column < 900; ++column) {
      const double azimuth = 2 * M_PI * (column + 0.5) / 900, elevation = -0.4 + 0.0125 * row;
      const Eigen::Vector3d d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                              std::sin(elevation));
      const Eigen::Vector3f p = (world.range(Eigen::Vector3d::Zero(), d) * d).cast<float>();
      cloud.push(p.x(), p.y(), p.z());
    }
  return cloud;
}

Cloud pointsAt(std::initializer_list<Eigen::Vector3f> points) {
  Cloud cloud;
  for (const Eigen::Vector3f& p : points) cloud.push(p.x(), p.y(), p.z());
  return cloud;
}

TEST(SightImage, SaysFreeBeforeTheWallAndSurfaceAtIt) {
  const SightGrid grid = sightGridOf({cube()}, false);
  const Cloud points = pointsAt({{5, 0.1F, 0.2F},
                                 {9.4F, 0.1F, 0.2F},
                                 {10, 0.1F, 0.2F},
                                 {10.2F, 0.1F, 0.2F},
                                 {12, 0.1F, 0.2F},
                                 {0.1F, 0.1F, -5},
                                 {0.5F, 0, 0}});
  SightVotes votes(points.size());
  SightImage(cube(), grid).vote(points, Pose::Identity(), grid, {}, votes);
  EXPECT_THAT(votes.free, ::testing::ElementsAre(1, 1, 0, 0, 0, 0, 0))
      << "below the field of view and too near: no word";
  EXPECT_THAT(votes.surface, ::testing::ElementsAre(0, 0, 1, 1, 0, 0, 0));
}

TEST(SightImage, TakesThePointsToWhereItStood) {
  const SightGrid grid = sightGridOf({cube()}, false);
  const Pose T_view_cloud = poseFromYaw(M_PI / 2, {0, 4, 0});
  SightVotes votes(2);  // (6, 0) lies at (0, 10) there, on the wall; (-1, 0) at (0, 3)
  SightImage(cube(), grid).vote(pointsAt({{6, 0, 0}, {-1, 0, 0}}), T_view_cloud, grid, {}, votes);
  EXPECT_THAT(votes.surface, ::testing::ElementsAre(1, 0));
  EXPECT_THAT(votes.free, ::testing::ElementsAre(0, 1));
}

TEST(SightImage, BeamsWithoutReturnLookedThroughUpToTheGivenRange) {
  const SightGrid grid = sightGridOf({cube()}, false);  // that sensor measures in all of these directions
  Cloud open;
  const Cloud all = cube();
  for (std::size_t i = 0; i < all.size(); ++i)
    if (all.x[i] < 0) open.push(all.x[i], all.y[i], all.z[i]);
  const Cloud points = pointsAt({{30, 0.1F, 0.2F}, {50, 0.1F, 0.2F}});
  SightVotes votes(2);
  SightImage(open, grid).vote(points, Pose::Identity(), grid, {}, votes);
  EXPECT_THAT(votes.free, ::testing::ElementsAre(1, 0));
  SightMargins careful;
  careful.sky_m = 0;
  SightVotes none(2);
  SightImage(open, grid).vote(points, Pose::Identity(), grid, careful, none);
  EXPECT_THAT(none.free, ::testing::ElementsAre(0, 0));
}

TEST(SightImage, NeverPiercesTheSurfacesThatItSaw) {
  const SightGrid grid = sightGridOf({cube()}, false);
  const SightImage image(cube(), grid);
  for (const Eigen::Vector3d& from : {Eigen::Vector3d(3, 2, 0.4), Eigen::Vector3d(-7, 5, -0.5)}) {
    const Pose T = poseFromYaw(0.7, from);  // the cube seen from elsewhere, as points of its own
    const BoxWorld world{{{{-10, -10, -10}, {10, 10, 10}}}};
    Cloud seen;
    for (int i = 0; i < 20000; ++i) {
      const double azimuth = 0.01234 * i, elevation = -0.4 + 0.8 * (i % 997) / 997;
      const Eigen::Vector3d d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                              std::sin(elevation));
      const Eigen::Vector3f p = (world.range(from, T.linear() * d) * d).cast<float>();
      seen.push(p.x(), p.y(), p.z());
    }
    SightVotes votes(seen.size());
    image.vote(seen, T, grid, {}, votes);
    EXPECT_EQ(std::count(votes.free.begin(), votes.free.end(), 1), 0);
    EXPECT_GT(std::count(votes.surface.begin(), votes.surface.end(), 1), 10000);
  }
}

TEST(SightImage, OutlivesEmptyAndInvalidScans) {
  Cloud nan;
  nan.push(NAN, 0, 0), nan.push(INFINITY, 1, 1), nan.push(0, 0, 0);
  for (const Cloud& cloud : {Cloud{}, nan}) {
    const SightGrid grid = sightGridOf({cloud}, false);
    SightVotes votes(nan.size());
    SightImage(cloud, grid).vote(nan, Pose::Identity(), grid, {}, votes);
    EXPECT_THAT(votes.free, ::testing::Each(0));
  }
}

TEST(SightGrid, IsAsFineAsTheBeams) {
  const SightGrid grid = sightGridOf({cube()}, false);
  EXPECT_NEAR(grid.row_rad, 1.25 * 0.0125, 0.002);
  EXPECT_NEAR(static_cast<double>(grid.rows) * grid.row_rad, 64 * 0.0125, 0.04);
  EXPECT_EQ(sightGridOf({cube()}, true).rows, 1u);
}

}  // namespace
}  // namespace scslam::test
