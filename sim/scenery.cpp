#include "sim/scenery.h"

#include <algorithm>
#include <cmath>

#include "sim/props_detail.h"

namespace scslam::sim {

using Eigen::Vector3d;

RoughGround::RoughGround(std::uint64_t seed, double std_m, double period_m)
    : random_(seed, RandomStream::kWorld, 77), std_m_(std_m), period_m_(period_m) {}

double RoughGround::octave(double x, double y, double cell_m, std::uint32_t index) const {
  const auto cells = static_cast<std::int64_t>(std::lround(period_m_ / cell_m));
  const auto knot = [&](std::int64_t i) {
    return static_cast<std::uint32_t>(cells > 0 ? (i % cells + cells) % cells : i);
  };
  const double u = x / cell_m, v = y / cell_m;
  const auto i = static_cast<std::int64_t>(std::floor(u)), j = static_cast<std::int64_t>(std::floor(v));
  const auto smooth = [](double t) { return t * t * (3 - 2 * t); };
  const double a = smooth(u - static_cast<double>(i)), b = smooth(v - static_cast<double>(j));
  const auto at = [&](std::int64_t p, std::int64_t q) {
    return static_cast<double>(normalOf(random_.block(knot(p), knot(q), index)[0]));
  };
  // Interpolation takes 0.743 of the variance per axis on average.
  return ((at(i, j) * (1 - b) + at(i, j + 1) * b) * (1 - a) + (at(i + 1, j) * (1 - b) + at(i + 1, j + 1) * b) * a) /
         0.743;
}

double RoughGround::operator()(double x, double y) const {
  return std_m_ == 0 ? 0 : std_m_ * (0.8 * octave(x, y, 2, 1) + 0.6 * octave(x, y, 0.8, 2));
}

double lengthOf(const Line& line) {
  double length = 0;
  for (std::size_t i = 1; i < line.size(); ++i) length += (line[i] - line[i - 1]).norm();
  return length;
}

Line resampled(const Line& line, double step_m, bool closed) {
  Line whole = line;
  if (closed) whole.push_back(line.front());
  const double length = lengthOf(whole);
  const int n = std::max(1, static_cast<int>(std::ceil(length / step_m)));
  Line result = {whole.front()};
  std::size_t i = 0;
  double before = 0;
  for (int k = 1; k < n; ++k) {
    const double s = length * k / n;
    while (i + 2 < whole.size() && before + (whole[i + 1] - whole[i]).norm() < s)
      before += (whole[i + 1] - whole[i]).norm(), ++i;
    result.push_back(whole[i] + (whole[i + 1] - whole[i]).normalized() * (s - before));
  }
  result.push_back(whole.back());
  return result;
}

Line arc(const Vector3d& centre, double radius, double from_deg, double to_deg, double step_deg) {
  const int n = std::max(1, static_cast<int>(std::lround(std::abs(to_deg - from_deg) / step_deg)));
  Line result;
  for (int k = 0; k <= n; ++k) {
    const double angle = (from_deg + (to_deg - from_deg) * k / n) * M_PI / 180;
    result.push_back(centre + radius * Vector3d(std::cos(angle), std::sin(angle), 0));
  }
  return result;
}

Line leftOf(const Line& line, bool closed) {
  const std::size_t n = line.size();
  Line result;
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3d& last = i > 0 ? line[i - 1] : line[closed ? n - 2 : 0];
    const Vector3d& next = i + 1 < n ? line[i + 1] : line[closed ? 1 : n - 1];
    const Vector3d d = next - last;
    result.push_back(Vector3d(-d.y(), d.x(), 0).normalized());
  }
  return result;
}

void addRibbon(MeshBuilder& builder, const Line& line, const std::vector<double>& offsets,
               const std::function<double(const Vector3d&, double, std::size_t)>& z, bool closed) {
  const Line left = leftOf(line, closed);
  builder.patch(static_cast<int>(line.size()) - 1, static_cast<int>(offsets.size()) - 1, [&](int row, int column) {
    const auto i = static_cast<std::size_t>(row);
    const double offset = offsets[static_cast<std::size_t>(column)];
    Vector3d p = line[i] + left[i] * offset;
    p.z() = z(p, offset, i);
    return p;
  });
}

void addRibbon(MeshBuilder& builder, const Line& line, const std::vector<double>& offsets,
               const std::vector<double>& lifts, const std::function<double(double, double)>& z, bool closed) {
  const Line left = leftOf(line, closed);
  builder.patch(static_cast<int>(line.size()) - 1, static_cast<int>(offsets.size()) - 1, [&](int row, int column) {
    const auto i = static_cast<std::size_t>(row), k = static_cast<std::size_t>(column);
    const Vector3d p = line[i] + left[i] * offsets[k];
    return Vector3d(p.x(), p.y(), z(p.x(), p.y()) + lifts[k]);
  });
}

std::vector<double> steps(double a, double b, int n) {
  std::vector<double> result;
  for (int i = 0; i <= n; ++i) result.push_back(a + (b - a) * i / n);
  return result;
}

void addFacade(MeshBuilder& builder, const Vector3d& a, const Vector3d& b, double height, const std::string& wall,
               bool door) {
  constexpr double kDeep = 0.12, kStorey = 3, kBay = 3.2;
  const double length = (b - a).norm();
  const Vector3d along = (b - a) / length, in(-along.y(), along.x(), 0);
  const auto p = [&](double s, double z, double deep) {
    return Vector3d(a + along * s + in * deep + Vector3d(0, 0, z));
  };
  const auto face = [&](double s0, double s1, double z0, double z1, double deep) {
    if (s1 - s0 > 1e-6 && z1 - z0 > 1e-6)
      builder.quad(p(s0, z0, deep), p(s1, z0, deep), p(s1, z1, deep), p(s0, z1, deep));
  };
  const int bays = std::max(1, static_cast<int>(length / kBay));
  const int storeys = std::max(1, static_cast<int>(height / kStorey));
  const double bay = length / bays, half = std::min(0.65, 0.3 * bay);
  for (int k = 0; k < storeys; ++k) {
    const double low = k * kStorey, high = k + 1 == storeys ? height : low + kStorey;
    for (int i = 0; i < bays; ++i) {
      const bool is_door = door && k == 0 && i == bays / 2;
      const double s0 = i * bay, s1 = s0 + bay, w0 = (s0 + s1) / 2 - half, w1 = (s0 + s1) / 2 + half;
      const double z0 = is_door ? low : low + 0.95, z1 = low + 2.25;
      builder.material(wall);
      face(s0, s1, low, z0, 0), face(s0, s1, z1, high, 0), face(s0, w0, z0, z1, 0), face(w1, s1, z0, z1, 0);
      builder.quad(p(w0, z0, 0), p(w0, z0, kDeep), p(w0, z1, kDeep), p(w0, z1, 0));
      builder.quad(p(w1, z0, kDeep), p(w1, z0, 0), p(w1, z1, 0), p(w1, z1, kDeep));
      builder.quad(p(w0, z0, 0), p(w1, z0, 0), p(w1, z0, kDeep), p(w0, z0, kDeep));
      builder.quad(p(w0, z1, kDeep), p(w1, z1, kDeep), p(w1, z1, 0), p(w0, z1, 0));
      builder.material(is_door ? "wood" : "glass");
      face(w0, w1, z0, z1, kDeep);
    }
  }
}

void addHouse(MeshBuilder& builder, const Pose& T_world_house, double length, double width, int storeys,
              RandomSequence& random) {
  RandomSequence own = fork(random);
  const char* wall = own.below(2) == 0 ? "brick" : "plaster";
  const double x = length / 2, y = width / 2, eaves = 3.0 * storeys, ridge = eaves + 0.42 * width;
  const auto p = [&](double px, double py, double pz) { return Vector3d(T_world_house * Vector3d(px, py, pz)); };
  builder.newInstance().material(wall);
  builder.box(T_world_house * poseFromYaw(0, Vector3d(0, 0, -0.8)), length, width, 0.8);
  addFacade(builder, p(-x, -y, 0), p(x, -y, 0), eaves, wall, true);
  addFacade(builder, p(x, -y, 0), p(x, y, 0), eaves, wall, false);
  addFacade(builder, p(x, y, 0), p(-x, y, 0), eaves, wall, false);
  addFacade(builder, p(-x, y, 0), p(-x, -y, 0), eaves, wall, false);
  builder.material(wall);
  builder.triangle(p(x, -y, eaves), p(x, y, eaves), p(x, 0, ridge));
  builder.triangle(p(-x, y, eaves), p(-x, -y, eaves), p(-x, 0, ridge));
  const double over = 0.4, low = eaves - over * 0.84;
  builder.material("roof");
  builder.quad(p(-x - over, -y - over, low), p(x + over, -y - over, low), p(x + over, 0, ridge + 0.1),
               p(-x - over, 0, ridge + 0.1));
  builder.quad(p(x + over, y + over, low), p(-x - over, y + over, low), p(-x - over, 0, ridge + 0.1),
               p(x + over, 0, ridge + 0.1));
  builder.material("brick");
  builder.box(T_world_house * poseFromYaw(0, Vector3d(own.uniform(-0.3, 0.3) * length, 0.6, ridge - 1)), 0.6, 0.6, 2);
  builder.noInstance();
}

}  // namespace scslam::sim
