// CPU time of an odometry front-end per scan, over a recording:
//   odometry_bench INPUT [FRONTEND [key=value ...]] [gt=FILE]
// Reading and decoding are not counted. One thread; compare ratios, not machines. With a truth (TUM or KITTI) also the
// errors of `scslam eval`, and the steps' mean normalised squared error: 6 where the covariance is honest.
#include <fmt/core.h>

#include <algorithm>
#include <cstdlib>
#include <ctime>
#include <exception>
#include <string_view>
#include <vector>

#include "scslam/apps/trajectory_error.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/odometry/odometry.h"
#include "scslam/sensor/scan_source.h"

namespace {

double threadCpuMs() {
  timespec t{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

double quantile(std::vector<double> values, double q) {
  if (values.empty()) return 0;
  std::sort(values.begin(), values.end());
  return values[std::min(values.size() - 1, static_cast<std::size_t>(q * static_cast<double>(values.size())))];
}

/// Steps beside the truth.
struct Truth {
  scslam::Trajectory trajectory;
  std::vector<scslam::Pose> truth, estimate;  ///< at the scans that have both
  std::vector<double> nees;

  void add(const scslam::Scan& scan, const scslam::OdometryStep& step, std::size_t row) {
    std::optional<scslam::Pose> T_world_base;
    if (trajectory.timed) T_world_base = trajectory.at(scan.stamp);
    if (!trajectory.timed && row < trajectory.poses.size())
      T_world_base = scslam::orthonormalised(trajectory.poses[row].T);
    if (!T_world_base) return;
    if (!truth.empty() && step.quality.ok) {
      const scslam::Vector6d d =
          scslam::local(truth.back().inverse() * *T_world_base, estimate.back().inverse() * step.T_odom_base);
      const scslam::Matrix6d covariance = step.covariance + scslam::Matrix6d(step.passing.asDiagonal());
      nees.push_back(d.dot(covariance.inverse() * d));
    }
    truth.push_back(*T_world_base);
    estimate.push_back(step.T_odom_base);
  }

  void print() const {
    if (truth.empty()) return;
    const auto ate = scslam::absoluteError(truth, estimate);
    const auto rpe = scslam::relativeError(truth, estimate);
    double sum = 0;
    for (const double value : nees) sum += value;
    fmt::print("ATE {:.4f} m (max {:.4f}), RPE {:.4f} % {:.5f} deg/m; NEES mean {:.2f} median {:.2f} of 6\n",
               ate.rmse_m, ate.max_m, rpe.trans_percent, rpe.rot_deg_per_m,
               sum / static_cast<double>(std::max<std::size_t>(nees.size(), 1)), quantile(nees, 0.5));
  }
};

struct Tally {
  std::vector<double> ms, inliers, rmse_m;
  std::size_t points = 0, lost = 0, noted = 0;
  double travelled_m = 0;
  scslam::Pose T_odom_base = scslam::Pose::Identity();
};

void print(const Tally& tally) {
  const auto& t = tally.T_odom_base.translation();
  fmt::print("scans {}  points/scan {}  lost {}  noted {}\n", tally.ms.size(),
             tally.points / std::max<std::size_t>(tally.ms.size(), 1), tally.lost, tally.noted);
  fmt::print("CPU ms/scan: median {:.2f}  p95 {:.2f}  max {:.2f}\n", quantile(tally.ms, 0.5), quantile(tally.ms, 0.95),
             quantile(tally.ms, 1.0));
  fmt::print("inlier ratio: median {:.3f}  p5 {:.3f}; rmse median {:.4f} m\n", quantile(tally.inliers, 0.5),
             quantile(tally.inliers, 0.05), quantile(tally.rmse_m, 0.5));
  fmt::print("travelled {:.2f} m, ends at {:.3f} {:.3f} {:.3f}, yaw {:.3f} deg\n", tally.travelled_m, t.x(), t.y(),
             t.z(), scslam::yawOf(tally.T_odom_base) * 180 / M_PI);
}

int run(int argc, char** argv) {
  scslam::ThreadPool threads(1);
  scslam::Log log(mrpt::system::LVL_WARN);
  const auto& entry = scslam::Registry<scslam::Odometry>::instance().find(argc > 2 ? argv[2] : "voxel_icp");
  const auto params = entry.defaults();
  Truth truth;
  for (int i = 3; i < argc; ++i) {
    const std::string_view argument = argv[i];
    if (argument.starts_with("gt="))
      truth.trajectory = scslam::readTrajectory(argument.substr(3));
    else
      scslam::setParam(*params, argv[i]);
  }
  const scslam::PluginContext context{threads, log};
  const auto odometry = entry.create(*params, context);
  const auto source = scslam::openSource(argv[1], context).source;
  odometry->begin(source->size(), source->T_base_reference());
  Tally tally;
  while (const auto scan = source->next()) {
    const double start = threadCpuMs();
    const scslam::OdometryStep step = odometry->step(*scan);
    tally.ms.push_back(threadCpuMs() - start);
    tally.points += scan->cloud.size();
    tally.lost += !step.quality.ok;
    tally.noted += !step.quality.note.empty();
    tally.inliers.push_back(step.quality.inlier_ratio);
    tally.rmse_m.push_back(step.quality.rmse_m);
    tally.travelled_m += (step.T_odom_base.translation() - tally.T_odom_base.translation()).norm();
    tally.T_odom_base = step.T_odom_base;
    truth.add(*scan, step, tally.ms.size() - 1);
  }
  print(tally);
  truth.print();
  return EXIT_SUCCESS;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc < 2) {
    fmt::print(stderr, "usage: {} INPUT [FRONTEND [key=value ...]] [gt=FILE]\n", argv[0]);
    return 2;
  }
  try {
    return run(argc, argv);
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return 3;
  }
}
