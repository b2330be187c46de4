// Hand-made distances against figures worked out by hand.
#include "scslam/apps/precision_recall.h"
#include "support/support.h"

namespace scslam {
namespace {

using ::testing::DoubleEq;
using ::testing::Optional;

JudgedQuery found(double distance) { return {true, distance, true, true}; }
JudgedQuery wrongPlace(double distance) { return {true, distance, false, false}; }
JudgedQuery noRevisit(double distance) { return {false, distance, false, false}; }

TEST(PrecisionRecall, FollowsTheThresholdStepByStep) {
  const auto f = precisionRecall({noRevisit(0.3), found(0.1), wrongPlace(0.4), found(0.5), found(0.2)});
  EXPECT_EQ(f.queries, 5u);
  EXPECT_EQ(f.revisits, 4u);
  ASSERT_EQ(f.curve.size(), 5u);
  const double precision[] = {1, 1, 2.0 / 3, 2.0 / 4, 3.0 / 5}, recall[] = {0.25, 0.5, 0.5, 0.5, 0.75};
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_DOUBLE_EQ(f.curve[i].threshold, 0.1 * static_cast<double>(i + 1));
    EXPECT_DOUBLE_EQ(f.curve[i].precision, precision[i]) << i;
    EXPECT_DOUBLE_EQ(f.curve[i].recall, recall[i]) << i;
  }
  EXPECT_THAT(f.auc, Optional(DoubleEq(0.25 + 0.25 + 0.25 * 3.0 / 5)));
  EXPECT_THAT(f.f1_max, Optional(DoubleEq(2 * 0.5 / 1.5))) << "2 P R / (P + R) at P = 1, R = 1/2 and at 3/5, 3/4";
  EXPECT_THAT(f.f1_threshold, Optional(DoubleEq(0.2)));
  EXPECT_THAT(f.recall_at_1, Optional(DoubleEq(0.75)));
  EXPECT_THAT(f.recall_full, Optional(DoubleEq(0.5)));
  EXPECT_THAT(f.full_precision_at, Optional(DoubleEq(0.2)));
  EXPECT_THAT(f.nearest_false, Optional(DoubleEq(0.3)));
}

TEST(PrecisionRecall, EqualDistancesAreTakenTogether) {
  const auto f = precisionRecall({found(0.1), found(0.2), noRevisit(0.2), found(0.3)});
  ASSERT_EQ(f.curve.size(), 3u);
  EXPECT_DOUBLE_EQ(f.curve[1].precision, 2.0 / 3);
  EXPECT_THAT(f.recall_full, Optional(DoubleEq(1.0 / 3))) << "no threshold separates the two at 0.2";
}

TEST(PrecisionRecall, APerfectRecogniserHasOneEverywhere) {
  const auto f = precisionRecall({found(0.1), found(0.2), noRevisit(0.9), {false, std::nullopt, false, false}});
  for (const auto& figure : {f.auc, f.f1_max, f.recall_at_1, f.recall_at_5, f.recall_full})
    EXPECT_THAT(figure, Optional(DoubleEq(1)));
  EXPECT_THAT(f.f1_threshold, Optional(DoubleEq(0.2)));
}

TEST(PrecisionRecall, ARevisitWithoutCandidateIsMissedAndOneOfFiveCountsForFive) {
  const auto f = precisionRecall({found(0.1), {true, std::nullopt, false, false}, {true, 0.2, false, true}});
  EXPECT_THAT(f.recall_at_1, Optional(DoubleEq(1.0 / 3)));
  EXPECT_THAT(f.recall_at_5, Optional(DoubleEq(2.0 / 3)));
}

TEST(PrecisionRecall, AFalseBestOneLeavesNoRecallAtFullPrecision) {
  const auto f = precisionRecall({noRevisit(0.1), found(0.2)});
  EXPECT_THAT(f.recall_full, Optional(DoubleEq(0)));
  EXPECT_FALSE(f.full_precision_at);
  EXPECT_THAT(f.auc, Optional(DoubleEq(0.5)));
}

TEST(PrecisionRecall, NothingToCountGivesNoFigures) {
  for (const auto& queries : {std::vector<JudgedQuery>{}, {noRevisit(0.1), noRevisit(0.2)}}) {
    const auto f = precisionRecall(queries);
    EXPECT_EQ(f.nearest_false.has_value(), !queries.empty());
    EXPECT_FALSE(f.auc || f.f1_max || f.recall_at_1 || f.recall_at_5 || f.recall_full);
  }
}

}  // namespace
}  // namespace scslam
