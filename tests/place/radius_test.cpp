#include "place/streets.h"

namespace scslam {
namespace {

using test::makeRecogniser;

/// Out 60 m along x and back, `aside_m` to the left, a keyframe every metre, each step uncertain by sigma_m.
std::vector<Keyframe> outAndBack(double aside_m, double sigma_m = 0) {
  std::vector<Keyframe> keyframes;
  for (int i = 0; i <= 120; ++i) {
    const bool out = i <= 60;
    Keyframe keyframe = test::keyframeAt(static_cast<KeyframeId>(i), i,
                                         poseFromYaw(out ? 0 : M_PI, {out ? i : 120.0 - i, out ? 0 : aside_m, 0}));
    keyframe.step_covariance.diagonal().head<3>().setConstant(sigma_m * sigma_m);
    keyframes.push_back(keyframe);
  }
  return keyframes;
}

std::unique_ptr<PlaceRecogniser> fed(const std::vector<Keyframe>& keyframes, const std::string& set) {
  auto recogniser = makeRecogniser("radius", set);
  for (const Keyframe& keyframe : keyframes) recogniser->add(keyframe, Descriptor());
  return recogniser;
}

TEST(Radius, ReturnsTheNearestEarlierPlaceAndWhereItIs) {
  const auto keyframes = outAndBack(3);
  const auto recogniser = fed(keyframes, "{radius_m: 5, sigmas: 0}");
  const auto candidates = recogniser->query(100);
  ASSERT_FALSE(candidates.empty());
  EXPECT_EQ(candidates[0].match, 20u);
  EXPECT_NEAR(candidates[0].distance, 3, 1e-9);
  EXPECT_THAT(candidates[0].T_match_query, test::IsNear(poseFromYaw(M_PI, {0, 3, 0}), 1e-9, 1e-6));
  EXPECT_TRUE(fed(outAndBack(6), "{radius_m: 5, sigmas: 0}")->query(100).empty());
}

TEST(Radius, WhatWasJustPassedIsNoLoop) {
  const auto recogniser = fed(outAndBack(3), "{radius_m: 5, sigmas: 0, min_travel_m: 15}");
  EXPECT_TRUE(recogniser->query(64).empty()) << "8 m of path";
  EXPECT_FALSE(recogniser->query(68).empty()) << "16 m of path";
}

TEST(Radius, TheDriftOfThePathInBetweenWidensIt) {
  // 80 steps of 0.1 m: 0.89 m along any axis; 6 m apart is within 5 m + 2 sigma.
  const std::string set = "{radius_m: 5, sigmas: 2, sigma_per_m: 0}";
  EXPECT_TRUE(fed(outAndBack(6.0, 0.0), set)->query(100).empty());
  EXPECT_FALSE(fed(outAndBack(6.0, 0.1), set)->query(100).empty());
  EXPECT_TRUE(fed(outAndBack(7.0, 0.1), set)->query(100).empty()) << "2 sigma are 1.79 m at most";
  EXPECT_FALSE(fed(outAndBack(6.0, 0.0), "{radius_m: 5, sigmas: 2, sigma_per_m: 0.01}")->query(100).empty());
  EXPECT_TRUE(fed(outAndBack(6.0, 9.0), "{radius_m: 5, sigmas: 2, max_reach_m: 5.5}")->query(100).empty());
}

TEST(Radius, AsksTheMapNotOdometryOncePosesAreGiven) {
  const auto keyframes = outAndBack(30);  // odometry believes 30 m, the map knows 2 m
  const auto recogniser = fed(keyframes, "{radius_m: 5, sigmas: 0}");
  EXPECT_TRUE(recogniser->query(100).empty());
  std::vector<Pose> T_map_base;
  for (const Keyframe& keyframe : outAndBack(2)) T_map_base.push_back(keyframe.T_odom_base);
  recogniser->setPoses(T_map_base);
  ASSERT_FALSE(recogniser->query(100).empty());
  EXPECT_NEAR(recogniser->query(100)[0].distance, 2, 1e-9);
  T_map_base.resize(100);  // keyframe 100 came later: placed by odometry from the one before
  recogniser->setPoses(T_map_base);
  EXPECT_NEAR(recogniser->query(100)[0].distance, 2, 1e-9);
}

}  // namespace
}  // namespace scslam
