// Sessions made by radar are as good as those of a LiDAR: merged, and localised in.
#include "scslam/apps/learn/learn_quality.h"
#include "scslam/apps/localize/localize.h"
#include "scslam/apps/merge/merge.h"
#include "scslam/pipeline/slam_params.h"
#include "support/simulated_drive.h"

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
  EXPECT_EQ(simulateDrive(sim::loadScenario("s18", all), folder).collision, "");
  mapDrive(folder, {"radar"});
  return {folder / "drive.rawlog", folder / "drive.gt.tum", folder / "session"};
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

TEST(RadarSessions, TeachWhatAGoodAlignmentIs) {
  const fs::path folder = freshFolder();
  // A small round, one lap and a half of it.
  const RadarDrive drive =
      radarDrive(folder, {"world.town.block_x_m=24", "world.town.block_y_m=24", "drive.laps=2", "drive.duration_s=36"});
  LearnOptions options;
  options.sessions = {drive.session}, options.truths = {drive.truth};
  options.quiet = true;
  const LearnSummary summary = learnQuality(options, context(2));
  EXPECT_GT(summary.right, 50u);
  EXPECT_LT(summary.right, summary.examples - 50);
  EXPECT_GT(summary.tested, 20u);
  EXPECT_GT(summary.auc, 0.98);
  EXPECT_LT(summary.quality.blur, 0) << "blur speaks against it";
  EXPECT_GT(summary.quality.shared, 0) << "what both see speaks for it";
  SlamParams slam;
  loadYaml(slam, learnYaml(summary, options), "learned");
  EXPECT_TRUE(slam.registration.gates.quality.on);
  options.sets = {"registration.gates.quality.min_probability=0.6"};
  const LearnSummary again = learnQuality(options, context(1));
  EXPECT_EQ(again.quality.blur, summary.quality.blur) << "for any number of threads";
  EXPECT_EQ(again.quality.min_probability, 0.6) << "what the user asks for";
  EXPECT_LE(again.wrong_believed, summary.wrong_believed);
}

}  // namespace
}  // namespace scslam::test
