#include "scslam/session/text_files.h"

#include "scslam/core/file.h"
#include "scslam/graph/g2o.h"
#include "scslam/session/georeference.h"
#include "scslam/session/layout.h"
#include "scslam/session/manifest.h"
#include "scslam/session/session_graph.h"

namespace scslam {

std::string manifestText(const SessionInfo& info, const JournalContents& contents, bool complete) {
  Manifest manifest;
  manifest.info = info;
  manifest.complete = complete;
  manifest.scans = contents.scans.size();
  manifest.keyframes = contents.keyframes.size();
  for (const LoopRecord& loop : contents.loops) manifest.loops_accepted += loop.accepted ? 1 : 0;
  return formatManifest(manifest);
}

std::vector<std::pair<std::string, std::string>> textFiles(const SessionInfo& info, const JournalContents& contents) {
  const auto& keyframes = contents.keyframes;
  std::vector<Pose> T_map_sensor, T_odom_sensor;
  for (std::size_t k = 0; k < keyframes.size(); ++k) {
    T_map_sensor.push_back(contents.T_map_base[k] * info.T_base_sensor);
    T_odom_sensor.push_back(keyframes[k].T_odom_base * info.T_base_sensor);
  }
  std::vector<std::pair<std::string, std::string>> files = {
      {layout::kOptimisedPoses, formatKitti(T_map_sensor)},
      {layout::kOdometryPoses, formatKitti(T_odom_sensor)},
      {layout::kTimes, layout::formatTimes(keyframes)},
      {layout::kTrajectory, formatTum(correctedTrajectory(contents.scans, keyframes, contents.T_map_base))},
      {layout::kOdometry, formatTum(odometryTrajectory(contents.scans))},
      {layout::kLoops, layout::formatLoops(contents.loops)}};
  if (!contents.gnss.empty()) files.emplace_back(layout::kGnss, layout::formatGnss(contents.gnss));
  if (const auto placed = georeference(contents.gnss, contents.T_map_base))
    files.emplace_back(layout::kGeoreference, formatGeoreference(*placed));
  return files;
}

void writeTextFiles(const std::filesystem::path& folder, const SessionInfo& info, const JournalContents& contents,
                    const PoseGraph& graph, bool complete) {
  for (const auto& [name, text] : textFiles(info, contents)) writeFileAtomically(folder / name, text);
  writeFileAtomically(folder / layout::kPoseGraph, formatG2o(graphOfSensor(graph, info.T_base_sensor)));
  writeFileAtomically(folder / layout::kManifest, manifestText(info, contents, complete));
}

}  // namespace scslam
