#include "scslam/view/trajectory_svg.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "scslam/apps/evaluate.h"
#include "scslam/core/error.h"
#include "scslam/view/svg_plot.h"

namespace scslam {
namespace {

constexpr const char* kGrey = "#8c959f";
constexpr const char* kBlue = "#0969da";
constexpr const char* kGreen = "#2da44e";
constexpr const char* kDarkGreen = "#116329";
constexpr const char* kRed = "#cf222e";

/// A trajectory in both views.
struct Track {
  std::vector<Eigen::Vector2d> above, side;  ///< (x, y) and (way driven, z) [m]
  void add(const Eigen::Vector3d& p) {
    if (!above.empty()) way_ += (p - last_).norm();
    last_ = p;
    above.push_back(p.head<2>());
    side.push_back({way_, p.z()});
  }

 private:
  double way_ = 0;
  Eigen::Vector3d last_ = Eigen::Vector3d::Zero();
};

struct Tracks {
  Track odometry, optimised, truth;
};

std::optional<Evaluation> evaluated(const Session& session, const std::optional<Trajectory>& truth) {
  if (!truth) return std::nullopt;
  try {
    return evaluate(session, *truth);
  } catch (const Error&) {
    return std::nullopt;
  }
}

Tracks tracksOf(const Session& session, const std::optional<Evaluation>& evaluation) {
  Tracks tracks;
  for (const StampedPose& pose : session.odometry()) tracks.odometry.add(pose.T.translation());
  for (const StampedPose& pose : session.trajectory()) tracks.optimised.add(pose.T.translation());
  if (!evaluation) return tracks;
  const Pose T_map_truth = evaluation->ate.T_truth_estimate.inverse();
  for (const auto& T_truth_base : evaluation->T_truth_base)
    if (T_truth_base) tracks.truth.add(T_map_truth * T_truth_base->translation());
  return tracks;
}

std::string drawTracks(const SvgPlot& plot, const Tracks& tracks, std::vector<Eigen::Vector2d> Track::*view) {
  return plot.line(tracks.odometry.*view, fmt::format("stroke='{}' stroke-width='1.8'", kGrey)) +
         plot.line(tracks.optimised.*view, fmt::format("stroke='{}' stroke-width='2.2'", kBlue)) +
         plot.line(tracks.truth.*view,
                   fmt::format("stroke='{}' stroke-width='1.4' stroke-dasharray='6 4'", kDarkGreen));
}

std::string drawLoops(const SvgPlot& plot, const Session& session) {
  std::string refused, accepted;
  for (const LoopRecord& loop : session.loops()) {
    const Eigen::Vector2d query = session.poses()[loop.query].translation().head<2>();
    const Eigen::Vector2d match = session.poses()[loop.match].translation().head<2>();
    if (!loop.accepted) {
      refused += plot.dot(query, 2.5, fmt::format("fill='{}' fill-opacity='0.25'", kRed));
    } else {
      accepted += plot.line({match, query}, fmt::format("stroke='{}' stroke-width='1.5'", kGreen));
      accepted += plot.dot(query, 2.2, fmt::format("fill='{}'", kGreen));
      accepted += plot.dot(match, 2.2, fmt::format("fill='{}'", kGreen));
    }
  }
  return refused + accepted;
}

std::string drawEnds(const SvgPlot& plot, const Track& track) {
  if (track.above.empty()) return {};
  const auto end = plot.toPage(track.above.back());
  return fmt::format("<rect x='{:.1f}' y='{:.1f}' width='9' height='9' fill='{}' stroke='white'/>\n", end.x() - 4.5,
                     end.y() - 4.5, kBlue) +
         plot.dot(track.above.front(), 5, fmt::format("fill='white' stroke='{}' stroke-width='2.5'", kBlue));
}

std::string scaleBar(const SvgPlot& plot, const PageRect& page) {
  const double metres = niceNumber(70 / plot.pixelsPerUnit());
  const double length = metres * plot.pixelsPerUnit();
  const double x = page.x + page.width - 16 - length, y = page.y + page.height - 16;
  return fmt::format(
      "<path d='M{:.1f} {:.1f}v6h{:.1f}v-6' fill='none' stroke='#1f2328' stroke-width='1.6'/>\n"
      "<text x='{:.1f}' y='{:.1f}' text-anchor='middle' class='label'>{:g} m</text>\n",
      x, y - 6, length, x + length / 2, y - 6, metres);
}

std::string legend(const Session& session, bool with_truth, double y) {
  const auto accepted = std::count_if(session.loops().begin(), session.loops().end(),
                                      [](const LoopRecord& loop) { return loop.accepted; });
  std::string svg;
  double x = 64;
  const auto entry = [&](const std::string& symbol, const std::string& text) {
    svg +=
        fmt::format("<g transform='translate({:.0f} {:.0f})'>{}<text x='30' y='4'>{}</text></g>\n", x, y, symbol, text);
    x += 48 + 6.9 * static_cast<double>(text.size());
  };
  const auto stroke = [](const char* colour, const char* extra) {
    return fmt::format("<path d='M0 0h24' stroke='{}' stroke-width='2.4' {}/>", colour, extra);
  };
  entry(stroke(kGrey, ""), "odometry");
  entry(stroke(kBlue, ""), "optimised");
  if (with_truth) entry(stroke(kDarkGreen, "stroke-dasharray='6 4'"), "ground truth");
  entry(stroke(kGreen, "") + fmt::format("<circle cx='0' r='3' fill='{0}'/><circle cx='24' r='3' fill='{0}'/>", kGreen),
        fmt::format("{} loops", accepted));
  entry(fmt::format("<circle cx='12' r='3.5' fill='{}' fill-opacity='0.4'/>", kRed),
        fmt::format("{} refused", session.loops().size() - static_cast<std::size_t>(accepted)));
  entry(fmt::format(
            "<circle cx='6' r='4.5' fill='white' stroke='{0}' stroke-width='2.5'/><rect x='16' y='-4.5' width='9' "
            "height='9' fill='{0}'/>",
            kBlue),
        "start, end");
  return svg;
}

std::string heading(const Session& session, const std::optional<Evaluation>& evaluation, const Track& track) {
  // Named after the input, not the folder: the same run gives the same page wherever it is put.
  const std::string& input = session.info().input;
  const auto path =
      std::filesystem::absolute(input.empty() ? session.folder() : std::filesystem::path(input)).lexically_normal();
  const std::string name = (path.has_filename() ? path : path.parent_path()).filename().string();
  std::string facts = fmt::format("{} scans, {} keyframes, {:.{}f} m", session.scans().size(),
                                  session.keyframes().size(), track.side.empty() ? 0.0 : track.side.back().x(),
                                  track.side.empty() || track.side.back().x() < 100 ? 1 : 0);
  if (evaluation)
    facts += fmt::format("; ATE {:.3f} m, odometry {:.3f} m", evaluation->ate.rmse_m, evaluation->odometry_ate.rmse_m);
  return fmt::format("<text x='64' y='30' class='title'>{}</text>\n<text x='64' y='50' fill='#57606a'>{}</text>\n",
                     escapedXml(name), escapedXml(facts));
}

}  // namespace

std::string trajectorySvg(const Session& session, const std::optional<Trajectory>& truth) {
  const std::optional<Evaluation> evaluation = evaluated(session, truth);
  const Tracks tracks = tracksOf(session, evaluation);
  const PageRect above_page{64, 90, 816, 400}, side_page{64, 545, 816, 110};
  Bounds above, side;
  for (const Track* track : {&tracks.odometry, &tracks.optimised, &tracks.truth}) {
    above.add(track->above);
    side.add(track->side);
  }
  above.pad(2.0, 0.04);
  side.pad(0.2, 0.0);
  const double height = side.max.y() - side.min.y();
  side.min.y() -= 0.1 * height;
  side.max.y() += 0.1 * height;
  const SvgPlot top(above_page, above, true), strip(side_page, side, false);
  return "<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 900 700' width='900' height='700'>\n"
         "<style>text{font:13px system-ui,'DejaVu Sans',sans-serif;fill:#1f2328}.title{font-size:18px;font-weight:600}"
         ".label text,text.label{font-size:11.5px;fill:#57606a}</style>\n"
         "<defs><clipPath id='above'><rect x='64' y='90' width='816' height='400'/></clipPath></defs>\n"
         "<rect width='900' height='700' fill='white'/>\n" +
         heading(session, evaluation, tracks.optimised) + legend(session, !tracks.truth.above.empty(), 72) +
         top.grid("x [m]", "y [m]") + "<g clip-path='url(#above)'>\n" + drawTracks(top, tracks, &Track::above) +
         drawLoops(top, session) + drawEnds(top, tracks.optimised) + "</g>\n" + scaleBar(top, above_page) +
         strip.grid("way driven [m]", "z [m]") + drawTracks(strip, tracks, &Track::side) + "</svg>\n";
}

}  // namespace scslam
