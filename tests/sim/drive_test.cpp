// Drives planned along routes.
#include "sim/drive.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace scslam::sim {
namespace {

/// Distance of p from the outline of a square of this side with a corner at (100, 100) [m].
double fromSquare(const Eigen::Vector3d& p, double side) {
  const Eigen::Vector2d d = (p.head<2>() - Eigen::Vector2d::Constant(100 + side / 2)).cwiseAbs();
  return std::abs(d.maxCoeff() - side / 2);
}

TEST(PlanDrive, ClosedRoutesOfAnyLengthAreFollowedLapAfterLap) {
  const auto flat = [](double, double, double) { return 0.0; };
  for (double side = 20; side < 90; side += 0.25) {
    const double a = 100, b = 100 + side;
    const Route square{"square", {{a, a, 0}, {b, a, 0}, {b, b, 0}, {a, b, 0}}, true};
    DriveParams drive;
    drive.laps = 2, drive.duration_s = 1e4;
    const Trajectory trajectory = planDrive(drive, {square}, flat);
    for (double t = 0; t < trajectory.duration(); t += 0.2)
      ASSERT_LT(fromSquare(trajectory.pose(t).translation(), side), 3) << "side " << side << " m, at " << t << " s";
  }
}

}  // namespace
}  // namespace scslam::sim
