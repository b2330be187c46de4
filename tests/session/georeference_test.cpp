#include "scslam/session/georeference.h"

#include "support/support.h"

namespace scslam {
namespace {

const Geodetic kOrigin{48.2, 11.6, 520};

struct Drive {
  Pose T_map_enu = poseFromYaw(0.8, {30, -20, 4});
  std::vector<Pose> poses;
  std::vector<GnssRecord> gnss;
  explicit Drive(double length_m) {
    const LocalEnu enu(kOrigin);
    for (int k = 0; k < 60; ++k) {
      const double s = length_m * k / 60;
      poses.push_back(poseFromYaw(0.02 * k, {s, 0.3 * s * std::sin(0.1 * k), 1}));
      GnssRecord record;
      record.keyframe = static_cast<KeyframeId>(k);
      record.antenna_in_keyframe_m = {0.4, -0.2, 1.8};
      const Geodetic g = enu.toGeodetic(T_map_enu.inverse() * (poses.back() * record.antenna_in_keyframe_m));
      record.fix.latitude_deg = g.latitude_deg, record.fix.longitude_deg = g.longitude_deg;
      record.fix.height_m = g.height_m;
      gnss.push_back(record);
    }
  }
};

TEST(Georeference, FindsHeadingAndShiftDespiteWildFixes) {
  Drive drive(120);
  for (const std::size_t k : {7u, 20u, 21u, 55u}) drive.gnss[k].fix.latitude_deg += 1e-3;  // 110 m
  const auto found = georeference(drive.gnss, drive.poses);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->fixes, 56u);
  EXPECT_LT(found->rms_m, 1e-3);
  for (const Eigen::Vector3d& p_map : {Eigen::Vector3d(0, 0, 0), Eigen::Vector3d(100, 50, 2)}) {
    const Geodetic g = found->toGeodetic(p_map);
    const Eigen::Vector3d p_enu = LocalEnu(kOrigin).fromGeodetic(g);
    EXPECT_LT((drive.T_map_enu * p_enu - p_map).norm(), 0.02);
  }
}

TEST(Georeference, AskForEnoughFixesAndEnoughWay) {
  const Drive standing(5), drive(120);
  EXPECT_FALSE(georeference(standing.gnss, standing.poses));
  EXPECT_FALSE(georeference({drive.gnss.begin(), drive.gnss.begin() + 9}, drive.poses));
  EXPECT_FALSE(georeference({}, {}));
}

TEST(Georeference, IsWrittenWithTheTransformAndTheUtmZone) {
  const Drive drive(120);
  const std::string text = formatGeoreference(*georeference(drive.gnss, drive.poses));
  EXPECT_THAT(text, ::testing::HasSubstr("epsg: 32632"));
  EXPECT_THAT(text, ::testing::HasSubstr("yaw_deg: -45.83"));
}

}  // namespace
}  // namespace scslam
