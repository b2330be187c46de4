#include "sim/facade.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace scslam::sim {

using Eigen::Vector3d;

namespace {

const Vector3d kUp = Vector3d::UnitZ();

/// One bay of one storey, in metres of the front: x to the right, z up, y outward.
struct Bay {
  const FrontPlace& place;
  double x, z, width, height;
  Vector3d at(double u, double v, double out) const {
    return place.corner + (x + u) * place.right + (z + v) * kUp + out * place.outward();
  }
  Pose frame(double u, double v, double out) const {
    Pose T = Pose::Identity();
    T.linear().col(0) = place.right, T.linear().col(1) = -place.outward(), T.linear().col(2) = kUp;
    T.translation() = at(u, v, out);
    return T;
  }
};

/// Wall around an opening, its reveal, and what closes it.
void opening(MeshBuilder& b, const Bay& bay, const FrontStyle& style, std::array<double, 4> hole,
             const std::string& pane) {
  const auto [l, r, lo, hi] = hole;
  b.material(style.wall);
  const double w = bay.width, h = bay.height, in = -style.recess_m;
  b.quad(bay.at(0, 0, 0), bay.at(l, 0, 0), bay.at(l, h, 0), bay.at(0, h, 0));
  b.quad(bay.at(r, 0, 0), bay.at(w, 0, 0), bay.at(w, h, 0), bay.at(r, h, 0));
  if (lo > 0) b.quad(bay.at(l, 0, 0), bay.at(r, 0, 0), bay.at(r, lo, 0), bay.at(l, lo, 0));
  b.quad(bay.at(l, hi, 0), bay.at(r, hi, 0), bay.at(r, h, 0), bay.at(l, h, 0));
  b.quad(bay.at(l, lo, 0), bay.at(l, lo, in), bay.at(l, hi, in), bay.at(l, hi, 0));
  b.quad(bay.at(r, lo, in), bay.at(r, lo, 0), bay.at(r, hi, 0), bay.at(r, hi, in));
  b.quad(bay.at(l, lo, 0), bay.at(r, lo, 0), bay.at(r, lo, in), bay.at(l, lo, in));
  b.quad(bay.at(l, hi, in), bay.at(r, hi, in), bay.at(r, hi, 0), bay.at(l, hi, 0));
  b.material(pane);
  b.quad(bay.at(l, lo, in), bay.at(r, lo, in), bay.at(r, hi, in), bay.at(l, hi, in));
}

void window(MeshBuilder& b, const Bay& bay, const FrontStyle& style, RandomSequence& random) {
  const double side = 0.28 * bay.width;
  // Half of the windows show curtains or blinds, the others only glass.
  opening(b, bay, style, {side, bay.width - side, 0.9, bay.height - 0.55},
          random.uniform() < 0.5 ? "glass" : "white");
  b.material("wood");
  const double middle = bay.width / 2;
  b.box(bay.frame(middle, 0.9, -style.recess_m + 0.03), 0.06, 0.05, bay.height - 1.45);  // its cross-bar
  b.box(bay.frame(middle, 0.85, 0.05), bay.width - 2 * side + 0.2, 0.18, 0.05);          // its sill
}

void door(MeshBuilder& b, const Bay& bay, const FrontStyle& style, RandomSequence& random) {
  const double middle = bay.width / 2, half = 0.55;
  opening(b, bay, style, {middle - half, middle + half, 0, 2.25}, random.uniform() < 0.3 ? "glass" : "wood");
  b.material("concrete");
  b.box(bay.frame(middle, 0, 0.3), 1.6, 0.6, 0.15);
}

void shopWindow(MeshBuilder& b, const Bay& bay, const FrontStyle& style, RandomSequence& random) {
  opening(b, bay, style, {0.25, bay.width - 0.25, 0.4, 2.4}, "glass");
  if (random.uniform() > 0.6 * style.clutter) return;
  b.material("clothes");  // an awning
  b.quad(bay.at(0.1, 2.35, 1.1), bay.at(bay.width - 0.1, 2.35, 1.1), bay.at(bay.width - 0.1, 2.7, 0),
         bay.at(0.1, 2.7, 0));
}

void balcony(MeshBuilder& b, const Bay& bay) {
  b.material("concrete");
  b.box(bay.frame(bay.width / 2, -0.12, 0.6), bay.width - 0.3, 1.2, 0.14);
  b.material("fence");
  for (double x = 0.25; x < bay.width - 0.2; x += 0.25) b.box(bay.frame(x, 0.02, 1.17), 0.03, 0.03, 1.0);
  for (const double side : {0.18, bay.width - 0.18})
    for (double out = 0.15; out < 1.15; out += 0.3) b.box(bay.frame(side, 0.02, out), 0.03, 0.03, 1.0);
  b.box(bay.frame(bay.width / 2, 1.0, 1.17), bay.width - 0.3, 0.06, 0.05);
}

/// Boxes, lamps, signs and pots that hang on or stand before walls.
void clutter(MeshBuilder& b, const Bay& bay, bool ground_floor, RandomSequence& random) {
  const double x = random.uniform(0.3, bay.width - 0.3);
  if (ground_floor) {
    b.material(random.uniform() < 0.5 ? "metal" : "wood");
    b.box(bay.frame(x, 0, random.uniform(0.15, 0.35)), random.uniform(0.2, 0.9), random.uniform(0.2, 0.5),
          random.uniform(0.3, 1.2));
    if (random.uniform() < 0.3) b.material("leaves").foliage(bay.at(x, 0.9, 0.35), {0.4, 0.4, 0.5}, 250, 0.12, random);
  } else {
    b.material("metal");
    b.box(bay.frame(x, random.uniform(0.1, 1.8), 0.2), 0.8, 0.35, 0.6);
  }
}

void drainPipe(MeshBuilder& b, const FrontPlace& place, double x) {
  b.material("metal");
  const Vector3d foot = place.corner + x * place.right + 0.12 * place.outward();
  b.cylinder(foot, foot + place.height * kUp, 0.06, 6);
}

}  // namespace

void addFront(MeshBuilder& b, const FrontPlace& place, const FrontStyle& style, RandomSequence& random) {
  const int storeys = std::max(1, static_cast<int>(std::lround(place.height / style.storey_m)));
  const int bays = std::max(1, static_cast<int>(std::lround(place.width / style.bay_m)));
  const double w = place.width / bays, h = place.height / storeys;
  const int door_bay = random.below(bays);
  const bool shop = random.uniform() < 0.35;
  for (int i = 0; i < bays; ++i)
    for (int k = 0; k < storeys; ++k) {
      const Bay bay{place, i * w, k * h, w, h};
      if (k == 0 && i == door_bay) {
        door(b, bay, style, random);
      } else if (k == 0 && shop) {
        shopWindow(b, bay, style, random);
      } else {
        window(b, bay, style, random);
      }
      if (k > 0 && random.uniform() < style.balcony_share) balcony(b, bay);
      if (random.uniform() < (k == 0 ? 0.35 : 0.12) * style.clutter) clutter(b, bay, k == 0, random);
    }
  if (random.uniform() < style.clutter) drainPipe(b, place, random.uniform() < 0.5 ? 0.15 : place.width - 0.15);
  b.material(style.wall);
  const Bay top{place, 0, place.height, place.width, 0.3};
  b.box(top.frame(place.width / 2, -0.3, 0.15), place.width, 0.4, 0.3);  // cornice
}

void addHouse(MeshBuilder& b, const FrontPlace& place, double depth, const FrontStyle& style, RandomSequence& random) {
  b.newInstance();
  addFront(b, place, style, random);
  const Vector3d in = -place.outward() * depth, up = place.height * kUp, right = place.right * place.width;
  const Vector3d a = place.corner, c = a + right;
  b.material(style.wall);
  b.quad(c, c + in, c + in + up, c + up);
  b.quad(c + in, a + in, a + in + up, c + in + up);
  b.quad(a + in, a, a + up, a + in + up);
  b.material("roof");
  const double ridge = random.uniform() < 0.5 ? random.uniform(1.5, 3) : 0;
  const Vector3d l = a + in / 2 + up + ridge * kUp, r = l + right;
  b.quad(a + up, c + up, r, l);
  b.quad(c + in + up, a + in + up, l, r);
  if (ridge > 0) b.triangle(a + up, l, a + in + up), b.triangle(c + up, c + in + up, r);
  b.noInstance();
}

}  // namespace scslam::sim
