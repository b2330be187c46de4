#include "scslam/core/image.h"

#include <png.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "scslam/core/error.h"

namespace scslam {
namespace {

/// Rows from top to bottom, bit 4 = leftmost of five pixels.
const std::map<char, std::array<std::uint8_t, 7>> kFont = {
    {'0', {14, 17, 19, 21, 25, 17, 14}}, {'1', {4, 12, 4, 4, 4, 4, 14}},    {'2', {14, 17, 1, 2, 4, 8, 31}},
    {'3', {31, 2, 4, 2, 1, 17, 14}},     {'4', {2, 6, 10, 18, 31, 2, 2}},   {'5', {31, 16, 30, 1, 1, 17, 14}},
    {'6', {6, 8, 16, 30, 17, 17, 14}},   {'7', {31, 1, 2, 4, 8, 8, 8}},     {'8', {14, 17, 17, 14, 17, 17, 14}},
    {'9', {14, 17, 17, 15, 1, 2, 12}},   {'.', {0, 0, 0, 0, 0, 12, 12}},    {' ', {0, 0, 0, 0, 0, 0, 0}},
    {'k', {16, 16, 18, 20, 24, 20, 18}}, {'m', {0, 0, 26, 21, 21, 21, 21}},
};

void appendBytes(png_structp png, png_bytep bytes, png_size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), count);
}

[[noreturn]] void fail(png_structp, png_const_charp message) {
  throw Error(ExitCode::kBug, fmt::format("PNG: {}", message));
}

}  // namespace

Image::Image(int width, int height, const Rgb& background)
    : width_(width), height_(height), pixels_(3 * static_cast<std::size_t>(width) * static_cast<std::size_t>(height)) {
  for (std::size_t i = 0; i < pixels_.size(); ++i) pixels_[i] = background[i % 3];
}

void Image::blend(int x, int y, const Rgb& colour, float opacity) {
  if (x < 0 || y < 0 || x >= width_ || y >= height_) return;
  float* pixel =
      &pixels_[3 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(width_) + static_cast<std::size_t>(x))];
  for (std::size_t c = 0; c < 3; ++c) pixel[c] += opacity * (colour[c] - pixel[c]);
}

void Image::line(double x0, double y0, double x1, double y1, double thickness, const Rgb& colour, float opacity) {
  const double radius = thickness / 2, dx = x1 - x0, dy = y1 - y0, squared = dx * dx + dy * dy;
  const auto lowest = [&](double a, double b) { return static_cast<int>(std::floor(std::min(a, b) - radius - 1)); };
  const auto highest = [&](double a, double b) { return static_cast<int>(std::ceil(std::max(a, b) + radius + 1)); };
  for (int y = std::max(0, lowest(y0, y1)); y <= std::min(height_ - 1, highest(y0, y1)); ++y)
    for (int x = std::max(0, lowest(x0, x1)); x <= std::min(width_ - 1, highest(x0, x1)); ++x) {
      const double u = squared > 0 ? std::clamp(((x - x0) * dx + (y - y0) * dy) / squared, 0.0, 1.0) : 0.0;
      const double distance = std::hypot(x - x0 - u * dx, y - y0 - u * dy);
      const double cover = std::clamp(radius + 0.5 - distance, 0.0, 1.0);
      if (cover > 0) blend(x, y, colour, opacity * static_cast<float>(cover));
    }
}

void Image::text(int x, int y, const std::string& text, int scale, const Rgb& colour) {
  for (const char c : text) {
    const auto glyph = kFont.find(c);
    if (glyph != kFont.end())
      for (int row = 0; row < 7 * scale; ++row)
        for (int column = 0; column < 5 * scale; ++column)
          if ((glyph->second[static_cast<std::size_t>(row / scale)] >> (4 - column / scale) & 1) != 0)
            blend(x + column, y + row, colour);
    x += 6 * scale;
  }
}

std::string Image::png() const {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, fail, nullptr);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, &bytes, appendBytes, nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(width_), static_cast<png_uint_32>(height_), 8, PNG_COLOR_TYPE_RGB,
               PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_write_info(png, info);
  std::vector<std::uint8_t> row(3 * static_cast<std::size_t>(width_));
  for (std::size_t y = 0; y < static_cast<std::size_t>(height_); ++y) {
    for (std::size_t i = 0; i < row.size(); ++i)
      row[i] = static_cast<std::uint8_t>(std::lround(std::clamp(pixels_[y * row.size() + i], 0.0f, 255.0f)));
    png_write_row(png, row.data());
  }
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

}  // namespace scslam
