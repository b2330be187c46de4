// tests/scenario/kill_slow_test.cpp: SIGKILL at any moment, --resume, same bytes.
#include <csignal>
#include <random>
#include <thread>

#include <sys/wait.h>
#include <unistd.h>

#include "scslam/session/session.h"
#include "support/support.h"
#include "support/town.h"

namespace scslam {
namespace {

namespace fs = std::filesystem;

pid_t start(const fs::path& in, const fs::path& out, bool resume) {
  const pid_t child = fork();
  if (child != 0) return child;
  freopen("/dev/null", "w", stderr);
  freopen("/dev/null", "w", stdout);
  execl(SCSLAM_BINARY, "scslam", "run", in.c_str(), "-o", out.c_str(), "-q", "--set", "session.checkpoint_every=5",
        resume ? "--resume" : "-w", nullptr);
  _exit(127);
}

TEST(Kill, TwentyKillsAtRandomMomentsEndInTheBytesOfAnUndisturbedRun) {
  const auto folder = test::freshFolder();
  const auto truth = test::aroundTheBlock(2.5, 1.15);
  test::writeKittiDrive(folder / "in", test::Town(), truth, truth, 3000);
  const auto run_time = [&] {
    const auto begin = std::chrono::steady_clock::now();
    int status = 0;
    waitpid(start(folder / "in", folder / "undisturbed", false), &status, 0);
    EXPECT_EQ(WEXITSTATUS(status), 0);
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  }();
  const auto expected = test::contents(folder / "undisturbed");
  std::mt19937 random(2026);
  int kills = 0, rounds = 0;
  while (kills < 20 && ++rounds < 60) {
    fs::remove_all(folder / "s");
    bool resume = false;
    while (true) {  // killed again and again until one run gets through
      const pid_t child = start(folder / "in", folder / "s", resume);
      const double wait_s = run_time * 0.7 * (random() % 1000) / 1000.0 + 0.02;
      const auto until = std::chrono::steady_clock::now() + std::chrono::duration<double>(wait_s);
      int status = 0;
      pid_t ended = 0;
      while ((ended = waitpid(child, &status, WNOHANG)) == 0 && std::chrono::steady_clock::now() < until)
        std::this_thread::sleep_for(std::chrono::milliseconds(1));
      if (ended == 0 && kills < 20) {
        kill(child, SIGKILL);
        waitpid(child, &status, 0);
        ++kills;
        resume = fs::exists(folder / "s/session.yaml");
        if (resume) {
          EXPECT_NO_THROW(Session::open(folder / "s")) << "kill " << kills;
        }
        continue;
      }
      if (ended == 0) waitpid(child, &status, 0);
      ASSERT_TRUE(WIFEXITED(status));
      ASSERT_EQ(WEXITSTATUS(status), 0) << "after kill " << kills;
      break;
    }
    EXPECT_EQ(test::contents(folder / "s"), expected) << "after kill " << kills;
  }
  EXPECT_EQ(kills, 20);
}

}  // namespace
}  // namespace scslam
