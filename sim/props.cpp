// Street furniture and plants; vehicles and people are in props_traffic.cpp.
#include "sim/props.h"

#include <algorithm>
#include <cmath>

#include "sim/props_detail.h"

namespace scslam::sim {

using Eigen::Vector3d;

namespace {

/// `count` leaves in an ellipsoid.
void leaves(MeshBuilder& builder, const Vector3d& centre, const Vector3d& radii, double count, double leaf_m,
            RandomSequence& random) {
  builder.foliage(centre, radii, count / (4.0 / 3.0 * M_PI * radii.prod()), leaf_m, random);
}

}  // namespace

void addTree(MeshBuilder& builder, const Vector3d& base, double height, RandomSequence& random, double leaf_share) {
  RandomSequence own = fork(random);
  builder.newInstance();
  const Vector3d up = Vector3d::UnitZ(), root = base - 0.3 * up;
  const double lean = own.uniform(-0.02, 0.02) * height, radius = 0.012 * height + 0.03;
  const Vector3d fork_point = base + Vector3d(lean, lean / 2, own.uniform(0.28, 0.38) * height);
  const Vector3d tip = base + Vector3d(2 * lean, lean, 0.85 * height);
  builder.material("bark");
  builder.cylinder(root, fork_point, radius, 8);
  builder.cylinder(fork_point, tip, 0.55 * radius, 6);
  constexpr int kBranches = 9;
  const double turn = own.uniform(0, 2 * M_PI), leaf_m = 0.2 * std::sqrt(std::max(1.0, height) / 8);
  const double reach = 0.22 * height;
  for (int i = 0; i < kBranches; ++i) {
    const double angle = turn + 2.4 * i, rise = static_cast<double>(i) / (kBranches - 1);
    const Vector3d from = fork_point + (0.75 * rise) * (tip - fork_point);
    const double out = reach * own.uniform(0.75, 1.1) * (1 - 0.45 * rise);
    const Vector3d to = from + Vector3d(std::cos(angle) * out, std::sin(angle) * out, own.uniform(0.35, 0.8) * out);
    builder.material("bark").cylinder(from, to, 0.25 * radius, 4);
    RandomSequence crown = fork(own);
    const double size = 0.13 * height * own.uniform(0.85, 1.15);
    builder.material("leaves");
    leaves(builder, to, Vector3d(size, size, 0.8 * size), 210 * leaf_share, leaf_m, crown);
  }
  RandomSequence crown = fork(own);
  builder.material("leaves");
  leaves(builder, tip, Vector3d(0.14, 0.14, 0.13) * height, 260 * leaf_share, leaf_m, crown);
  builder.noInstance();
}

void addBush(MeshBuilder& builder, const Vector3d& base, double height, RandomSequence& random, double leaf_share) {
  RandomSequence own = fork(random);
  builder.newInstance().material("bark");
  for (int i = 0; i < 5; ++i) {
    const double angle = own.uniform(0, 2 * M_PI), out = 0.3 * height * own.uniform();
    const Vector3d to = base + Vector3d(std::cos(angle) * out, std::sin(angle) * out, 0.8 * height);
    builder.cylinder(base - Vector3d(0, 0, 0.1), to, 0.012, 3);
  }
  builder.material("leaves");
  for (int i = 0; i < 3; ++i) {
    const Vector3d off(own.uniform(-0.2, 0.2) * height, own.uniform(-0.2, 0.2) * height, 0.55 * height);
    RandomSequence part = fork(own);
    leaves(builder, base + off, Vector3d(0.4, 0.4, 0.45) * height, 170 * leaf_share, 0.1 + 0.03 * height, part);
  }
  builder.noInstance();
}

void addPole(MeshBuilder& builder, const Pose& T_world_pole, RandomSequence& random) {
  RandomSequence own = fork(random);
  const auto at = [&](double x, double y, double z) { return Vector3d(T_world_pole * Vector3d(x, y, z)); };
  const double height = own.uniform(5, 9);
  builder.newInstance().material("pole");
  builder.cylinder(at(0, 0, -0.2), at(0, 0, 1), 0.1, 8);
  builder.cylinder(at(0, 0, 1), at(0, 0, height), 0.065, 8);
  builder.cylinder(at(0, 0, height - 0.1), at(1.6, 0, height + 0.15), 0.04, 6);
  builder.box(T_world_pole * poseFromYaw(0, Vector3d(1.6, 0, height + 0.05)), 0.6, 0.22, 0.12);
  builder.noInstance();
}

void addSign(MeshBuilder& builder, const Pose& T_world_sign, RandomSequence& random) {
  RandomSequence own = fork(random);
  const auto at = [&](double x, double y, double z) { return Vector3d(T_world_sign * Vector3d(x, y, z)); };
  const double height = own.uniform(2.2, 2.6), r = own.uniform(0.3, 0.38);
  const int corners = std::array{3, 4, 8, 12}[static_cast<std::size_t>(own.below(4))];
  builder.newInstance().material("pole");
  builder.cylinder(at(0, 0, -0.1), at(0, 0, height + r), 0.035, 6);
  const auto rim = [&](double x, int k) {
    const double angle = M_PI / 2 + (corners == 4 ? M_PI / 4 : 0) + 2 * M_PI * k / corners;
    return at(x, r * std::cos(angle), height + r * std::sin(angle));
  };
  for (int k = 0; k < corners; ++k) {
    builder.material("sign").triangle(at(0.06, 0, height), rim(0.06, k), rim(0.06, k + 1));
    builder.material("pole").triangle(at(0.045, 0, height), rim(0.045, k + 1), rim(0.045, k));
  }
  builder.noInstance();
}

void addTrafficLight(MeshBuilder& builder, const Pose& T_world_light, RandomSequence& random) {
  RandomSequence own = fork(random);
  const double height = own.uniform(2.4, 3.2);
  builder.newInstance().material("pole");
  builder.cylinder(T_world_light * Vector3d(0, 0, -0.2), T_world_light * Vector3d(0, 0, height + 0.9), 0.06, 8);
  builder.material("black");
  builder.box(T_world_light * poseFromYaw(0, Vector3d(0.2, 0, height)), 0.22, 0.28, 0.85);
  builder.box(T_world_light * poseFromYaw(0, Vector3d(0.1, 0, height - 0.12)), 0.02, 0.55, 1.09);
  builder.material("pole");
  for (int k = 0; k < 3; ++k)  // hoods
    builder.box(T_world_light * poseFromYaw(0, Vector3d(0.37, 0, height + 0.24 + 0.27 * k)), 0.13, 0.2, 0.015);
  builder.box(T_world_light * poseFromYaw(0, Vector3d(0.1, 0, 1.0)), 0.1, 0.1, 0.22);  // push button
  builder.noInstance();
}

void addBench(MeshBuilder& builder, const Pose& T_world_bench, RandomSequence& random) {
  fork(random);
  const auto slat = [&](double x, double z, double depth, double height) {
    builder.box(T_world_bench * poseFromYaw(0, Vector3d(x, 0, z)), depth, 1.8, height);
  };
  builder.newInstance().material("default");
  for (int k = 0; k < 4; ++k) slat(-0.18 + 0.125 * k, 0.42, 0.1, 0.03);
  for (int k = 0; k < 3; ++k) slat(-0.27 - 0.02 * k, 0.52 + 0.13 * k, 0.03, 0.1);
  for (const double y : {-0.75, 0.75}) {
    builder.box(T_world_bench * poseFromYaw(0, Vector3d(0.15, y, 0)), 0.05, 0.05, 0.42);
    builder.box(T_world_bench * poseFromYaw(0, Vector3d(-0.24, y, 0)), 0.05, 0.05, 0.88);
    builder.box(T_world_bench * poseFromYaw(0, Vector3d(-0.04, y, 0.37)), 0.45, 0.05, 0.05);
  }
  builder.noInstance();
}

void addBin(MeshBuilder& builder, const Pose& T_world_bin, RandomSequence& random) {
  RandomSequence own = fork(random);
  const bool wheeled = own.uniform() < 0.5;
  const double height = own.uniform(0.8, 1.1);
  builder.newInstance().material("default");
  if (wheeled) {
    builder.prism(T_world_bin, {{-0.24, 0.05}, {0.22, 0.05}, {0.3, height}, {-0.32, height}}, -0.26, 0.26);
    builder.prism(T_world_bin, {{-0.34, height}, {0.33, height}, {0.3, height + 0.06}, {-0.34, height + 0.1}}, -0.29,
                  0.29);
  } else {
    builder.cylinder(T_world_bin * Vector3d(0, 0, 0.1), T_world_bin * Vector3d(0, 0, height), 0.24, 12);
    builder.cylinder(T_world_bin * Vector3d(0, 0, -0.1), T_world_bin * Vector3d(0, 0, 0.1), 0.08, 6);
  }
  builder.noInstance();
}

void addFence(MeshBuilder& builder, const Vector3d& a, const Vector3d& b, double height, FenceKind kind) {
  const Vector3d up = Vector3d::UnitZ(), along = b - a;
  const double length = along.head<2>().norm();
  if (!(length > 0.05)) return;
  const double yaw = std::atan2(along.y(), along.x());
  const auto upright = [&](double s, double thick, double from, double to) {
    builder.box(a + along * s + from * up, thick, thick, to - from, yaw);
  };
  builder.newInstance().material(kind == FenceKind::kGuardRail ? "guard_rail" : "fence");
  const int spans = std::max(1, static_cast<int>(std::lround(length / (kind == FenceKind::kGuardRail ? 4.0 : 2.5))));
  for (int i = 0; i <= spans; ++i) upright(static_cast<double>(i) / spans, 0.08, -0.2, height);
  Pose frame = poseFromYaw(yaw, a);
  frame.linear().col(0) = along / length;  // sheared, not turned: what stands upright stays upright
  const auto band = [&](double y, double z, double thick, double tall) {
    builder.prism(frame, {{0, z}, {length, z}, {length, z + tall}, {0, z + tall}}, y - thick / 2, y + thick / 2);
  };
  if (kind == FenceKind::kGuardRail) {
    band(0.07, height - 0.31, 0.05, 0.31);
  } else if (kind == FenceKind::kRails) {
    for (int k = 1; k <= 3; ++k) band(0.05, height * k / 3 - 0.12, 0.03, 0.1);
  } else {
    band(0, 0.12, 0.03, 0.04), band(0, height - 0.08, 0.03, 0.04);
    const int bars = static_cast<int>(length / 0.14);
    for (int i = 1; i < bars; ++i) upright(static_cast<double>(i) / bars, 0.018, 0.12, height - 0.04);
  }
  builder.noInstance();
}

}  // namespace scslam::sim
