#include "scslam/view/trajectories_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "scslam/view/svg_plot.h"

namespace scslam {
namespace {

/// Okabe and Ito's colours, told apart by colour-blind eyes.
constexpr std::array<const char*, 6> kColours = {"#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9"};
constexpr double kTop = 96, kPanelWidth = 380, kPanelHeight = 300, kPitchX = 440, kPitchY = 380;

using Line = std::vector<Eigen::Vector2d>;

Line laid(const std::vector<StampedPose>& poses, const Pose& T_truth_estimate) {
  Line line;
  for (const StampedPose& pose : poses) line.push_back((T_truth_estimate * pose.T.translation()).head<2>());
  return line;
}

Line truthOf(const Evaluation& evaluation) {
  Line line;
  for (const auto& T : evaluation.T_truth_base)
    if (T) line.push_back(T->translation().head<2>());
  return line;
}

struct Drawn {
  Line points;
  std::string style;
};

/// What the panel of `input` shows, in drawing order.
std::vector<Drawn> linesOf(const std::vector<ComparedRun>& runs, const std::string& input,
                           const std::vector<std::string>& frontends) {
  std::vector<Drawn> lines;
  const ComparedRun* with_truth = nullptr;
  for (const ComparedRun& run : runs) {
    if (run.input != input || !run.session) continue;
    const auto at =
        static_cast<std::size_t>(std::find(frontends.begin(), frontends.end(), run.frontend) - frontends.begin());
    const char* colour = kColours[at % kColours.size()];
    const Pose before = run.evaluation ? run.evaluation->odometry_ate.T_truth_estimate : Pose::Identity();
    lines.push_back({laid(run.session->odometry(), before),
                     fmt::format("stroke='{}' stroke-width='1.2' stroke-opacity='0.5'", colour)});
    if (run.with_loops) {
      const Pose after = run.evaluation ? run.evaluation->ate.T_truth_estimate : Pose::Identity();
      lines.push_back({laid(run.session->trajectory(), after), fmt::format("stroke='{}' stroke-width='2'", colour)});
    }
    if (run.evaluation) with_truth = &run;
  }
  if (with_truth != nullptr)
    lines.push_back({truthOf(*with_truth->evaluation), "stroke='black' stroke-width='1.1' stroke-dasharray='5 4'"});
  return lines;
}

std::string panel(const std::vector<ComparedRun>& runs, const std::string& input,
                  const std::vector<std::string>& frontends, const PageRect& page) {
  const std::vector<Drawn> lines = linesOf(runs, input, frontends);
  std::string svg =
      fmt::format("<text x='{:.0f}' y='{:.0f}' class='title'>{}</text>\n", page.x, page.y - 10, escapedXml(input));
  if (lines.empty())
    return svg + fmt::format("<text x='{:.0f}' y='{:.0f}'>no run got anywhere</text>\n", page.x, page.y + 20);
  Bounds bounds;
  for (const Drawn& line : lines) bounds.add(line.points);
  bounds.pad(2, 0.04);
  const SvgPlot plot(page, bounds, true);
  svg += plot.grid("x [m]", "y [m]");
  for (const Drawn& line : lines) svg += plot.line(line.points, line.style);
  return svg;
}

std::string legend(const std::vector<std::string>& frontends) {
  std::string svg;
  double x = 64;
  const auto entry = [&](const std::string& style, const std::string& text) {
    svg += fmt::format("<path d='M{0:.0f} 46h24' {1}/><text x='{2:.0f}' y='50'>{3}</text>\n", x, style, x + 30,
                       escapedXml(text));
    x += 56 + 7.2 * static_cast<double>(text.size());
  };
  for (std::size_t f = 0; f < frontends.size(); ++f)
    entry(fmt::format("stroke='{}' stroke-width='2.4'", kColours[f % kColours.size()]), frontends[f]);
  entry("stroke='#57606a' stroke-width='1.2' stroke-opacity='0.6'", "odometry alone: pale");
  entry("stroke='black' stroke-dasharray='5 4'", "truth");
  return svg;
}

void addOnce(std::vector<std::string>& names, const std::string& name) {
  if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

}  // namespace

std::string trajectoriesSvg(const std::vector<ComparedRun>& runs) {
  std::vector<std::string> inputs, frontends;
  for (const ComparedRun& run : runs) addOnce(inputs, run.input), addOnce(frontends, run.frontend);
  const std::size_t rows = (inputs.size() + 1) / 2;
  const double height = kTop + kPitchY * static_cast<double>(rows);
  std::string svg = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 900 {0:.0f}' width='900' height='{0:.0f}'>\n"
      "<style>text{{font:13px system-ui,'DejaVu Sans',sans-serif;fill:#1f2328}}.title{{font-size:15px;font-weight:600}}"
      ".label text{{font-size:11.5px;fill:#57606a}}</style>\n<rect width='900' height='{0:.0f}' fill='white'/>\n",
      height);
  svg += legend(frontends);
  for (std::size_t i = 0; i < inputs.size(); ++i) {
    const std::size_t row = i / 2, column = i % 2;
    const PageRect page{64 + kPitchX * static_cast<double>(column), kTop + kPitchY * static_cast<double>(row),
                        kPanelWidth, kPanelHeight};
    svg += panel(runs, inputs[i], frontends, page);
  }
  return svg + "</svg>\n";
}

}  // namespace scslam
