#include <cmath>
#include <random>

#include "place/streets.h"
#include "scslam/core/gravity.h"
#include "scslam/place/context_image.h"

namespace scslam {
namespace {

using test::frontOf, test::IsNear, test::keyframeAt, test::streetFrom, test::visit;

std::unique_ptr<PlaceRecogniser> scanContext(const std::string& set = "") {
  return test::makeRecogniser("scan_context", set);
}

/// Places `seeds` of different streets 100 m apart, then the query; returns the candidates for the query.
std::vector<PlaceCandidate> recognise(PlaceRecogniser& recogniser, const Cloud& query,
                                      const Pose& T_odom_query = Pose::Identity()) {
  KeyframeId id = 0;
  for (const unsigned seed : {11u, 12u, 13u, 14u, 15u}) {
    const Keyframe keyframe = keyframeAt(id, 100.0 * id);
    visit(recogniser, keyframe, streetFrom(poseFromYaw(0, {0, 0, 1.8}), seed));
    ++id;
  }
  const Keyframe keyframe = keyframeAt(id, 100.0 * id, T_odom_query);
  visit(recogniser, keyframe, query);
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
    visit(*recogniser, keyframe, cloud);
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
    visit(*recogniser, keyframe, cloud);
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
    visit(*recogniser, keyframe, id == 1 ? one : Cloud());
    EXPECT_TRUE(recogniser->query(id).empty());
  }
}

TEST(ScanContext, ManyPlacesNeedNoRebuildAndTheRightOneIsFound) {
  const auto recogniser = scanContext("lateral_reach_m: 0");
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

TEST(ScanContext, TheImageShiftsByWholeColumnsWhenTheRobotTurnsByWholeSectors) {
  Cloud cloud;  // in the middle of bins, so that rounding cannot move a point
  for (int i = 0; i < 300; ++i) {
    const double azimuth = (i % 60 + 0.5) * 6 * M_PI / 180, range = 4 * ((i + i / 60 * 7) % 20 + 0.5);
    cloud.push(static_cast<float>(range * std::cos(azimuth)), static_cast<float>(range * std::sin(azimuth)),
               static_cast<float>(i % 11 + 1));
  }
  const Descriptor image = polarContext(cloud, Upright(), PolarGrid());
  ASSERT_GT((image.array() > 0).count(), 200);
  for (const int sectors : {1, 13, 30, 59}) {
    const Cloud turned = transformed(cloud, poseFromYaw(-sectors * 6 * M_PI / 180, {0, 0, 0}));
    const Descriptor other = polarContext(turned, Upright(), PolarGrid());
    for (int s = 0; s < 60; ++s)
      EXPECT_LT((other.col(s) - image.col((s + sectors) % 60)).cwiseAbs().maxCoeff(), 1e-4) << sectors << ", " << s;
  }
}

TEST(ScanContext, StartsTheRegistrationAtTheOffsetAcrossTheStreet) {
  for (const double left_m : {-3.5, 0.0, 2.0, 3.5})
    for (const double yaw : {0.0, M_PI}) {
      const auto recogniser = scanContext();
      const Pose T_world_match = poseFromYaw(0, {0, 0, 1.8}), T_world_query = poseFromYaw(yaw, {0, left_m, 1.8});
      visit(*recogniser, keyframeAt(0, 0), streetFrom(T_world_match, 12, 6));
      visit(*recogniser, keyframeAt(1, 100), streetFrom(T_world_query, 12, 6));
      const auto candidates = recogniser->query(1);
      ASSERT_FALSE(candidates.empty()) << left_m;
      EXPECT_THAT(candidates[0].T_match_query, IsNear(T_world_match.inverse() * T_world_query, 1.1, 3.0)) << left_m;
    }
}

TEST(ScanContext, WithoutTheCloudTheShiftedCopiesComeFromTheDescriptor) {
  const auto distance = [](const std::string& set) {
    const auto recogniser = scanContext(set);
    for (KeyframeId id = 0; id < 2; ++id) {
      const Keyframe keyframe = keyframeAt(id, 100.0 * id);
      recogniser->add(keyframe, recogniser->describe(keyframe, streetFrom(poseFromYaw(0, {0, 4.0 * id, 1.8}), 21)));
    }
    const auto candidates = recogniser->query(1);
    return candidates.empty() ? 1.0 : candidates[0].distance;
  };
  EXPECT_LT(distance("{max_distance: 1}"), 0.95 * distance("{max_distance: 1, lateral_reach_m: 0}"));
}

TEST(ScanContext, ComparesOnlyWhatBothScansSaw) {
  for (const double half_deg : {45.0, 90.0, 145.0}) {
    const auto recogniser = scanContext("max_distance: 1");
    const auto candidates = recognise(*recogniser, frontOf(streetFrom(poseFromYaw(1, {0, 0, 1.8}), 13), half_deg));
    ASSERT_FALSE(candidates.empty());
    EXPECT_EQ(candidates[0].match, 2u) << half_deg;
    EXPECT_LT(candidates[0].distance, 0.15) << half_deg;
    EXPECT_NEAR(yawOf(candidates[0].T_match_query), 1, 0.06) << half_deg;
  }
}

TEST(ScanContext, TheRunnerUpIsTheNextPlaceAndTheRatioTestRefusesTwins) {
  const auto twoAlike = [](const std::string& set, unsigned second) {
    const auto recogniser = scanContext(set);
    const Cloud cloud = streetFrom(poseFromYaw(0, {0, 0, 1.8}), 5);
    visit(*recogniser, keyframeAt(0, 0), streetFrom(poseFromYaw(0, {0.5, 0, 1.8}), 5));
    visit(*recogniser, keyframeAt(1, 100), streetFrom(poseFromYaw(0, {0.5, 0.2, 1.8}), second));
    visit(*recogniser, keyframeAt(2, 200), cloud);
    return recogniser->query(2);
  };
  const auto alone = twoAlike("{max_distance: 1, max_ratio: 0.7}", 77);
  ASSERT_EQ(alone.size(), 1u) << "the other one is farther than its runner-up";
  EXPECT_EQ(alone[0].match, 0u);
  EXPECT_GT(alone[0].runner_up, 2 * alone[0].distance);
  EXPECT_TRUE(twoAlike("{max_distance: 1, max_ratio: 0.7}", 5).empty());
  EXPECT_EQ(twoAlike("{max_distance: 1}", 5).size(), 2u);
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
