#include "sim/radar_echoes.h"

#include <algorithm>
#include <cmath>

namespace scslam::sim {

using Eigen::Vector3d;

namespace {

constexpr double kSkin = 0.002;        ///< a reflected ray starts so far off the surface [m]
constexpr double kFaintest = 1e-5;     ///< echoes below so many quanta are not kept
constexpr double kFaintestRay = 1e-4;  ///< rays whose power is less (quanta at 1 m) are not followed

/// Bits mirrored: i = 0, 1, 2 … spread evenly over (0, 1) at every length.
double vanDerCorput(std::uint32_t i) {
  std::uint32_t r = 0;
  for (int bit = 0; bit < 32; ++bit) r = r << 1 | (i >> bit & 1U);
  return r * 0x1p-32;
}

}  // namespace

/// A ray on its way, after as many mirrors as it has met.
struct RadarPaths::Ray {
  Vector3d origin, direction;  ///< world
  Vector3d first;              ///< direction in which it left the antenna
  double length;               ///< from the antenna to `origin` [m]
  double power;                ///< solid angle times elevation gain where it left, scaled to quanta
  double gain;                 ///< that elevation gain
  double mirrors;              ///< product of the reflectivities on its way
  double azimuth;              ///< where it left, clockwise of the beam [rad]
  std::uint32_t number;        ///< within its row
};

/// A ray meets a surface.
struct RadarPaths::Meeting {
  Vector3d point, normal;
  double length;  ///< of the way there [m]
  RadarSurface surface;
  double speed;  ///< of the surface, away from the antenna [m/s]
};

RadarPaths::RadarPaths(const RadarModel& model, const RadarAntenna& antenna, const RayScene& scene,
                       const CounterRandom& random, std::uint32_t scan_number, const World* world)
    : model_(model),
      antenna_(antenna),
      scene_(scene),
      random_(random),
      scan_(scan_number),
      world_(world),
      gain_(std::pow(10.0, model.gain_db / 10) * 1e4 * 4 * M_PI),
      slope_(std::tan(model.surface_slope_deg * M_PI / 180)) {}

std::vector<RadarEcho> RadarPaths::trace(const RadarRow& row) const {
  std::vector<Ray> rays;
  std::vector<RadarEcho> echoes;
  aim(row, rays);
  for (int bounce = 1; bounce <= model_.max_bounces && !rays.empty(); ++bounce) traceOn(row, bounce, rays, echoes);
  return echoes;
}

/// Elevations in equal shares of the antenna's power, azimuths spread over the row, both jittered.
void RadarPaths::aim(const RadarRow& row, std::vector<Ray>& rays) const {
  const int n = model_.rays_per_azimuth;
  const double row_width = 2 * M_PI / model_.azimuths;
  const double turn = static_cast<double>(uniformOf(random_.block(scan_, row.number)[0]));
  rays.reserve(static_cast<std::size_t>(n));
  for (int i = 0; i < n; ++i) {
    const auto number = static_cast<std::uint32_t>(i);
    const auto words = random_.block(scan_, row.number, number + 1);
    const auto [elevation, density] = antenna_.draw((i + static_cast<double>(uniformOf(words[0]))) / n);
    double across = vanDerCorput(number) + turn + static_cast<double>(uniformOf(words[1])) / n;
    across -= std::floor(across);
    const double azimuth = (across - 0.5) * row_width, angle = row.angle + azimuth;
    const double c = std::cos(elevation), gain = antenna_.elevationGain(elevation);
    const Vector3d d(c * std::cos(angle), -c * std::sin(angle), std::sin(elevation));
    const Vector3d direction = row.T_world_sensor.linear() * d;
    const double solid_angle = row_width * c / (n * density);
    rays.push_back({row.T_world_sensor.translation(), direction, direction, 0, gain_ * solid_angle * gain, gain, 1,
                    azimuth, number});
  }
}

void RadarPaths::fill(RayPacket& packet, const RadarRow& row, const Ray* rays, int count) const {
  for (int k = 0; k < count; ++k) {
    const Eigen::Vector3f o = rays[k].origin.cast<float>(), d = rays[k].direction.cast<float>();
    packet.ray.org_x[k] = o.x(), packet.ray.org_y[k] = o.y(), packet.ray.org_z[k] = o.z();
    packet.ray.dir_x[k] = d.x(), packet.ray.dir_y[k] = d.y(), packet.ray.dir_z[k] = d.z();
    packet.ray.tnear[k] = 0, packet.ray.time[k] = static_cast<float>(row.time);
    packet.ray.tfar[k] = static_cast<float>(std::max(0.0, 2 * model_.maxRange() - rays[k].length));
    packet.ray.mask[k] = 0xFFFFFFFF, packet.ray.flags[k] = 0, packet.ray.id[k] = 0;
    packet.hit.geomID[k] = packet.hit.instID[0][k] = RTC_INVALID_GEOMETRY_ID;
  }
}

/// Traces the rays to the next surface; leaves those that go on as from a mirror.
void RadarPaths::traceOn(const RadarRow& row, int bounce, std::vector<Ray>& rays,
                         std::vector<RadarEcho>& echoes) const {
  std::vector<Ray> next;
  RayPacket packet;
  for (std::size_t begin = 0; begin < rays.size(); begin += 16) {
    const int count = static_cast<int>(std::min<std::size_t>(16, rays.size() - begin));
    fill(packet, row, &rays[begin], count);
    scene_.trace(packet, (1U << count) - 1);
    for (int k = 0; k < count; ++k) {
      if (packet.hit.geomID[k] == RTC_INVALID_GEOMETRY_ID) continue;
      Ray ray = rays[begin + static_cast<std::size_t>(k)];
      const Vector3d normal = scene_.normal(packet, k).cast<double>();
      if (!normal.allFinite()) continue;  // a triangle without area
      const double leg = static_cast<double>(packet.ray.tfar[k]);
      const Vector3d point = ray.origin + leg * ray.direction;
      const double speed = bounce == 1 ? speedOf(packet, k, point, ray.direction, row.seconds) : 0;
      const Meeting at{point, normal, ray.length + leg, {materials()[scene_.materialOf(packet, k)], slope_}, speed};
      sendBack(row, ray, at, bounce, echoes);
      const double cosine = -normal.dot(ray.direction);
      ray.mirrors *= at.surface.mirrored(cosine);
      if (bounce == model_.max_bounces || ray.power * ray.mirrors < kFaintestRay) continue;
      ray.direction = (ray.direction + 2 * cosine * normal).normalized();
      ray.origin = point + kSkin * normal;
      ray.length = at.length;
      next.push_back(ray);
    }
  }
  rays = std::move(next);
}

/// The way it came, by all mirrors again; and after a mirror also straight home.
void RadarPaths::sendBack(const RadarRow& row, const Ray& ray, const Meeting& at, int bounce,
                          std::vector<RadarEcho>& echoes) const {
  if (bounce > 1) sendHome(row, ray, at, bounce, echoes);
  if (2 * bounce - 1 > model_.max_bounces) return;
  RadarEcho echo{};
  echo.range = at.length;
  echo.motion = -row.velocity.dot(ray.first);
  echo.doppler = echo.motion + at.speed;
  echo.azimuth_out = echo.azimuth_in = static_cast<float>(ray.azimuth);
  const double scattered = at.surface.scattered(ray.direction, -ray.direction, at.normal);
  keep(echo, ray.power * ray.gain * ray.mirrors * ray.mirrors * scattered / (at.length * at.length), row.number,
       ray.number, 2 * bounce, echoes);
}

void RadarPaths::sendHome(const RadarRow& row, const Ray& ray, const Meeting& at, int bounce,
                          std::vector<RadarEcho>& echoes) const {
  const Vector3d antenna = row.T_world_sensor.translation();
  const double distance = (antenna - at.point).norm();
  if (!(distance > 0)) return;
  const Vector3d home = (antenna - at.point) / distance, seen = row.T_world_sensor.linear().transpose() * -home;
  const double azimuth = std::remainder(std::atan2(-seen.y(), seen.x()) - row.angle, 2 * M_PI);
  if (std::abs(azimuth) > antenna_.azimuthReach()) return;
  const double gain = antenna_.elevationGain(std::asin(std::clamp(seen.z(), -1.0, 1.0)));
  const double power =
      ray.power * ray.mirrors * gain * at.surface.scattered(ray.direction, home, at.normal) / (distance * distance);
  if (!(power > kFaintest) || !scene_.sees(at.point + kSkin * at.normal, antenna, row.time)) return;
  RadarEcho echo{};
  echo.range = (at.length + distance) / 2;
  echo.motion = echo.doppler = -row.velocity.dot(ray.first - home) / 2;
  echo.azimuth_out = static_cast<float>(ray.azimuth), echo.azimuth_in = static_cast<float>(azimuth);
  keep(echo, power, row.number, ray.number, 2 * bounce + 1, echoes);
}

void RadarPaths::keep(RadarEcho echo, double power, std::uint32_t row, std::uint32_t ray, int way,
                      std::vector<RadarEcho>& echoes) const {
  if (!(power > kFaintest) || !(echo.range >= model_.min_range_m)) return;
  const auto words = random_.block(scan_, row, ray + 1, static_cast<std::uint32_t>(way));
  const float half = std::sqrt(0.5F);
  echo.power = static_cast<float>(power);
  echo.re = half * normalOf(words[0]), echo.im = half * normalOf(words[1]);
  echoes.push_back(echo);
}

/// Speed of what a ray met, away from the antenna, where it is an actor.
double RadarPaths::speedOf(const RayPacket& rays, int lane, const Vector3d& point, const Vector3d& away,
                           double seconds) const {
  constexpr double kStep = 1e-3, kFastest = 100;  // beyond: it jumps to the start of its path
  const unsigned part = rays.hit.instID[0][lane];
  if (world_ == nullptr || part == RTC_INVALID_GEOMETRY_ID || part == 0 || part > world_->actors.size()) return 0;
  const Actor& actor = world_->actors[part - 1];
  const Pose before = actor.at(seconds - kStep), after = actor.at(seconds + kStep);
  const Vector3d step = after * (actor.at(seconds).inverse() * point) - before * (actor.at(seconds).inverse() * point);
  const double speed = away.dot(step) / (2 * kStep);
  return std::abs(speed) < kFastest ? speed : 0;
}

}  // namespace scslam::sim
