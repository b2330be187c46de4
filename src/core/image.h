// An RGB raster with the few things a map picture needs.
#pragma once
#include <array>
#include <cstdint>
#include <string>
#include <vector>

namespace scslam {

using Rgb = std::array<float, 3>;  ///< 0 … 255

class Image {
 public:
  Image(int width, int height, const Rgb& background);
  int width() const { return width_; }
  int height() const { return height_; }
  /// Outside the picture: nothing happens. @param opacity 0 … 1.
  void blend(int x, int y, const Rgb& colour, float opacity = 1);
  /// A line with round ends and smooth edges.
  void line(double x0, double y0, double x1, double y1, double thickness, const Rgb& colour, float opacity = 1);
  /// Digits, '.', ' ', 'k' and 'm' in a font of 5 x 7, `scale` times as large; (x, y) is its top left corner.
  void text(int x, int y, const std::string& text, int scale, const Rgb& colour);
  static int textWidth(const std::string& text, int scale) { return 6 * scale * static_cast<int>(text.size()) - scale; }
  /// The bytes of a PNG file; the same picture gives the same bytes.
  std::string png() const;

 private:
  int width_, height_;
  std::vector<float> pixels_;
};

}  // namespace scslam
