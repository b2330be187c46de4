#include "sim/realism_score.h"

#include "scslam/core/error.h"
#include "sim/embedded_targets.h"
#include "sim/realism.h"
#include "sim/synthetic_scans.h"
#include "support/support.h"

namespace scslam::test {
namespace {

using namespace scslam::sim;
using ::testing::HasSubstr;

const PipeScan kPipe{.noise_m = 0.02, .dropout = 0.02, .weak_dropout = 0.1};

RealismFigures measuredFrom(const PipeScan& pipe, const SensorModel& sensor, int scans = 6) {
  RealismMeter meter(sensor);
  for (int i = 0; i < scans; ++i) meter.add(scanOf(pipe, sensor, static_cast<std::uint32_t>(i + 1)));
  return meter.figures();
}

RealismTarget targetOf(const RealismFigures& figures, const SensorModel& sensor) {
  RealismTarget target;
  target.name = "pipe";
  target.sensor = sensor;
  target.grid.range_quantum_m = 0.001;
  target.figures = figures;
  return target;
}

Score named(const std::vector<Score>& scores, const std::string& name) {
  for (const Score& score : scores)
    if (score.name == name) return score;
  ADD_FAILURE() << "no score " << name;
  return {};
}

/// Scores of hand-made figures against others, where rings and grid do not matter.
Score between(const std::string& name, const RealismFigures& input, const RealismFigures& real) {
  return named(scoreRealism(input, aSensor(), targetOf(real, aSensor())), name);
}

// ==== Whole sets ====

TEST(RealismScore, APerfectCopyScoresOneInAllSix) {
  const SensorModel sensor = aSensor(32);
  const RealismFigures figures = measuredFrom(kPipe, sensor);
  const auto scores = scoreRealism(figures, sensor, targetOf(figures, sensor));
  ASSERT_EQ(scores.size(), 6u);
  for (const Score& score : scores) {
    ASSERT_TRUE(score.value) << score.name << ": " << score.note;
    EXPECT_DOUBLE_EQ(*score.value, 1) << score.name << ": " << score.note;
  }
}

TEST(RealismScore, AnotherSampleOfTheSameSensorScoresNearlyOne) {
  const SensorModel sensor = aSensor(32);
  const RealismTarget target = targetOf(measuredFrom(kPipe, sensor), sensor);
  RealismMeter meter(sensor);
  for (std::uint32_t seed = 100; seed < 106; ++seed) meter.add(scanOf(kPipe, sensor, seed));
  for (const Score& score : scoreRealism(meter.figures(), sensor, target))
    EXPECT_GT(score.value.value_or(0), 0.9) << score.name << ": " << score.note;
}

TEST(RealismScore, OneBrokenPartOfTheGridMakesItZero) {
  const SensorModel sensor = aSensor();
  const RealismTarget target = targetOf(measuredFrom(kPipe, sensor), sensor);
  const auto grid = [&](const PipeScan& pipe, const SensorModel& table) {
    return named(scoreRealism(measuredFrom(pipe, table), table, target), "grid");
  };
  EXPECT_EQ(grid(kPipe, sensor).value, 1);

  PipeScan smooth = kPipe, coarse = kPipe;
  smooth.quantum_m = 0, coarse.quantum_m = 0.01;
  EXPECT_EQ(grid(smooth, sensor).value, 0);
  EXPECT_EQ(grid(coarse, sensor).value, 0);
  EXPECT_THAT(grid(coarse, sensor).note, HasSubstr("WRONG: range quantum 10 mm of 1 mm"));
}

TEST(RealismScore, TheGridIsThatOfTheTable) {
  const SensorModel sensor = aSensor();
  const RealismTarget target = targetOf(measuredFrom(kPipe, sensor), sensor);
  const auto grid = [&](const SensorModel& table, Cloud cloud) {
    RealismMeter meter(table);
    meter.add(cloud);
    return named(scoreRealism(meter.figures(), table, target), "grid");
  };
  const Cloud cloud = scanOf(kPipe, sensor);
  EXPECT_EQ(grid(sensor, cloud).value, 1);

  SensorModel other = sensor;
  other.elevation_deg[5] += 0.05;
  EXPECT_THAT(grid(other, cloud).note, HasSubstr("WRONG: elevation"));
  other = sensor;
  other.columns = 1000;
  EXPECT_THAT(grid(other, cloud).note, HasSubstr("WRONG: azimuth"));
  other = sensor;
  other.clockwise = false;
  EXPECT_THAT(grid(other, cloud).note, HasSubstr("WRONG: column time"));

  Cloud timeless = cloud;
  timeless.dt.clear();
  EXPECT_EQ(grid(sensor, timeless).value, 1);
  EXPECT_THAT(grid(sensor, timeless).note, HasSubstr("column time left out"));
}

// ==== The formulas, on figures made by hand ====

TEST(RealismScore, NoiseIsJudgedByItsWorstBinOnALogarithmicScale) {
  RealismFigures real, input;
  real.range_noise_m = {0.01, 0.02, kNotMeasured};
  input.range_noise_m = {0.01, 0.02 * std::sqrt(2.0), 5};
  EXPECT_NEAR(*between("noise", input, real).value, 0.5, 1e-12);
  input.range_noise_m = {0.01, 0.04, 5};
  EXPECT_NEAR(*between("noise", input, real).value, 0, 1e-12);
  input.range_noise_m = {0.01, 0, 5};
  EXPECT_EQ(between("noise", input, real).value, 0) << "no noise at all";
}

TEST(RealismScore, DropOutIsTheMeanOverTheBinsAndABinCostsAtMostItself) {
  RealismFigures real, input;
  real.dropout_by_range = {0.01, 0.02, kNotMeasured};
  input.dropout_by_range = {0.01, 0, 0.5};
  EXPECT_NEAR(*between("drop-out", input, real).value, 0.5, 1e-12);
  EXPECT_THAT(between("drop-out", input, real).note, HasSubstr("real set has no signal"));
  real.dropout_by_signal = input.dropout_by_signal = {0.1, 0.05};
  EXPECT_NEAR(*between("drop-out", input, real).value, 0.75, 1e-12);
}

TEST(RealismScore, RangesAreHeldAgainstTheNearestRealSet) {
  RealismFigures near, far, input;
  near.range_histogram = {1, 0}, far.range_histogram = {0, 1}, input.range_histogram = {1, 0};
  RealismTarget other = targetOf(near, aSensor());
  other.name = "the near one";
  EXPECT_DOUBLE_EQ(*between("range histogram", input, far).value, 0);
  const Score score = named(scoreRealism(input, aSensor(), targetOf(far, aSensor()), {other}), "range histogram");
  EXPECT_DOUBLE_EQ(*score.value, 1);
  EXPECT_THAT(score.note, HasSubstr("the near one"));
}

/// Figures of a ray-caster without materials, against the real set: 0.56 by hand.
TEST(RealismScore, LocalGeometryOfANaiveSimulatorIsFarFromAStreet) {
  RealismFigures naive;
  naive.linear_planar_scatter = {0.16688, 0.79251, 0.05308};
  naive.jump = 0.12834, naive.mixed_pixels_per_jump = 0.52070;
  naive.range_noise_m = {0.02144, 0.02596, 0.03287, 0.04036, 0.04917, 0.05998, 0.07318, kNotMeasured};
  naive.dropout_by_range = {0, 0.00075420, 0.0019222};
  const auto real = loadRealismTarget(embeddedTargets().at("kaist03_os1-64"), "kaist03");
  const auto scores = scoreRealism(naive, real.sensor, real);
  EXPECT_NEAR(*named(scores, "local geometry").value, 0.565, 0.001);
  EXPECT_NEAR(*named(scores, "noise").value, 0.91, 0.005);
  EXPECT_NEAR(*named(scores, "drop-out").value, 0, 1e-12);
}

TEST(RealismScore, WhatCannotBeJudgedIsLeftOutAndSaid) {
  const SensorModel sensor = aSensor();
  const RealismTarget target = targetOf(measuredFrom(kPipe, sensor), sensor);
  for (const Score& score : scoreRealism({}, sensor, target)) {
    EXPECT_FALSE(score.value) << score.name;
    EXPECT_FALSE(score.note.empty()) << score.name;
  }
  const Score few = named(scoreRealism(measuredFrom(kPipe, sensor, 2), sensor, target), "ring occupancy");
  EXPECT_FALSE(few.value);
  EXPECT_THAT(few.note, HasSubstr("2 scans"));
  const Score other = named(scoreRealism(measuredFrom(kPipe, aSensor(8)), aSensor(8), target), "ring occupancy");
  EXPECT_FALSE(other.value);
  EXPECT_THAT(other.note, HasSubstr("8 rings"));
}

// ==== Real sets as files ====

TEST(RealismTargets, EveryShippedOneLoadsAndScoresOneAgainstItself) {
  ASSERT_EQ(embeddedTargets().size(), 2u);
  for (const auto& [name, text] : embeddedTargets()) {
    EXPECT_TRUE(text.starts_with("# ")) << name;
    const RealismTarget target = loadRealismTarget(text, name);
    EXPECT_EQ(target.name, name);
    for (const Score& score : scoreRealism(target.figures, target.sensor, target))
      EXPECT_EQ(score.value, 1) << name << ", " << score.name << ": " << score.note;
  }
}

TEST(RealismTargets, ReadBackAsWritten) {
  const SensorModel sensor = aSensor();
  PipeScan pipe = kPipe;
  pipe.time = pipe.signal = false;
  const RealismTarget target = targetOf(measuredFrom(pipe, sensor), sensor);
  const RealismTarget back = loadRealismTarget(targetYaml(target), "back");
  EXPECT_EQ(targetYaml(back), targetYaml(target));
  EXPECT_FALSE(measured(back.figures.column_time_s));
  EXPECT_FALSE(measured(back.figures.range_noise_m[0]));
  EXPECT_TRUE(back.figures.dropout_by_signal.empty());
}

TEST(RealismTargets, MistakesInAFileAreNamed) {
  const auto message = [](const std::string& text) -> std::string {
    try {
      loadRealismTarget(text, "x.yaml");
    } catch (const Error& error) {
      return error.what();
    }
    return "accepted";
  };
  EXPECT_THAT(message("figures: {pionts: 3}"), HasSubstr("points"));
  EXPECT_THAT(message("figures: {range_histogram: [1, 2]}"), HasSubstr("2 entries instead of 10"));
  EXPECT_THAT(message("sensor: {rings: 2, elevation_deg: [1]}"), HasSubstr("1 entries for 2 rings"));
}

}  // namespace
}  // namespace scslam::test
