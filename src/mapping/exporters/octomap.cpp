// OctoMap occupancy: map.bt (most likely state) and map.ot (probabilities). Free space is ray-cast from each keyframe's
// sensor (Hornung et al., "OctoMap", Autonomous Robots 2013), each scan's end points reduced to one per cell first.
// Memory grows with the mapped volume, not with the number of scans: about 27 bytes per tree node.
#include <octomap/OcTree.h>

#include <cmath>
#include <fstream>

#include "scslam/mapping/map_exporter.h"

namespace scslam {
namespace {

constexpr double kDefaultResolution = 0.2;  // [m]
constexpr double kCellsPerSide = 32767;     // the tree has 16 levels around the origin

/// Writes through a temporary file; the library reports nothing but the state of the stream.
template <class Write>
std::filesystem::path writeTree(const std::filesystem::path& file, const Write& write) {
  const std::filesystem::path temporary = file.string() + ".tmp";
  bool ok = false;
  {
    std::ofstream out(temporary, std::ios::binary);
    ok = out && write(out) && out.flush();
  }
  if (ok) {
    std::filesystem::rename(temporary, file);
    return file;
  }
  std::filesystem::remove(temporary);
  throw inputError("cannot write {}", file.string());
}

class OctomapExporter final : public MapExporter {
 public:
  struct Params : ParamSetOf<Params> {
    double max_range_m = 50;
    void describe(ParamVisitor& v) override {
      v.field("max_range_m", max_range_m, "rays are cut there: free up to it, their end points unknown [m]", 1e-3);
    }
  };
  OctomapExporter(const Params& params, const PluginContext&) : params_(params) {}

  Tiles tiles() const override { return Tiles::kEveryPoint; }

  void begin(const MapInfo& info) override {
    folder_ = info.folder;
    planar_ = info.planar;
    tree_ = std::make_unique<octomap::OcTree>(info.voxel_m > 0 ? info.voxel_m : kDefaultResolution);
  }

  void add(const MapTile& tile) override {
    if (planar_ && !started_) plane_z_ = static_cast<float>(tile.sensor_origin.z());
    started_ = true;
    const Cloud& cloud = tile.cloud_map;
    octomap::Pointcloud points;
    points.reserve(cloud.size());
    for (std::size_t i = 0; i < cloud.size(); ++i)
      points.push_back(cloud.x[i], cloud.y[i], planar_ ? plane_z_ : cloud.z[i]);
    const octomap::point3d origin(static_cast<float>(tile.sensor_origin.x()),
                                  static_cast<float>(tile.sensor_origin.y()),
                                  planar_ ? plane_z_ : static_cast<float>(tile.sensor_origin.z()));
    checkExtent(tile.sensor_origin);
    tree_->insertPointCloud(points, origin, params_.max_range_m, true, true);  // lazy, discretised
  }

  std::vector<std::filesystem::path> end() override {
    tree_->updateInnerOccupancy();
    tree_->prune();
    // .ot first: writing .bt rounds every probability to occupied or free.
    const auto ot = writeTree(folder_ / "map.ot", [&](std::ostream& out) { return tree_->write(out); });
    const auto bt = writeTree(folder_ / "map.bt", [&](std::ostream& out) { return writeBinary(out); });
    return {bt, ot};
  }

 private:
  /// As OcTree::writeBinary() does, which also prints on stderr.
  bool writeBinary(std::ostream& out) {
    tree_->toMaxLikelihood();
    tree_->prune();
    out << "# Octomap OcTree binary file\n# (feel free to add / change comments, but leave the first line as it is!)\n"
        << fmt::format("#\nid {}\nsize {}\nres {}\ndata\n", tree_->getTreeType(), tree_->size(),
                       tree_->getResolution());
    if (tree_->getRoot() != nullptr) tree_->writeBinaryNode(out, tree_->getRoot());
    return out.good();
  }

  /// Beyond its key range the library drops rays with nothing but a line on stderr.
  void checkExtent(const Eigen::Vector3d& origin) const {
    const double reach = origin.cwiseAbs().maxCoeff() + params_.max_range_m;
    if (const double limit = kCellsPerSide * tree_->getResolution(); reach > limit)
      throw inputError(
          "octomap: the map reaches {:.0f} m from its origin, at {} m a cell the format ends at {:.0f} m; "
          "give a larger --voxel",
          reach, tree_->getResolution(), limit);
  }

  Params params_;
  std::filesystem::path folder_;
  bool planar_ = false, started_ = false;
  float plane_z_ = 0;
  std::unique_ptr<octomap::OcTree> tree_;
};

SCSLAM_REGISTER(MapExporter, OctomapExporter, "octomap", "occupancy octree with free space, .bt and .ot")

}  // namespace
}  // namespace scslam
