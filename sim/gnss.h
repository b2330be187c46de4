// GNSS receiver: positions with white noise, bursts of multipath, and outages (listed, or where the sky is blocked).
#pragma once
#include "scslam/core/geodesy.h"
#include "scslam/core/params.h"
#include "sim/navigation_sensor.h"

namespace scslam::sim {

class RayScene;

/// Defaults: a single-frequency receiver with differential corrections. Set RTK by sigmas of centimetres,
/// fix_quality 4.
struct GnssModel : ParamSetOf<GnssModel> {
  bool enabled = true;
  double rate_hz = 5;
  std::vector<double> translation_m = {0, 0, 0};                           ///< of the antenna in the base frame
  double latitude_deg = 36.3721, longitude_deg = 127.3604, height_m = 60;  ///< of the world's origin
  double horizontal_sigma_m = 0.6;                                         ///< per axis, under open sky
  double vertical_sigma_m = 1.2;
  double multipath_per_s = 0.01;  ///< chance that a burst begins
  double multipath_s = 8;         ///< mean length of a burst
  double multipath_sigma_m = 4;   ///< stationary, per axis (vertical: 1.5 times)
  double multipath_tau_s = 5;     ///< time constant of the first-order Gauss-Markov process
  std::vector<double> outages_s;  ///< start, end, start, end …
  int sky_rays = 64;              ///< cast upwards to find the open share of the sky; 0: always open
  double mask_deg = 10;           ///< elevation below which satellites do not count
  double blocked_share = 0.8;     ///< of the sky, above which there is no fix
  int satellites = 12;            ///< in use under open sky
  double hdop = 0.9;              ///< under open sky
  int fix_quality = 2;

  void describe(ParamVisitor& v) override;
};

/// Emits mrpt::obs::CObservationGPS, label "gnss", with a GGA message: UTC time of the stamp, latitude, longitude,
/// height above the ellipsoid (undulation 0), fix quality, satellites, HDOP. During an outage it emits nothing. The
/// world's frame is east-north-up at the origin of the model.
class Gnss : public NavigationSensor {
 public:
  /// @param sky what may stand before the satellites, or null. It is asked with the actors where they are at the time
  /// 0 of the last RayScene::poseActors(); it must outlive the sensor.
  Gnss(const GnssModel& model, const Trajectory& trajectory, std::uint64_t seed, Stamp start,
       const RayScene* sky = nullptr);

  /// Share of the sky above the mask that can be seen from a point of the world, 0 … 1.
  double openSky(const Eigen::Vector3d& p_world) const;

 private:
  mrpt::obs::CObservation::Ptr measure(std::uint32_t index, double t) override;
  bool listedOutage(double t) const;
  void stepMultipath(std::uint32_t index);

  GnssModel model_;
  Eigen::Vector3d antenna_base_;
  LocalEnu enu_;
  CounterRandom random_;
  const RayScene* sky_;
  std::vector<Eigen::Vector3d> rays_;
  bool burst_ = false;
  Eigen::Vector3d multipath_m_ = Eigen::Vector3d::Zero();
};

}  // namespace scslam::sim
