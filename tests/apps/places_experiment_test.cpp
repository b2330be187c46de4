// A recogniser that answers as it is told, so that every figure is known beforehand.
#include <nlohmann/json.hpp>

#include "scslam/apps/place_recognition.h"
#include "scslam/view/curve_svg.h"
#include "support/support.h"

namespace scslam {
namespace {

using ::testing::DoubleEq;
using ::testing::HasSubstr;
using ::testing::Optional;
using ::testing::ThrowsMessage;

/// What the next query() of each keyframe answers.
std::map<KeyframeId, std::vector<PlaceCandidate>> answers;

class Told : public PlaceRecogniser {
 public:
  struct Params : ParamSetOf<Params> {
    double max_distance = 0.1, min_travel_m = 3;
    int candidates = 1;
    std::vector<double> weights;
    void describe(ParamVisitor& v) override {
      v.field("max_distance", max_distance, "threshold", 0, 7);
      v.field("min_travel_m", min_travel_m, "way [m]", 0, 100);
      v.field("candidates", candidates, "so many", 1, 9);
      v.field("weights", weights, "a list");
    }
  };
  Told(const Params&, const PluginContext&) {}
  Descriptor describe(const Keyframe&, const Cloud&) const override { return Descriptor::Zero(2, 3); }
  void add(const Keyframe&, const Descriptor&, const Cloud&) override {}
  std::vector<PlaceCandidate> query(KeyframeId k) const override { return answers[k]; }
};

/// Registered for these tests only: not by SCSLAM_REGISTER, which would show up in everybody's lists.
const PlaceVariant kTold{"told", "told", std::make_shared<Told::Params>()};

class Places : public ::testing::Test {
 protected:
  Places() {
    answers.clear();
    Registry<PlaceRecogniser>::instance().add(
        {"told", "answers as it is told", [] { return std::make_unique<Told::Params>(); },
         [](const ParamSet& p, const PluginContext& c) -> std::unique_ptr<PlaceRecogniser> {
           return std::make_unique<Told>(dynamic_cast<const Told::Params&>(p), c);
         }});
  }

  /// 20 keyframes 2 m apart along x, then 20 back to the start beside them, turned by 180 degrees.
  PlaceFigures thereAndBack(double aside_m, const PlaceOptions& options = {}) {
    PlaceExperiment experiment({kTold}, options, test::context());
    for (std::size_t k = 0; k < 40; ++k) {
      const bool back = k >= 20;
      const double x = 2.0 * static_cast<double>(back ? 39 - k : k);
      Keyframe keyframe;
      keyframe.id = static_cast<KeyframeId>(k);
      keyframe.travelled_m = 2.0 * static_cast<double>(k);
      experiment.add(keyframe, Cloud(), poseFromYaw(back ? M_PI : 0, {x, back ? aside_m : 0, 0}));
    }
    return experiment.figures().front();
  }
  /// Each keyframe of the way back names its counterpart, at the distance given.
  static void answerAll(double distance) {
    for (KeyframeId k = 20; k < 40; ++k) answers[k] = {{39 - k, distance, Pose::Identity(), 0}};
  }
};

const SplitCell& cellOf(const PlaceFigures& f, int heading, double from_m, double to_m) {
  for (const SplitCell& cell : f.split)
    if (cell.heading_deg == heading && cell.from_m == from_m && std::abs(cell.to_m - to_m) < 1e-6) return cell;
  throw std::runtime_error("no such cell");
}

TEST_F(Places, CountsRevisitsWithEnoughWayBetweenAndFindsThem) {
  answerAll(0.2);
  const PlaceFigures f = thereAndBack(1.5);
  // Keyframe k returns to 39 - k after 2 (2 k - 39) m: 15 m are reached from k = 24 on. Before that the nearest place
  // with 15 m in between is too far away, save one row further out, within 3 m: sqrt(2^2 + 1.5^2) = 2.5 m at k = 23.
  EXPECT_EQ(f.figures.revisits, 17u);
  EXPECT_THAT(f.figures.recall_at_1, Optional(DoubleEq(16.0 / 17)));
}

TEST_F(Places, WrongAnswersLowerPrecisionAndOneOfFiveStillCounts) {
  answerAll(0.2);
  answers[30] = {{0, 0.1, Pose::Identity(), 0}, {9, 0.15, Pose::Identity(), 0}};
  const PlaceFigures f = thereAndBack(1.5);
  EXPECT_THAT(f.figures.recall_at_1, Optional(DoubleEq(15.0 / 17)));
  EXPECT_THAT(f.figures.recall_at_5, Optional(DoubleEq(16.0 / 17)));
  EXPECT_THAT(f.figures.recall_full, Optional(DoubleEq(0)));
}

TEST_F(Places, SplitsByHeadingAndLateralOffset) {
  answerAll(0.2);
  const PlaceFigures f = thereAndBack(4);
  EXPECT_EQ(f.figures.revisits, 0u) << "4 m is not within 3 m";
  // Within the 8 m of the split: now keyframes 22 and 23, too, are near enough to one with 15 m in between.
  EXPECT_EQ(cellOf(f, 180, 3, 5).revisits, 18u);
  EXPECT_THAT(cellOf(f, 180, 3, 5).recall_at_1, Optional(DoubleEq(16.0 / 18)));
  EXPECT_EQ(cellOf(f, 180, 1, 3).revisits, 0u);
  EXPECT_EQ(cellOf(f, 0, 0, 8).revisits, 0u);
  EXPECT_EQ(cellOf(f, -1, 0, 8).revisits, cellOf(f, 180, 3, 5).revisits);
}

TEST_F(Places, KeyframesWithoutTruthAreNeitherAskedNorCounted) {
  PlaceExperiment experiment({kTold}, {}, test::context());
  answers[20] = {{0, 0.1, Pose::Identity(), 0}};
  for (KeyframeId k = 0; k < 21; ++k) {
    Keyframe keyframe;
    keyframe.id = k;
    keyframe.travelled_m = 2.0 * k;
    experiment.add(keyframe, Cloud(), k == 20 ? std::nullopt : std::optional(poseFromYaw(0, {2.0 * k, 0, 0})));
  }
  EXPECT_EQ(experiment.withTruth(), 20u);
  EXPECT_EQ(experiment.figures().front().figures.revisits, 0u);
}

TEST_F(Places, AVariantOpensTheThresholdAndTakesItsOwnParameters) {
  PlaceOptions options;
  options.min_travel_m = 20;
  const PlaceVariant v = placeVariant("told:weights=[1,2],candidates=3", SlamParams(), options);
  const auto& p = dynamic_cast<const Told::Params&>(*v.params);
  EXPECT_EQ(p.max_distance, 7);
  EXPECT_EQ(p.min_travel_m, 20);
  EXPECT_EQ(p.candidates, 5) << "five are needed for recall@5";
  EXPECT_THAT(p.weights, ::testing::ElementsAre(1, 2));
  EXPECT_THAT([&] { placeVariant("told:max_distance=0.3", SlamParams(), options); },
              ThrowsMessage<Error>(HasSubstr("max_distance")));
  EXPECT_THAT([&] { placeVariant("told:weight=1", SlamParams(), options); },
              ThrowsMessage<Error>(HasSubstr("weights")));
  EXPECT_THAT([&] { placeVariant("tolt", SlamParams(), options); }, ThrowsMessage<Error>(HasSubstr("told")));
}

TEST_F(Places, ReportsSayTheSameAsJsonTableAndPicture) {
  answerAll(0.2);
  PlaceReport report{"a <drive>", "the session", 40, 40, {}, {thereAndBack(1.5)}};
  const auto json = nlohmann::json::parse(placeJson(report));
  EXPECT_EQ(json["variants"][0]["revisits"], 17);
  EXPECT_EQ(json["variants"][0]["curve"].size(), 1u);
  EXPECT_EQ(json["variants"][0]["descriptor_bytes"], 24);
  EXPECT_THAT(placeTable(report), ::testing::AllOf(HasSubstr("17 revisit"), HasSubstr("told")));
  const std::string svg = placesSvg(report);
  EXPECT_THAT(svg, ::testing::AllOf(HasSubstr("a &lt;drive&gt;"), HasSubstr("recall by lateral offset")));
  EXPECT_THAT(placesSvg({"nothing", "the session", 0, 0, {}, {}}), HasSubstr("</svg>"));
}

}  // namespace
}  // namespace scslam
