#include <cmath>
#include <random>

#include "scslam/core/gravity.h"
#include "scslam/place/place_recogniser.h"
#include "support/support.h"

namespace scslam {
namespace {

std::unique_ptr<PlaceRecogniser> scanContext(const std::string& set = "") {
  auto params = Registry<PlaceRecogniser>::instance().find("scan_context").defaults();
  if (!set.empty()) loadYaml(*params, set, "test");
  return Registry<PlaceRecogniser>::instance().create("scan_context", *params, test::context());
}

/// A street of random boxes seen from `T_world_base`: surfaces of towers around, and the ground.
Cloud streetFrom(const Pose& T_world_base, unsigned seed) {
  std::mt19937 random(seed);
  const auto uniform = [&random](double lo, double hi) {
    return lo + (hi - lo) * static_cast<double>(random()) / 4294967296.0;
  };
  Cloud world;
  for (int tower = 0; tower < 60; ++tower) {
    const double cx = uniform(-60, 60), cy = uniform(-60, 60), top = uniform(1, 15), half = uniform(0.3, 4);
    for (double z = 0; z < top; z += 0.5)
      for (double s = -half; s <= half; s += 0.4)
        for (const double side : {-half, half}) {
          world.push(static_cast<float>(cx + s), static_cast<float>(cy + side), static_cast<float>(z));
          world.push(static_cast<float>(cx + side), static_cast<float>(cy + s), static_cast<float>(z));
        }
  }
  for (double x = -60; x <= 60; x += 1.5)
    for (double y = -60; y <= 60; y += 1.5) world.push(static_cast<float>(x), static_cast<float>(y), 0);
  return transformed(world, T_world_base.inverse());
}

Keyframe keyframeAt(KeyframeId id, double travelled, const Pose& T_odom_base = Pose::Identity()) {
  Keyframe keyframe;
  keyframe.id = id, keyframe.travelled_m = travelled, keyframe.T_odom_base = T_odom_base;
  return keyframe;
}

/// Places `seeds` of different streets 100 m apart, then the query; returns the candidates for the query.
std::vector<PlaceCandidate> recognise(PlaceRecogniser& recogniser, const Cloud& query,
                                      const Pose& T_odom_query = Pose::Identity()) {
  KeyframeId id = 0;
  for (const unsigned seed : {11u, 12u, 13u, 14u, 15u}) {
    const Keyframe keyframe = keyframeAt(id, 100.0 * id);
    recogniser.add(keyframe, recogniser.describe(keyframe, streetFrom(poseFromYaw(0, {0, 0, 1.8}), seed)));
    ++id;
  }
  const Keyframe keyframe = keyframeAt(id, 100.0 * id, T_odom_query);
  recogniser.add(keyframe, recogniser.describe(keyframe, query));
  return recogniser.query(id);
}

TEST(ScanContext, FindsTheSamePlaceForEveryHeadingAndKeepsTheYaw) {
  for (const double yaw_deg : {0.0, 30.0, 91.0, 180.0, 243.5, 357.0}) {
    const auto recogniser = scanContext();
    const auto candidates = recognise(*recogniser, streetFrom(poseFromYaw(yaw_deg * M_PI / 180, {0, 0, 1.8}), 13));
    ASSERT_FALSE(candidates.empty()) << yaw_deg;
    EXPECT_EQ(candidates[0].match, 2u);
    EXPECT_LT(rotationAngle(poseFromYaw(yaw_deg * M_PI / 180, {0, 0, 0}).inverse() * candidates[0].T_match_query) *
                  180 / M_PI,
              3.0)
        << yaw_deg;
  }
}

TEST(ScanContext, RecognisesThePlaceFromTwoMetresAside) {
  const auto recogniser = scanContext();
  const auto candidates = recognise(*recogniser, streetFrom(poseFromYaw(M_PI, {1, 1.7, 1.8}), 14));
  ASSERT_FALSE(candidates.empty());
  EXPECT_EQ(candidates[0].match, 3u);
}

TEST(ScanContext, AForeignPlaceIsFartherThanTheSamePlace) {
  const auto recogniser = scanContext("max_distance: 1.0");
  const auto same = recognise(*recogniser, streetFrom(poseFromYaw(1, {0.5, 0.5, 1.8}), 12));
  const auto other = scanContext("max_distance: 1.0");
  const auto foreign = recognise(*other, streetFrom(poseFromYaw(1, {0.5, 0.5, 1.8}), 99));
  ASSERT_FALSE(same.empty());
  ASSERT_FALSE(foreign.empty());
  EXPECT_LT(same[0].distance, 0.6 * foreign[0].distance);
}

TEST(ScanContext, TiltIsRemovedWithTheRollAndPitchOfOdometry) {
  Pose tilt = Pose::Identity();
  tilt.linear() = so3Exp({0.12, -0.09, 0});
  const Pose T_world_base = poseFromYaw(0.7, {0, 0, 1.8}) * tilt;
  const auto levelled = scanContext();
  const auto candidates = recognise(*levelled, streetFrom(T_world_base, 11), poseFromYaw(0.7, {0, 0, 0}) * tilt);
  ASSERT_FALSE(candidates.empty());
  EXPECT_EQ(candidates[0].match, 0u);
  // The guess carries the tilt: it maps the tilted scan onto the upright one.
  EXPECT_LT(rotationAngle(T_world_base.inverse() * Pose(Eigen::Isometry3d(candidates[0].T_match_query.linear()))) *
                180 / M_PI,
            3.5);
  const auto ignorant = scanContext();
  const auto tilted = recognise(*ignorant, streetFrom(T_world_base, 11));
  EXPECT_TRUE(tilted.empty() || candidates[0].distance < 0.7 * tilted[0].distance);
}

TEST(ScanContext, WhatWasJustPassedIsNoLoop) {
  const auto recogniser = scanContext("min_travel_m: 15");
  const Cloud cloud = streetFrom(poseFromYaw(0, {0, 0, 1.8}), 5);
  for (KeyframeId id = 0; id < 4; ++id) {
    const Keyframe keyframe = keyframeAt(id, 7.0 * id);
    recogniser->add(keyframe, recogniser->describe(keyframe, cloud));
  }
  EXPECT_TRUE(recogniser->query(1).empty());
  EXPECT_TRUE(recogniser->query(2).empty()) << "14 m";
  const auto candidates = recogniser->query(3);
  ASSERT_EQ(candidates.size(), 1u) << "21 m: the first; the second is only 14 m away";
  EXPECT_EQ(candidates[0].match, 0u);
}

TEST(ScanContext, NearIdenticalNeighboursCountAsOnePlace) {
  const auto recogniser = scanContext("{distinct_travel_m: 10, candidates: 3}");
  const Cloud cloud = streetFrom(poseFromYaw(0, {0, 0, 1.8}), 5);
  const std::vector<double> travelled = {0, 2, 4, 50, 52, 100, 200};
  for (KeyframeId id = 0; id < travelled.size(); ++id) {
    const Keyframe keyframe = keyframeAt(id, travelled[id]);
    recogniser->add(keyframe, recogniser->describe(keyframe, cloud));
  }
  std::vector<KeyframeId> matches;
  for (const auto& candidate : recogniser->query(6)) matches.push_back(candidate.match);
  EXPECT_EQ(matches, (std::vector<KeyframeId>{0, 3, 5}));
}

TEST(ScanContext, EmptyAndTinyCloudsAreHarmless) {
  const auto recogniser = scanContext();
  Cloud one;
  one.push(3, 0, 0);
  for (KeyframeId id = 0; id < 3; ++id) {
    const Keyframe keyframe = keyframeAt(id, 100.0 * id);
    recogniser->add(keyframe, recogniser->describe(keyframe, id == 1 ? one : Cloud()));
    EXPECT_TRUE(recogniser->query(id).empty());
  }
}

TEST(ScanContext, ManyPlacesNeedNoRebuildAndTheRightOneIsFound) {
  const auto recogniser = scanContext();
  std::mt19937 random(1);
  std::vector<Descriptor> images;
  for (KeyframeId id = 0; id < 700; ++id) {
    Descriptor image(20, 60);
    for (float& value : image.reshaped()) value = static_cast<float>(random() % 1000) / 100;
    images.push_back(image);
    recogniser->add(keyframeAt(id, 20.0 * id), image);
  }
  Descriptor turned(20, 60);
  for (int s = 0; s < 60; ++s) turned.col((s + 17) % 60) = images[431].col(s);
  recogniser->add(keyframeAt(700, 20.0 * 700), turned);
  const auto candidates = recogniser->query(700);
  ASSERT_FALSE(candidates.empty());
  EXPECT_EQ(candidates[0].match, 431u);
  EXPECT_NEAR(candidates[0].distance, 0, 1e-5);
  EXPECT_NEAR(std::remainder(yawOf(candidates[0].T_match_query) + 17 * 6 * M_PI / 180, 2 * M_PI), 0, 0.02);
}

TEST(Gravity, GroundIsFoundBelowTheSensorWhateverItsHeight) {
  for (const double height : {0.4, 1.8, 3.0}) {
    const Cloud cloud = streetFrom(poseFromYaw(0, {0, 0, height}), 3);
    EXPECT_NEAR(groundHeight(cloud), -height, 0.06);
  }
  EXPECT_EQ(groundHeight(Cloud()), 0);
}

}  // namespace
}  // namespace scslam
