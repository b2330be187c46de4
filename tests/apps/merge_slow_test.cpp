// Sessions in one frame: what is joined, what is not, what is written, and that nothing half is left.
#include <atomic>
#include <fstream>
#include <sstream>

#include "apps/kitti_halves.h"
#include "apps/town_sessions.h"
#include "scslam/apps/doctor.h"
#include "scslam/apps/merge/merge.h"
#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/mapping/map_builder.h"
#include "scslam/session/session.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

MergeOptions mergeOf(const std::vector<const TownSession*>& sessions, const fs::path& output) {
  MergeOptions options;
  for (const TownSession* session : sessions) {
    options.sessions.push_back(session->folder);
    options.truths.push_back(session->truth);
  }
  options.output = output;
  options.quiet = true;
  options.sets = {"merge.max_trials=60"};
  return options;
}

std::string refusalOf(const MergeOptions& options, ExitCode code) {
  try {
    mergeSessions(options, context());
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_FALSE(fs::exists(options.output)) << "something half was left";
    EXPECT_FALSE(fs::exists(options.output.string() + ".partial"));
    return error.what();
  }
  ADD_FAILURE() << "not refused";
  return "";
}

/// Made once: two drives through one town and one elsewhere, given in the order second, elsewhere, first.
struct Merged {
  fs::path folder;
  MergeSummary summary;
};
const Merged& merged() {
  static const Merged result = [] {
    const ThreeDrives& drives = threeDrives();
    const fs::path folder = drives.first.folder.parent_path() / "merged";
    return Merged{folder,
                  mergeSessions(mergeOf({&drives.second, &drives.elsewhere, &drives.first}, folder), context(2))};
  }();
  return result;
}

TEST(Merge, DrivesThroughOneTownComeIntoOneFrameAndTheOneElsewhereStaysSeparate) {
  const MergeSummary& summary = merged().summary;
  ASSERT_EQ(summary.parents.size(), 3u);
  ASSERT_EQ(summary.pairs.size(), 3u);
  for (const MergedParent& parent : summary.parents)
    EXPECT_EQ(parent.joined, parent.name != "elsewhere") << parent.name;
  for (const MergedPair& pair : summary.pairs) {
    const bool both = summary.parents[pair.a].joined && summary.parents[pair.b].joined;
    EXPECT_EQ(pair.joined, both) << pair.reason;
    EXPECT_EQ(pair.false_loops.value_or(99), 0u);
    EXPECT_EQ(pair.reason.empty(), both);
    if (both) {
      EXPECT_GE(pair.loops, 5u);
      EXPECT_LT(*pair.relative_error_m, 0.15);
      EXPECT_LT(*pair.relative_error_deg, 0.5);
    }
  }
}

/// The parents of `merged()` in the order of its keyframes.
std::vector<Session> parentsOf(const Session& session) {
  std::vector<Session> parents;
  for (const SessionParent& parent : session.info().parents)
    parents.push_back(Session::open(threeDrives().first.folder.parent_path() / parent.name));
  return parents;
}

TEST(Merge, TheOrderOfTheSessionsChangesNoByte) {
  const ThreeDrives& drives = threeDrives();
  const fs::path folder = freshFolder() / "m";
  mergeSessions(mergeOf({&drives.first, &drives.second, &drives.elsewhere}, folder), context(1));
  EXPECT_EQ(contents(folder), contents(merged().folder));
}

TEST(Merge, TheResultIsASoundSessionWhoseKeyframesTellWhereTheyCameFrom) {
  const Session session = Session::open(merged().folder);
  const std::vector<Session> parents = parentsOf(session);
  ASSERT_EQ(parents.size(), 2u);
  const Session &first = parents[0], &second = parents[1];
  EXPECT_EQ(session.keyframes().size(), first.keyframes().size() + second.keyframes().size());
  EXPECT_EQ(session.scans().size(), first.scans().size() + second.scans().size());
  for (const DoctorCheck& check : examine(merged().folder)) EXPECT_TRUE(check.sound) << check.what << check.finding;
  for (std::size_t i = 1; i < session.scans().size(); ++i)
    EXPECT_GT(session.scans()[i].stamp, session.scans()[i - 1].stamp);

  std::istringstream table(readFile(merged().folder / "parent_keyframes.csv"));
  std::string line;
  std::getline(table, line);
  for (std::size_t k = 0; std::getline(table, line); ++k) {
    const std::size_t parent = k < first.keyframes().size() ? 0 : 1;
    const std::size_t own = parent == 0 ? k : k - first.keyframes().size();
    EXPECT_EQ(line, fmt::format("{},{},{}", k, parent, own));
    const Cloud here = session.cloud(static_cast<KeyframeId>(k));
    const Cloud there = (parent == 0 ? first : second).cloud(static_cast<KeyframeId>(own));
    EXPECT_EQ(here.x, there.x);
  }
}

TEST(Merge, OdometryDoesNotJoinTheEndOfOneParentToTheBeginOfTheNext) {
  const Session session = Session::open(merged().folder);
  const std::size_t begin = parentsOf(session).front().keyframes().size();
  std::size_t odometry = 0, across = 0;
  for (const Factor& factor : session.graph().factors) {
    odometry += factor.kind == FactorKind::kOdometry;
    EXPECT_FALSE(factor.kind == FactorKind::kOdometry && factor.j == begin);
    across += factor.kind == FactorKind::kLoop && factor.i < begin && factor.j >= begin;
  }
  EXPECT_EQ(odometry, session.keyframes().size() - 2);
  EXPECT_GE(across, 5u);
}

TEST(Merge, AMapMadeByOthersHoldsStillAndTheSessionComesIntoItsFrame) {
  const ThreeDrives& drives = threeDrives();
  const Session first = Session::open(drives.first.folder), second = Session::open(drives.second.folder);
  const fs::path folder = freshFolder();
  exportMap(first, {"ply"}, {}, folder, context(2));
  MergeOptions options = mergeOf({&drives.second}, folder / "merged");
  options.truths.clear();
  options.sessions.push_back(folder / "map.ply");
  const MergeSummary summary = mergeSessions(options, context(2));
  ASSERT_EQ(summary.parents.size(), 2u);
  const MergedParent &map = summary.parents[0], &other = summary.parents[1];
  EXPECT_EQ(map.name, "map");
  EXPECT_EQ(map.folder, folder / "map.ply");
  EXPECT_THAT(map.T_map_parent, IsNear(Pose::Identity(), 1e-9, 1e-6));
  EXPECT_GE(summary.pairs[0].loops, 10u);
  const Pose T_first_world = first.poses()[0] * drives.first.T_world_base[0].inverse();
  const Session merged = Session::open(folder / "merged");
  for (const Keyframe& keyframe : second.keyframes()) {
    const Pose T_true = T_first_world * drives.second.T_world_base[keyframe.scan_index];
    EXPECT_THAT(merged.poses()[other.first_keyframe + keyframe.id], IsNear(T_true, 0.35, 1.0));
  }
  EXPECT_FALSE(fs::exists(folder / "merged.maps.partial"));
}

/// LT-removert's reader: 12 numbers a line, row-major, one line per scan of the parent.
TEST(Merge, PosesOfEachParentAreThereAsLtMapperReadsThem) {
  const Session session = Session::open(merged().folder);
  std::size_t k = 0;
  for (const SessionParent& parent : session.info().parents) {
    std::ifstream file(merged().folder / "lt_mapper" / (parent.name + "_central_aft_intersession_loops.txt"));
    ASSERT_TRUE(file) << parent.name;
    for (std::string line; std::getline(file, line); ++k) {
      std::istringstream words(line);
      const std::vector<double> numbers{std::istream_iterator<double>(words), {}};
      ASSERT_EQ(numbers.size(), 12u);
      const Pose T = session.poses()[k] * session.info().T_base_sensor;
      for (int i = 0; i < 12; ++i) EXPECT_NEAR(numbers[static_cast<std::size_t>(i)], T.matrix()(i / 4, i % 4), 1e-9);
    }
  }
  EXPECT_EQ(k, session.keyframes().size());
}

TEST(Merge, AMergeIsMergedAgainButNotWithItsOwnParents) {
  const ThreeDrives& drives = threeDrives();
  std::vector<Pose> third = aroundTheBlock(1.6, 0.6);
  for (Pose& T : third) T = T * poseFromYaw(-0.04, {0, -0.3, 0});
  const TownSession another = townSession("another", Town(1), third, poseFromYaw(0.7, {-90, 12, 0}));
  MergeOptions options = mergeOf({&another}, freshFolder() / "m");
  options.sessions.push_back(merged().folder);
  options.truths.clear();
  const MergeSummary summary = mergeSessions(options, context(2));
  EXPECT_TRUE(summary.parents[0].joined && summary.parents[1].joined);
  const Session session = Session::open(options.output);
  for (const DoctorCheck& check : examine(options.output)) EXPECT_TRUE(check.sound) << check.what << check.finding;

  std::vector<std::string> ancestors;
  for (const SessionParent& parent : session.info().parents)
    ancestors.insert(ancestors.end(), parent.leaves.begin(), parent.leaves.end());
  EXPECT_EQ(ancestors.size(), 2u);
  options.sessions = {options.output, drives.second.folder};
  options.output = options.output.parent_path() / "again";
  EXPECT_THAT(refusalOf(options, ExitCode::kUsage), HasSubstr("hold the same keyframes"));
}

TEST(Merge, SessionsThatDoNotOverlapAreRefusedWithTheReasons) {
  const ThreeDrives& drives = threeDrives();
  const std::string why =
      refusalOf(mergeOf({&drives.first, &drives.elsewhere}, freshFolder() / "m"), ExitCode::kQualityGate);
  EXPECT_THAT(why, HasSubstr("no two of the sessions overlap"));
  EXPECT_THAT(why, ::testing::AnyOf(HasSubstr("are needed"), HasSubstr("looks like")));
}

TEST(Merge, BadInputEndsInOneClearLineAndLeavesNothing) {
  const ThreeDrives& drives = threeDrives();
  const fs::path folder = freshFolder();
  fs::copy(drives.second.folder, folder / "copy", fs::copy_options::recursive);
  MergeOptions options = mergeOf({&drives.first, &drives.second}, folder / "m");
  options.truths.clear();

  options.sessions = {drives.second.folder, folder / "copy"};
  EXPECT_THAT(refusalOf(options, ExitCode::kUsage), HasSubstr("copy"));
  options.sessions = {drives.first.folder, folder / "copy"};
  fs::remove(folder / "copy" / "Scans" / "000003.pcd");
  EXPECT_THAT(refusalOf(options, ExitCode::kInput), HasSubstr("000003.pcd is missing"));
  options.sessions = {drives.first.folder};
  EXPECT_THAT(refusalOf(options, ExitCode::kUsage), HasSubstr("two sessions"));
  options.sessions = {drives.first.folder, folder / "nothing"};
  EXPECT_THAT(refusalOf(options, ExitCode::kInput), HasSubstr("does not exist"));

  std::vector<Pose> one = {Pose::Identity()};
  const TownSession lone = townSession("lone", Town(1), one, Pose::Identity());
  options.sessions = {drives.first.folder, lone.folder};
  EXPECT_THAT(refusalOf(options, ExitCode::kInput), HasSubstr("holds 1 keyframe with"));
}

TEST(Merge, AnInterruptedMergeLeavesTheOldSessionStanding) {
  const ThreeDrives& drives = threeDrives();
  const fs::path folder = freshFolder();
  fs::copy(drives.elsewhere.folder, folder / "m", fs::copy_options::recursive);
  const auto before = contents(folder / "m", {});
  MergeOptions options = mergeOf({&drives.first, &drives.second}, folder / "m");
  std::atomic<bool> stop{true};
  EXPECT_THROW(mergeSessions(options, context()), Error) << "replaced without -w";
  options.overwrite = true;
  options.stop = &stop;
  try {
    mergeSessions(options, context());
    ADD_FAILURE() << "not stopped";
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), ExitCode::kStopped);
  }
  EXPECT_EQ(contents(folder / "m", {}), before);
  EXPECT_FALSE(fs::exists((folder / "m").string() + ".partial"));
  options.stop = nullptr;
  mergeSessions(options, context());
  EXPECT_EQ(Session::open(folder / "m").info().parents.size(), 2u);
}

TEST(Merge, FarTooStrictDemandsJoinNothing) {
  const ThreeDrives& drives = threeDrives();
  MergeOptions options = mergeOf({&drives.first, &drives.second}, freshFolder() / "m");
  options.sets = {"merge.min_spread_m=5000", "merge.max_trials=15"};
  EXPECT_THAT(refusalOf(options, ExitCode::kQualityGate), HasSubstr("merge.min_spread_m"));
}

TEST(Merge, TheTwoHalvesOfARealStreetComeTogetherWithinTenCentimetres) {
  SCSLAM_NEEDS_DATA(recording, "kitti00_kf000-039");
  const fs::path folder = freshFolder();
  const KittiHalves halves = kittiHalves(recording, folder);
  const MergeSummary summary = mergeSessions(mergeOf({&halves.even, &halves.odd}, folder / "m"), context(2));
  ASSERT_EQ(summary.pairs.size(), 1u);
  EXPECT_TRUE(summary.pairs[0].joined) << summary.pairs[0].reason;
  EXPECT_EQ(summary.pairs[0].false_loops.value_or(99), 0u);
  EXPECT_LT(*summary.pairs[0].relative_error_m, 0.10);
  EXPECT_LT(*summary.pairs[0].relative_error_deg, 0.2);
  EXPECT_LT(*summary.ate_rmse_m, 1.2 * std::max(*summary.single_ate_rmse_m[0], *summary.single_ate_rmse_m[1]));
}

}  // namespace
}  // namespace scslam::test
