// What every place recogniser promises (place/place_recogniser.h), checked on each that is registered.
#include <cmath>
#include <limits>

#include "place/streets.h"

namespace scslam {
namespace {

using test::keyframeAt, test::streetFrom, test::visit;

class RecogniserConformance : public ::testing::TestWithParam<std::string> {
 protected:
  static std::unique_ptr<PlaceRecogniser> make() { return test::makeRecogniser(GetParam()); }
};

/// Six streets along x, 100 m apart, then the first four of them again, half a metre beside.
std::vector<std::pair<Keyframe, Cloud>> twoLaps() {
  std::vector<std::pair<Keyframe, Cloud>> visits;
  for (KeyframeId id = 0; id < 10; ++id) {
    const unsigned street = id < 6 ? id : id - 6;
    const double aside = id < 6 ? 0 : 0.5;
    visits.emplace_back(keyframeAt(id, 100.0 * id, poseFromYaw(0, {100.0 * street, aside, 0})),
                        streetFrom(poseFromYaw(0, {0, aside, 1.8}), 100 + street, 6));
  }
  return visits;
}

TEST_P(RecogniserConformance, FindsEachPlaceAgainAndSaysWhereItIs) {
  const auto recogniser = make();
  for (const auto& [keyframe, cloud] : twoLaps()) {
    visit(*recogniser, keyframe, cloud);
    const auto candidates = recogniser->query(keyframe.id);
    if (keyframe.id < 6) continue;
    ASSERT_FALSE(candidates.empty()) << keyframe.id;
    EXPECT_EQ(candidates[0].match, keyframe.id - 6);
    EXPECT_THAT(candidates[0].T_match_query, test::IsNear(poseFromYaw(0, {0, 0.5, 0}), 1.2, 3.0));
  }
}

TEST_P(RecogniserConformance, CandidatesAreEarlierDistinctOrderedAndFinite) {
  const auto recogniser = make();
  for (const auto& [keyframe, cloud] : twoLaps()) {
    visit(*recogniser, keyframe, cloud);
    double last = 0;
    for (const PlaceCandidate& candidate : recogniser->query(keyframe.id)) {
      EXPECT_LT(candidate.match, keyframe.id);
      EXPECT_GE(candidate.distance, last);
      EXPECT_TRUE(isRigid(candidate.T_match_query));
      EXPECT_GE(candidate.runner_up, 0);
      last = candidate.distance;
    }
  }
}

TEST_P(RecogniserConformance, ThePlaceItselfIsAtDistanceZero) {
  const auto recogniser = make();
  auto visits = twoLaps();
  visits.resize(6);
  visits.emplace_back(visits[2]);
  visits.back().first.id = 6, visits.back().first.travelled_m = 600;
  for (const auto& [keyframe, cloud] : visits) visit(*recogniser, keyframe, cloud);
  const auto candidates = recogniser->query(6);
  ASSERT_FALSE(candidates.empty());
  EXPECT_EQ(candidates[0].match, 2u);
  EXPECT_NEAR(candidates[0].distance, 0, 1e-5);
  EXPECT_THAT(candidates[0].T_match_query, test::IsNear(Pose::Identity(), 0.01, 0.1));
}

TEST_P(RecogniserConformance, AnEarlierKeyframeMayBeQueriedAgainWithTheSameAnswer) {
  const auto recogniser = make();
  std::vector<std::vector<PlaceCandidate>> online;
  for (const auto& [keyframe, cloud] : twoLaps()) {
    visit(*recogniser, keyframe, cloud);
    online.push_back(recogniser->query(keyframe.id));
  }
  for (KeyframeId k = 0; k < online.size(); ++k) {
    const auto again = recogniser->query(k);
    ASSERT_EQ(again.size(), online[k].size()) << k;
    for (std::size_t i = 0; i < again.size(); ++i) {
      EXPECT_EQ(again[i].match, online[k][i].match);
      EXPECT_EQ(again[i].distance, online[k][i].distance);
      EXPECT_EQ(again[i].T_match_query.matrix(), online[k][i].T_match_query.matrix());
    }
  }
}

TEST_P(RecogniserConformance, AScanOfAnotherSessionFindsWhatAnAddedOneWould) {
  const auto map = make(), grown = make();
  auto visits = twoLaps();
  for (std::size_t k = 0; k < 6; ++k)
    for (const auto* recogniser : {&map, &grown}) visit(**recogniser, visits[k].first, visits[k].second);
  for (std::size_t k = 6; k < visits.size(); ++k) {
    Keyframe visitor = visits[k].first;
    visitor.travelled_m = 1000;  // visitors are never candidates for each other
    visit(*grown, visitor, visits[k].second);
    const auto expected = grown->query(visitor.id);
    visitor.id = 77, visitor.travelled_m = 3;
    const auto found = map->find(visitor, Descriptor(), visits[k].second);
    if (!map->usesScans()) {
      EXPECT_TRUE(found.empty());
      continue;
    }
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found[0].match, k - 6);
    EXPECT_NEAR(found[0].distance, expected[0].distance, 1e-2);  // stored images have fewer digits
    EXPECT_THAT(found[0].T_match_query, test::IsNear(expected[0].T_match_query, 1e-6, 1.0));
  }
}

TEST_P(RecogniserConformance, ADescriptorReadBackGivesTheSameAsTheOneJustMade) {
  const auto live = make(), resumed = make();
  for (const auto& [keyframe, cloud] : twoLaps()) {
    visit(*live, keyframe, cloud);
    resumed->add(keyframe, Descriptor(), live->usesScans() ? cloud : Cloud());  // nothing stored: made from the cloud
    const auto a = live->query(keyframe.id), b = resumed->query(keyframe.id);
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i) EXPECT_EQ(a[i].distance, b[i].distance);
  }
}

TEST_P(RecogniserConformance, UselessCloudsAreHarmless) {
  const auto recogniser = make();
  Cloud one, nans, far;
  one.push(3, 0, 0);
  for (int i = 0; i < 1000; ++i) {
    nans.push(std::numeric_limits<float>::quiet_NaN(), std::numeric_limits<float>::infinity(), 1);
    far.push(1e30f, -1e30f, 1e30f);
  }
  KeyframeId id = 0;
  for (const Cloud& cloud : {Cloud(), one, nans, far, streetFrom(poseFromYaw(0, {0, 0, 1.8}), 1)}) {
    visit(*recogniser, keyframeAt(id, 100.0 * id, poseFromYaw(0, {100.0 * id, 0, 0})), cloud);
    EXPECT_TRUE(recogniser->query(id).empty()) << id;
    ++id;
  }
}

INSTANTIATE_TEST_SUITE_P(All, RecogniserConformance, ::testing::ValuesIn(Registry<PlaceRecogniser>::instance().names()),
                         [](const auto& plugin) { return plugin.param; });

}  // namespace
}  // namespace scslam
