#include "sim/drive.h"

#include <algorithm>
#include <cmath>

#include "scslam/core/error.h"
#include "scslam/core/suggest.h"

namespace scslam::sim {

using Eigen::Vector2d;
using Eigen::Vector3d;

namespace {

constexpr double kStep = 0.25;  ///< between the points of a path [m]
constexpr double kKnot = 0.1;   ///< between the control poses of the trajectory [s]
constexpr double kDeg = M_PI / 180;

/// A path in steps of about kStep: points, distance from the start, heading, curvature.
struct Path {
  std::vector<Vector3d> points;
  std::vector<double> s, heading, curvature;
  double length() const { return s.back(); }
};

/// Corners replaced by arcs that touch both sides.
std::vector<Vector3d> rounded(const std::vector<Vector3d>& corners, bool closed, double radius) {
  std::vector<Vector3d> result;
  const std::size_t n = corners.size();
  const auto lineTo = [&result](const Vector3d& to) {
    if (result.empty()) return result.push_back(to);
    const Vector3d start = result.back(), way = to - start;  // before the result grows: `to` may be one of its own
    const int steps = static_cast<int>(std::ceil(way.norm() / kStep));
    for (int k = 1; k <= steps; ++k) result.push_back(start + way * k / steps);
  };
  for (std::size_t i = 0; i < n; ++i) {
    if (!closed && (i == 0 || i + 1 == n)) {
      lineTo(corners[i]);
      continue;
    }
    const Vector3d &at = corners[i], &before = corners[(i + n - 1) % n], &after = corners[(i + 1) % n];
    const Vector3d in = (at - before).normalized(), out = (after - at).normalized();
    const double angle = std::acos(std::clamp(in.dot(out), -1.0, 1.0));
    const double room = 0.45 * std::min((at - before).norm(), (after - at).norm());
    const double cut = std::min(radius * std::tan(std::min(angle, 3.0) / 2), room);
    lineTo(at - in * cut);
    const int steps = std::max(1, static_cast<int>(std::ceil(angle * radius / kStep)));
    for (int k = 1; k <= steps && angle > 1e-3; ++k) {
      // A quadratic Bezier through the corner's tangents: close to the arc, and smooth for any pair of sides.
      const double u = static_cast<double>(k) / steps;
      result.push_back((1 - u) * (1 - u) * (at - in * cut) + 2 * u * (1 - u) * at + u * u * (at + out * cut));
    }
  }
  if (closed) lineTo(result.front());
  return result;
}

/// The points moved `offset(s)` to the left of the way.
Path measured(const std::vector<Vector3d>& points, const std::function<double(double)>& offset) {
  Path path;
  double s = 0;
  std::vector<Vector3d> moved;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (i > 0) s += (points[i] - points[i - 1]).norm();
    const Vector3d d = points[std::min(i + 1, points.size() - 1)] - points[i > 0 ? i - 1 : 0];
    const Vector2d left = Vector2d(-d.y(), d.x()).normalized();
    moved.emplace_back(points[i] + offset(s) * Vector3d(left.x(), left.y(), 0));
  }
  for (std::size_t i = 0; i < moved.size(); ++i) {
    if (i > 0 && (moved[i] - path.points.back()).norm() < 1e-3) continue;
    path.s.push_back(path.points.empty() ? 0 : path.s.back() + (moved[i] - path.points.back()).norm());
    path.points.push_back(moved[i]);
  }
  const std::size_t n = path.points.size();
  for (std::size_t i = 0; i < n; ++i) {
    const Vector3d d = path.points[std::min(i + 2, n - 1)] - path.points[i >= 2 ? i - 2 : 0];
    double heading = std::atan2(d.y(), d.x());
    if (i > 0) heading += 2 * M_PI * std::round((path.heading[i - 1] - heading) / (2 * M_PI));
    path.heading.push_back(heading);
  }
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t a = i >= 2 ? i - 2 : 0, b = std::min(i + 2, n - 1);
    path.curvature.push_back((path.heading[b] - path.heading[a]) / std::max(1e-6, path.s[b] - path.s[a]));
  }
  return path;
}

/// Greatest speed at each point that keeps the accelerations and stops where it must.
std::vector<double> speeds(const Path& path, const DriveParams& p) {
  std::vector<double> v;
  for (const double k : path.curvature)
    v.push_back(std::min(p.speed_mps, std::sqrt(p.corner_mps2 / std::max(1e-6, std::abs(k)))));
  v.front() = v.back() = 0;
  for (const double stop : p.stops_m) {
    const auto i = std::lower_bound(path.s.begin(), path.s.end(), stop) - path.s.begin();
    if (i < std::ssize(v)) v[static_cast<std::size_t>(i)] = 0;
  }
  const auto reach = [&](double from, std::size_t a, std::size_t b) {
    return std::sqrt(from * from + 2 * p.accelerate_mps2 * (path.s[b] - path.s[a]));
  };
  for (std::size_t i = 1; i < v.size(); ++i) v[i] = std::min(v[i], reach(v[i - 1], i - 1, i));
  for (std::size_t i = v.size() - 1; i-- > 0;) v[i] = std::min(v[i], reach(v[i + 1], i, i + 1));
  return v;
}

/// When each point is passed; a stop makes two entries.
struct Timetable {
  std::vector<double> t, s, v;
};

Timetable timetable(const Path& path, const DriveParams& p) {
  const std::vector<double> v = speeds(path, p);
  Timetable table;
  const auto add = [&table](double t, double s, double speed) {
    table.t.push_back(t), table.s.push_back(s), table.v.push_back(speed);
  };
  add(0, 0, 0);
  add(p.start_pause_s, 0, 0);
  for (std::size_t i = 1; i < v.size() && table.t.back() < p.duration_s; ++i) {
    const double mean = std::max(0.05, (v[i] + v[i - 1]) / 2);
    add(table.t.back() + (path.s[i] - path.s[i - 1]) / mean, path.s[i], v[i]);
    if (v[i] <= 0 && i + 1 < v.size()) add(table.t.back() + p.stop_s, path.s[i], 0);
  }
  return table;
}

double interpolated(const std::vector<double>& x, const std::vector<double>& y, double at) {
  const auto hi = std::lower_bound(x.begin(), x.end(), at) - x.begin();
  if (hi == 0) return y.front();
  if (hi == std::ssize(x)) return y.back();
  const auto i = static_cast<std::size_t>(hi);
  const double width = x[i] - x[i - 1];
  return width <= 0 ? y[i] : y[i - 1] + (y[i] - y[i - 1]) * (at - x[i - 1]) / width;
}

/// The body on its four wheels, leaning with the accelerations.
Pose onGround(const Vector3d& at, double heading, double forward_mps2, double left_mps2, const DriveParams& p,
              const GroundHeight& ground) {
  const Vector3d ahead(std::cos(heading), std::sin(heading), 0), left(-std::sin(heading), std::cos(heading), 0);
  const auto wheel = [&](double x, double y) {
    const Vector3d w = at + x * p.wheelbase_m / 2 * ahead + y * p.track_m / 2 * left;
    const double z = ground(w.x(), w.y(), at.z());
    return std::isfinite(z) ? z : at.z();
  };
  const double fl = wheel(1, 1), fr = wheel(1, -1), rl = wheel(-1, 1), rr = wheel(-1, -1);
  const double lean = p.lean_deg_per_mps2 * kDeg;
  const double pitch = -std::atan2((fl + fr - rl - rr) / 2, p.wheelbase_m) - lean * forward_mps2;
  const double roll = std::atan2((fl + rl - fr - rr) / 2, p.track_m) + lean * left_mps2;
  Pose T = poseFromYaw(heading, Vector3d(at.x(), at.y(), (fl + fr + rl + rr) / 4));
  T.linear() = T.linear() * Eigen::AngleAxisd(pitch, Vector3d::UnitY()) * Eigen::AngleAxisd(roll, Vector3d::UnitX());
  return T;
}

Route chosenRoute(const DriveParams& p, const std::vector<Route>& routes) {
  if (!p.points.empty()) {
    if (p.points.size() < 4 || p.points.size() % 2 != 0)
      throw usageError("drive.points needs pairs x y, at least two; it has {} numbers", p.points.size());
    Route route{"points", {}, p.closed};
    for (std::size_t i = 0; i < p.points.size(); i += 2) route.points.emplace_back(p.points[i], p.points[i + 1], 0);
    return route;
  }
  std::vector<std::string> names;
  for (const Route& route : routes) {
    if (p.route.empty() || route.name == p.route) return route;
    names.push_back(route.name);
  }
  if (routes.empty()) throw usageError("this world has no routes: give drive.points");
  throw usageError("this world has no route '{}'{}", p.route, didYouMean(p.route, names));
}

/// The route lap after lap, lanes and offsets applied.
Path pathOf(const Route& route, const DriveParams& p) {
  const std::vector<Vector3d> lap = rounded(route.points, route.closed, p.turn_radius_m);
  double lap_length = 0;
  for (std::size_t i = 1; i < lap.size(); ++i) lap_length += (lap[i] - lap[i - 1]).norm();
  if (lap_length < 1) throw usageError("the route '{}' is only {:.2f} m long", route.name, lap_length);
  std::vector<Vector3d> points = lap;
  const double laps = route.closed ? p.laps : 1;
  for (double done = 1; done < laps; ++done) {
    const auto share = std::min(1.0, laps - done);
    const auto n = static_cast<std::size_t>(share * static_cast<double>(lap.size()));
    points.insert(points.end(), lap.begin(), lap.begin() + static_cast<std::ptrdiff_t>(n));
  }
  if (laps < 1)
    points.resize(std::max<std::size_t>(8, static_cast<std::size_t>(laps * static_cast<double>(lap.size()))));
  const auto offsetOfLap = [&p](double number) {
    if (p.lap_offset_m.empty()) return 0.0;
    const auto i = static_cast<std::size_t>(std::clamp(number, 0.0, static_cast<double>(p.lap_offset_m.size() - 1)));
    return p.lap_offset_m[i];
  };
  return measured(points, [&](double s) {
    const double number = std::floor(s / lap_length), into = s - number * lap_length;
    const double u = std::clamp(into / 20, 0.0, 1.0), smooth = u * u * (3 - 2 * u);  // lanes change within 20 m
    const double before = number > 0 ? offsetOfLap(number - 1) : offsetOfLap(0);
    return p.lane_m + before + (offsetOfLap(number) - before) * smooth;
  });
}

}  // namespace

void DriveParams::describe(ParamVisitor& v) {
  v.field("route", route, "which of the world's routes; empty: its first");
  v.field("points", points, "an own route instead: x, y, x, y ... [m]");
  v.field("closed", closed, "the own route is a loop");
  v.field("laps", laps, "of a loop; may be broken", 0.01, 1000);
  v.field("lane_m", lane_m, "the robot keeps so far to the left of the route [m]", -50, 50);
  v.field("lap_offset_m", lap_offset_m, "and so much more in lap 1, 2, ... [m]");
  v.field("speed_mps", speed_mps, "greatest speed [m/s]", 0.05, 100);
  v.field("accelerate_mps2", accelerate_mps2, "greatest acceleration and braking [m/s^2]", 0.05, 20);
  v.field("corner_mps2", corner_mps2, "greatest sideways acceleration [m/s^2]", 0.05, 20);
  v.field("turn_radius_m", turn_radius_m, "corners are rounded with this radius [m]", 0.1, 1000);
  v.field("start_pause_s", start_pause_s, "it stands so long before it goes [s]", 0, 1e5);
  v.field("stops_m", stops_m, "distances travelled at which it stops [m]");
  v.field("stop_s", stop_s, "how long it stops there [s]", 0, 1e5);
  v.field("duration_s", duration_s, "the drive is cut here [s]", 0, 1e6);
  v.field("wheelbase_m", wheelbase_m, "distance of the axles [m]", 0.05, 20);
  v.field("track_m", track_m, "distance of left and right wheels [m]", 0.05, 10);
  v.field("lean_deg_per_mps2", lean_deg_per_mps2, "pitch and roll of the body for each m/s^2 [deg]", 0, 10);
}

Trajectory planDrive(const DriveParams& p, const std::vector<Route>& routes, const GroundHeight& ground) {
  const Path path = pathOf(chosenRoute(p, routes), p);
  const Timetable table = timetable(path, p);
  const double end = std::min(p.duration_s, table.t.back());
  if (!(end > 0)) throw usageError("the drive lasts {} s: nothing to simulate", p.duration_s);
  std::vector<double> x, y;
  for (const Vector3d& point : path.points) x.push_back(point.x()), y.push_back(point.y());
  std::vector<Pose> control;
  double hint = path.points.front().z();
  const auto knots = static_cast<int>(std::ceil(end / kKnot));
  for (int k = -1; k <= knots + 1; ++k) {
    const double t = std::clamp(k * kKnot, 0.0, table.t.back());
    const double s = interpolated(table.t, table.s, t), speed = interpolated(table.t, table.v, t);
    const double forward = (interpolated(table.t, table.v, t + 0.3) - interpolated(table.t, table.v, t - 0.3)) / 0.6;
    const double sideways = speed * speed * interpolated(path.s, path.curvature, s);
    // The ground is followed from where the robot was: the route's z matters at its start only.
    control.push_back(onGround({interpolated(path.s, x, s), interpolated(path.s, y, s), hint},
                               interpolated(path.s, path.heading, s), forward, sideways, p, ground));
    hint = control.back().translation().z();
  }
  return Trajectory(std::move(control), kKnot);
}

}  // namespace scslam::sim
