// What the sensor makes of what its beams met: split beams, noise, lost echoes.
#include <algorithm>
#include <cmath>
#include <utility>

#include "sim/lidar.h"

namespace scslam::sim {

namespace {

/// Rays that stand for a split beam: its centre and one on each side of the edge, at 0.4 of the width at half power.
constexpr float kCentreShare = 0.5F, kSideShare = 0.25F, kSide = 0.4F;

/// Of what is not negative.
float rounded(float value) { return static_cast<float>(static_cast<std::int64_t>(value + 0.5F)); }

/// Echoes of a beam that the receiver cannot tell apart, as one.
struct Pulse {
  float weighted_range = 0, signal = 0, last = 0;
  float strongest = 0;
  std::uint16_t label = 0, instance = 0;
  float range() const { return weighted_range / signal; }
};

}  // namespace

/// On a plane 1 / range is linear along rings and columns, to second order in their step: what is not, is an edge.
bool Lidar::mayBeSplit(const std::vector<Echo>& centres, SplitBeam& beam) const {
  constexpr float kStep = 0.3F;  ///< [m]
  const int rings = grid_.rings(), columns = grid_.columns();
  const auto at = [&](int c, int r) {
    return centres[static_cast<std::size_t>((c + columns) % columns * rings + r)].range;
  };
  const float here = at(beam.column, beam.ring);
  const auto step = [here](float before, float after) {
    if (here <= 0 || before <= 0 || after <= 0) return here > 0 || before > 0 || after > 0 ? 1000.0F : 0.0F;
    return here * std::abs(here / before + here / after - 2) / 2;
  };
  const float across = step(at(beam.column - 1, beam.ring), at(beam.column + 1, beam.ring));
  float along = 0;
  if (const int below = beam.ring - 1, above = beam.ring + 1; below >= 0 && above < rings)
    along = step(at(grid_.sameAzimuth(beam.column, beam.ring, below), below),
                 at(grid_.sameAzimuth(beam.column, beam.ring, above), above));
  beam.upright = across >= along;
  return std::max(across, along) > kStep;
}

std::uint64_t Lidar::splitBeams(const RayScene& scene, const std::vector<Echo>& centres, int first_column,
                                int last_column) {
  SplitBeams beams{};
  std::uint64_t split = 0;
  std::size_t n = 0;
  for (int column = first_column; column < last_column; ++column)
    for (int ring = 0; ring < grid_.rings(); ++ring) {
      beams[n] = {column, ring, true};
      if (!grid_.isActive(column, ring) || !mayBeSplit(centres, beams[n])) continue;
      ++split;
      if (++n == kBeamsPerPacket) splitSome(scene, beams, std::exchange(n, 0));
    }
  if (n > 0) splitSome(scene, beams, n);
  return split * kAround;
}

void Lidar::splitSome(const RayScene& scene, const SplitBeams& beams, std::size_t n) {
  RayPacket rays;
  const auto width = static_cast<float>(1e-3 * sensor_.beams.divergence_mrad);
  for (std::size_t i = 0; i < 16; ++i) {
    const SplitBeam& beam = beams[std::min(i / kAround, n - 1)];
    const Eigen::Vector3f d = grid_.direction(beam.column, beam.ring), o = grid_.origin(beam.column, beam.ring);
    const Eigen::Vector3f left = Eigen::Vector3f(-d.y(), d.x(), 0).normalized();
    const Eigen::Vector3f aside = beam.upright ? left : Eigen::Vector3f(d.cross(left));
    const Eigen::Vector3f ray = (d + (i % kAround == 0 ? kSide : -kSide) * width * aside).normalized();
    const ColumnPose& pose = columns_[static_cast<std::size_t>(beam.column)];
    const Eigen::Map<const Eigen::Matrix<float, 3, 3, Eigen::RowMajor>> R(pose.R.data());
    const Eigen::Vector3f d_world = R * ray;
    const Eigen::Vector3f o_world = R * o + Eigen::Vector3f(pose.t[0], pose.t[1], pose.t[2]);
    rays.ray.dir_x[i] = d_world.x(), rays.ray.dir_y[i] = d_world.y(), rays.ray.dir_z[i] = d_world.z();
    rays.ray.org_x[i] = o_world.x(), rays.ray.org_y[i] = o_world.y(), rays.ray.org_z[i] = o_world.z();
    rays.ray.tnear[i] = 0, rays.ray.tfar[i] = static_cast<float>(sensor_.max_range_m);
    rays.ray.time[i] = std::min(1.0F, static_cast<float>(grid_.columnTime(beam.column) / grid_.sweep()));
    rays.ray.mask[i] = 0xFFFFFFFF, rays.ray.flags[i] = 0, rays.ray.id[i] = 0;
    rays.hit.geomID[i] = rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }
  scene.trace(rays, (1U << (n * kAround)) - 1);
  float cosine[16];
  scene.incidence(rays, cosine);
  for (std::size_t k = 0; k < n; ++k) {
    std::array<Echo, kBeamParts> parts;
    for (std::size_t i = 0; i < kAround; ++i) {
      const std::size_t lane = k * kAround + i;
      parts[i] = echoOf(scene, rays, static_cast<int>(lane), cosine[lane]);
      parts[i].signal *= kSideShare;
    }
    const auto beam = static_cast<std::size_t>(beams[k].column * grid_.rings() + beams[k].ring);
    parts[kAround] = echoes_[beam];
    parts[kAround].signal *= kCentreShare;
    choose(parts, beam);
  }
}

void Lidar::choose(std::array<Echo, kBeamParts>& parts, std::size_t beam) {
  std::sort(parts.begin(), parts.end(), [](const Echo& a, const Echo& b) { return a.range < b.range; });
  std::array<Pulse, kBeamParts> pulses;
  std::size_t n = 0;
  for (const Echo& part : parts) {
    if (part.range <= 0 || part.signal <= 0) continue;
    if (n == 0 || part.range - pulses[n - 1].last > static_cast<float>(sensor_.beams.pulse_m)) ++n;
    Pulse& pulse = pulses[n - 1];
    pulse.weighted_range += part.range * part.signal, pulse.signal += part.signal, pulse.last = part.range;
    if (part.signal > pulse.strongest)
      pulse.strongest = part.signal, pulse.label = part.label, pulse.instance = part.instance;
  }
  echoes_[beam] = second_[beam] = {};
  if (n == 0) return;
  const auto asEcho = [](const Pulse& p) { return Echo{p.range(), p.signal, p.label, p.instance}; };
  const auto end = pulses.begin() + static_cast<std::ptrdiff_t>(n);
  const auto strongest =
      std::max_element(pulses.begin(), end, [](const Pulse& a, const Pulse& b) { return a.signal < b.signal; });
  if (effects_.returns == "strongest") {
    echoes_[beam] = asEcho(*strongest);
  } else {
    echoes_[beam] = asEcho(pulses[n - 1]);
    if (effects_.returns == "dual" && strongest != end - 1) second_[beam] = asEcho(*strongest);
  }
}

bool Lidar::report(Echo echo, const Beam& beam, std::uint32_t number, LidarScan& out, std::size_t at) const {
  const SignalModel& s = sensor_.signal;
  if (!weather_.clear()) {
    const auto more = random_.block(number, static_cast<std::uint32_t>(beam.column),
                                    static_cast<std::uint32_t>(beam.ring), beam.draw + 16);
    const float u[3] = {uniformOf(more[0]), uniformOf(more[1]), uniformOf(more[2])};
    const float hard = echo.range > 0 ? echo.range : static_cast<float>(sensor_.max_range_m);
    if (const auto air = static_cast<float>(weather_.airEcho(static_cast<double>(hard), u)); air > 0)
      echo = {air, static_cast<float>(s.floor) * 1.5F, static_cast<std::uint16_t>(Label::kOutlier), 0};
  }
  if (echo.range <= 0) return false;
  if (effects_.dropout && isLost(echo.signal, beam.uniform)) return false;
  float r = echo.range;
  if (effects_.noise) {
    float sigma = static_cast<float>(s.sigma_m) + static_cast<float>(s.sigma_per_m) * r;
    if (s.sigma_signal_m > 0) sigma += static_cast<float>(s.sigma_signal_m) * std::pow(echo.signal, -0.63F);
    r += sigma * beam.normal;
    if (const auto q = static_cast<float>(sensor_.beams.range_quantum_m); q > 0) r = rounded(r / q) * q;
  }
  if (r < static_cast<float>(sensor_.min_range_m) || r > static_cast<float>(sensor_.max_range_m)) return false;
  const Eigen::Vector3f p = grid_.origin(beam.column, beam.ring) + r * grid_.direction(beam.column, beam.ring);
  Cloud& cloud = out.cloud;
  cloud.x[at] = p.x(), cloud.y[at] = p.y(), cloud.z[at] = p.z();
  cloud.intensity[at] = rounded(std::min(echo.signal, static_cast<float>(s.saturation)));
  cloud.dt[at] = static_cast<float>(grid_.columnTime(beam.column) + grid_.beamTime(beam.ring));
  cloud.ring[at] = static_cast<std::uint16_t>(beam.ring);
  out.labels[at] = std::uint32_t{echo.label} | std::uint32_t{echo.instance} << 16;
  return true;
}

bool Lidar::isLost(float signal, float u) const {
  const SignalModel& s = sensor_.signal;
  if (signal < static_cast<float>(s.floor)) return true;
  if (u >= static_cast<float>(s.dropout_most)) return false;
  const float ratio = static_cast<float>(s.dropout_signal) / signal;
  // The square bounds higher powers of a small ratio: most echoes are decided without taking them.
  if (ratio < 1 && s.dropout_power >= 2 &&
      u >= static_cast<float>(s.dropout_base) + static_cast<float>(s.dropout_scale) * ratio * ratio)
    return false;
  return u < static_cast<float>(s.dropout_base) +
                 static_cast<float>(s.dropout_scale) * std::pow(ratio, static_cast<float>(s.dropout_power));
}

void Lidar::collect(int first_column, int last_column, std::uint32_t number, LidarScan& out) const {
  const auto rings = static_cast<std::size_t>(grid_.rings());
  const std::size_t beams = static_cast<std::size_t>(last_column - first_column) * rings;
  const auto resize = [&out](std::size_t n) {
    for (auto* values : {&out.cloud.x, &out.cloud.y, &out.cloud.z, &out.cloud.intensity, &out.cloud.dt})
      values->resize(n);
    out.cloud.ring.resize(n), out.labels.resize(n);
  };
  resize(effects_.returns == "dual" ? 2 * beams : beams);
  std::vector<float> normal(rings), uniform(rings);
  std::size_t n = 0;
  for (int column = first_column; column < last_column; ++column) {
    random_.drawColumn(number, static_cast<std::uint32_t>(column), rings, normal.data(), uniform.data());
    for (int ring = 0; ring < grid_.rings(); ++ring) {
      if (!grid_.isActive(column, ring)) continue;
      const auto r = static_cast<std::size_t>(ring), i = static_cast<std::size_t>(column) * rings + r;
      n += report(echoes_[i], {column, ring, 0, normal[r], uniform[r]}, number, out, n);
      if (second_[i].range <= 0) continue;
      const auto words = random_.block(number, static_cast<std::uint32_t>(column), static_cast<std::uint32_t>(ring), 1);
      n += report(second_[i], {column, ring, 1, normalOf(words[0]), uniformOf(words[1])}, number, out, n);
    }
  }
  resize(n);
}

}  // namespace scslam::sim
