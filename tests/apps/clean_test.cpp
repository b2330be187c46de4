// Cleaning where every ray is known: what moved goes, what stands stays, and the session is left alone.
#include "scslam/apps/clean/clean.h"

#include <atomic>

#include "apps/clean_scenes.h"
#include "scslam/apps/doctor.h"
#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "support/town.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

CleanOptions cleanOf(const CleanScene& scene, const fs::path& output) {
  CleanOptions options;
  options.session = scene.session;
  options.labels = scene.labels;
  options.output = output;
  options.quiet = true;
  return options;
}

struct Cleaned {
  fs::path folder;
  CleanSummary summary;
};
const Cleaned& cleaned() {
  static const Cleaned result = [] {
    const fs::path folder = memoryFolder() / "clean" / "cleaned";
    return Cleaned{folder, cleanSession(cleanOf(passingCar(), folder), context(2))};
  }();
  return result;
}

std::size_t pointsIn(const Session& session, const Box& box) {
  std::size_t inside = 0;
  for (std::size_t k = 0; k < session.keyframes().size(); ++k) {
    const Pose T = session.poses()[k] * session.info().T_base_sensor;
    const Cloud cloud = session.cloud(static_cast<KeyframeId>(k));
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Eigen::Vector3d p = T * cloud.point(i).cast<double>();
      inside += (box.low - p).cwiseMax(p - box.high).maxCoeff() < 0.05;
    }
  }
  return inside;
}

TEST(Clean, AMovingCarGoesAndTheRestStays) {
  const CleanScore score = cleaned().summary.score.value();
  EXPECT_GT(score.dynamic_points, 5000u);
  EXPECT_GT(score.da(), 0.98) << cleanTable(cleaned().summary);
  EXPECT_GT(score.sa(), 0.99);
  EXPECT_GT(score.pr(), 0.99);
  EXPECT_GT(score.rr(), 0.97);
}

TEST(Clean, AParkedCarStays) {
  const std::size_t before = pointsIn(Session::open(passingCar().session), parkedCar());
  ASSERT_GT(before, 1000u);
  EXPECT_GE(pointsIn(Session::open(cleaned().folder / "static"), parkedCar()), before - before / 100);
}

TEST(Clean, AStationarySensorSeesACarPass) {
  std::vector<Pose> poses(16, poseFromYaw(0.3, {-3, -1, 0}));
  std::vector<Box> cars;
  for (int k = 0; k < 16; ++k) cars.push_back(carAt(-16 + 2.0 * k, 3));
  const CleanScene scene = cleanScene("standing", poses, cars);
  const CleanScore score = cleanSession(cleanOf(scene, freshFolder() / "out"), context()).score.value();
  EXPECT_GT(score.da(), 0.97);
  EXPECT_GT(score.sa(), 0.99);
}

TEST(Clean, NothingGoesWhereNothingMoves) {
  std::vector<Pose> poses;
  for (int k = 0; k < 12; ++k) poses.push_back(poseFromYaw(0.02 * k, {-12 + 1.5 * k, -1, 0}));
  const CleanScene scene = cleanScene("nothing", poses, std::vector<Box>(12, carAt(4, 3)));
  const CleanSummary summary = cleanSession(cleanOf(scene, freshFolder() / "out"), context());
  EXPECT_LT(static_cast<double>(summary.removed), 1e-3 * static_cast<double>(summary.points));
}

TEST(Clean, EveryPointIsInOneOfTheTwoSessions) {
  const Session all = Session::open(passingCar().session);
  const Session stays = Session::open(cleaned().folder / "static"), goes = Session::open(cleaned().folder / "dynamic");
  ASSERT_EQ(stays.keyframes().size(), all.keyframes().size());
  ASSERT_EQ(goes.keyframes().size(), all.keyframes().size());
  for (KeyframeId k = 0; k < all.keyframes().size(); ++k) {
    const Cloud whole = all.cloud(k), a = stays.cloud(k), b = goes.cloud(k);
    ASSERT_EQ(a.size() + b.size(), whole.size());
    std::size_t in_a = 0, in_b = 0;
    for (std::size_t i = 0; i < whole.size(); ++i)
      if (in_a < a.size() && a.point(in_a) == whole.point(i))
        ++in_a;
      else if (in_b < b.size() && b.point(in_b) == whole.point(i))
        ++in_b;
    EXPECT_EQ(in_a + in_b, whole.size()) << "keyframe " << k;
    EXPECT_EQ(stays.poses()[k].matrix(), all.poses()[k].matrix());
  }
}

TEST(Clean, TheResultIsASessionThatCanBeCleanedAgain) {
  EXPECT_TRUE(Session::open(cleaned().folder / "static").complete());
  for (const DoctorCheck& check : examine(cleaned().folder / "static")) EXPECT_TRUE(check.sound) << check.finding;
  CleanOptions again;
  again.session = cleaned().folder / "static";
  again.output = freshFolder() / "again";
  again.quiet = true;
  const CleanSummary summary = cleanSession(again, context());
  EXPECT_LT(static_cast<double>(summary.removed), 2e-3 * static_cast<double>(summary.points));
}

TEST(Clean, SameBytesForAnyNumberOfThreadsAndTheSessionIsLeftAlone) {
  const auto before = contents(passingCar().session);
  const fs::path folder = freshFolder() / "one";
  cleanSession(cleanOf(passingCar(), folder), context(1));
  EXPECT_EQ(contents(folder, {"clean.json"}), contents(cleaned().folder, {"clean.json"}));
  EXPECT_EQ(contents(passingCar().session), before);
}

TEST(Clean, WithLittleMemoryTheResultIsTheSame) {
  CleanOptions options = cleanOf(passingCar(), freshFolder() / "little");
  options.sets = {"clean.cache_mb=0"};
  cleanSession(options, context());
  EXPECT_EQ(contents(options.output, {"clean.json"}), contents(cleaned().folder, {"clean.json"}));
}

void expectRefused(const CleanOptions& options, ExitCode code, const std::string& words) {
  try {
    cleanSession(options, context());
    ADD_FAILURE() << "not refused: " << words;
  } catch (const Error& error) {
    EXPECT_EQ(error.code(), code) << error.what();
    EXPECT_THAT(error.what(), HasSubstr(words));
  }
  EXPECT_FALSE(fs::exists(options.output.string() + ".partial"));
}

TEST(CleanRefuses, WhatCannotBeCleanedOrScoredAndLeavesNothing) {
  const fs::path folder = freshFolder();
  CleanOptions one = cleanOf(cleanScene("one", {Pose::Identity()}, {carAt(5, 3)}), folder / "one");
  expectRefused(one, ExitCode::kInput, "one keyframe");
  CleanOptions options = cleanOf(passingCar(), folder / "out");
  options.labels = folder / "nowhere";
  expectRefused(options, ExitCode::kInput, "nowhere");
  options.labels = cleanScene("other", {Pose::Identity(), Pose::Identity()}, {carAt(5, 3), carAt(6, 3)}).labels;
  expectRefused(options, ExitCode::kInput, "labels");
  options = cleanOf(passingCar(), folder / "out");
  options.sets = {"clean.later_view=3"};
  expectRefused(options, ExitCode::kUsage, "later_views");
  EXPECT_FALSE(fs::exists(folder / "out"));
}

TEST(CleanRefuses, ToReplaceWithoutBeingTold) {
  CleanOptions options = cleanOf(passingCar(), freshFolder() / "out");
  fs::create_directories(options.output);
  writeFileAtomically(options.output / "thesis.tex", "\\cite{kim2022}");
  options.overwrite = true;
  expectRefused(options, ExitCode::kUsage, "no cleaned session");
  EXPECT_TRUE(fs::exists(options.output / "thesis.tex"));
  options.output = cleaned().folder;
  options.overwrite = false;
  expectRefused(options, ExitCode::kUsage, "-w");
}

TEST(CleanRefuses, ToGoOnWhenStopped) {
  const std::atomic<bool> stop{true};
  CleanOptions options = cleanOf(passingCar(), freshFolder() / "out");
  options.stop = &stop;
  expectRefused(options, ExitCode::kStopped, "nothing was written");
  EXPECT_FALSE(fs::exists(options.output));
}

TEST(CleanVerb, TellsWhatWentAndDrawsIt) {
  const fs::path out = freshFolder() / "out";
  const RunResult result =
      runScslam(fmt::format("clean '{}' -o '{}' --gt-labels '{}' -q", passingCar().session.string(), out.string(),
                            passingCar().labels.string()));
  ASSERT_EQ(result.exit_code, 0) << result.err;
  EXPECT_THAT(result.out, HasSubstr("removed"));
  EXPECT_GT(fs::file_size(out / "clean.png"), 1000u);
  EXPECT_GT(fs::file_size(out / "static" / "map" / "map.ply"), 1000u);
  EXPECT_EQ(runScslam(fmt::format("clean '{}' -o '{}'", passingCar().session.string(), out.string())).exit_code, 2);
}

}  // namespace
}  // namespace scslam::test
