#include "sim/truth.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace scslam::sim {

using Eigen::Vector3d;

namespace {

constexpr double kFar = 10;                                    ///< a revisit is within this [m]
constexpr int kLooks = 512;                                    ///< rays that stand for what a place sees
constexpr int kAzimuths = 72;                                  ///< of the shape around a place
constexpr std::array<double, 4> kElevations = {-3, 2, 7, 12};  ///< [deg]
constexpr double kAlike = 0.12;                                ///< mean |ln| below which two places look alike
using Shape = std::array<float, kAzimuths * kElevations.size()>;

/// What a sensor of +-20 degrees sees there: a point per ray that meets something.
std::vector<Vector3d> seenFrom(const Place& place, const RayScene& scene, double max_range) {
  std::vector<Vector3d> points;
  const Vector3d eye = place.T_world_sensor.translation();
  for (int k = 0; k < kLooks; ++k) {
    const double z = std::sin(20 * M_PI / 180) * (2 * (k + 0.5) / kLooks - 1), azimuth = 2.399963229728653 * k;
    const double flat = std::sqrt(1 - z * z);
    const Vector3d d = place.T_world_sensor.linear() * Vector3d(flat * std::cos(azimuth), flat * std::sin(azimuth), z);
    if (const auto hit = scene.first(eye, d, max_range)) points.emplace_back(eye + hit->range * d);
  }
  return points;
}

double shareSeen(const std::vector<Vector3d>& points, const Place& from, const RayScene& scene, double max_range) {
  if (points.empty()) return 0;
  const Vector3d eye = from.T_world_sensor.translation();
  const auto seen = std::count_if(points.begin(), points.end(), [&](const Vector3d& p) {
    return (p - eye).squaredNorm() < max_range * max_range && scene.sees(eye, p);
  });
  return static_cast<double>(seen) / static_cast<double>(points.size());
}

/// ln of the range all around, level with gravity, from the heading on.
Shape shapeOf(const Place& place, const RayScene& scene, double max_range) {
  Shape shape{};
  const double heading = yawOf(place.T_world_base);
  for (std::size_t e = 0; e < kElevations.size(); ++e)
    for (int k = 0; k < kAzimuths; ++k) {
      const double azimuth = heading + 2 * M_PI * k / kAzimuths, elevation = kElevations[e] * M_PI / 180;
      const Vector3d d(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                       std::sin(elevation));
      const auto hit = scene.first(place.T_world_sensor.translation(), d, max_range);
      shape[e * kAzimuths + static_cast<std::size_t>(k)] = static_cast<float>(std::log(hit ? hit->range : max_range));
    }
  return shape;
}

/// Least mean difference over all turns.
float difference(const Shape& a, const Shape& b) {
  float best = 1e9F;
  for (int turn = 0; turn < kAzimuths; ++turn) {
    float sum = 0;
    for (std::size_t e = 0; e < kElevations.size(); ++e)
      for (int k = 0; k < kAzimuths; ++k) {
        const auto other = static_cast<std::size_t>((k + turn) % kAzimuths);
        sum += std::abs(a[e * kAzimuths + static_cast<std::size_t>(k)] - b[e * kAzimuths + other]);
      }
    best = std::min(best, sum);
  }
  return best / static_cast<float>(a.size());
}

double distance(const Place& a, const Place& b) {
  return (a.T_world_base.translation() - b.T_world_base.translation()).norm();
}

}  // namespace

std::vector<Place> placesOf(const Trajectory& drive, const Pose& T_base_sensor, double sweep_s,
                            const std::vector<std::uint32_t>& sweeps, double every_m) {
  std::vector<Place> places;
  double travel = 0;
  Vector3d last = drive.pose(0).translation();
  for (std::size_t i = 0; i < sweeps.size(); ++i) {
    const double t = sweeps[i] * sweep_s;
    const Pose T = drive.pose(t);
    travel += (T.translation() - last).norm();
    last = T.translation();
    if (places.empty() || travel - places.back().travel_m >= every_m)
      places.push_back({static_cast<std::uint32_t>(i), t, travel, T, T * T_base_sensor});
  }
  return places;
}

std::vector<Revisit> revisits(const std::vector<Place>& places, const RayScene& scene, double max_range_m,
                              double min_travel_m, ThreadPool& threads) {
  std::vector<Revisit> found;
  std::vector<char> needed(places.size(), 0);
  for (std::size_t b = 0; b < places.size(); ++b)
    for (std::size_t a = 0; a < b; ++a) {
      if (places[b].travel_m - places[a].travel_m <= min_travel_m || distance(places[a], places[b]) > kFar) continue;
      const Pose T_a_b = places[a].T_world_base.inverse() * places[b].T_world_base;
      found.push_back({a, b, T_a_b.translation().norm(), yawOf(T_a_b) * 180 / M_PI, T_a_b.translation().y(), 0, 0});
      needed[a] = needed[b] = 1;
    }
  std::sort(found.begin(), found.end(),
            [](const Revisit& x, const Revisit& y) { return std::pair(x.a, x.b) < std::pair(y.a, y.b); });
  std::vector<std::vector<Vector3d>> seen(places.size());
  threads.forEachChunk(places.size(), 4, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i)
      if (needed[i] != 0) seen[i] = seenFrom(places[i], scene, max_range_m);
  });
  threads.forEachChunk(found.size(), 8, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) {
      Revisit& r = found[i];
      r.overlap_a = shareSeen(seen[r.a], places[r.b], scene, max_range_m);
      r.overlap_b = shareSeen(seen[r.b], places[r.a], scene, max_range_m);
    }
  });
  return found;
}

std::vector<Alias> aliases(const std::vector<Place>& places, const RayScene& scene, double max_range_m,
                           ThreadPool& threads) {
  constexpr std::size_t kMost = 500;  // every pair is compared: long drives are thinned
  const std::size_t stride = (places.size() + kMost - 1) / kMost;
  std::vector<std::size_t> chosen;
  for (std::size_t i = 0; i < places.size(); i += std::max<std::size_t>(1, stride)) chosen.push_back(i);
  std::vector<Shape> shapes(chosen.size());
  threads.forEachChunk(chosen.size(), 4, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t i = begin; i < end; ++i) shapes[i] = shapeOf(places[chosen[i]], scene, max_range_m);
  });
  std::vector<std::vector<Alias>> parts(chosen.size());
  threads.forEachChunk(chosen.size(), 1, [&](std::size_t begin, std::size_t, std::size_t) {
    for (std::size_t j = begin + 1; j < chosen.size(); ++j) {
      if (distance(places[chosen[begin]], places[chosen[j]]) <= kFar) continue;
      const auto d = static_cast<double>(difference(shapes[begin], shapes[j]));
      if (d < kAlike) parts[begin].push_back({chosen[begin], chosen[j], d});
    }
  });
  std::vector<Alias> all;
  for (const auto& part : parts) all.insert(all.end(), part.begin(), part.end());
  return all;
}

std::string revisitsCsv(const std::vector<Place>& places, const std::vector<Revisit>& revisits) {
  std::string text = "scan_a,scan_b,distance_m,heading_deg,lateral_m,overlap_a,overlap_b,within_3m\n";
  for (const Revisit& r : revisits)
    text += fmt::format("{},{},{:.3f},{:.2f},{:.3f},{:.3f},{:.3f},{}\n", places[r.a].scan, places[r.b].scan,
                        r.distance_m, r.heading_deg, r.lateral_m, r.overlap_a, r.overlap_b, r.distance_m < 3 ? 1 : 0);
  return text;
}

std::string aliasesCsv(const std::vector<Place>& places, const std::vector<Alias>& aliases) {
  std::string text = "scan_a,scan_b,difference,distance_m\n";
  for (const Alias& a : aliases)
    text += fmt::format("{},{},{:.4f},{:.2f}\n", places[a.a].scan, places[a.b].scan, a.difference,
                        distance(places[a.a], places[a.b]));
  return text;
}

}  // namespace scslam::sim
