// tests/cli/bad_input_test.cpp: one clear line, the documented exit code, nothing lost.
#include <mrpt/system/filesystem.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <fstream>
#include <random>
#include <thread>

#include "scslam/core/file.h"
#include "scslam/core/pcd.h"
#include "scslam/session/session.h"
#include "support/support.h"
#include "support/town.h"

namespace scslam {
namespace {

namespace fs = std::filesystem;
using test::RunResult;
using test::runScslam;
using testing::HasSubstr;

/// The one line of the error, without its "error: ".
std::string errorLine(const RunResult& result) {
  std::string found;
  std::size_t begin = 0;
  while (begin < result.err.size()) {
    const std::size_t end = std::min(result.err.find('\n', begin), result.err.size());
    const std::string line = result.err.substr(begin, end - begin);
    if (line.starts_with("error: ")) {
      EXPECT_TRUE(found.empty()) << "more than one error line:\n" << result.err;
      found = line.substr(7);
    }
    begin = end + 1;
  }
  EXPECT_THAT(found, testing::Not(HasSubstr("bug"))) << result.err;
  return found;
}

/// A folder of `n` PCD scans along a street.
fs::path pcdFolder(const fs::path& folder, int n, std::size_t points = 1500) {
  fs::create_directories(folder);
  const test::Town town;
  for (int i = 0; i < n; ++i)
    writeFileAtomically(folder / fmt::format("{:06d}.pcd", i),
                        encodePcd(town.scan(poseFromYaw(0, {1.0 * i, 0, 1.7}), static_cast<std::uint32_t>(i), points)));
  return folder;
}

RunResult run(const fs::path& input, const fs::path& output, const std::string& more = "") {
  return runScslam(fmt::format("run '{}' -o '{}' {}", input.string(), output.string(), more));
}

TEST(BadInput, NoFlagsAndUnknownVerbsAreUsageErrors) {
  EXPECT_EQ(runScslam("").exit_code, 2);
  EXPECT_EQ(runScslam("rnu x").exit_code, 2);
  EXPECT_EQ(runScslam("run").exit_code, 2);
  EXPECT_EQ(runScslam("run x --no-such-flag").exit_code, 2);
  EXPECT_EQ(runScslam("--help").exit_code, 0);
  EXPECT_EQ(runScslam("run --help").exit_code, 0);
}

TEST(BadInput, AbsentPathAndEmptyFolderAreUnreadable) {
  const auto folder = test::freshFolder();
  RunResult r = run(folder / "absent", folder / "s");
  EXPECT_EQ(r.exit_code, 3);
  EXPECT_THAT(errorLine(r), HasSubstr("absent"));
  fs::create_directories(folder / "empty");
  r = run(folder / "empty", folder / "s");
  EXPECT_EQ(r.exit_code, 3);
  EXPECT_THAT(errorLine(r), HasSubstr("empty"));
  EXPECT_FALSE(fs::exists(folder / "s")) << "nothing is made when nothing can be read";
}

TEST(BadInput, TruncatedPcdAnywhereNeverCrashesAndKeepsWhatCameBefore) {
  const auto folder = test::freshFolder();
  pcdFolder(folder / "in", 3, 600);
  const std::string whole = readFile(folder / "in/000002.pcd");
  std::mt19937 random(5);
  for (int i = 0; i < 50; ++i) {
    const std::size_t cut = i == 0 ? 0 : random() % whole.size();
    std::ofstream(folder / "in/000002.pcd", std::ios::binary) << whole.substr(0, cut);
    const RunResult r = run(folder / "in", folder / "s", "-w -q");
    EXPECT_EQ(r.exit_code, 4) << "cut at " << cut << "\n" << r.err;
    EXPECT_THAT(r.err, HasSubstr("000002.pcd")) << cut;
    EXPECT_EQ(Session::open(folder / "s").scans().size(), 2u) << cut;
  }
}

TEST(BadInput, TruncatedRawlogAnywhereEndsCleanly) {
  const auto folder = test::freshFolder();
  const fs::path original =
      fs::path(mrpt::system::getShareMRPTDir()) / "datasets/2006-01ENE-21-SENA_Telecom Faculty_one_loop_only.rawlog";
  ASSERT_TRUE(fs::exists(original)) << "package mrpt-common";
  const std::string whole = readFile(original);
  std::mt19937 random(6);
  for (int i = 0; i < 50; ++i) {
    const std::size_t cut = random() % whole.size();
    std::ofstream(folder / "cut.rawlog", std::ios::binary | std::ios::trunc) << whole.substr(0, cut);
    const RunResult r = run(folder / "cut.rawlog", folder / "s", "-w -q --max 40");
    EXPECT_TRUE(r.exit_code == 0 || r.exit_code == 3 || r.exit_code == 4)
        << "cut at " << cut << ": " << r.exit_code << "\n"
        << r.err;
    if (r.exit_code == 0) {
      EXPECT_EQ(Session::open(folder / "s").scans().size(), 40u) << "all that was asked for, or an error";
    }
    if (r.exit_code == 4) {
      EXPECT_GT(Session::open(folder / "s").scans().size(), 0u);
    }
    if (r.exit_code != 0) {
      EXPECT_THAT(r.err, HasSubstr("cut.rawlog"));
    }
  }
}

TEST(BadInput, PcdThatLiesAboutItsPointsIsRefusedWithoutAllocating) {
  const auto folder = test::freshFolder();
  pcdFolder(folder / "in", 1, 600);
  const std::string whole = readFile(folder / "in/000000.pcd");
  const auto withPoints = [&](const std::string& count) {
    std::string text = whole;
    for (const char* key : {"WIDTH ", "POINTS "}) {
      const std::size_t at = text.find(key) + std::string(key).size();
      text.replace(at, text.find('\n', at) - at, count);
    }
    std::ofstream(folder / "in/000000.pcd", std::ios::binary) << text;
    return run(folder / "in", folder / "s", "-w -q");
  };
  for (const char* count : {"999999999999", "-5", "18446744073709551615", "4294967296", "many", ""}) {
    const RunResult r = withPoints(count);
    EXPECT_EQ(r.exit_code, 3) << count << "\n" << r.err;
    EXPECT_THAT(errorLine(r), HasSubstr("000000.pcd")) << count;
  }
  std::ofstream(folder / "in/000000.pcd", std::ios::binary) << whole << std::string(3908, 'x');
  EXPECT_EQ(run(folder / "in", folder / "s", "-w -q").exit_code, 0)
      << "bytes after the last point, as the classic saver leaves";
}

TEST(BadInput, NanAndInfinitePointsAreDropped) {
  const auto folder = test::freshFolder();
  pcdFolder(folder / "in", 3);
  Cloud cloud = readPcd(folder / "in/000001.pcd");
  for (std::size_t i = 0; i < cloud.size(); i += 3) cloud.x[i] = i % 2 == 0 ? NAN : INFINITY;
  writeFileAtomically(folder / "in/000001.pcd", encodePcd(cloud));
  const RunResult r = run(folder / "in", folder / "s");
  EXPECT_EQ(r.exit_code, 0) << r.err;
  const Session session = Session::open(folder / "s");
  for (const auto& keyframe : session.keyframes()) {
    const Cloud saved = session.cloud(keyframe.id);
    for (std::size_t i = 0; i < saved.size(); ++i) ASSERT_TRUE(std::isfinite(saved.x[i]));
  }
}

TEST(BadInput, AnEmptyScanInTheMiddleIsCountedAndTheRunGoesOn) {
  const auto folder = test::freshFolder();
  pcdFolder(folder / "in", 6);
  writeFileAtomically(folder / "in/000003.pcd", encodePcd(Cloud()));
  const RunResult r = run(folder / "in", folder / "s");
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(r.out, HasSubstr("1 without points"));
  EXPECT_EQ(Session::open(folder / "s").scans().size(), 6u);
}

TEST(BadInput, StampsThatGoBackOrRepeatAreLeftOutAndSaid) {
  const auto folder = test::freshFolder();
  test::writeKittiDrive(folder / "in", test::Town(), test::outAndBack(12), test::outAndBack(12), 1500);
  std::string times;
  const auto scans = std::distance(fs::directory_iterator(folder / "in/velodyne"), {});
  for (int i = 0; i < scans; ++i) times += fmt::format("{}\n", i == 4 ? 0.2 : i == 6 ? 0.5 : 0.1 * i);
  writeFileAtomically(folder / "in/times.txt", times);
  const RunResult r = run(folder / "in", folder / "s", "-v");
  EXPECT_EQ(r.exit_code, 0) << r.err;
  EXPECT_THAT(r.err, HasSubstr("scan 4: its time"));
  EXPECT_THAT(r.err, HasSubstr("scan 6: its time"));
  EXPECT_EQ(Session::open(folder / "s").scans().size(), static_cast<std::size_t>(scans) - 2);
}

TEST(BadInput, APoseFileOneLineShortIsNamedWithBothCounts) {
  const auto folder = test::freshFolder();
  const auto truth = test::outAndBack(10);
  test::writeKittiDrive(folder / "in", test::Town(), truth, truth, 800);
  auto fewer = truth;
  fewer.pop_back();
  writeFileAtomically(folder / "short.txt", formatKitti(fewer));
  const RunResult r = run(folder / "in", folder / "s", "--poses '" + (folder / "short.txt").string() + "'");
  EXPECT_EQ(r.exit_code, 3) << r.err;
  EXPECT_THAT(errorLine(r), testing::AllOf(HasSubstr("short.txt"), HasSubstr(std::to_string(truth.size())),
                                           HasSubstr(std::to_string(fewer.size()))));
}

TEST(BadInput, UnknownKeyNamesLineColumnAndTheKeyThatWasMeant) {
  const auto folder = test::freshFolder();
  pcdFolder(folder / "in", 2, 600);
  writeFileAtomically(folder / "my.yaml", "keyframe:\n  distance_n: 2\n");
  RunResult r = run(folder / "in", folder / "s", "-c '" + (folder / "my.yaml").string() + "'");
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_THAT(errorLine(r), testing::AllOf(HasSubstr("my.yaml:2:3"), HasSubstr("did you mean 'distance_m'")));
  EXPECT_FALSE(fs::exists(folder / "s"));
  r = run(folder / "in", folder / "s", "--odometry voxel_icq");
  EXPECT_EQ(r.exit_code, 2);
  EXPECT_THAT(errorLine(r), HasSubstr("voxel_icp"));
  EXPECT_EQ(run(folder / "in", folder / "s", "-c absent.yaml").exit_code, 2);
}

TEST(BadInput, AnExistingOutputIsNeverTouchedWithoutLeaveAndOnlyIfItIsASession) {
  const auto folder = test::freshFolder();
  pcdFolder(folder / "in", 2, 600);
  fs::create_directories(folder / "precious");
  writeFileAtomically(folder / "precious/thesis.tex", "years of work");
  for (const char* flag : {"", "-w"}) {
    const RunResult r = run(folder / "in", folder / "precious", flag);
    EXPECT_EQ(r.exit_code, 2);
    EXPECT_THAT(errorLine(r), HasSubstr("precious"));
    EXPECT_EQ(readFile(folder / "precious/thesis.tex"), "years of work");
  }
  EXPECT_EQ(run(folder / "in", folder / "s").exit_code, 0);
  const RunResult again = run(folder / "in", folder / "s");
  EXPECT_EQ(again.exit_code, 2);
  EXPECT_THAT(errorLine(again), testing::AllOf(HasSubstr("-w"), HasSubstr("--resume")));
  EXPECT_EQ(run(folder / "in", folder / "s", "-w").exit_code, 0);
}

TEST(BadInput, AFullDiskIsOneLineAndTheSessionCanGoOn) {
  const auto folder = test::freshFolder();
  pcdFolder(folder / "in", 8, 20000);
  // A file size limit stands in for the full disk: write() fails in the middle of a scan in the same way. (A coverage
  // build's own files are smaller.)
  const std::string limited = fmt::format("(ulimit -f 150; trap '' XFSZ; '{}' run '{}' -o '{}' -q)", SCSLAM_BINARY,
                                          (folder / "in").string(), (folder / "s").string());
  const std::string err_file = (folder / "err").string();
  const int status = std::system(("bash -c \"" + limited + "\" 2>" + err_file).c_str());
  const std::string err = readFile(err_file);
  EXPECT_EQ(WEXITSTATUS(status), 3) << err;
  EXPECT_THAT(err, HasSubstr("cannot write"));
  EXPECT_EQ(std::count(err.begin(), err.end(), '\n'), 1) << err;
  const RunResult resumed = run(folder / "in", folder / "s", "--resume");
  EXPECT_EQ(resumed.exit_code, 0) << resumed.err;
  EXPECT_EQ(Session::open(folder / "s").scans().size(), 8u);
}

TEST(BadInput, AnAnswerThatFindsNoRoomIsSaid) {
  const std::string err_file = (test::freshFolder() / "err").string();
  const int status = std::system(fmt::format("'{}' list >/dev/full 2>'{}'", SCSLAM_BINARY, err_file).c_str());
  EXPECT_EQ(WEXITSTATUS(status), 3);
  EXPECT_THAT(readFile(err_file), HasSubstr("cannot write"));
}

TEST(BadInput, CtrlCFlushesAValidSessionThatGoesOnToTheSameBytes) {
  const auto folder = test::freshFolder();
  pcdFolder(folder / "in", 30, 20000);
  ASSERT_EQ(run(folder / "in", folder / "undisturbed", "-q").exit_code, 0);
  const pid_t child = fork();
  ASSERT_GE(child, 0);
  if (child == 0) {
    freopen("/dev/null", "w", stderr);
    freopen("/dev/null", "w", stdout);
    execl(SCSLAM_BINARY, "scslam", "run", (folder / "in").c_str(), "-o", (folder / "s").c_str(), "-q", nullptr);
    _exit(127);
  }
  for (int i = 0; i < 30000 && !fs::exists(folder / "s/Scans/000003.pcd"); ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  kill(child, SIGINT);
  int status = 0;
  waitpid(child, &status, 0);
  ASSERT_TRUE(WIFEXITED(status));
  EXPECT_EQ(WEXITSTATUS(status), 130);
  const Session stopped = Session::open(folder / "s");
  EXPECT_TRUE(stopped.complete());
  EXPECT_GE(stopped.keyframes().size(), 3u);
  EXPECT_EQ(runScslam("doctor '" + (folder / "s").string() + "'").exit_code, 0);
  ASSERT_EQ(run(folder / "in", folder / "s", "--resume -q").exit_code, 0);
  EXPECT_EQ(test::contents(folder / "s"), test::contents(folder / "undisturbed"));
}

}  // namespace
}  // namespace scslam
