// Two visits to a yard: one car left, another came, a third drives through; everything else stayed.
#include "scslam/apps/changes/changes.h"

#include <atomic>

#include "apps/clean_scenes.h"
#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/session/layout.h"
#include "support/town.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

constexpr int kScans = 20;  // of each visit
Box leaver() { return {{-9, -7, 0.2}, {-5, -5.2, 1.5}}; }
Box comer() { return {{9, -7, 0.2}, {13, -5.2, 1.6}}; }

/// A merged session as `merge` writes it. @param with_changes false: both visits see the same.
fs::path twoVisits(const std::string& name, bool with_changes) {
  const fs::path folder = memoryFolder() / "changes" / name;
  SessionParts parts;
  std::vector<Cloud> clouds;
  std::string table = "keyframe,parent,parent_keyframe\n";
  for (int visit = 0; visit < 2; ++visit)
    for (int k = 0; k < kScans; ++k) {
      BoxWorld world = yard();
      if (!with_changes || visit == 0) world.boxes.push_back(leaver());
      if (with_changes && visit == 1) world.boxes.push_back(comer());
      if (visit == 1) world.boxes.push_back(carAt(16 - 1.5 * k, 3));
      const double x = visit == 0 ? -14 + 1.4 * k : 14 - 1.4 * k;
      parts.optimised.push_back(poseFromYaw(visit == 0 ? 0.01 * k : M_PI - 0.01 * k, {x, visit == 0 ? -1.0 : 0.2, 0}));
      const auto index = static_cast<std::size_t>(visit * kScans + k);
      clouds.push_back(spunAt(index, parts.optimised.back(), world, {48, 720, -0.42, 0.1, 0.01}).cloud);
      table += fmt::format("{},{},{}\n", index, visit, k);
    }
  parts.odometry = parts.optimised;
  parts.cloud_sensor = [&clouds](std::size_t k) { return clouds[k]; };
  parts.T_base_sensor = T_base_sensor();
  parts.parents = {{"monday", "m", {}}, {"friday", "f", {}}};
  sessionOf(folder, parts);
  writeFileAtomically(folder / layout::kKeyframeParents, table);
  return folder;
}

const fs::path& changed() {
  static const fs::path folder = twoVisits("changed", true);
  return folder;
}

ChangesOptions optionsOf(const fs::path& session, const fs::path& output) {
  ChangesOptions options;
  options.session = session, options.output = output, options.quiet = true;
  return options;
}

bool near(const Eigen::Vector3f& p, const Box& box, double margin_m) {
  const Eigen::Vector3d q = p.cast<double>();
  return (box.low - q).cwiseMax(q - box.high).maxCoeff() < margin_m;
}

/// Precision and recall of one kind of change against the box that truly changed.
std::pair<double, double> precisionRecall(const ChangeMap& map, Change change, const Box& box) {
  double found = 0, right = 0, truly = 0;
  for (std::size_t i = 0; i < map.change.size(); ++i) {
    const bool says = map.change[i] == change, is = near(map.cloud_map.point(i), box, 0.08);
    found += says, right += says && near(map.cloud_map.point(i), box, 0.25), truly += is;
  }
  double hit = 0;
  for (std::size_t i = 0; i < map.change.size(); ++i)
    hit += map.change[i] == change && near(map.cloud_map.point(i), box, 0.08);
  return {right / std::max(found, 1.0), hit / std::max(truly, 1.0)};
}

TEST(Changes, WhatCameAndWhatLeftIsFoundAndTrafficIsNone) {
  const ChangesSummary summary = findChanges(optionsOf(changed(), freshFolder() / "out"), context(2));
  EXPECT_EQ(summary.older, "monday");
  EXPECT_EQ(summary.newer, "friday");
  const auto [gone_precision, gone_recall] = precisionRecall(summary.map, Change::kDisappeared, leaver());
  const auto [new_precision, new_recall] = precisionRecall(summary.map, Change::kAppeared, comer());
  EXPECT_GT(gone_precision, 0.95) << changesTable(summary);
  EXPECT_GT(new_precision, 0.95) << changesTable(summary);
  EXPECT_GT(gone_recall, 0.8);
  EXPECT_GT(new_recall, 0.8);
  ASSERT_EQ(summary.things.size(), 2u) << changesTable(summary);
  EXPECT_GT(summary.moving_points, 1000u);
  EXPECT_GT(summary.stayed, 20 * (summary.appeared + summary.disappeared));
}

TEST(Changes, NothingIsFoundWhereAllStayed) {
  const ChangesSummary summary =
      findChanges(optionsOf(twoVisits("unchanged", false), freshFolder() / "out"), context(2));
  EXPECT_TRUE(summary.things.empty()) << changesTable(summary);
  EXPECT_EQ(summary.appeared + summary.disappeared, 0u);
}

TEST(Changes, TheOtherWayRoundWhatCameIsWhatLeft) {
  ChangesOptions options = optionsOf(changed(), freshFolder() / "out");
  const ChangesSummary forward = findChanges(options, context());
  options.older = "friday", options.newer = "monday", options.output = freshFolder() / "back";
  const ChangesSummary back = findChanges(options, context());
  EXPECT_EQ(back.appeared, forward.disappeared);
  EXPECT_EQ(back.disappeared, forward.appeared);
}

TEST(Changes, SameBytesForAnyNumberOfThreadsAndTheSessionIsLeftAlone) {
  const auto before = contents(changed());
  const fs::path folder = freshFolder();
  findChanges(optionsOf(changed(), folder / "one"), context(1));
  findChanges(optionsOf(changed(), folder / "two"), context(2));
  EXPECT_EQ(contents(folder / "one", {"changes.json"}), contents(folder / "two", {"changes.json"}));
  EXPECT_EQ(contents(changed()), before);
}

TEST(Changes, TheVerbWritesAMapAPictureAndAList) {
  const fs::path out = freshFolder() / "out";
  const RunResult result = runScslam(fmt::format("changes '{}' -o '{}' -q", changed().string(), out.string()));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("appeared"));
  EXPECT_TRUE(readFile(out / "changes.ply").starts_with("ply\n"));
  EXPECT_THAT(readFile(out / "things.csv"), HasSubstr("\nappeared,"));
  EXPECT_THAT(readFile(out / "things.csv"), HasSubstr("\ndisappeared,"));
  EXPECT_GT(fs::file_size(out / "changes.png"), 1000u);
}

void expectRefused(const ChangesOptions& options, ExitCode code, const std::string& words) {
  try {
    findChanges(options, context());
    ADD_FAILURE() << "not refused: " << words;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_THAT(error.what(), HasSubstr(words));
  }
  EXPECT_FALSE(fs::exists(options.output));
}

TEST(ChangesRefuse, WhatCannotBeComparedAndLeaveNothing) {
  const fs::path folder = freshFolder();
  expectRefused(optionsOf(passingCar().session, folder / "a"), ExitCode::kInput, "not a merged session");
  ChangesOptions options = optionsOf(changed(), folder / "b");
  options.older = "tuesday";
  expectRefused(options, ExitCode::kUsage, "monday, friday");
  options.older = "friday";
  expectRefused(options, ExitCode::kUsage, "with itself");
  options = optionsOf(changed(), folder / "c");
  options.sets = {"min_voxel=3"};
  expectRefused(options, ExitCode::kUsage, "min_voxels");
  const std::atomic<bool> stop{true};
  options = optionsOf(changed(), folder / "d");
  options.stop = &stop;
  expectRefused(options, ExitCode::kStopped, "nothing was written");
}

}  // namespace
}  // namespace scslam::test
