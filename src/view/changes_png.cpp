#include "scslam/view/changes_png.h"

#include <algorithm>
#include <cmath>

#include "scslam/core/image.h"
#include "scslam/view/scale_bar.h"
#include "scslam/view/svg_plot.h"

namespace scslam {
namespace {

constexpr Rgb kBackground = {13, 17, 23}, kUnseen = {60, 70, 110}, kStayed = {190, 190, 190},
              kAppeared = {60, 220, 100}, kDisappeared = {255, 60, 60};

/// Later ones are drawn over earlier ones.
constexpr std::array<std::pair<Change, Rgb>, 4> kLayers = {{{Change::kUnseen, kUnseen},
                                                            {Change::kStayed, kStayed},
                                                            {Change::kDisappeared, kDisappeared},
                                                            {Change::kAppeared, kAppeared}}};

}  // namespace

std::string changesPng(const ChangeMap& map, int max_pixels) {
  Bounds bounds;
  for (std::size_t i = 0; i < map.cloud_map.size(); ++i)
    if (map.change[i] != Change::kUnseen) bounds.add({map.cloud_map.point(i).head<2>().cast<double>()});
  bounds.pad(5, 0);
  const Eigen::Vector2d size = bounds.max - bounds.min;
  const double pixel_m = std::max(size.maxCoeff() / max_pixels, 0.05);
  const int width = std::max(200, static_cast<int>(size.x() / pixel_m)),
            height = std::max(100, static_cast<int>(size.y() / pixel_m));
  Image image(width, height, kBackground);
  for (const auto& [change, colour] : kLayers)
    for (std::size_t i = 0; i < map.cloud_map.size(); ++i) {
      if (map.change[i] != change) continue;
      const Eigen::Vector2d p = map.cloud_map.point(i).head<2>().cast<double>();
      const bool plain = change == Change::kStayed || change == Change::kUnseen;
      image.blend(static_cast<int>(std::floor((p.x() - bounds.min.x()) / pixel_m)),
                  static_cast<int>(std::floor((bounds.max.y() - p.y()) / pixel_m)), colour, plain ? 0.3F : 0.9F);
    }
  drawScaleBar(image, pixel_m);
  return image.png();
}

}  // namespace scslam
