// The safety net: each shipped scenario is simulated, mapped, and held against the bounds in its own file.
#include <fmt/format.h>

#include <cmath>
#include <iostream>

#include "scenario_run.h"
#include "support/simulated_drive.h"

namespace scslam::test {

namespace fs = std::filesystem;

void simulateInto(const sim::Scenario& scenario, const fs::path& folder, ScenarioFigures& figures) {
  const sim::SimulationSummary summary = simulateDrive(scenario, folder, 1);
  figures.sim_wall_s = summary.wall_s, figures.collision = summary.collision;
}

void mapIn(const sim::ExpectParams& expect, const fs::path& folder, const std::vector<std::string>& sets,
           ScenarioFigures& figures) {
  std::vector<std::string> configs, all;
  if (!expect.config.empty()) configs = {expect.config};
  if (!expect.odometry.empty()) all = {"odometry.frontend=" + expect.odometry};
  all.insert(all.end(), sets.begin(), sets.end());
  figures.run_wall_s = mapDrive(folder, configs, all, 1).wall_s;
  const Session session = Session::open(folder / "session");
  figures.evaluation = evaluate(session, readTrajectory(folder / "drive.gt.tum"));
  figures.steps = stepConsistency(session, figures.evaluation);
  const auto trajectory = session.trajectory();
  double sum = 0;
  for (std::size_t i = 0; i < trajectory.size(); ++i)
    if (const auto& truth = figures.evaluation.T_truth_base[i]) {
      const Pose aligned = figures.evaluation.ate.T_truth_estimate * trajectory[i].T;
      sum += std::pow(aligned.translation().z() - truth->translation().z(), 2);
    }
  figures.z_rmse_m = std::sqrt(sum / static_cast<double>(figures.evaluation.poses));
}

std::vector<std::string> violations(const sim::ExpectParams& expect, const ScenarioFigures& figures) {
  std::vector<std::string> broken;
  const Evaluation& e = figures.evaluation;
  const auto atMost = [&broken](const char* what, double value, double bound) {
    if (bound >= 0 && !(value <= bound)) broken.push_back(fmt::format("{} {:.3f} > {:.3f}", what, value, bound));
  };
  const auto atLeast = [&broken](const char* what, double value, double bound) {
    if (bound >= 0 && !(value >= bound)) broken.push_back(fmt::format("{} {:.3f} < {:.3f}", what, value, bound));
  };
  atMost("ate_m", e.ate.rmse_m, expect.ate_max_m);
  atMost("odometry_ate_m", e.odometry_ate.rmse_m, expect.odometry_ate_max_m);
  atMost("z_rmse_m", figures.z_rmse_m, expect.z_rmse_max_m);
  atMost("false_loops", static_cast<double>(e.loops.false_accepted), expect.false_loops_max);
  atLeast("loops", static_cast<double>(e.loops.true_accepted), expect.loops_min);
  atLeast("recall", e.loops.recall.value_or(0), expect.recall_min);
  atMost("nees", figures.steps.mean.value_or(0), expect.nees_max);
  if (!figures.collision.empty()) broken.push_back(figures.collision);
  return broken;
}

std::string row(const std::string& name, const sim::ExpectParams& expect, const ScenarioFigures& figures) {
  const Evaluation& e = figures.evaluation;
  std::string text = fmt::format(
      "{:<22} ATE {:6.3f} m (odometry {:6.3f}), z {:.3f} m, loops {:3} true {} false of {:4}, recall {}, NEES {:4.1f}, "
      "sim {:.0f} s, run {:.0f} s",
      name, e.ate.rmse_m, e.odometry_ate.rmse_m, figures.z_rmse_m, e.loops.true_accepted, e.loops.false_accepted,
      e.loops.candidates, e.loops.recall ? fmt::format("{:.2f}", *e.loops.recall) : "   -",
      figures.steps.mean.value_or(0), figures.sim_wall_s, figures.run_wall_s);
  if (expect.wished_ate_m >= 0) text += fmt::format("; wished: ATE {} m", expect.wished_ate_m);
  if (expect.wished_recall >= 0) text += fmt::format("; wished: recall {}", expect.wished_recall);
  return text;
}

namespace {

class Scenarios : public ::testing::TestWithParam<std::string> {};

void meetsItsBounds(const sim::Scenario& scenario, const sim::ExpectParams& expect, const std::string& name) {
  const fs::path folder = freshFolder();
  ScenarioFigures figures;
  simulateInto(scenario, folder, figures);
  if (!expect.slam) return;
  mapIn(expect, folder, {}, figures);
  std::cout << row(name, expect, figures) << std::endl;
  EXPECT_THAT(violations(expect, figures), ::testing::IsEmpty());
  fs::remove_all(folder);
}

TEST_P(Scenarios, MeetTheirBounds) {
  const sim::Scenario scenario = sim::loadScenario(GetParam(), {"truth.pictures=false"});
  meetsItsBounds(scenario, scenario.expect, GetParam());
}

class ScenariosByRadar : public ::testing::TestWithParam<std::string> {};

TEST_P(ScenariosByRadar, MeetTheirBounds) {
  const sim::Scenario scenario =
      sim::loadScenario(GetParam(), {"truth.pictures=false", "lidar.on=false", "radar.on=true"});
  meetsItsBounds(scenario, scenario.expect_radar, GetParam() + " (radar)");
}

std::vector<std::string> shipped() {
  std::vector<std::string> names;
  for (const auto& [name, summary] : sim::scenarioNames()) names.push_back(name);
  return names;
}

std::vector<std::string> forRadar() {
  std::vector<std::string> names;
  for (const std::string& name : shipped())
    if (sim::loadScenario(name).expect_radar.slam) names.push_back(name);
  return names;
}

const auto nameOf = [](const auto& scenario) { return scenario.param; };
INSTANTIATE_TEST_SUITE_P(Shipped, Scenarios, ::testing::ValuesIn(shipped()), nameOf);
INSTANTIATE_TEST_SUITE_P(Shipped, ScenariosByRadar, ::testing::ValuesIn(forRadar()), nameOf);

/// The other half of S17: carried on with all sensors off, it says that it is lost, and agreeing loops join both parts.
TEST(Scenarios, CarriedOffItFindsBack) {
  const sim::Scenario scenario =
      sim::loadScenario("s17", {"truth.pictures=false", "drive.laps=2", "drive.start_pause_s=12", "drive.duration_s=60",
                                "wheels.enabled=false", "faults.off_s=[21, 30]", "expect.ate_max_m=0.1",
                                "expect.loops_min=30", "expect.recall_min=0.9"});
  meetsItsBounds(scenario, scenario.expect, "s17, carried off");
}

/// The whole of S09's road, there, back and there again: echoes of grass and of forty cars, and few trees that stand.
TEST(Scenarios, ARoadThroughOpenCountryIsClosedByRadar) {
  const sim::Scenario scenario =
      sim::loadScenario("s09", {"truth.pictures=false", "lidar.on=false", "radar.on=true", "drive.route=there_and_back",
                                "drive.laps=2", "drive.duration_s=145", "expect_radar.ate_max_m=1.2",
                                "expect_radar.loops_min=50", "expect_radar.recall_min=0.15"});
  meetsItsBounds(scenario, scenario.expect_radar, "s09, there and back by radar");
}

/// The net has no holes: with any one part broken, the bounds of the plainest scenario do not hold.
TEST(Scenarios, NoticeABrokenPart) {
  const sim::Scenario scenario = sim::loadScenario("s01_loop", {"truth.pictures=false"});
  const fs::path folder = freshFolder();
  ScenarioFigures figures;
  simulateInto(scenario, folder, figures);
  for (const std::string breakage :
       {"place.scan_context.max_distance=0.001", "registration.gates.max_rmse_m=0.001", "odometry.voxel_icp.voxel_m=8",
        "preprocess.max_range_m=6", "keyframe.distance_m=40"}) {
    // The other recognisers would stand in for a broken one; and a broken map is not worth a second look.
    mapIn(scenario.expect, folder, {breakage, "place.recognisers=[scan_context]", "place.look_again=false"}, figures);
    std::cout << row(breakage, {}, figures) << std::endl;
    EXPECT_THAT(violations(scenario.expect, figures), ::testing::Not(::testing::IsEmpty())) << breakage;
  }
  fs::remove_all(folder);
}

TEST(Scenarios, AreAllThere) {
  std::vector<std::string> numbers;
  for (const std::string& name : shipped()) numbers.push_back(name.substr(0, 3));
  for (int k = 1; k <= 19; ++k) EXPECT_THAT(numbers, ::testing::Contains(fmt::format("s{:02}", k)));
  EXPECT_THAT(forRadar(), ::testing::SizeIs(3));
}

}  // namespace
}  // namespace scslam::test
