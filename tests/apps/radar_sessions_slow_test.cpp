// Sessions made by radar are as good as those of a LiDAR: merged, and localised in.
#include "scslam/apps/localize/localize.h"
#include "scslam/apps/merge/merge.h"
#include "scslam/apps/run_job.h"
#include "sim/simulation.h"
#include "support/support.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;

struct RadarDrive {
  fs::path rawlog, truth, session;
};

/// Through the same streets with other noise, in another lane, at another speed.
RadarDrive radarDrive(const fs::path& folder, const std::vector<std::string>& sets) {
  std::vector<std::string> all = {"truth.pictures=false", "truth.loops=false", "truth.aliases=false", "world.seed=1",
                                  "drive.duration_s=18"};
  all.insert(all.end(), sets.begin(), sets.end());
  sim::SimulateOptions simulate;
  simulate.output = folder / "drive.rawlog";
  simulate.compression = 0, simulate.quiet = true;
  const sim::SimulationSummary simulated = sim::simulate(sim::loadScenario("s18", all), simulate, context(2));
  EXPECT_EQ(simulated.collision, "");
  RunOptions run;
  run.input = simulate.output.string();
  run.output = folder / "session";
  run.configs = {"radar"};
  run.quiet = true;
  runJob(run, context(2));
  return {simulate.output, folder / "drive.gt.tum", run.output};
}

TEST(RadarSessions, AreMergedAndLocalisedIn) {
  const fs::path folder = freshFolder();
  const RadarDrive monday = radarDrive(folder / "monday", {});
  const RadarDrive friday =
      radarDrive(folder / "friday", {"seed=7", "drive.lane_m=-0.8", "drive.speed_mps=6", "radar.rpy_deg=[0, 0, 30]"});

  LocalizeOptions localise;
  localise.session = monday.session, localise.session_truth = monday.truth;
  localise.input = friday.rawlog.string(), localise.truth = friday.truth;
  localise.output = folder / "where";
  localise.quiet = true;
  const LocalizeSummary where = localize(localise, context(2));
  EXPECT_LE(where.first_fix_scan.value_or(99), 4u);
  EXPECT_GT(where.tracked, 0.7 * static_cast<double>(where.scans));
  EXPECT_EQ(where.error->wrong, 0u);
  EXPECT_LT(where.error->rmse_m, 0.1);

  MergeOptions merge;
  merge.sessions = {friday.session, monday.session};
  merge.truths = {friday.truth, monday.truth};
  merge.output = folder / "both";
  merge.quiet = true;
  const MergeSummary both = mergeSessions(merge, context(2));
  EXPECT_GE(both.pairs[0].loops, 20u);
  EXPECT_EQ(both.pairs[0].false_loops.value(), 0u);
  EXPECT_LT(both.pairs[0].relative_error_m.value(), 0.1);
  EXPECT_LT(both.pairs[0].relative_error_deg.value(), 1.0);
}

}  // namespace
}  // namespace scslam::test
