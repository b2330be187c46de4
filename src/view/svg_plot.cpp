#include "scslam/view/svg_plot.h"

#include <fmt/format.h>

#include <cmath>

namespace scslam {
namespace {

constexpr double kTickPixels = 85;  // wished distance of grid lines; less where the plot is low

/// Nice multiples inside [low, high].
std::vector<double> ticks(double low, double high, double size_px) {
  const double step = niceNumber(std::min(kTickPixels, size_px / 5) * (high - low) / size_px);
  std::vector<double> values;
  for (double i = std::ceil(low / step); i * step <= high; ++i) values.push_back(i * step + 0.0);
  return values;
}

}  // namespace

double niceNumber(double value) {
  if (!(value > 0) || !std::isfinite(value)) return 1;
  const double power = std::pow(10, std::floor(std::log10(value)));
  for (const double factor : {1.0, 2.0, 5.0})
    if (factor * power >= value * (1 - 1e-9)) return factor * power;
  return 10 * power;
}

std::string escapedXml(const std::string& text) {
  std::string result;
  for (const char c : text) {
    if (c == '&')
      result += "&amp;";
    else if (c == '<')
      result += "&lt;";
    else if (c == '>')
      result += "&gt;";
    else if (static_cast<unsigned char>(c) >= 0x20)
      result += c;
  }
  return result;
}

void Bounds::add(const std::vector<Eigen::Vector2d>& points) {
  for (const auto& p : points) {
    min = min.cwiseMin(p);
    max = max.cwiseMax(p);
  }
}

void Bounds::pad(double smallest, double margin) {
  if (min.x() > max.x()) min = max = Eigen::Vector2d::Zero();
  const Eigen::Vector2d middle = (min + max) / 2;
  const Eigen::Vector2d half = ((max - min) / 2).cwiseMax(smallest / 2) * (1 + 2 * margin);
  min = middle - half;
  max = middle + half;
}

SvgPlot::SvgPlot(PageRect page, const Bounds& bounds, bool equal) : page_(page), min_(bounds.min), max_(bounds.max) {
  scale_ = {page.width / (max_.x() - min_.x()), page.height / (max_.y() - min_.y())};
  if (!equal) return;
  scale_.setConstant(scale_.minCoeff());
  const Eigen::Vector2d middle = (min_ + max_) / 2;
  const Eigen::Vector2d half = Eigen::Vector2d(page.width, page.height).cwiseQuotient(scale_) / 2;
  min_ = middle - half;
  max_ = middle + half;
}

Eigen::Vector2d SvgPlot::toPage(const Eigen::Vector2d& p) const {
  return {page_.x + (p.x() - min_.x()) * scale_.x(), page_.y + (max_.y() - p.y()) * scale_.y()};
}

std::string SvgPlot::grid(const std::string& x_label, const std::string& y_label) const {
  std::string svg = fmt::format(
      "<rect x='{}' y='{}' width='{}' height='{}' fill='#fbfcfd' stroke='#d0d7de'/>\n<g stroke='#e6eaef' "
      "stroke-width='1' class='tick'>\n",
      page_.x, page_.y, page_.width, page_.height);
  std::string labels = "<g class='label'>\n";
  const double bottom = page_.y + page_.height, right = page_.x + page_.width;
  for (const double x : ticks(min_.x(), max_.x(), page_.width)) {
    const double px = toPage({x, 0}).x();
    svg += fmt::format("<path d='M{:.1f} {:.1f}V{:.1f}'/>\n", px, page_.y, bottom);
    labels += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='middle'>{:g}</text>\n", px, bottom + 15, x);
  }
  for (const double y : ticks(min_.y(), max_.y(), page_.height)) {
    const double py = toPage({0, y}).y();
    svg += fmt::format("<path d='M{:.1f} {:.1f}H{:.1f}'/>\n", page_.x, py, right);
    labels += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='end'>{:g}</text>\n", page_.x - 6, py + 4, y);
  }
  labels += fmt::format("<text x='{:.1f}' y='{:.1f}' text-anchor='middle'>{}</text>\n", page_.x + page_.width / 2,
                        bottom + 31, escapedXml(x_label));
  labels += fmt::format("<text transform='translate({:.1f} {:.1f}) rotate(-90)' text-anchor='middle'>{}</text>\n",
                        page_.x - 46, page_.y + page_.height / 2, escapedXml(y_label));
  return svg + "</g>\n" + labels + "</g>\n";
}

std::string SvgPlot::line(const std::vector<Eigen::Vector2d>& points, const std::string& style) const {
  if (points.size() < 2) return {};
  std::string path;
  Eigen::Vector2d last = Eigen::Vector2d::Constant(1e300);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const Eigen::Vector2d p = toPage(points[i]);
    if (i + 1 < points.size() && (p - last).squaredNorm() < 0.1) continue;
    path += fmt::format("{}{:.1f} {:.1f}", i == 0 ? "M" : "L", p.x(), p.y());
    last = p;
  }
  return fmt::format("<path d='{}' fill='none' stroke-linejoin='round' {}/>\n", path, style);
}

std::string SvgPlot::dot(const Eigen::Vector2d& p, double radius_px, const std::string& style) const {
  const Eigen::Vector2d at = toPage(p);
  return fmt::format("<circle cx='{:.1f}' cy='{:.1f}' r='{:g}' {}/>\n", at.x(), at.y(), radius_px, style);
}

}  // namespace scslam
