#include "sim/gnss.h"

#include <mrpt/obs/CObservationGPS.h>

#include <cmath>

#include "scslam/core/error.h"
#include "sim/ray_scene.h"

namespace scslam::sim {

using Eigen::Vector3d;

namespace {

enum Draw : std::uint32_t { kWhite, kMultipath };

/// Directions above the mask, each for the same solid angle: a spiral by the golden angle.
std::vector<Vector3d> skyRays(int n, double mask_deg) {
  const double lowest = std::sin(mask_deg * M_PI / 180), golden = M_PI * (3 - std::sqrt(5.0));
  std::vector<Vector3d> rays;
  for (int i = 0; i < n; ++i) {
    const double z = lowest + (1 - lowest) * (i + 0.5) / n, r = std::sqrt(1 - z * z);
    rays.emplace_back(r * std::cos(golden * i), r * std::sin(golden * i), z);
  }
  return rays;
}

mrpt::obs::gnss::UTC_time utcTime(Stamp stamp) {
  constexpr std::int64_t kTicksPerSecond = 10'000'000, kTicksPerDay = 86400 * kTicksPerSecond;
  // The clock counts from a midnight.
  const std::int64_t ticks = (stamp.time_since_epoch().count() % kTicksPerDay + kTicksPerDay) % kTicksPerDay;
  const std::int64_t minutes = ticks / (60 * kTicksPerSecond);
  mrpt::obs::gnss::UTC_time utc;
  utc.hour = static_cast<std::uint8_t>(minutes / 60);
  utc.minute = static_cast<std::uint8_t>(minutes % 60);
  utc.sec = static_cast<double>(ticks % (60 * kTicksPerSecond)) / double{kTicksPerSecond};
  return utc;
}

}  // namespace

void GnssModel::describe(ParamVisitor& v) {
  v.field("enabled", enabled, "is there a GNSS receiver?");
  v.field("rate_hz", rate_hz, "fixes per second", 0.01, 100);
  v.field("translation_m", translation_m, "position of the antenna in the base frame: x y z [m]");
  v.field("latitude_deg", latitude_deg, "latitude of the world's origin, north positive [deg]", -90, 90);
  v.field("longitude_deg", longitude_deg, "longitude of the world's origin, east positive [deg]", -180, 180);
  v.field("height_m", height_m, "height of the world's origin above the WGS-84 ellipsoid [m]", -10000, 100000);
  v.field("horizontal_sigma_m", horizontal_sigma_m, "white noise east and north, each, under open sky [m]", 0, 1000);
  v.field("vertical_sigma_m", vertical_sigma_m, "white noise of the height under open sky [m]", 0, 1000);
  v.field("multipath_per_s", multipath_per_s, "chance per second that a burst of multipath begins", 0, 1000);
  v.field("multipath_s", multipath_s, "mean length of a burst [s]", 0.001, 1e6);
  v.field("multipath_sigma_m", multipath_sigma_m, "sigma of the error in a burst, per axis (height: 1.5 times) [m]", 0,
          1000);
  v.field("multipath_tau_s", multipath_tau_s, "time constant of the error in a burst [s]", 0.001, 1e6);
  v.field("outages_s", outages_s, "times without a fix: [start, end, start, end, ...] [s]");
  v.field("sky_rays", sky_rays, "rays that look for open sky at each fix; 0: the sky is always open", 0, 10000);
  v.field("mask_deg", mask_deg, "elevation below which satellites do not count [deg]", 0, 80);
  v.field("blocked_share", blocked_share, "no fix when more of the sky than this is blocked, 0 ... 1", 0, 1);
  v.field("satellites", satellites, "satellites in use under open sky", 4, 100);
  v.field("hdop", hdop, "horizontal dilution of precision under open sky", 0.1, 99);
  v.field("fix_quality", fix_quality, "of GGA: 1 single, 2 differential, 4 RTK fixed, 5 RTK float", 1, 8);
}

Gnss::Gnss(const GnssModel& model, const Trajectory& trajectory, std::uint64_t seed, Stamp start, const RayScene* sky)
    : NavigationSensor(trajectory, model.rate_hz, model.enabled, start),
      model_(model),
      antenna_base_(threeOf(model.translation_m, "gnss", "translation_m")),
      enu_({model.latitude_deg, model.longitude_deg, model.height_m}),
      random_(seed, RandomStream::kGnss),
      sky_(sky),
      rays_(skyRays(model.sky_rays, model.mask_deg)) {
  const auto& times = model_.outages_s;
  bool in_pairs = times.size() % 2 == 0;
  for (std::size_t i = 0; i + 1 < times.size(); i += 2) in_pairs = in_pairs && times[i] <= times[i + 1];
  if (!in_pairs) throw usageError("gnss: outages_s must be pairs of a start and a later end: [10, 25, 60, 70]");
}

bool Gnss::listedOutage(double t) const {
  for (std::size_t i = 0; i + 1 < model_.outages_s.size(); i += 2)
    if (t >= model_.outages_s[i] && t <= model_.outages_s[i + 1]) return true;
  return false;
}

double Gnss::openSky(const Vector3d& p_world) const {
  if (sky_ == nullptr || rays_.empty()) return 1;
  constexpr double kFar = 500;  // [m]
  int open = 0;
  for (const Vector3d& ray : rays_) open += sky_->sees(p_world, p_world + kFar * ray) ? 1 : 0;
  return static_cast<double>(open) / static_cast<double>(rays_.size());
}

/// Within a burst the error is driven, so that its sigma tends to multipath_sigma_m; after it, it dies away.
void Gnss::stepMultipath(std::uint32_t index) {
  const auto words = random_.block(index, kMultipath);
  const double rate = burst_ ? 1 / model_.multipath_s : model_.multipath_per_s;
  if (static_cast<double>(uniformOf(words[3])) < -std::expm1(-rate * period())) burst_ = !burst_;
  const double keep = std::exp(-period() / model_.multipath_tau_s);
  multipath_m_ *= keep;
  if (!burst_) return;
  const Vector3d sigma = model_.multipath_sigma_m * Vector3d(1, 1, 1.5);
  multipath_m_ += std::sqrt(1 - keep * keep) * sigma.cwiseProduct(normals(words));
}

mrpt::obs::CObservation::Ptr Gnss::measure(std::uint32_t index, double t) {
  stepMultipath(index);
  if (listedOutage(t)) return nullptr;
  const Vector3d antenna = trajectory().pose(t) * antenna_base_;
  const double open = openSky(antenna);
  if (1 - open > model_.blocked_share || open <= 0) return nullptr;
  // Fewer satellites, worse geometry: dilution grows as the root of the open share falls.
  const double dilution = 1 / std::sqrt(open);
  const Vector3d sigma(model_.horizontal_sigma_m, model_.horizontal_sigma_m, model_.vertical_sigma_m);
  const Vector3d noise = dilution * sigma.cwiseProduct(normals(random_.block(index, kWhite))) + multipath_m_;
  const Geodetic g = enu_.toGeodetic(antenna + noise);

  mrpt::obs::gnss::Message_NMEA_GGA gga;
  gga.fields.UTCTime = utcTime(stampAt(t));
  gga.fields.latitude_degrees = g.latitude_deg;
  gga.fields.longitude_degrees = g.longitude_deg;
  gga.fields.altitude_meters = g.height_m;
  gga.fields.geoidal_distance = 0;
  gga.fields.orthometric_altitude = gga.fields.corrected_orthometric_altitude = g.height_m;
  gga.fields.fix_quality = static_cast<std::uint8_t>(model_.fix_quality);
  gga.fields.satellitesUsed = static_cast<std::uint32_t>(std::max(4L, std::lround(model_.satellites * open)));
  gga.fields.thereis_HDOP = true;
  gga.fields.HDOP = static_cast<float>(model_.hdop * dilution);

  auto observation = mrpt::obs::CObservationGPS::Create();
  observation->sensorLabel = "gnss";
  observation->sensorPose = mrpt::poses::CPose3D(antenna_base_.x(), antenna_base_.y(), antenna_base_.z(), 0, 0, 0);
  observation->has_satellite_timestamp = true;
  observation->originalReceivedTimestamp = stampAt(t);
  observation->setMsg(gga);
  return observation;
}

}  // namespace scslam::sim
