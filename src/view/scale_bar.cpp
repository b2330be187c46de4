#include "scslam/view/scale_bar.h"

#include <fmt/format.h>

#include <cmath>

#include "scslam/view/svg_plot.h"

namespace scslam {

void drawScaleBar(Image& image, double pixel_m) {
  constexpr Rgb kColour = {255, 255, 255};
  const int width = image.width(), height = image.height();
  const double metres = niceNumber(width * pixel_m / 8);
  const std::string label = metres >= 1000 ? fmt::format("{:g} km", metres / 1000) : fmt::format("{:g} m", metres);
  const int length = static_cast<int>(std::lround(metres / pixel_m)), scale = std::max(width, height) >= 1000 ? 3 : 2;
  const int x = 6 * scale, y = height - 7 * scale;
  image.line(x, y, x + length, y, 1.2 * scale, kColour);
  for (const int end : {x, x + length}) image.line(end, y - 2 * scale, end, y, 1.2 * scale, kColour);
  image.text(x + (length - Image::textWidth(label, scale)) / 2, y - 11 * scale, label, scale, kColour);
}

}  // namespace scslam
