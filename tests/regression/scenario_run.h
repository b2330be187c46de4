// A scenario simulated, mapped and measured against its own truth.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "scslam/apps/evaluate.h"
#include "scslam/apps/nees.h"
#include "sim/scenario.h"

namespace scslam::test {

struct ScenarioFigures {
  Evaluation evaluation;
  StepConsistency steps;
  double z_rmse_m = 0;
  double sim_wall_s = 0, run_wall_s = 0;
  std::string collision;
};

/// Writes the scenario's rawlog and truth into `folder` (OUT = folder/drive).
void simulateInto(const sim::Scenario& scenario, const std::filesystem::path& folder, ScenarioFigures& figures);
/// Maps folder/drive.rawlog with the configuration of the bounds and `sets`, into folder/session.
void mapIn(const sim::ExpectParams& expect, const std::filesystem::path& folder, const std::vector<std::string>& sets,
           ScenarioFigures& figures);
/// Every bound of the scenario that the figures break, in words.
std::vector<std::string> violations(const sim::ExpectParams& expect, const ScenarioFigures& figures);
/// One line for people.
std::string row(const std::string& name, const sim::ExpectParams& expect, const ScenarioFigures& figures);

}  // namespace scslam::test
