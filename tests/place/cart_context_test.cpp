#include "place/streets.h"
#include "scslam/place/context_image.h"

namespace scslam {
namespace {

using test::IsNear, test::keyframeAt, test::streetFrom, test::visit;

constexpr double kRoadHalf = 9;
const Pose kMatch = poseFromYaw(0, {0, -3.5, 1.8});

/// Eight other streets and the one driven before, then the query; the best candidate is expected to be `3`.
std::vector<PlaceCandidate> recognise(PlaceRecogniser& recogniser, const Pose& T_world_query) {
  for (KeyframeId id = 0; id < 8; ++id)
    visit(recogniser, keyframeAt(id, 100.0 * id), streetFrom(kMatch, id == 3 ? 50 : 60 + id, kRoadHalf));
  visit(recogniser, keyframeAt(8, 800), streetFrom(T_world_query, 50, kRoadHalf));
  return recogniser.query(8);
}

TEST(CartContext, TheImageShiftsByWholeColumnsWhenTheLaneChanges) {
  Cloud cloud;
  for (int i = 0; i < 300; ++i)
    cloud.push(static_cast<float>(5 * (i % 30) - 75 + 2.5), static_cast<float>(2 * ((i + i / 30 * 2) % 21) - 20 + 1),
               1.0f + static_cast<float>(i % 9));
  const Descriptor image = cartContext(cloud, Upright(), CartGrid());
  const Descriptor shifted = cartContext(transformed(cloud, poseFromYaw(0, {0, -4, 0})), Upright(), CartGrid());
  ASSERT_GT((image.array() > 0).count(), 150);
  EXPECT_LT((shifted.leftCols(38) - image.rightCols(38)).cwiseAbs().maxCoeff(), 1e-5);
}

TEST(CartContext, FindsAReverseRevisitSevenMetresAsideThatThePolarContextMisses) {
  const Pose T_world_query = poseFromYaw(M_PI, {0.5, 3.5, 1.8});
  const auto cart = test::makeRecogniser("cart_context"),
             polar = test::makeRecogniser("scan_context", "lateral_reach_m: 0");
  const auto found = recognise(*cart, T_world_query), missed = recognise(*polar, T_world_query);
  ASSERT_FALSE(found.empty());
  EXPECT_EQ(found[0].match, 3u);
  EXPECT_THAT(found[0].T_match_query, IsNear(kMatch.inverse() * T_world_query, 1.5, 0.1));
  EXPECT_TRUE(missed.empty() || missed[0].match != 3u);
}

TEST(CartContext, KeepsTheOffsetOfALaneChangeInTheSameDirection) {
  for (const double left_m : {0.0, 3.5, 7.0}) {
    const Pose T_world_query = poseFromYaw(0, {0, -3.5 + left_m, 1.8});
    const auto candidates = recognise(*test::makeRecogniser("cart_context"), T_world_query);
    ASSERT_FALSE(candidates.empty()) << left_m;
    EXPECT_EQ(candidates[0].match, 3u) << left_m;
    EXPECT_THAT(candidates[0].T_match_query, IsNear(kMatch.inverse() * T_world_query, 0.8, 0.1)) << left_m;
  }
}

TEST(CartContext, RefusesAGridThatLeavesNoRoomForTheShift) {
  EXPECT_THROW(test::makeRecogniser("cart_context", "{columns: 60, max_offset_m: 40}"), Error);
}

}  // namespace
}  // namespace scslam
