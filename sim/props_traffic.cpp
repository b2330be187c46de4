// Vehicles and people of props.h.
#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "sim/props.h"
#include "sim/props_detail.h"

namespace scslam::sim {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

/// A cabin: rectangle x0 … x1 at height z0 that narrows to x2 … x3 at z1; half widths w0, w1 [m].
struct Cabin {
  double x0, x1, z0, w0, x2, x3, z1, w1;
};

/// Roof and pillars of paint, windows of glass; the sides have `windows` windows each.
void addCabin(MeshBuilder& builder, const Pose& T, const Cabin& c, const std::string& paint, int windows) {
  // Corners clockwise seen from below … at the bottom (level 0) and top (level 1): rear right, front right, front left,
  // rear left.
  const auto corner = [&](int k, double level) {
    const double x = k == 1 || k == 2 ? c.x1 + (c.x3 - c.x1) * level : c.x0 + (c.x2 - c.x0) * level;
    const double y = (c.w0 + (c.w1 - c.w0) * level) * (k == 2 || k == 3 ? 1 : -1);
    return Vector3d(T * Vector3d(x, y, c.z0 + (c.z1 - c.z0) * level));
  };
  const auto strip = [&](int k, double u0, double u1, double v0, double v1) {
    const auto p = [&](double u, double v) { return Vector3d(corner(k, v) * (1 - u) + corner((k + 1) % 4, v) * u); };
    builder.quad(p(u0, v0), p(u1, v0), p(u1, v1), p(u0, v1));
  };
  for (int k = 0; k < 4; ++k) {
    const int panes = k % 2 == 0 ? windows : 1;
    const double pillar = k % 2 == 0 ? 0.05 : 0.04;
    builder.material(paint);
    strip(k, 0, 1, 0.9, 1);
    for (int i = 0; i <= panes; ++i) {
      const double middle = static_cast<double>(i) / panes;
      strip(k, std::max(0.0, middle - pillar), std::min(1.0, middle + pillar), 0, 0.9);
    }
    builder.material("car_glass");
    for (int i = 0; i < panes; ++i)
      strip(k, static_cast<double>(i) / panes + pillar, static_cast<double>(i + 1) / panes - pillar, 0, 0.9);
  }
  builder.material(paint).quad(corner(0, 1), corner(1, 1), corner(2, 1), corner(3, 1));
}

void addWheels(MeshBuilder& builder, const Pose& T, const std::vector<double>& axles, double half_width,
               double radius) {
  builder.material("tyre");
  for (const double x : axles)
    for (const double side : {-1.0, 1.0})
      builder.cylinder(T * Vector3d(x, side * (half_width - 0.22), radius),
                       T * Vector3d(x, side * (half_width + 0.01), radius), radius, 12);
}

/// A retro-reflecting plate in the plane x = const that looks along `way` (+1 forward, -1 back).
void addPlate(MeshBuilder& builder, const Pose& T, const Vector3d& centre, double width, double height, double way) {
  const auto p = [&](double y, double z) { return Vector3d(T * (centre + Vector3d(0, way * y, z))); };
  const double y = width / 2, z = height / 2;
  builder.material("number_plate").quad(p(-y, -z), p(y, -z), p(y, z), p(-y, z));
}

void addPlates(MeshBuilder& builder, const Pose& T, double front, double rear, double half_width) {
  addPlate(builder, T, {front + 0.015, 0, 0.45}, 0.52, 0.11, 1);
  addPlate(builder, T, {rear - 0.015, 0, 0.6}, 0.52, 0.11, -1);
  for (const double side : {-1.0, 1.0})
    addPlate(builder, T, {rear - 0.015, side * (half_width - 0.18), 0.7}, 0.12, 0.06, -1);
}

/// Limbs, trunk and head of somebody `tall` [m]; `hips` and `shoulders` in the frame T, feet and hands likewise.
struct Posture {
  Vector3d hips, shoulders;
  std::array<Vector3d, 2> feet, hands;  ///< right, left
};
void addBody(MeshBuilder& builder, const Pose& T, const Posture& posture, double tall) {
  builder.material("clothes");
  const Vector3d neck = (posture.shoulders - posture.hips).normalized();
  for (int side = 0; side < 2; ++side) {
    const Vector3d off(0, side == 0 ? -1 : 1, 0);
    const auto k = static_cast<std::size_t>(side);
    builder.cylinder(T * posture.feet[k], T * (posture.hips + 0.09 * off), 0.075, 6);
    builder.cylinder(T * posture.hands[k], T * (posture.shoulders + 0.21 * off), 0.045, 6);
    builder.cylinder(T * (posture.hips + 0.09 * off), T * (posture.shoulders + 0.1 * off), 0.13, 8);
  }
  builder.sphere(T * (posture.shoulders + neck * 0.13 * tall), 0.065 * tall, 6);
}

void addWheelRing(MeshBuilder& builder, const Pose& T, double x) {
  constexpr int kSides = 14;
  constexpr double kRadius = 0.34;
  const auto at = [&](int k) {
    const double angle = 2 * M_PI * k / kSides;
    return Vector3d(T * Vector3d(x + kRadius * std::cos(angle), 0, kRadius + 0.01 + kRadius * std::sin(angle)));
  };
  for (int k = 0; k < kSides; ++k) builder.cylinder(at(k), at(k + 1), 0.02, 4);
  for (int k = 0; k < kSides; k += 2) builder.cylinder(at(k), T * Vector3d(x, 0, kRadius + 0.01), 0.004, 3);
}

void addBicycleParts(MeshBuilder& builder, const Pose& T) {
  const Vector3d rear(-0.52, 0, 0.35), crank(-0.08, 0, 0.3), seat(-0.25, 0, 0.92), head(0.36, 0, 0.85),
      front(0.53, 0, 0.35), bars(0.32, 0, 1.03);
  builder.material("bicycle");
  addWheelRing(builder, T, rear.x());
  addWheelRing(builder, T, front.x());
  const std::vector<std::pair<Vector3d, Vector3d>> tubes = {
      {rear, crank},
      {crank, seat},
      {rear, {-0.2, 0, 0.75}},
      {crank, head},
      {{-0.2, 0, 0.75}, head},
      {front, bars},
      {bars + Vector3d(0, -0.28, 0), bars + Vector3d(0, 0.28, 0)}};
  for (const auto& [a, b] : tubes) builder.cylinder(T * a, T * b, 0.018, 5);
  builder.box(T * poseFromYaw(0, seat), 0.25, 0.14, 0.05);
}

}  // namespace

void addCar(MeshBuilder& builder, const Pose& T_world_car, RandomSequence& random, CarBody body) {
  RandomSequence own = fork(random);
  const bool van = body == CarBody::kVan || (body == CarBody::kAny && own.below(8) == 0);
  const double l = (van ? own.uniform(5, 5.9) : own.uniform(3.7, 4.8)) / 2;
  const double w = (van ? own.uniform(1.95, 2.05) : own.uniform(1.7, 1.85)) / 2;
  const double h = van ? own.uniform(2, 2.4) : own.uniform(1.42, 1.65);
  const double sill = 0.24, belt = van ? 1.15 : 0.55 * h + 0.08, hood = belt - 0.14;
  builder.newInstance().material("car_paint");
  builder.prism(T_world_car,
                {{-l, sill + 0.08},
                 {-l + 0.1, sill},
                 {l - 0.12, sill},
                 {l, sill + 0.12},
                 {l - 0.04, hood - 0.12},
                 {l - 0.2, hood},
                 {0.35 * l, belt},
                 {-l + 0.03, belt}},
                -w, w);
  if (van) {
    addCabin(builder, T_world_car, {0.3 * l, 0.72 * l, belt, w, 0.3 * l, 0.42 * l, h, w - 0.1}, "car_paint", 1);
    builder.prism(T_world_car, {{-l + 0.03, belt}, {0.3 * l, belt}, {0.3 * l, h}, {-l + 0.06, h}}, -w, w);
  } else {
    const bool estate = own.below(2) == 0;
    addCabin(builder, T_world_car,
             {estate ? -l + 0.06 : -0.72 * l, 0.38 * l, belt, w - 0.03, estate ? -0.86 * l : -0.42 * l, 0.02 * l, h,
              w - 0.2},
             "car_paint", 2);
  }
  for (const double side : {-1.0, 1.0})  // mirrors
    builder.box(T_world_car * poseFromYaw(0, Vector3d(0.36 * l, side * (w + 0.08), belt)), 0.1, 0.16, 0.13);
  addWheels(builder, T_world_car, {-0.58 * l, 0.62 * l}, w, 0.32);
  addPlates(builder, T_world_car, l, -l, w);
  builder.noInstance();
}

void addBus(MeshBuilder& builder, const Pose& T_world_bus, RandomSequence& random) {
  fork(random);
  constexpr double kHalf = 6, kSide = 1.275, kBelt = 1.15, kTop = 3.1;
  builder.newInstance().material("bus_paint");
  builder.box(T_world_bus * poseFromYaw(0, Vector3d(0, 0, 0.3)), 2 * kHalf, 2 * kSide, kBelt - 0.3);
  addCabin(builder, T_world_bus, {-kHalf, kHalf, kBelt, kSide, -kHalf + 0.05, kHalf - 0.12, kTop, kSide - 0.04},
           "bus_paint", 8);
  builder.box(T_world_bus * poseFromYaw(0, Vector3d(-1, 0, kTop)), 3, 1.6, 0.25);  // air conditioning
  addWheels(builder, T_world_bus, {-2.9, 3.1}, kSide, 0.48);
  addPlates(builder, T_world_bus, kHalf, -kHalf, kSide);
  builder.noInstance();
}

void addBicycle(MeshBuilder& builder, const Pose& T_world_bicycle, RandomSequence& random) {
  fork(random);
  builder.newInstance();
  addBicycleParts(builder, T_world_bicycle);
  builder.noInstance();
}

void addCyclist(MeshBuilder& builder, const Pose& T_world_bicycle, RandomSequence& random) {
  RandomSequence own = fork(random);
  const double tall = own.uniform(1.6, 1.9), lift = own.uniform(-0.15, 0.15);
  builder.newInstance();
  addBicycleParts(builder, T_world_bicycle);
  const Posture riding = {{-0.25, 0, 1.0},
                          {0.0, 0, 1.0 + 0.29 * tall},
                          {Vector3d(-0.05, -0.12, 0.3 + lift), Vector3d(-0.05, 0.12, 0.3 - lift)},
                          {Vector3d(0.32, -0.25, 1.06), Vector3d(0.32, 0.25, 1.06)}};
  addBody(builder, T_world_bicycle, riding, tall);
  builder.noInstance();
}

void addPerson(MeshBuilder& builder, const Pose& T_world_person, RandomSequence& random) {
  RandomSequence own = fork(random);
  const double tall = own.uniform(1.55, 1.9), stride = own.uniform(-0.3, 0.3);
  builder.newInstance();
  const Posture walking = {{0, 0, 0.5 * tall},
                           {0.03, 0, 0.81 * tall},
                           {Vector3d(stride, -0.1, 0.03), Vector3d(-stride, 0.1, 0.03)},
                           {Vector3d(-0.8 * stride, -0.27, 0.47 * tall), Vector3d(0.8 * stride, 0.27, 0.47 * tall)}};
  addBody(builder, T_world_person, walking, tall);
  builder.noInstance();
}

}  // namespace scslam::sim
