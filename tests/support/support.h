// What all tests share: a temporary folder of their own, data that may be absent, matchers for poses.
#pragma once
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>
#include <optional>
#include <string>

#include "scslam/core/cloud.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/core/pose.h"
#include "scslam/core/registry.h"

namespace scslam::test {

/// An empty folder named after the running test, removed first if it was there.
std::filesystem::path freshFolder();

/// ../shared/data/NAME beside the checkout (or $SCSLAM_DATA/NAME), where it exists.
std::optional<std::filesystem::path> sharedData(const std::string& name);

/// Skips the test, visibly, when the recording is absent (a stranger's clone has none).
#define SCSLAM_NEEDS_DATA(variable, name)                                                       \
  const auto variable##_or_none = ::scslam::test::sharedData(name);                             \
  if (!variable##_or_none) GTEST_SKIP() << "no recording " << (name) << " beside the checkout"; \
  const std::filesystem::path variable = *variable##_or_none

/// Plug-in context with a quiet log and `threads` threads, alive as long as the process.
PluginContext context(int threads = 1);

/// EXPECT_THAT(T, IsNear(expected, 0.01 m, 0.1 deg)); prints both poses and the difference.
MATCHER_P3(IsNear, expected, trans_m, rot_deg, "") {
  const Vector6d d = local(expected, arg);
  const double t = d.head<3>().norm(), r = d.tail<3>().norm() * 180 / M_PI;
  *result_listener << "off by " << t << " m, " << r << " deg; got\n"
                   << arg.matrix() << "\nexpected\n"
                   << Pose(expected).matrix();
  return t <= trans_m && r <= rot_deg;
}

struct RunResult {
  int exit_code = 0;
  std::string out, err;
};
/// Runs the scslam binary with these arguments (shell-quoted by the caller).
RunResult runScslam(const std::string& arguments);

/// A room of 20 x 12 x 4 m with a few boxes, about `points` points on its surfaces, frame: its centre on the floor.
/// Deterministic in `seed`; noise along the normal [m].
Cloud aRoom(std::size_t points, std::uint32_t seed = 1, double noise_m = 0.01);

}  // namespace scslam::test
