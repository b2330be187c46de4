// A rectangle of an SVG page with world coordinates.
#pragma once
#include <string>
#include <vector>

#include <Eigen/Core>

namespace scslam {

/// The smallest of 1, 2, 5 times a power of ten that is at least `value`; 1 for what is not positive.
double niceNumber(double value);

struct PageRect {
  double x = 0, y = 0, width = 0, height = 0;  ///< [px], y down
};

/// Bounds of what is drawn, grown to something drawable when it is a point or a line.
class Bounds {
 public:
  void add(const std::vector<Eigen::Vector2d>& points);
  /// Never smaller than `smallest` in either direction, and `margin` (share of the size) wider on each side.
  void pad(double smallest, double margin);
  Eigen::Vector2d min = Eigen::Vector2d::Constant(1e300), max = Eigen::Vector2d::Constant(-1e300);
};

class SvgPlot {
 public:
  /// @param equal one metre is as long in x as in y: the bounds are widened to the rectangle's shape.
  SvgPlot(PageRect page, const Bounds& bounds, bool equal);
  Eigen::Vector2d toPage(const Eigen::Vector2d& p) const;
  double pixelsPerUnit() const { return scale_.x(); }  ///< along x
  /// Frame, grid lines at nice numbers and their labels.
  std::string grid(const std::string& x_label, const std::string& y_label) const;
  /// A polyline without points that move less than a third of a pixel. @param style SVG attributes.
  std::string line(const std::vector<Eigen::Vector2d>& points, const std::string& style) const;
  std::string dot(const Eigen::Vector2d& p, double radius_px, const std::string& style) const;

 private:
  PageRect page_;
  Eigen::Vector2d min_, max_, scale_;
};

/// Text as XML.
std::string escapedXml(const std::string& text);

}  // namespace scslam
