#include "sim/radar.h"

#include <algorithm>
#include <cmath>

#include "scslam/core/error.h"
#include "sim/radar_echoes.h"
#include "sim/radar_receiver.h"

namespace scslam::sim {

namespace {

constexpr std::size_t kRowsPerChunk = 8;
constexpr double kRadPerDeg = M_PI / 180;

RadarRow rowOf(const RadarModel& model, const Trajectory& drive, double start_s, int row) {
  RadarRow r;
  r.seconds = start_s + row * model.rowTime();
  const MotionState state = drive.state(r.seconds);
  const Pose T_base_sensor = model.T_base_sensor();
  r.T_world_sensor = state.T_world_base * T_base_sensor;
  r.velocity = state.velocity +
               state.T_world_base.linear() * state.angular_velocity.cross(Eigen::Vector3d(T_base_sensor.translation()));
  r.angle = 2 * M_PI * row / model.azimuths;
  r.time = std::clamp(row * model.rowTime() / model.sweep(), 0.0, 1.0);
  r.number = static_cast<std::uint32_t>(row);
  if (!r.T_world_sensor.matrix().allFinite() || !r.velocity.allFinite())
    throw usageError("the radar has no finite pose {} s into the drive", r.seconds);
  return r;
}

}  // namespace

void RadarModel::describe(ParamVisitor& v) {
  v.field("name", name, "what it is, for messages");
  v.field("azimuths", azimuths, "rows a sweep", 4, 5600);
  v.field("bins", bins, "range bins a row", 16, 65536);
  v.field("rate_hz", rate_hz, "sweeps a second [Hz]", 0.01, 100);
  v.field("range_resolution_m", range_resolution_m, "width of a range bin [m]", 0.001, 10);
  v.field("range_offset_m", range_offset_m, "what users must add to a bin's range to get the true one [m]", -100, 100);
  v.field("min_range_m", min_range_m, "echoes from nearer are blanked [m]", 0.01, 1000);
  v.field("beam_azimuth_deg", beam_azimuth_deg, "one-way half-power width in azimuth [deg]", 0.1, 90);
  v.field("beam_elevation_deg", beam_elevation_deg, "one-way half-power width in elevation [deg]", 0.1, 90);
  v.field("fill_in_deg", fill_in_deg, "the cosec^2 tail of the beam reaches down to this elevation; 0: none [deg]", 0,
          85);
  v.field("range_width_m", range_width_m, "half-power width of the range response [m]", 0.001, 100);
  v.field("gain_db", gain_db, "power of 1 m^2 at 10 m in mid-beam, over one quantum of power [dB]", -100, 200);
  v.field("noise", noise, "mean power of thermal noise [quanta]; 0: no noise of any kind", 0, 1e6);
  v.field("phase_noise_db", phase_noise_db, "mean power of the noise that a row's own echoes add, over their sum [dB]",
          -200, 0);
  v.field("speckle", speckle, "echoes add up with random phases (else their powers do)");
  v.field("saturation_db", saturation_db, "power where the receiver saturates, over one quantum [dB]", 0, 200);
  v.field("streak_db", streak_db, "rise of the noise behind a return that just saturates [dB]", 0, 100);
  v.field("doppler_beta_s", doppler_beta_s, "range error by range rate: approaching looks nearer [s]", -10, 10);
  v.field("max_bounces", max_bounces, "surfaces on a path; 1: no multipath", 1, 9);
  v.field("rays_per_azimuth", rays_per_azimuth, "rays that leave within a row's share of the circle", 1, 100000);
  v.field("surface_slope_deg", surface_slope_deg, "rms slope of the facets of what is not diffuse [deg]", 0.5, 45);
  v.field("compression", compression, "of power to 8 bits: counts_per_db per dB, or 255 sqrt(power / saturation)",
          {"log", "sqrt"});
  v.field("counts_per_db", counts_per_db, "grey levels per dB", 0.1, 100);
  v.field("translation_m", translation_m, "position of the sensor in the base frame: x y z [m]");
  v.field("rpy_deg", rpy_deg, "roll, pitch, yaw of the sensor in the base frame [deg]; R = Rz(yaw) Ry(pitch) Rx(roll)");
}

Pose RadarModel::T_base_sensor() const {
  const auto turn = [this](std::size_t i, const Eigen::Vector3d& axis) {
    return Eigen::AngleAxisd(rpy_deg.at(i) * kRadPerDeg, axis);
  };
  Pose T = Pose::Identity();
  T.linear() =
      (turn(2, Eigen::Vector3d::UnitZ()) * turn(1, Eigen::Vector3d::UnitY()) * turn(0, Eigen::Vector3d::UnitX()))
          .toRotationMatrix();
  T.translation() = Eigen::Vector3d(translation_m.at(0), translation_m.at(1), translation_m.at(2));
  return T;
}

Radar::Radar(RadarModel model, std::uint64_t seed, std::uint32_t unit)
    : model_(std::move(model)), random_(seed, RandomStream::kRadar, unit) {
  const auto threeNumbers = [](const std::vector<double>& v) {
    return v.size() == 3 && std::all_of(v.begin(), v.end(), [](double x) { return std::isfinite(x); });
  };
  if (!threeNumbers(model_.translation_m) || !threeNumbers(model_.rpy_deg))
    throw usageError("radar '{}': translation_m and rpy_deg need three numbers each", model_.name);
  constexpr double kMostRays = 2e7;
  if (static_cast<double>(model_.azimuths) * model_.rays_per_azimuth > kMostRays)
    throw usageError("radar '{}': {} azimuths x {} rays are too many", model_.name, model_.azimuths,
                     model_.rays_per_azimuth);
}

RadarScan Radar::scan(const RayScene& scene, const Trajectory& drive, double start_s, std::uint32_t number,
                      ThreadPool& threads, const World* world) const {
  if (!std::isfinite(start_s)) throw usageError("a radar sweep needs a start");
  const RadarAntenna antenna(model_.beam_azimuth_deg * kRadPerDeg, model_.beam_elevation_deg * kRadPerDeg,
                             model_.fill_in_deg * kRadPerDeg);
  const RadarPaths paths(model_, antenna, scene, random_, number, world);
  const RadarReceiver receiver(model_, antenna, random_, number);

  // Rows before the first and after the last are seen by the beam's flanks; they are not reported.
  const auto rows = static_cast<std::size_t>(model_.azimuths), reach = static_cast<std::size_t>(receiver.reach());
  std::vector<std::vector<RadarEcho>> echoes(rows + 2 * reach);
  threads.forEachChunk(echoes.size(), kRowsPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i)
      echoes[i] = paths.trace(rowOf(model_, drive, start_s, static_cast<int>(i) - receiver.reach()));
  });

  RadarScan result;
  result.resize(rows, static_cast<std::size_t>(model_.bins));
  result.range_resolution_m = model_.range_resolution_m, result.range_offset_m = model_.range_offset_m;
  result.doppler_beta_s = model_.doppler_beta_s;
  result.label = model_.name, result.T_base_sensor = model_.T_base_sensor();
  threads.forEachChunk(rows, kRowsPerChunk, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) {
      const std::span neighbours(&echoes[i], 2 * reach + 1);
      receiver.compress(receiver.power(neighbours, static_cast<std::uint32_t>(i)), result.row(i));
      result.stamps[i] = stampFromSeconds(start_s + static_cast<double>(i) * model_.rowTime());
      result.angles[i] = 2 * M_PI * static_cast<double>(i) / model_.azimuths;
    }
  });
  return result;
}

}  // namespace scslam::sim
