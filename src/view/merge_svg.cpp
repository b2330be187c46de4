#include "scslam/view/merge_svg.h"

#include <fmt/format.h>

#include <array>

#include "scslam/view/svg_plot.h"

namespace scslam {
namespace {

/// Okabe and Ito's colours without the green of the loops.
constexpr std::array<const char*, 6> kColours = {"#0072b2", "#d55e00", "#cc79a7", "#e69f00", "#56b4e9", "#57606a"};

using Line = std::vector<Eigen::Vector2d>;

struct Part {
  const MergedParent* parent;
  Line line;
  const char* colour;
};

std::vector<Part> partsOf(const Session& merged, const MergeSummary& summary) {
  std::vector<Part> parts;
  for (const MergedParent& parent : summary.parents) {
    if (!parent.joined) continue;
    Part part{&parent, {}, kColours[parts.size() % kColours.size()]};
    for (std::size_t k = 0; k < parent.keyframes; ++k)
      part.line.push_back(merged.poses()[parent.first_keyframe + k].translation().head<2>());
    parts.push_back(std::move(part));
  }
  return parts;
}

std::string loopLines(const Session& merged, const std::vector<Part>& parts, const SvgPlot& plot) {
  const auto part_of = [&parts](KeyframeId k) {
    std::size_t part = 0;
    while (part + 1 < parts.size() && parts[part + 1].parent->first_keyframe <= k) ++part;
    return part;
  };
  std::string svg;
  for (const LoopRecord& loop : merged.loops()) {
    if (!loop.accepted) continue;
    const Line line = {merged.poses()[loop.match].translation().head<2>(),
                       merged.poses()[loop.query].translation().head<2>()};
    const bool between = part_of(loop.match) != part_of(loop.query);
    const char* style = between ? "stroke='#009e73' stroke-width='1.6'" : "stroke='#8c959f' stroke-width='0.8'";
    svg += plot.line(line, style);
    if (between) svg += plot.dot(line[1], 2, "fill='#009e73'");
  }
  return svg;
}

}  // namespace

std::string mergeSvg(const Session& merged, const MergeSummary& summary) {
  const std::vector<Part> parts = partsOf(merged, summary);
  Bounds bounds;
  for (const Part& part : parts) bounds.add(part.line);
  bounds.pad(2, 0.04);
  const double top = 64 + 20 * static_cast<double>(parts.size());
  const SvgPlot plot({64, top, 810, 640}, bounds, true);
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 900 {0:.0f}' width='900' height='{0:.0f}'>\n"
      "<style>text{{font:13px system-ui,'DejaVu Sans',sans-serif;fill:#1f2328}}.title{{font-size:15px;font-weight:600}}"
      ".label text{{font-size:11.5px;fill:#57606a}}</style>\n<rect width='900' height='{0:.0f}' fill='white'/>\n"
      "<text x='24' y='30' class='title'>{1} sessions in one frame: {2} keyframes, {3} loops</text>\n",
      top + 700, parts.size(), summary.keyframes, summary.loops);
  double y = 54;
  for (const Part& part : parts) {
    svg += fmt::format(
        "<path d='M24 {0:.0f}h24' stroke='{1}' stroke-width='2.4'/><text x='56' y='{2:.0f}'>{3}: {4} "
        "keyframes</text>\n",
        y, part.colour, y + 4, escapedXml(part.parent->name), part.parent->keyframes);
    y += 20;
  }
  svg += fmt::format(
      "<path d='M424 54h24' stroke='#009e73' stroke-width='2.4'/><text x='456' y='58'>loops between "
      "sessions</text>\n");
  svg += plot.grid("x [m]", "y [m]");
  for (const Part& part : parts) svg += plot.line(part.line, fmt::format("stroke='{}' stroke-width='2'", part.colour));
  return svg + loopLines(merged, parts, plot) + "</svg>\n";
}

}  // namespace scslam
