// A map that somebody else made, looked at from places on its ground.
#include "scslam/apps/point_map/point_map.h"

#include <fstream>

#include "scslam/apps/point_map/map_views.h"
#include "scslam/apps/point_map/viewpoints.h"
#include "scslam/core/error.h"
#include "scslam/session/session.h"
#include "support/support.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

/// A yard of 30 x 20 m about the origin with walls of 4 m around it, a car-sized block in the middle and, outside, a
/// flat roof at 6 m.
Cloud yard() {
  Cloud cloud;
  constexpr float step = 0.1F;
  for (float x = -15; x <= 15; x += step)
    for (float y = -10; y <= 10; y += step) {
      const bool under_block = std::abs(x) < 2 && std::abs(y) < 1;
      cloud.push(x, y, under_block ? 1.4F : 0.0F);
    }
  for (float z = 0; z < 1.4F; z += step) {
    for (float x = -2; x <= 2; x += step) cloud.push(x, -1, z), cloud.push(x, 1, z);
    for (float y = -1; y <= 1; y += step) cloud.push(-2, y, z), cloud.push(2, y, z);
  }
  for (float z = 0; z <= 4; z += step) {
    for (float x = -15; x <= 15; x += step) cloud.push(x, -10, z), cloud.push(x, 10, z);
    for (float y = -10; y <= 10; y += step) cloud.push(-15, y, z), cloud.push(15, y, z);
  }
  for (float x = 20; x <= 24; x += step)
    for (float y = 0; y <= 4; y += step) cloud.push(x, y, 6);
  return cloud;
}

std::string plyOf(const Cloud& cloud) {
  std::string text = fmt::format(
      "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\nend_header\n",
      cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i)
    text += fmt::format("{:.3f} {:.3f} {:.3f}\n", cloud.x[i], cloud.y[i], cloud.z[i]);
  return text;
}

TEST(PointMap, IsLookedAtFromItsGroundClearOfWhatStandsOnIt) {
  const auto viewpoints = groundViewpoints(yard(), 4);
  EXPECT_GE(viewpoints.size(), 12u);
  for (const Eigen::Vector3f& p : viewpoints) {
    EXPECT_NEAR(p.z(), 0, 0.01);
    EXPECT_LT(std::abs(p.x()), 14.5F);
    EXPECT_LT(std::abs(p.y()), 9.5F);
    EXPECT_FALSE(std::abs(p.x()) < 2.3F && std::abs(p.y()) < 1.3F) << "on the car: " << p.transpose();
    for (const Eigen::Vector3f& q : viewpoints) EXPECT_TRUE(&p == &q || (p - q).norm() >= 4);
  }
}

TEST(PointMap, IsSeenAsAScannerWouldSeeIt) {
  const MapViews views(yard(), 80);
  const Eigen::Vector3f eye(-6, 0, 1);
  const Cloud view = views.from(eye);
  std::size_t hidden = 0, beyond = 0, left_wall = 0;
  for (std::size_t i = 0; i < view.size(); ++i) {
    const Eigen::Vector3f p = view.point(i) + eye;
    beyond += p.x() > 16 && p.z() < 5;  // behind the wall: nothing but the roof above it
    // Behind the block and lower than the line of sight over it.
    hidden += p.x() > 4 && p.x() < 12 && std::abs(p.y()) < 0.8F && p.z() < 0.5F;
    left_wall += p.x() < -14.9F && p.z() > 1;
  }
  EXPECT_EQ(beyond, 0u);
  EXPECT_EQ(hidden, 0u);
  EXPECT_GT(left_wall, 3000u);
}

TEST(PointMap, BecomesASessionInItsOwnFrame) {
  const fs::path folder = freshFolder();
  std::ofstream(folder / "yard.ply") << plyOf(yard());
  writeMapSession(folder / "yard.ply", folder / "session", {}, context(2), [](std::size_t, std::size_t) {});
  const Session session = Session::open(folder / "session");
  EXPECT_TRUE(session.complete());
  ASSERT_GE(session.keyframes().size(), 12u);
  for (KeyframeId k = 0; k < session.keyframes().size(); ++k) {
    const Cloud cloud_map = transformed(session.cloud(k), session.poses()[k]);
    ASSERT_GT(cloud_map.size(), 5000u);
    EXPECT_NEAR(session.poses()[k].translation().z(), 1.8, 0.01);
    for (std::size_t i = 0; i < cloud_map.size(); i += 97) {
      const Eigen::Vector3f p = cloud_map.point(i).cwiseAbs();
      const bool block = p.x() < 2.02F && p.y() < 1.02F && p.z() < 1.42F;
      const bool ground = p.z() < 0.02F, wall = std::abs(p.x() - 15) < 0.02F || std::abs(p.y() - 10) < 0.02F;
      EXPECT_TRUE(ground || wall || block || p.z() > 5.98F) << p.transpose();
    }
  }
}

TEST(PointMap, ItsSessionsLieBesideTheResultAndTouchNothingElse) {
  const fs::path folder = freshFolder();
  std::ofstream(folder / "yard.ply") << plyOf(yard());
  fs::path made;
  {
    PointMapSessions sessions(folder / "both");
    EXPECT_EQ(sessions.sessionFor(folder, {}, context(), true, nullptr), folder) << "a session stays what it is";
    made = sessions.sessionFor(folder / "yard.ply", {}, context(2), true, nullptr);
    EXPECT_EQ(made.filename(), "yard");
    EXPECT_TRUE(Session::open(made).complete());
  }
  EXPECT_FALSE(fs::exists(made));
  fs::create_directories(folder / "mine.maps");
  std::ofstream(folder / "mine.maps" / "precious.txt") << "kept";
  {
    PointMapSessions sessions(folder / "mine");
    EXPECT_THROW(sessions.sessionFor(folder / "yard.ply", {}, context(), true, nullptr), Error);
  }
  EXPECT_TRUE(fs::exists(folder / "mine.maps" / "precious.txt"));
}

std::string refusalOf(const fs::path& file) {
  try {
    writeMapSession(file, file.string() + ".session", {}, context(), [](std::size_t, std::size_t) {});
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kInput) << error.what();
    return error.what();
  }
  return "";
}

TEST(PointMap, SaysWhatIsWrongWithIt) {
  const fs::path folder = freshFolder();
  Cloud far = yard();
  far.y[7] = 4.1e6F;
  std::ofstream(folder / "utm.ply") << plyOf(far);
  EXPECT_THAT(refusalOf(folder / "utm.ply"), HasSubstr("subtract an offset"));
  std::ofstream(folder / "empty.ply") << plyOf(Cloud());
  EXPECT_THAT(refusalOf(folder / "empty.ply"), HasSubstr("holds no points"));
  Cloud small;
  for (float x = 0; x < 1; x += 0.1F) small.push(x, 0, 0);
  std::ofstream(folder / "small.ply") << plyOf(small);
  EXPECT_THAT(refusalOf(folder / "small.ply"), HasSubstr("no ground in it on which a robot fits"));
  std::ofstream(folder / "cut.ply") << plyOf(yard()).substr(0, 4000);
  EXPECT_THAT(refusalOf(folder / "cut.ply"), HasSubstr("cut.ply"));
}

}  // namespace
}  // namespace scslam::test
