#include "scslam/apps/point_map/point_map.h"

#include <algorithm>
#include <cmath>

#include "scslam/apps/point_map/map_views.h"
#include "scslam/apps/point_map/viewpoints.h"
#include "scslam/core/error.h"
#include "scslam/core/log.h"
#include "scslam/core/parallel.h"
#include "scslam/core/progress.h"
#include "scslam/core/voxel_filter.h"
#include "scslam/sensor/cloud_files.h"
#include "scslam/session/session_graph.h"
#include "scslam/session/session_writer.h"

namespace scslam {
namespace fs = std::filesystem;
namespace {

constexpr std::size_t kBatch = 16;  ///< views in memory at a time

/// The points, one a voxel.
Cloud readMap(const fs::path& file, double voxel_m) {
  constexpr float kMost_m = 1e5F;  // float32 resolves 8 mm there
  const Cloud whole = readCloudFile(file);
  for (std::size_t i = 0; i < whole.size(); ++i)
    if (const Eigen::Vector3f p = whole.point(i); p.allFinite() && p.cwiseAbs().maxCoeff() > kMost_m)
      throw inputError("{}: point {} lies {:.0f} m from the origin, where float32 is too coarse: subtract an offset",
                       file.string(), i, p.norm());
  Cloud map;
  if (whole.hasIntensity()) map.intensity.reserve(whole.size() / 2);
  for (const std::uint32_t i : onePerVoxel(whole, voxel_m, 0, 2 * static_cast<double>(kMost_m))) {
    map.push(whole.x[i], whole.y[i], whole.z[i]);
    if (whole.hasIntensity()) map.intensity.push_back(whole.intensity[i]);
  }
  if (map.empty()) throw inputError("{} holds no points", file.string());
  return map;
}

Keyframe keyframeAt(std::size_t k, const Eigen::Vector3f& viewpoint, double travelled_m) {
  constexpr double kStiff = 1e-8;  // [m^2, rad^2]: the views do not move against each other
  Keyframe keyframe;
  keyframe.id = static_cast<KeyframeId>(k);
  keyframe.scan_index = k;
  keyframe.stamp = stampFromSeconds(static_cast<double>(k));
  keyframe.T_odom_base.translation() = viewpoint.cast<double>();
  keyframe.travelled_m = travelled_m;
  keyframe.step_covariance = kStiff * Matrix6d::Identity();
  return keyframe;
}

}  // namespace

void PointMapParams::describe(ParamVisitor& v) {
  v.field("spacing_m", spacing_m, "between the places from which a point map is looked at [m]", 0.5, 1000);
  v.field("height_m", height_m, "of the eye above the ground there [m]", 0.1, 100);
  v.field("range_m", range_m, "how far it sees [m]", 1, 1000);
  v.field("voxel_m", voxel_m, "the map is thinned to one point in such a cube [m]", 0.01, 10);
}

bool isPointMap(const fs::path& path) {
  const std::string extension = path.extension().string();
  return fs::is_regular_file(path) && (extension == ".ply" || extension == ".pcd");
}

void writeMapSession(const fs::path& file, const fs::path& folder, const PointMapParams& params,
                     const PluginContext& context, const std::function<void(std::size_t, std::size_t)>& progress) {
  Cloud map = readMap(file, params.voxel_m);
  std::vector<Eigen::Vector3f> viewpoints = groundViewpoints(map, params.spacing_m);
  if (viewpoints.empty())
    throw inputError("{}: there is no ground in it on which a robot fits (z must point up; the unit is a metre)",
                     file.string());
  logInfo(context.log, "{}: {} points, looked at from {} places on its ground", file.string(), map.size(),
          viewpoints.size());
  for (Eigen::Vector3f& p : viewpoints) p.z() += static_cast<float>(params.height_m);
  const MapViews views(std::move(map), params.range_m);

  SessionInfo info;
  info.input = file.string();
  info.input_format = kPointMap;
  const auto writer = SessionWriter::create(folder, info, true);
  std::vector<Keyframe> keyframes;
  std::vector<Pose> poses;
  double travelled_m = 0;
  for (std::size_t begin = 0; begin < viewpoints.size(); begin += kBatch) {
    progress(begin, viewpoints.size());
    std::vector<Cloud> clouds(std::min(kBatch, viewpoints.size() - begin));
    context.threads.forEachChunk(clouds.size(), 1, [&](std::size_t i, std::size_t, std::size_t) {
      clouds[i] = views.from(viewpoints[begin + i]);
    });
    for (std::size_t i = 0; i < clouds.size(); ++i) {
      const std::size_t k = begin + i;
      if (k > 0) travelled_m += static_cast<double>((viewpoints[k] - viewpoints[k - 1]).norm());
      const Keyframe& keyframe = keyframes.emplace_back(keyframeAt(k, viewpoints[k], travelled_m));
      poses.push_back(keyframe.T_odom_base);
      writer->addKeyframe(keyframe, poses.back(), clouds[i], Descriptor());
    }
  }
  writer->finish(buildGraph(keyframes, {}, poses, false));
  writer->seal();
}

fs::path PointMapSessions::sessionFor(const fs::path& session_or_map, const PointMapParams& params,
                                      const PluginContext& context, bool quiet, const std::atomic<bool>* stop) {
  if (!isPointMap(session_or_map)) return session_or_map;
  if (!folder_) folder_.emplace(beside_, std::vector<fs::path>{}, ResultKind{"views of point maps", "", {}}, false);
  fs::path folder = folder_->folder() / std::to_string(count_++) / session_or_map.stem();
  fs::create_directories(folder.parent_path());
  std::optional<Progress> progress;
  writeMapSession(session_or_map, folder, params, context, [&](std::size_t done, std::size_t all) {
    if (stop != nullptr && *stop) throw Error(ExitCode::kStopped, "stopped; nothing was written");
    if (!progress) progress.emplace("views of " + session_or_map.filename().string(), all, quiet);
    progress->update(done);
  });
  progress->finish();
  return folder;
}

}  // namespace scslam
