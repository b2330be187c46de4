// Binary little-endian PLY: float x y z intensity.
#include "scslam/mapping/map_exporter.h"

namespace scslam {
namespace {

std::string headerOf(const std::string& frame, std::uint64_t points) {
  constexpr std::size_t kCountDigits = 20;
  const std::string count = std::to_string(points);
  // The comment takes up what the count leaves, so that the header's length is known before the points are.
  return fmt::format(
      "ply\nformat binary_little_endian 1.0\ncomment scslam map, frame {}, metres{}\nelement vertex {}\n"
      "property float x\nproperty float y\nproperty float z\nproperty float intensity\nend_header\n",
      frame, std::string(kCountDigits - count.size(), ' '), count);
}

class PlyExporter final : public MapExporter {
 public:
  struct Params : ParamSetOf<Params> {
    void describe(ParamVisitor&) override {}
  };
  PlyExporter(const Params&, const PluginContext&) {}

  void begin(const MapInfo& info) override {
    frame_ = info.frame;
    file_ = std::make_unique<PointFile>(info.folder / "map.ply", headerOf(frame_, 0).size());
  }
  void add(const MapTile& tile) override { file_->append(tile.cloud_map); }
  std::vector<std::filesystem::path> end() override { return {file_->close(headerOf(frame_, file_->points()))}; }

 private:
  std::string frame_;
  std::unique_ptr<PointFile> file_;
};

SCSLAM_REGISTER(MapExporter, PlyExporter, "ply", "point cloud, binary PLY with intensity")

}  // namespace
}  // namespace scslam
