#include "scslam/view/curve_svg.h"

#include <algorithm>
#include <array>

#include "scslam/view/svg_plot.h"

namespace scslam {
namespace {

/// Okabe and Ito's colours, told apart by colour-blind eyes; the order keeps neighbours far apart.
constexpr std::array<const char*, 7> kColours = {"#0072b2", "#d55e00", "#009e73", "#cc79a7",
                                                 "#e69f00", "#56b4e9", "#000000"};
const char* colour(std::size_t variant) { return kColours[variant % kColours.size()]; }

constexpr PageRect kCurves{64, 80, 400, 330}, kHeadings{530, 80, 350, 140}, kOffsets{530, 286, 350, 124};
constexpr double kLegendTop = 482, kLegendLine = 22;

Bounds unitBounds(double right) {
  Bounds bounds;
  bounds.min = {0, 0};
  bounds.max = {right, 1.0};
  return bounds;
}

std::string curveOf(const SvgPlot& plot, const PrecisionRecall& f, const char* stroke) {
  if (f.curve.empty()) return {};
  std::vector<Eigen::Vector2d> points = {{0, f.curve.front().precision}};
  std::string marks;
  for (const CurvePoint& p : f.curve) {
    points.push_back({p.recall, p.precision});
    if (f.f1_threshold && p.threshold == *f.f1_threshold)
      marks += plot.dot(points.back(), 4.5, fmt::format("fill='{}' stroke='white'", stroke));
  }
  if (f.recall_full && *f.recall_full > 0) {
    const Eigen::Vector2d at = plot.toPage({*f.recall_full, 1});
    marks += fmt::format("<path d='M{:.1f} {:.1f}v14' stroke='{}' stroke-width='3'/>\n", at.x(), at.y() - 7, stroke);
  }
  return plot.line(points, fmt::format("stroke='{}' stroke-width='2'", stroke)) + marks;
}

struct BarGroup {
  std::string name;
  std::vector<const SplitCell*> cells;  ///< one per variant
};

/// Groups of bars, a colour each: pale = recall@1, full = recall at 100 % precision.
std::string bars(const PageRect& page, const std::vector<BarGroup>& groups, const std::string& title) {
  std::string svg = fmt::format("<text x='{:.0f}' y='{:.0f}'>{}</text>\n", page.x, page.y - 8, title);
  for (const double level : {0.0, 0.5, 1.0}) {
    const double y = page.y + page.height * (1 - level);
    svg += fmt::format(
        "<path d='M{:.0f} {:.1f}h{:.0f}' stroke='#d0d7de'/><text class='label' x='{:.0f}' y='{:.1f}' "
        "text-anchor='end'>{:g}</text>\n",
        page.x, y, page.width, page.x - 6, y + 4, level);
  }
  const double slot = page.width / static_cast<double>(groups.size());
  for (std::size_t g = 0; g < groups.size(); ++g) {
    const double left = page.x + slot * static_cast<double>(g), n = static_cast<double>(groups[g].cells.size());
    const double width = std::min(26.0, 0.8 * slot / n);
    for (std::size_t v = 0; v < groups[g].cells.size(); ++v) {
      const SplitCell& cell = *groups[g].cells[v];
      const double x = left + slot / 2 + (static_cast<double>(v) - n / 2) * width;
      const auto bar = [&](double height, double opacity) {
        svg += fmt::format("<rect x='{:.1f}' y='{:.1f}' width='{:.1f}' height='{:.1f}' fill='{}' opacity='{}'/>\n", x,
                           page.y + page.height * (1 - height), 0.9 * width, page.height * height, colour(v), opacity);
      };
      if (cell.recall_at_1) bar(*cell.recall_at_1, 0.3);
      if (cell.recall_full) bar(*cell.recall_full, 1);
    }
    const std::size_t revisits = groups[g].cells.empty() ? 0 : groups[g].cells.front()->revisits;
    svg += fmt::format(
        "<text x='{0:.1f}' y='{1:.1f}' text-anchor='middle'>{2}</text><text class='label' x='{0:.1f}' y='{3:.1f}' "
        "text-anchor='middle'>{4}</text>\n",
        left + slot / 2, page.y + page.height + 15, groups[g].name, page.y + page.height + 29,
        revisits == 0 ? "no revisit" : fmt::format("{} revisits", revisits));
  }
  return svg;
}

/// One group per cell of the split that `take` wants.
template <class Take>
std::vector<BarGroup> groupsOf(const PlaceReport& report, const Take& take) {
  std::vector<BarGroup> groups;
  if (report.variants.empty()) return groups;
  for (std::size_t c = 0; c < report.variants.front().split.size(); ++c) {
    const std::string name = take(report.variants.front().split[c]);
    if (name.empty()) continue;
    groups.push_back({name, {}});
    for (const PlaceFigures& v : report.variants) groups.back().cells.push_back(&v.split[c]);
  }
  return groups;
}

std::string barPanels(const PlaceReport& report) {
  if (report.variants.empty()) return {};
  const double end = report.variants.front().split.back().to_m;
  const auto headings = groupsOf(report, [end](const SplitCell& c) {
    const bool all_offsets = c.from_m == 0 && c.to_m == end;
    return all_offsets && c.heading_deg >= 0 ? fmt::format("{}°", c.heading_deg) : std::string();
  });
  const auto offsets = groupsOf(report, [end](const SplitCell& c) {
    const bool all_offsets = c.from_m == 0 && c.to_m == end;
    return c.heading_deg < 0 && !all_offsets ? fmt::format("{:g}–{:.3g} m", c.from_m, c.to_m) : std::string();
  });
  return bars(kHeadings, headings, fmt::format("recall by heading difference (within {:.3g} m)", end)) +
         bars(kOffsets, offsets, "recall by lateral offset (pale: @1, full: precision 1)");
}

std::string legend(const PlaceReport& report) {
  const auto figure = [](const std::optional<double>& v) { return v ? fmt::format("{:.3f}", *v) : std::string("-"); };
  const std::array<const char*, 5> heads = {"AUC", "F1max", "recall@1", "recall@5", "at precision 1"};
  constexpr std::array<double, 5> columns = {480, 560, 650, 740, 865};
  std::string svg;
  for (std::size_t c = 0; c < heads.size(); ++c)
    svg += fmt::format("<text class='label' x='{:.0f}' y='{:.0f}' text-anchor='end'>{}</text>\n", columns[c],
                       kLegendTop - kLegendLine, heads[c]);
  for (std::size_t v = 0; v < report.variants.size(); ++v) {
    const PrecisionRecall& f = report.variants[v].figures;
    const double y = kLegendTop + kLegendLine * static_cast<double>(v);
    svg += fmt::format("<path d='M64 {:.0f}h24' stroke='{}' stroke-width='3'/><text x='96' y='{:.0f}'>{}</text>\n",
                       y - 4, colour(v), y, escapedXml(report.variants[v].variant.label));
    const std::array<std::optional<double>, 5> values = {f.auc, f.f1_max, f.recall_at_1, f.recall_at_5, f.recall_full};
    for (std::size_t c = 0; c < values.size(); ++c)
      svg += fmt::format("<text x='{:.0f}' y='{:.0f}' text-anchor='end'>{}</text>\n", columns[c], y, figure(values[c]));
  }
  return svg;
}

}  // namespace

std::string placesSvg(const PlaceReport& report) {
  const double height = kLegendTop + kLegendLine * static_cast<double>(report.variants.size()) + 10;
  const SvgPlot plot(kCurves, unitBounds(1.0), false);
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 900 {0:.0f}' width='900' height='{0:.0f}'>\n"
      "<style>text{{font:13px system-ui,'DejaVu Sans',sans-serif;fill:#1f2328}}.title{{font-size:18px;font-weight:600}}"
      "text.label{{font-size:11.5px;fill:#57606a}}.label text{{font-size:11.5px;fill:#57606a}}</style>\n"
      "<rect width='900' height='{0:.0f}' fill='white'/>\n"
      "<text x='64' y='30' class='title'>{1}</text>\n<text x='64' y='50' fill='#57606a'>{2} keyframes from {3}; same "
      "place: within {4:g} m, {5:g} m of way between</text>\n",
      height, escapedXml(report.input), report.keyframes, escapedXml(report.keyframes_from),
      report.options.revisit_radius_m, report.options.min_travel_m);
  svg += plot.grid("recall", "precision");
  for (std::size_t v = 0; v < report.variants.size(); ++v) svg += curveOf(plot, report.variants[v].figures, colour(v));
  return svg + barPanels(report) + legend(report) + "</svg>\n";
}

}  // namespace scslam
