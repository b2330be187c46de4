// A scenario driven and mapped: what tests on simulated drives begin with.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "scslam/apps/run_job.h"
#include "sim/simulation.h"
#include "support/support.h"

namespace scslam::test {

/// Writes FOLDER/drive.rawlog, its truth beside it (FOLDER/drive.gt.tum, …).
inline sim::SimulationSummary simulateDrive(const sim::Scenario& scenario, const std::filesystem::path& folder,
                                            int threads = 2) {
  sim::SimulateOptions options;
  options.output = folder / "drive.rawlog";
  options.compression = 0, options.overwrite = options.quiet = true;
  return sim::simulate(scenario, options, context(threads));
}

/// Maps FOLDER/drive.rawlog into FOLDER/session.
inline RunSummary mapDrive(const std::filesystem::path& folder, const std::vector<std::string>& configs = {},
                           const std::vector<std::string>& sets = {}, int threads = 2) {
  RunOptions options;
  options.input = (folder / "drive.rawlog").string(), options.output = folder / "session";
  options.overwrite = options.quiet = true;
  options.configs = configs, options.sets = sets;
  return runJob(options, context(threads));
}

}  // namespace scslam::test
