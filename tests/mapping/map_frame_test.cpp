// A map on Earth: every coordinate against geodesy done point by point.
#include "scslam/mapping/map_frame.h"

#include <cstring>

#include "apps/session_of.h"
#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/geodesy.h"
#include "scslam/mapping/map_builder.h"
#include "session/memory_folder.h"
#include "support/support.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const Geodetic kOrigin{48.2, 11.6, 520};
const Pose kT_map_enu = poseFromYaw(0.8, {30, -20, 4});

Geodetic onEarth(const Eigen::Vector3d& p_map) { return LocalEnu(kOrigin).toGeodetic(kT_map_enu.inverse() * p_map); }

/// A drive of 1.2 km with exact fixes; each scan is one point 5 m before the sensor.
Session drive(const fs::path& folder, bool with_fixes = true) {
  SessionParts parts;
  for (int k = 0; k < 61; ++k) parts.optimised.push_back(poseFromYaw(0.02 * k, {20.0 * k, 200 * std::sin(0.1 * k), 1}));
  parts.odometry = parts.optimised;
  parts.cloud_sensor = [](std::size_t) {
    Cloud cloud;
    cloud.push(5, 0, 0);
    return cloud;
  };
  for (std::size_t k = 0; with_fixes && k < parts.optimised.size(); ++k) {
    GnssRecord record;
    record.keyframe = static_cast<KeyframeId>(k);
    const Geodetic g = onEarth(parts.optimised[k].translation());
    record.fix.latitude_deg = g.latitude_deg, record.fix.longitude_deg = g.longitude_deg;
    record.fix.height_m = g.height_m;
    record.fix.covariance_m2 = 1e-4 * Eigen::Matrix3d::Identity();
    parts.gnss.push_back(record);
  }
  return sessionOf(folder, parts);
}

TEST(MapFrame, UtmIsWhatGeodesySaysOfEveryPoint) {
  const Session session = drive(memoryFolder() / "s");
  const MapFrame utm(session, MapFrameKind::kUtm);
  EXPECT_EQ(utm.name(), "epsg:32632");
  for (const Eigen::Vector3d& p : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(1200, -150, 30)}) {
    const Utm expected = toUtm(onEarth(p));
    const Eigen::Vector3d there = utm(p) + utm.offset_m();
    EXPECT_NEAR(there.x(), expected.easting_m, 5e-3);
    EXPECT_NEAR(there.y(), expected.northing_m, 5e-3);
    EXPECT_NEAR(there.z(), onEarth(p).height_m, 5e-3);
    EXPECT_LT(utm(p).head<2>().maxCoeff(), 4000) << "float32 keeps millimetres";
    const Eigen::Vector3d beside = p + Eigen::Vector3d(70, -70, 5);
    EXPECT_LT((utm.around(p) * beside - utm(beside)).norm(), 1e-3);
  }
}

TEST(MapFrame, PosesTurnWithTheGrid) {
  const Session session = drive(memoryFolder() / "s");
  const MapFrame enu(session, MapFrameKind::kEnu), utm(session, MapFrameKind::kUtm);
  const Pose T = poseFromYaw(0.3, {100, 20, 1});
  Pose expected = kT_map_enu.inverse() * T;  // but for the origin, which is the first fix
  expected.translation() =
      LocalEnu(onEarth(session.poses().front().translation())).fromGeodetic(onEarth(T.translation()));
  EXPECT_THAT(enu(T), IsNear(expected, 0.02, 0.01));
  const Utm grid = toUtm(onEarth(T.translation()));
  EXPECT_NEAR(yawOf(utm(T)) - yawOf(enu(T)), grid.convergence_deg * M_PI / 180, 1e-4);
  EXPECT_NEAR((utm(T).linear() * utm(T).linear().transpose() - Eigen::Matrix3d::Identity()).norm(), 0, 1e-9);
}

TEST(MapFrame, ExportsWriteItAndSayHowToReadIt) {
  const fs::path folder = memoryFolder();
  MapOptions options;
  options.frame = MapFrameKind::kUtm, options.voxel_m = 0;
  const Session session = drive(folder / "s");
  const MapSummary summary = exportMap(session, {"ply", "tum"}, options, folder / "map", context());
  EXPECT_EQ(summary.files.back(), folder / "map" / "georeference.yaml");
  const std::string text = readFile(summary.files.back());
  EXPECT_THAT(text, HasSubstr("epsg: 32632\noffset_m: [693000, 5341000, 0]"));
  EXPECT_THAT(text, HasSubstr("T_enu_map"));
  const std::string ply = readFile(folder / "map" / "map.ply");
  EXPECT_THAT(ply, HasSubstr("frame epsg:32632"));
  float last[4];
  std::memcpy(last, ply.data() + ply.size() - 16, 16);
  const Utm expected = toUtm(onEarth(session.poses().back() * Eigen::Vector3d(5, 0, 0)));
  EXPECT_NEAR(693000.0 + last[0], expected.easting_m, 0.01);
  EXPECT_NEAR(5341000.0 + last[1], expected.northing_m, 0.01);
  const Trajectory written = readTrajectory(folder / "map" / "trajectory.tum");
  const Utm start = toUtm(onEarth(session.poses().front().translation()));
  EXPECT_NEAR(written.poses.front().T.translation().x() + 693000, start.easting_m, 0.01);
}

TEST(MapFrame, SessionsWithoutFixesAreRefusedBeforeAnythingIsWritten) {
  const fs::path folder = memoryFolder();
  MapOptions options;
  options.frame = MapFrameKind::kEnu;
  try {
    exportMap(drive(folder / "s", false), {"ply"}, options, folder / "map", context());
    ADD_FAILURE() << "not refused";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("not placed on Earth"));
  }
  EXPECT_FALSE(fs::exists(folder / "map"));
}

}  // namespace
}  // namespace scslam::test
