// The paths of a radar's rays through the world, row by row.
#pragma once
#include <vector>

#include "sim/radar.h"
#include "sim/radar_antenna.h"

namespace scslam::sim {

/// What one path brings back.
struct RadarEcho {
  double range;                   ///< half its length [m]
  double motion;                  ///< rate of that by the sensor's motion [m/s]
  double doppler;                 ///< the same, with the motion of what it met
  float power;                    ///< [quanta], but for the gains in azimuth
  float azimuth_out, azimuth_in;  ///< where it left and came back, clockwise of the row's beam [rad]
  float re, im;                   ///< complex normal, of variance 1
};

/// Where the sensor is when a row is measured.
struct RadarRow {
  Pose T_world_sensor;
  Eigen::Vector3d velocity;  ///< of the sensor, world frame [m/s]
  double angle;              ///< of the beam, clockwise [rad]
  double time;               ///< within the sweep, 0 … 1, for actors
  double seconds;            ///< into the drive
  std::uint32_t number;      ///< for random numbers
};

/// How a surface scatters: a share diffusely, the rest by facets of Gaussian slopes (geometrical optics), both
/// times Fresnel's reflectivity.
class RadarSurface {
 public:
  /// @param slope rms of the facets' slope (tangent).
  RadarSurface(const Material& material, double slope) : material_(material), slope_(slope) {}
  /// Fresnel reflectivity of power, mean of both polarisations.
  double reflectivity(double cos_incidence) const;
  /// Share of the power that goes on as from a mirror.
  double mirrored(double cos_incidence) const;
  /// Scattering function times the cosine of the leaving direction [1/sr]; unit vectors, normal against `incoming`.
  double scattered(const Eigen::Vector3d& incoming, const Eigen::Vector3d& leaving,
                   const Eigen::Vector3d& normal) const;

 private:
  const Material& material_;
  double slope_;
};

class RadarPaths {
 public:
  RadarPaths(const RadarModel& model, const RadarAntenna& antenna, const RayScene& scene, const CounterRandom& random,
             std::uint32_t scan_number, const World* world);
  /// The echoes of the rays that leave within one row's share of the circle, in a fixed order.
  std::vector<RadarEcho> trace(const RadarRow& row) const;

 private:
  struct Ray;
  struct Meeting;
  void aim(const RadarRow& row, std::vector<Ray>& rays) const;
  void traceOn(const RadarRow& row, int bounce, std::vector<Ray>& rays, std::vector<RadarEcho>& echoes) const;
  void fill(RayPacket& packet, const RadarRow& row, const Ray* rays, int count) const;
  void sendBack(const RadarRow& row, const Ray& ray, const Meeting& at, int bounce,
                std::vector<RadarEcho>& echoes) const;
  void sendHome(const RadarRow& row, const Ray& ray, const Meeting& at, int bounce,
                std::vector<RadarEcho>& echoes) const;
  void keep(RadarEcho echo, double power, std::uint32_t row, std::uint32_t ray, int way,
            std::vector<RadarEcho>& echoes) const;
  double speedOf(const RayPacket& rays, int lane, const Eigen::Vector3d& point, const Eigen::Vector3d& away,
                 double seconds) const;

  const RadarModel& model_;
  const RadarAntenna& antenna_;
  const RayScene& scene_;
  const CounterRandom& random_;
  std::uint32_t scan_;
  const World* world_;
  double gain_, slope_;
};

}  // namespace scslam::sim
