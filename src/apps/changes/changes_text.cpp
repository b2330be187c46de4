#include <fmt/format.h>

#include <nlohmann/json.hpp>

#include "scslam/apps/changes/changes.h"

namespace scslam {
namespace {

std::size_t thingsThat(const ChangesSummary& summary, Change change) {
  std::size_t count = 0;
  for (const ChangedThing& thing : summary.things) count += thing.change == change;
  return count;
}

}  // namespace

std::string changesJson(const ChangesSummary& summary) {
  const nlohmann::ordered_json json = {{"older", summary.older},
                                       {"newer", summary.newer},
                                       {"older_keyframes", summary.older_keyframes},
                                       {"newer_keyframes", summary.newer_keyframes},
                                       {"voxels_stayed", summary.stayed},
                                       {"voxels_appeared", summary.appeared},
                                       {"voxels_disappeared", summary.disappeared},
                                       {"voxels_seen_by_one", summary.unseen},
                                       {"things_appeared", thingsThat(summary, Change::kAppeared)},
                                       {"things_disappeared", thingsThat(summary, Change::kDisappeared)},
                                       {"moving_points_left_out", summary.moving_points},
                                       {"wall_s", summary.wall_s},
                                       {"peak_rss_mb", summary.peak_rss_mb}};
  return json.dump(2) + "\n";
}

std::string changesTable(const ChangesSummary& summary) {
  constexpr std::size_t kShown = 10;
  std::string text = "\n";
  const auto row = [&text](const std::string& name, const std::string& value) {
    text += fmt::format("  {:<16} {}\n", name, value);
  };
  row("older", fmt::format("{} ({} keyframes)", summary.older, summary.older_keyframes));
  row("newer", fmt::format("{} ({} keyframes)", summary.newer, summary.newer_keyframes));
  row("stayed", fmt::format("{} voxels", summary.stayed));
  row("appeared", fmt::format("{} things, {} voxels", thingsThat(summary, Change::kAppeared), summary.appeared));
  row("disappeared",
      fmt::format("{} things, {} voxels", thingsThat(summary, Change::kDisappeared), summary.disappeared));
  row("seen by one only", fmt::format("{} voxels: no word on them", summary.unseen));
  row("moving", fmt::format("{} points, left out", summary.moving_points));
  for (std::size_t i = 0; i < std::min(kShown, summary.things.size()); ++i) {
    const ChangedThing& thing = summary.things[i];
    const Eigen::Vector3f middle = 0.5F * (thing.low + thing.high), size = thing.high - thing.low;
    text += fmt::format("  {} {:>5.1f} x {:.1f} x {:.1f} m at ({:.1f}, {:.1f}, {:.1f})\n",
                        thing.change == Change::kAppeared ? "+" : "-", size.x(), size.y(), size.z(), middle.x(),
                        middle.y(), middle.z());
  }
  if (summary.things.size() > kShown)
    text += fmt::format("  … {} more in things.csv\n", summary.things.size() - kShown);
  row("time", fmt::format("{:.1f} s, {:.0f} MB at most", summary.wall_s, summary.peak_rss_mb));
  return text;
}

}  // namespace scslam
