#include "scslam/view/top_view_png.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scslam/core/image.h"
#include "scslam/view/scale_bar.h"
#include "scslam/view/svg_plot.h"

namespace scslam {
namespace {

constexpr Rgb kBackground = {13, 17, 23}, kTrack = {255, 255, 255}, kCasing = {13, 17, 23}, kStart = {87, 242, 135},
              kMarked = {255, 40, 60};
constexpr double kLongest = 3;  // longer side : shorter side, at most
/// Low to high, even steps.
constexpr std::array<Rgb, 6> kPalette = {
    {{58, 90, 200}, {38, 150, 190}, {60, 190, 130}, {190, 210, 70}, {250, 165, 60}, {255, 110, 90}}};

Rgb paletteAt(double u) {
  const double at = std::clamp(u, 0.0, 1.0) * (kPalette.size() - 1);
  const auto i = std::min(static_cast<std::size_t>(at), kPalette.size() - 2);
  const auto f = static_cast<float>(at - static_cast<double>(i));
  Rgb colour;
  for (std::size_t c = 0; c < 3; ++c) colour[c] = kPalette[i][c] + f * (kPalette[i + 1][c] - kPalette[i][c]);
  return colour;
}

double quantile(std::vector<float>& values, double share) {
  if (values.empty()) return 0;
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

/// Points of keyframe k in the map frame. @return false where there is no scan.
bool load(const Session& session, KeyframeId k, Cloud& cloud_map, Eigen::Vector3d& origin) {
  if (!session.hasCloud(k)) return false;
  const Pose T_map_sensor = session.poses()[k] * session.info().T_base_sensor;
  origin = T_map_sensor.translation();
  cloud_map = transformed(session.cloud(k), T_map_sensor);
  dropNonFinite(cloud_map);
  return true;
}

/// What the picture must show, from a sample of the keyframes.
struct Extent {
  Eigen::Vector2d min = Eigen::Vector2d::Zero(), max = Eigen::Vector2d::Zero();
  double low = 0, high = 0;  ///< heights over the sensor [m]
  double points = 0;         ///< estimate of all
};

Extent survey(const Session& session) {
  constexpr std::size_t kSamples = 40;
  std::vector<float> reach, heights;
  const std::size_t n = session.keyframes().size();
  std::size_t sampled = 0;
  Bounds bounds;
  for (std::size_t k = 0; k < n; ++k)
    if (session.hasCloud(static_cast<KeyframeId>(k))) bounds.add({session.poses()[k].translation().head<2>()});
  for (std::size_t k = 0; k < n; k += std::max<std::size_t>(1, n / kSamples)) {
    Cloud cloud;
    Eigen::Vector3d origin;
    if (!load(session, static_cast<KeyframeId>(k), cloud, origin)) continue;
    ++sampled;
    for (std::size_t i = 0; i < cloud.size(); i += 7) {
      const Eigen::Vector3d d = cloud.point(i).cast<double>() - origin;
      reach.push_back(static_cast<float>(d.head<2>().norm()));
      heights.push_back(static_cast<float>(d.z()));
    }
  }
  Extent extent;
  extent.points = sampled > 0 ? 7.0 * static_cast<double>(reach.size() * n) / static_cast<double>(sampled) : 0;
  const double margin = 1.1 * std::clamp(quantile(reach, 0.97), 2.0, 80.0);
  bounds.pad(0, 0);
  bounds.min.array() -= margin;
  bounds.max.array() += margin;
  bounds.pad((bounds.max - bounds.min).maxCoeff() / kLongest, 0);
  extent.min = bounds.min;
  extent.max = bounds.max;
  extent.low = quantile(heights, 0.03);
  extent.high = quantile(heights, 0.97);
  return extent;
}

class TopView {
 public:
  TopView(const Session& session, const TopViewOptions& options) : session_(session), extent_(survey(session)) {
    const Eigen::Vector2d size = extent_.max - extent_.min;
    // About as many pixels as there are points, so that a single scan is no dust on a huge canvas.
    const double wished = std::sqrt(extent_.points * size.maxCoeff() / size.minCoeff());
    const double side = std::max(wished, 500.0);
    pixel_m_ = size.maxCoeff() / std::min(side, static_cast<double>(options.max_pixels));
    width_ = std::max(1, static_cast<int>(std::floor(size.x() / pixel_m_)));
    height_ = std::max(1, static_cast<int>(std::floor(size.y() / pixel_m_)));
    count_.resize(static_cast<std::size_t>(width_) * static_cast<std::size_t>(height_));
    height_sum_.resize(count_.size());
  }

  void addKeyframe(KeyframeId k) {
    forEachPoint(session_, k, [this](std::size_t pixel, double height) {
      count_[pixel] += 1;
      height_sum_[pixel] += static_cast<float>(height);
    });
  }
  void mark(const Session& session, KeyframeId k) {
    marked_.resize(count_.size());
    forEachPoint(session, k, [this](std::size_t pixel, double) { marked_[pixel] = true; });
  }

  std::string png() {
    Image image(width_, height_, kBackground);
    drawPoints(image);
    drawMarked(image);
    drawTrack(image);
    drawScaleBar(image, pixel_m_);
    return image.png();
  }

 private:
  Eigen::Vector2d toPixel(const Eigen::Vector2d& p_map) const {
    return {(p_map.x() - extent_.min.x()) / pixel_m_, (extent_.max.y() - p_map.y()) / pixel_m_};
  }

  template <class Visit>
  void forEachPoint(const Session& session, KeyframeId k, const Visit& visit) const {
    Cloud cloud;
    Eigen::Vector3d origin;
    if (!load(session, k, cloud, origin)) return;
    for (std::size_t i = 0; i < cloud.size(); ++i) {
      const Eigen::Vector2d p = toPixel({cloud.x[i], cloud.y[i]});
      if (p.x() < 0 || p.y() < 0 || p.x() >= width_ || p.y() >= height_) continue;
      visit(static_cast<std::size_t>(p.y()) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(p.x()),
            cloud.z[i] - origin.z());
    }
  }

  void drawMarked(Image& image) const {
    for (std::size_t at = 0; at < marked_.size(); ++at)
      if (marked_[at])
        image.blend(static_cast<int>(at % static_cast<std::size_t>(width_)),
                    static_cast<int>(at / static_cast<std::size_t>(width_)), kMarked, 0.9F);
  }

  void drawPoints(Image& image) const {
    std::vector<float> filled;
    for (const float count : count_)
      if (count > 0) filled.push_back(count);
    const double brightest = std::log1p(std::max(3.0, quantile(filled, 0.98)));
    for (int y = 0; y < height_; ++y)
      for (int x = 0; x < width_; ++x) {
        const std::size_t at =
            static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x);
        if (count_[at] == 0) continue;
        const double height = height_sum_[at] / count_[at];
        const double range = extent_.high - extent_.low;
        const double density = std::min(1.0, std::log1p(count_[at]) / brightest);
        image.blend(x, y, paletteAt(range > 0.05 ? (height - extent_.low) / range : 0.4),
                    static_cast<float>(0.25 + 0.75 * density));
      }
  }

  void drawTrack(Image& image) const {
    const double thickness = std::clamp(std::max(width_, height_) / 400.0, 1.5, 3.5);
    std::vector<Eigen::Vector2d> track;
    for (const StampedPose& pose : session_.trajectory()) {
      const Eigen::Vector2d p = toPixel(pose.T.translation().head<2>());
      if (track.empty() || (p - track.back()).norm() > 0.5) track.push_back(p);
    }
    if (track.empty()) return;
    for (const auto& [width, colour] : {std::pair(thickness + 2.5, kCasing), std::pair(thickness, kTrack)})
      for (std::size_t i = 1; i < track.size(); ++i)
        image.line(track[i - 1].x(), track[i - 1].y(), track[i].x(), track[i].y(), width, colour);
    for (const auto& [width, colour] : {std::pair(4 * thickness + 3, kCasing), std::pair(4 * thickness, kStart)})
      image.line(track[0].x(), track[0].y(), track[0].x(), track[0].y(), width, colour);
  }

  const Session& session_;
  Extent extent_;
  double pixel_m_ = 1;
  int width_ = 1, height_ = 1;
  std::vector<float> count_, height_sum_;
  std::vector<bool> marked_;  ///< by pixel; empty: none
};

}  // namespace

std::string topViewPng(const Session& session, const TopViewOptions& options,
                       const std::function<void(std::size_t)>& progress) {
  TopView view(session, options);
  for (std::size_t k = 0; k < session.keyframes().size(); ++k) {
    view.addKeyframe(static_cast<KeyframeId>(k));
    if (options.marked != nullptr) view.mark(*options.marked, static_cast<KeyframeId>(k));
    if (progress) progress(k + 1);
  }
  return view.png();
}

}  // namespace scslam
