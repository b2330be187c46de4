#include "scslam/core/cloud.h"

#include <cmath>

#include "scslam/core/simd.h"

namespace scslam {
namespace {

template <class Function>
void forEachField(Cloud& cloud, Function&& function) {
  function(cloud.x), function(cloud.y), function(cloud.z);
  if (cloud.hasIntensity()) function(cloud.intensity);
  if (cloud.hasTime()) function(cloud.dt);
  if (cloud.hasRing()) function(cloud.ring);
}

SCSLAM_KERNEL void transformKernel(float* x, float* y, float* z, std::size_t n, const float* R, const float* t) {
  for (std::size_t i = 0; i < n; ++i) {
    const float px = x[i], py = y[i], pz = z[i];
    x[i] = R[0] * px + R[1] * py + R[2] * pz + t[0];
    y[i] = R[3] * px + R[4] * py + R[5] * pz + t[1];
    z[i] = R[6] * px + R[7] * py + R[8] * pz + t[2];
  }
}

}  // namespace

void Cloud::clear() {
  forEachField(*this, [](auto& field) { field.clear(); });
}

void Cloud::reserve(std::size_t n) { x.reserve(n), y.reserve(n), z.reserve(n); }

void Cloud::resize(std::size_t n) {
  forEachField(*this, [n](auto& field) { field.resize(n); });
}

void Cloud::pushFrom(const Cloud& other, std::size_t i) {
  const bool first = empty();
  const bool with_intensity = first ? other.hasIntensity() : hasIntensity();
  const bool with_time = first ? other.hasTime() : hasTime();
  const bool with_ring = first ? other.hasRing() : hasRing();
  push(other.x[i], other.y[i], other.z[i]);
  if (with_intensity) intensity.push_back(other.hasIntensity() ? other.intensity[i] : 0.0f);
  if (with_time) dt.push_back(other.hasTime() ? other.dt[i] : 0.0f);
  if (with_ring) ring.push_back(other.hasRing() ? other.ring[i] : std::uint16_t{0});
}

void Cloud::filter(const std::vector<std::uint8_t>& keep) {
  forEachField(*this, [&keep](auto& field) {
    std::size_t out = 0;
    for (std::size_t i = 0; i < field.size(); ++i) {
      field[out] = field[i];
      out += keep[i] != 0;
    }
    field.resize(out);
  });
}

void transformInPlace(Cloud& cloud, const Pose& T_a_b) { transformInPlace(cloud, Eigen::Affine3d(T_a_b)); }

void transformInPlace(Cloud& cloud, const Eigen::Affine3d& T_a_b) {
  float R[9], t[3];
  for (int r = 0; r < 3; ++r) {
    for (int c = 0; c < 3; ++c) R[3 * r + c] = static_cast<float>(T_a_b.linear()(r, c));
    t[r] = static_cast<float>(T_a_b.translation()(r));
  }
  transformKernel(cloud.x.data(), cloud.y.data(), cloud.z.data(), cloud.size(), R, t);
}

Cloud transformed(const Cloud& cloud_b, const Pose& T_a_b) {
  Cloud cloud_a = cloud_b;
  transformInPlace(cloud_a, T_a_b);
  return cloud_a;
}

std::size_t dropNonFinite(Cloud& cloud) {
  std::vector<std::uint8_t> keep(cloud.size());
  std::size_t dropped = 0;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    keep[i] = std::isfinite(cloud.x[i]) && std::isfinite(cloud.y[i]) && std::isfinite(cloud.z[i]);
    dropped += keep[i] == 0;
  }
  if (dropped != 0) cloud.filter(keep);
  return dropped;
}

void saveCloud(ByteWriter& state, const Cloud& cloud) {
  for (const auto* values : {&cloud.x, &cloud.y, &cloud.z, &cloud.intensity, &cloud.dt}) state.put(*values);
  state.put(cloud.ring);
}

void loadCloud(ByteReader& state, Cloud& cloud) {
  for (auto* values : {&cloud.x, &cloud.y, &cloud.z, &cloud.intensity, &cloud.dt}) state.get(*values);
  state.get(cloud.ring);
  const auto fits = [&cloud](std::size_t n, bool optional) { return n == cloud.size() || (optional && n == 0); };
  if (!fits(cloud.y.size(), false) || !fits(cloud.z.size(), false) || !fits(cloud.intensity.size(), true) ||
      !fits(cloud.dt.size(), true) || !fits(cloud.ring.size(), true))
    throw inputError("odometry: a saved scan with arrays of different lengths");
}

}  // namespace scslam
