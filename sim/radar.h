// A spinning radar (FMCW, 76 GHz) in a world: power over azimuth and range as the sensor would report it.
//
// A ray that leaves the antenna meets up to max_bounces surfaces. From each of them power comes back; a path of total
// length L shows at range L / 2. In units of the echo of 1 m^2 at 10 m, a ray that stands for the solid angle dO adds
//   (10 m)^4 * 4 pi * f * cos(leaving) * R_1 … R_k-1 * G_out * G_in * dO / d^2
// with the scattering function f of the last surface, the reflectivities R of the mirrors before it, the antenna's
// gains G and the distance d the scattered wave travels: power falls with d^-4 for what is smaller than the beam, with
// d^-3 for ground in a range cell, d^-2 for a wall, without a rule for each. The receiver (radar_receiver.h) does the
// rest.
#pragma once
#include <vector>

#include "scslam/core/counter_random.h"
#include "scslam/core/parallel.h"
#include "scslam/core/params.h"
#include "scslam/sensor/radar_scan.h"
#include "sim/ray_scene.h"
#include "sim/trajectory.h"

namespace scslam::sim {

/// sim/radars/*.yaml. Defaults are the CTS350-X of the Oxford Radar RobotCar data set; where its figures come from is
/// said there.
struct RadarModel : ParamSetOf<RadarModel> {
  std::string name = "radar";
  int azimuths = 400, bins = 3768;
  double rate_hz = 4;
  double range_resolution_m = 0.0438, range_offset_m = 0, min_range_m = 2.5;
  double beam_azimuth_deg = 1.8, beam_elevation_deg = 4, fill_in_deg = 40;
  double range_width_m = 0.37;
  double gain_db = 72, noise = 1.5;
  bool speckle = true;
  double phase_noise_db = -72, saturation_db = 70, streak_db = 10;
  double doppler_beta_s = 0.049;
  int max_bounces = 3, rays_per_azimuth = 192;
  double surface_slope_deg = 12;
  std::string compression = "log";
  double counts_per_db = 2;
  std::vector<double> translation_m = {0, 0, 0}, rpy_deg = {0, 0, 0};

  void describe(ParamVisitor& visitor) override;
  Pose T_base_sensor() const;
  double sweep() const { return 1 / rate_hz; }                                    ///< [s]
  double rowTime() const { return 1 / (rate_hz * azimuths); }                     ///< from one row to the next [s]
  double maxRange() const { return bins * range_resolution_m + range_offset_m; }  ///< true range of the last bin's end
};

class Radar {
 public:
  /// @throw usageError for a model whose vectors have the wrong length.
  Radar(RadarModel model, std::uint64_t seed, std::uint32_t unit = 0);

  const RadarModel& model() const { return model_; }

  /// The sweep that starts `start_s` into the drive, each row from its own pose; row i looks 2 pi i / azimuths
  /// clockwise of the sensor's x axis, stamped start_s + i * rowTime(). poseActors(start_s, start_s + sweep) is the
  /// caller's.
  /// @param number of the scan: random numbers depend on it and the seed alone.
  /// @param world when given, what moves in it is seen with the Doppler shift of its own speed too.
  /// @throw usageError when the drive has no finite pose there.
  RadarScan scan(const RayScene& scene, const Trajectory& drive, double start_s, std::uint32_t number,
                 ThreadPool& threads, const World* world = nullptr) const;

 private:
  RadarModel model_;
  CounterRandom random_;
};

}  // namespace scslam::sim
