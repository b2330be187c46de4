// tests/scenario/memory_slow_test.cpp: memory does not grow with the length of the drive.
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>

#include "scslam/apps/run_job.h"
#include "scslam/core/voxel_filter.h"
#include "support/support.h"
#include "support/town.h"

namespace scslam {
namespace {

/// The scans of one drive over and over, with stamps and odometry that go on.
class Looping : public ScanSource {
 public:
  Looping(std::vector<Scan> scans, std::size_t total) : scans_(std::move(scans)), total_(total) {}
  std::optional<Scan> next() override {
    if (given_ == total_) return std::nullopt;
    Scan scan = scans_[given_ % scans_.size()];
    scan.index = given_;
    scan.stamp = stampFromSeconds(0.1 * static_cast<double>(given_++));
    return scan;
  }
  std::optional<std::size_t> size() const override { return total_; }
  std::string description() const override { return "a drive repeated"; }

 private:
  std::vector<Scan> scans_;
  std::size_t total_, given_ = 0;
};

/// The 40 real scans out and back where they are, else a made-up drive of 40 scans.
std::vector<Scan> fortyScans(const std::filesystem::path& folder) {
  const auto data = test::sharedData("kitti00_kf000-039");
  const auto tool = std::filesystem::path(SCSLAM_SOURCE_DIR) / "../shared/tools/out_and_back.py";
  if (data && std::filesystem::exists(tool) &&
      std::system(
          fmt::format("python3 '{}' '{}' '{}' >/dev/null", tool.string(), data->string(), folder.string()).c_str()) ==
          0) {
    const auto opened = openSource(folder, test::context());
    const Trajectory odometry = readTrajectory(folder / "odometry.txt");
    std::vector<Scan> scans;
    while (auto scan = opened.source->next()) {
      scan->T_odom_base = odometry.poses.at(scan->index).T;
      scan->cloud = selected(scan->cloud, onePerVoxel(scan->cloud, 0.4));  // disk and time: 2,000 scans are written
      scans.push_back(std::move(*scan));
    }
    return scans;
  }
  const auto truth = test::outAndBack(27.5);
  std::vector<Scan> scans;
  for (const Pose& T : truth) {
    Scan scan;
    scan.cloud = test::Town().scan(T, static_cast<std::uint32_t>(scans.size()), 20000);
    scan.T_odom_base = T;
    scans.push_back(std::move(scan));
  }
  return scans;
}

/// Peak RSS [MB] of a run over `total` scans, in a process of its own; negative when that failed (it says why on
/// stderr).
double peakMb(const std::vector<Scan>& scans, std::size_t total, const std::filesystem::path& output) {
  int ends[2];
  EXPECT_EQ(pipe(ends), 0);
  const pid_t child = fork();
  if (child == 0) {
    double peak = -1;
    try {
      Log log(mrpt::system::LVL_ERROR);
      ThreadPool threads(2);
      Looping source(scans, total);
      RunOptions options;
      options.input = "looping";
      options.output = output;
      options.quiet = true;
      options.sets = {"odometry.frontend=poses", "place.recognisers=[scan_context]", "place.scan_context.candidates=1",
                      "place.look_again=false"};  // every place is seen ten times: one loop each is enough
      peak = runJob(options, {threads, log}, source, "test").peak_rss_mb;
    } catch (const std::exception& error) {
      std::fprintf(stderr, "%s\n", error.what());
    }
    _exit(write(ends[1], &peak, sizeof peak) == sizeof peak ? 0 : 1);
  }
  close(ends[1]);  // so that read() ends with the child, whatever it did
  double peak = -1;
  EXPECT_EQ(read(ends[0], &peak, sizeof peak), static_cast<ssize_t>(sizeof peak));
  int status = 0;
  waitpid(child, &status, 0);
  close(ends[0]);
  EXPECT_GT(peak, 0);
  return peak;
}

TEST(Memory, FiveTimesTheDriveTakesLessThan100MbMore) {
  constexpr std::size_t kShort = 80, kLong = 5 * kShort;
  const auto folder = test::freshFolder();
  const std::vector<Scan> scans = fortyScans(folder / "in");
  const double peak_short = peakMb(scans, kShort, folder / "short");
  std::filesystem::remove_all(folder / "short");
  const double peak_long = peakMb(scans, kLong, folder / "long");
  std::filesystem::remove_all(folder / "long");
  std::printf("peak RSS: %.0f MB over %zu scans, %.0f MB over %zu\n", peak_short, kShort, peak_long, kLong);
  EXPECT_LT(peak_long - peak_short, 100);
}

}  // namespace
}  // namespace scslam
