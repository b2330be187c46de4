// `scslam run INPUT -c radar` on real sweeps and on damaged ones.
#include <fstream>
#include <sstream>

#include "odometry/radar_drive.h"
#include "scslam/apps/run_job.h"
#include "scslam/core/file.h"
#include "scslam/sensor/pose_track.h"
#include "scslam/sensor/radar_sweep.h"
#include "scslam/session/session.h"

namespace scslam {
namespace {

using testing::HasSubstr;
using testing::Not;

RunOptions radarRun(const std::filesystem::path& output, const std::string& frontend) {
  RunOptions options;
  options.configs = {"radar"};
  options.output = output;
  options.quiet = true;
  options.sets = {"odometry.frontend=" + frontend};
  return options;
}

TEST(RadarRun, FollowsTheSweepsOfARealDrive) {
  SCSLAM_NEEDS_DATA(folder, "oxford_radar_tiny");
  const auto out = test::freshFolder();
  RunOptions options = radarRun(out / "s", "radar_surface");
  options.input = folder.string();
  const RunSummary summary = runJob(options, test::context(2));
  EXPECT_EQ(summary.counts.scans, 11u);
  EXPECT_EQ(summary.counts.lost_scans, 0u);
  PoseTrack truth;
  for (const StampedPose& pose : summary.ground_truth->poses) truth.add(pose.stamp, pose.T);
  const auto trajectory = Session::open(out / "s").trajectory();
  double path_m = 0;
  for (std::size_t k = 1; k < trajectory.size(); ++k)
    path_m += (truth.at(trajectory[k].stamp)->translation() - truth.at(trajectory[k - 1].stamp)->translation()).norm();
  EXPECT_NEAR(path_m, 19.9, 0.2);
  const Pose T_true = truth.at(trajectory.front().stamp)->inverse() * *truth.at(trajectory.back().stamp);
  EXPECT_THAT(trajectory.front().T.inverse() * trajectory.back().T, test::IsNear(T_true, 0.03 * path_m, 1.0));
}

/// Sweeps that are already there.
class Sweeps : public ScanSource {
 public:
  explicit Sweeps(std::vector<RadarScan> sweeps) : sweeps_(std::move(sweeps)) {}
  std::optional<Scan> next() override {
    if (next_ == sweeps_.size()) return std::nullopt;
    Scan scan = scanOfSweep(sweeps_[next_]);
    scan.index = next_++;
    return scan;
  }
  std::string description() const override { return "made-up sweeps"; }
  bool planar() const override { return true; }

 private:
  std::vector<RadarScan> sweeps_;
  std::size_t next_ = 0;
};

constexpr std::size_t kSweeps = 30;
const Vector6d kTwist = (Vector6d() << 1, 0, 0, 0, 0, 0.2).finished();

std::vector<RadarScan> driveOf(const std::string& damage) {
  test::RadarSensor sensor;
  sensor.sweep_s = 0.25;
  std::vector<RadarScan> sweeps;
  Pose T = poseFromYaw(0.2, {-2, -3, 0});
  for (std::size_t k = 0; k < kSweeps; ++k, T = retract(T, sensor.sweep_s * kTwist))
    sweeps.push_back(*test::radarAt(k, T, test::roomWorld(), sensor, kTwist).radar);
  RadarScan& hit = sweeps[15];
  if (damage == "dropped azimuths") std::fill_n(hit.valid.begin() + 100, 200, 0);
  if (damage == "zero") std::fill(hit.power.begin(), hit.power.end(), 0);
  if (damage == "saturated") std::fill(hit.power.begin(), hit.power.end(), 255);
  if (damage == "stuck encoder") std::fill(hit.angles.begin() + 200, hit.angles.end(), hit.angles[200]);
  if (damage == "out of order") std::swap(sweeps[15], sweeps[16]);
  if (damage == "nothing measured") std::fill(hit.valid.begin(), hit.valid.end(), 0);
  return sweeps;
}

class DamagedSweeps : public testing::TestWithParam<std::tuple<std::string, std::string>> {};

TEST_P(DamagedSweeps, AreSaidInALineAndTheRunGoesOn) {
  const auto& [damage, line] = GetParam();
  const auto out = test::freshFolder();
  Sweeps source(driveOf(damage));
  RunOptions options = radarRun(out / "s", "radar_surface");
  options.sets.insert(options.sets.end(), {"preprocess.min_range_m=0.5", "radar.k_strongest.min_range_m=0.5"});
  const RunSummary summary = runJob(options, test::context(), source, "test");
  EXPECT_EQ(summary.end, SessionEnd::kDone);
  const bool late = damage == "out of order";
  EXPECT_EQ(summary.counts.scans, late ? kSweeps - 1 : kSweeps);
  EXPECT_EQ(summary.counts.loops, 0u) << "nothing false enters the graph";
  EXPECT_THAT(readFile(out / "s" / "run.log"), HasSubstr(line));
  const auto trajectory = Session::open(out / "s").trajectory();
  const Pose T_end = retract(Pose::Identity(), Vector6d::Zero());
  Pose T_true = T_end;
  for (std::size_t k = 1; k < kSweeps; ++k) T_true = retract(T_true, 0.25 * kTwist);
  EXPECT_THAT(trajectory.front().T.inverse() * trajectory.back().T, test::IsNear(T_true, 0.05, 0.5));
}

INSTANTIATE_TEST_SUITE_P(Kinds, DamagedSweeps,
                         testing::Values(std::tuple("dropped azimuths", "scan 15: 200 of 800 azimuths not measured"),
                                         std::tuple("zero", "scan 15: no echo in it"),
                                         std::tuple("saturated", "scan 15: "),
                                         std::tuple("stuck encoder", "scan 15: 599 of 800 azimuths not measured"),
                                         std::tuple("out of order", "does not come after that of the scan before"),
                                         std::tuple("nothing measured", "scan 15: 800 of 800 azimuths not measured")),
                         [](const auto& tested) {
                           std::string name = std::get<0>(tested.param);
                           std::replace(name.begin(), name.end(), ' ', '_');
                           return name;
                         });

}  // namespace
}  // namespace scslam
