#include "sim/render.h"

#include <algorithm>
#include <cmath>

namespace scslam::sim {

using Eigen::Vector3d;

namespace {

const Rgb kSky = {232, 238, 245};

/// Colours of the classes, near those SemanticKITTI made familiar.
Rgb colourOf(std::uint16_t label) {
  switch (label) {
    case 10:
    case 252:
      return {60, 110, 230};
    case 13:
    case 257:
      return {30, 60, 180};
    case 11:
    case 31:
    case 253:
      return {40, 190, 200};
    case 30:
    case 254:
      return {230, 60, 60};
    case 40:
      return {125, 118, 128};
    case 44:
      return {150, 130, 160};
    case 48:
      return {178, 165, 160};
    case 49:
      return {120, 170, 215};
    case 50:
      return {226, 196, 140};
    case 51:
      return {205, 140, 90};
    case 52:
      return {190, 170, 150};
    case 70:
      return {70, 155, 60};
    case 71:
      return {125, 85, 50};
    case 72:
      return {150, 190, 100};
    case 80:
      return {220, 200, 60};
    case 81:
      return {240, 60, 200};
    default:
      return {170, 170, 170};
  }
}

Rgb shaded(const Hit& hit, double fade) {
  const Vector3d light = Vector3d(0.4, 0.25, 0.88).normalized();
  const auto shade = static_cast<float>(0.45 + 0.55 * std::abs(hit.normal.dot(light)));
  const auto mist = static_cast<float>(std::clamp(fade, 0.0, 0.85));
  Rgb colour = colourOf(hit.surface.label);
  for (std::size_t k = 0; k < 3; ++k) colour[k] = colour[k] * shade * (1 - mist) + kSky[k] * mist;
  return colour;
}

/// A picture of what the ray of each pixel meets. @param ray gives origin and direction of pixel (x, y).
template <class Ray>
Image traced(const RayScene& scene, int width, int height, double fog_m, ThreadPool& threads, const Ray& ray) {
  std::vector<Rgb> pixels(static_cast<std::size_t>(width * height), kSky);
  threads.forEachChunk(static_cast<std::size_t>(height), 8, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (auto y = begin; y < end; ++y)
      for (int x = 0; x < width; ++x) {
        const auto [origin, direction] = ray(x, static_cast<int>(y));
        if (const auto hit = scene.first(origin, direction, 5000))
          pixels[y * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)] =
              shaded(*hit, fog_m > 0 ? hit->range / fog_m : 0);
      }
  });
  Image image(width, height, kSky);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) image.blend(x, y, pixels[static_cast<std::size_t>(y * width + x)]);
  return image;
}

}  // namespace

std::string renderTop(const RayScene& scene, const Eigen::AlignedBox3f& bounds, const Trajectory& drive,
                      ThreadPool& threads) {
  // The surroundings of the drive: a world may be far larger.
  Eigen::AlignedBox2d way;
  for (double t = 0; t <= drive.duration(); t += 0.25) way.extend(drive.pose(t).translation().head<2>().eval());
  const Eigen::Vector2d low = (way.min().array() - 40).max(bounds.min().head<2>().cast<double>().array());
  const Eigen::Vector2d high = (way.max().array() + 40).min(bounds.max().head<2>().cast<double>().array());
  const Eigen::Vector2d size = (high - low).cwiseMax(1.0);
  const double metres_per_pixel = std::max(size.x() / 1200, size.y() / 900);
  const int width = std::max(2, static_cast<int>(size.x() / metres_per_pixel));
  const int height = std::max(2, static_cast<int>(size.y() / metres_per_pixel));
  const double top = static_cast<double>(bounds.max().z()) + 10;
  Image image = traced(scene, width, height, 0, threads, [&](int x, int y) {
    return std::pair(Vector3d(low.x() + (x + 0.5) * metres_per_pixel, high.y() - (y + 0.5) * metres_per_pixel, top),
                     Vector3d(0, 0, -1));
  });
  const auto pixel = [&](double t) {
    const Vector3d p = drive.pose(t).translation();
    return Eigen::Vector2d((p.x() - low.x()) / metres_per_pixel, (high.y() - p.y()) / metres_per_pixel);
  };
  for (double t = 0; t < drive.duration(); t += 0.25) {
    const Eigen::Vector2d a = pixel(t), b = pixel(std::min(t + 0.25, drive.duration()));
    image.line(a.x(), a.y(), b.x(), b.y(), 2.5, {230, 30, 60});
  }
  return image.png();
}

std::string renderOblique(const RayScene& scene, const Trajectory& drive, double t, ThreadPool& threads) {
  constexpr int kWidth = 1200, kHeight = 700;
  const Pose T = drive.pose(t);
  const double heading = yawOf(T);
  const Vector3d ahead(std::cos(heading), std::sin(heading), 0);
  // Through a tunnel or a hall the eye stays below the ceiling.
  double lift = 14;
  if (const auto roof = scene.first(T.translation() + Vector3d(0, 0, 1.5), Vector3d::UnitZ(), 25))
    lift = std::max(1.0, roof->range + 1.5 - 0.5);
  lift = std::min(lift, 14.0);
  const Vector3d eye = T.translation() - ahead * (0.8 * lift) + Vector3d(0, 0, lift);
  const Vector3d look = (T.translation() + 12 * ahead - eye).normalized();
  const Vector3d right = look.cross(Vector3d::UnitZ()).normalized(), up = right.cross(look);
  return traced(scene, kWidth, kHeight, 350, threads,
                [&](int x, int y) {
                  const double u = (x - kWidth / 2.0) / kWidth * 1.4, v = (kHeight / 2.0 - y) / kWidth * 1.4;
                  return std::pair(eye, Vector3d((look + u * right + v * up).normalized()));
                })
      .png();
}

std::string renderScan(const LidarScan& scan, const Lidar& lidar) {
  constexpr int kSize = 1000;
  constexpr double kReach = 45;  ///< [m] shown to each side
  const int strip = std::max(24, 3 * lidar.grid().rings());
  Image image(kSize, kSize + strip + 4, {18, 20, 26});
  const Cloud& cloud = scan.cloud;
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Rgb colour = colourOf(static_cast<std::uint16_t>(scan.labels[i] & 0xFFFF));
    const auto azimuth = std::atan2(static_cast<double>(cloud.y[i]), static_cast<double>(cloud.x[i]));
    const int column = static_cast<int>((0.5 - azimuth / (2 * M_PI)) * kSize);
    const auto near = static_cast<float>(std::clamp(1.2 - static_cast<double>(cloud.point(i).norm()) / 60, 0.25, 1.0));
    const int row_height = std::max(1, strip / lidar.grid().rings());
    for (int k = 0; k < row_height; ++k)
      image.blend(column, strip - 1 - static_cast<int>(cloud.ring[i]) * row_height - k,
                  {colour[0] * near, colour[1] * near, colour[2] * near});
    const double x = kSize / 2.0 - static_cast<double>(cloud.y[i]) / kReach * kSize / 2;
    const double y = kSize / 2.0 - static_cast<double>(cloud.x[i]) / kReach * kSize / 2;
    if (x < 0 || y < 0 || x >= kSize || y >= kSize) continue;
    image.blend(static_cast<int>(x), strip + 4 + static_cast<int>(y), colour, 0.8F);
  }
  return image.png();
}

}  // namespace scslam::sim
