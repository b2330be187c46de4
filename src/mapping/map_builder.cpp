#include "scslam/mapping/map_builder.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/parallel.h"
#include "scslam/mapping/map_exporter.h"
#include "scslam/mapping/voxel_set.h"
#include "scslam/session/layout.h"

namespace scslam {
namespace {

constexpr double kDefaultVoxel = 0.1;  // [m], of point clouds

/// A keyframe's cloud, loaded and moved by one thread.
struct Loaded {
  bool missing = false;
  std::uint64_t read = 0, out_of_range = 0, not_finite = 0;
  MapTile tile;
};

Loaded load(const Session& session, KeyframeId k, const MapOptions& options, const MapFrame& frame) {
  Loaded loaded;
  const Pose T_map_sensor = session.poses()[k] * session.info().T_base_sensor;
  loaded.tile.sensor_origin = frame(Eigen::Vector3d(T_map_sensor.translation()));
  if (session.classic() && !session.hasCloud(k)) {
    loaded.missing = true;
    return loaded;
  }
  Cloud cloud = session.cloud(k);
  loaded.read = cloud.size();
  loaded.not_finite = dropNonFinite(cloud);
  std::vector<std::uint8_t> keep(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const double range = cloud.point(i).cast<double>().norm();
    keep[i] = range >= options.min_range_m && range <= options.max_range_m;
    loaded.out_of_range += keep[i] ? 0 : 1;
  }
  cloud.filter(keep);
  Eigen::Affine3d A = frame.around(T_map_sensor.translation());
  A = A * T_map_sensor;
  transformInPlace(cloud, A);
  loaded.tile.cloud_map = std::move(cloud);
  return loaded;
}

MapTile thinned(const MapTile& tile, VoxelSet& voxels) {
  const Cloud& cloud = tile.cloud_map;
  MapTile result{cloud, tile.sensor_origin};
  std::vector<std::uint8_t> keep(cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Eigen::Vector3d p = cloud.point(i).cast<double>();
    if (p.cwiseAbs().maxCoeff() > voxels.reach_m())
      throw inputError("a point lies {:.0f} km from the map's origin, too far for these voxels; give a larger --voxel",
                       p.cwiseAbs().maxCoeff() / 1000);
    keep[i] = voxels.insert(p);
  }
  result.cloud_map.filter(keep);
  voxels.trim();
  return result;
}

class MapBuild {
 public:
  MapBuild(const Session& session, const std::vector<std::string>& formats, const MapOptions& options,
           const std::filesystem::path& out_folder, const PluginContext& context)
      : session_(session),
        options_(options),
        context_(context),
        frame_(session, options.frame),
        folder_(out_folder),
        voxel_m_(options.voxel_m.value_or(kDefaultVoxel)),
        voxels_(voxel_m_ > 0 ? voxel_m_ : 1, options.voxel_budget_bytes, out_folder) {
    const auto& registry = Registry<MapExporter>::instance();
    for (const std::string& format : formats) registry.find(format);  // complain before anything is written
    std::error_code error;
    std::filesystem::create_directories(out_folder, error);
    if (error) throw inputError("cannot create {}: {}", out_folder.string(), error.message());
    const MapInfo info = infoOf(out_folder);
    std::set<std::string> done;
    for (const std::string& format : formats) {
      if (!done.insert(format).second) continue;
      exporters_.push_back(registry.create(format, context));
      exporters_.back()->begin(info);
    }
  }

  MapSummary run(const std::function<void(std::size_t)>& progress) {
    const std::size_t n = session_.keyframes().size();
    const auto wanted = [](const auto& e) { return e->tiles() != MapExporter::Tiles::kNone; };
    if (std::any_of(exporters_.begin(), exporters_.end(), wanted)) {
      const auto batch = static_cast<std::size_t>(context_.threads.size());
      for (std::size_t begin = 0; begin < n; begin += batch) {
        addKeyframes(begin, std::min(n, begin + batch));
        if (progress) progress(std::min(n, begin + batch));
      }
    }
    for (const auto& exporter : exporters_)
      for (const auto& file : exporter->end()) summary_.files.push_back(file);
    if (!frame_.description().empty()) {
      summary_.files.push_back(folder_ / layout::kGeoreference);
      writeFileAtomically(summary_.files.back(), frame_.description());
    }
    summary_.keyframes = n;
    return summary_;
  }

 private:
  MapInfo infoOf(const std::filesystem::path& out_folder) const {
    const SessionInfo& of = session_.info();
    MapInfo info;
    info.folder = out_folder;
    info.voxel_m = options_.voxel_m.value_or(0);
    info.min_range_m = options_.min_range_m, info.max_range_m = options_.max_range_m;
    info.planar = of.planar;
    info.frame = frame_.name(), info.offset_m = frame_.offset_m();
    info.trajectory = session_.trajectory(), info.graph = session_.graph();
    info.input = of.input, info.sensor_label = of.sensor_label, info.sensor_table = of.sensor_table;
    for (StampedPose& pose : info.trajectory) pose.T = frame_(pose.T);
    for (Pose& T : info.graph.poses) T = frame_(T);
    return info;
  }

  /// Loads in parallel, adds in order.
  void addKeyframes(std::size_t begin, std::size_t end) {
    std::vector<Loaded> batch(end - begin);
    context_.threads.forEachChunk(batch.size(), 1, [&](std::size_t i, std::size_t, std::size_t) {
      batch[i] = load(session_, static_cast<KeyframeId>(begin + i), options_, frame_);
    });
    for (const Loaded& loaded : batch) add(loaded);
  }

  void add(const Loaded& loaded) {
    summary_.missing_scans += loaded.missing ? 1 : 0;
    summary_.points_read += loaded.read;
    summary_.out_of_range += loaded.out_of_range;
    summary_.not_finite += loaded.not_finite;
    if (loaded.missing) return;
    const auto wants = [this](MapExporter::Tiles tiles) {
      return std::any_of(exporters_.begin(), exporters_.end(), [=](const auto& e) { return e->tiles() == tiles; });
    };
    MapTile thin;
    if (wants(MapExporter::Tiles::kThinned)) {
      thin = voxel_m_ > 0 ? thinned(loaded.tile, voxels_) : loaded.tile;
      summary_.points_written += thin.cloud_map.size();
      summary_.thinned += loaded.tile.cloud_map.size() - thin.cloud_map.size();
    }
    for (const auto& exporter : exporters_) {
      if (exporter->tiles() == MapExporter::Tiles::kThinned) exporter->add(thin);
      if (exporter->tiles() == MapExporter::Tiles::kEveryPoint) exporter->add(loaded.tile);
    }
  }

  const Session& session_;
  const MapOptions& options_;
  const PluginContext& context_;
  MapFrame frame_;
  std::filesystem::path folder_;
  double voxel_m_;
  VoxelSet voxels_;
  std::vector<std::unique_ptr<MapExporter>> exporters_;
  MapSummary summary_;
};

}  // namespace

MapSummary exportMap(const Session& session, const std::vector<std::string>& formats, const MapOptions& options,
                     const std::filesystem::path& out_folder, const PluginContext& context,
                     const std::function<void(std::size_t)>& progress) {
  return MapBuild(session, formats, options, out_folder, context).run(progress);
}

}  // namespace scslam
