// Binary PCD v0.7: float x y z intensity.
#include "scslam/mapping/map_exporter.h"

namespace scslam {
namespace {

std::string headerOf(std::uint64_t points) {
  constexpr std::size_t kCountDigits = 20;
  const std::string count = std::to_string(points);
  // The comment line takes up what the two counts leave, so that the header's length is known before the points are.
  return fmt::format(
      "# .PCD v0.7 - Point Cloud Data file format{}\nVERSION 0.7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\n"
      "COUNT 1 1 1 1\nWIDTH {}\nHEIGHT 1\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS {}\nDATA binary\n",
      std::string(2 * (kCountDigits - count.size()), ' '), count, count);
}

class PcdExporter final : public MapExporter {
 public:
  struct Params : ParamSetOf<Params> {
    void describe(ParamVisitor&) override {}
  };
  PcdExporter(const Params&, const PluginContext&) {}

  void begin(const MapInfo& info) override {
    file_ = std::make_unique<PointFile>(info.folder / "map.pcd", headerOf(0).size());
  }
  void add(const MapTile& tile) override { file_->append(tile.cloud_map); }
  std::vector<std::filesystem::path> end() override { return {file_->close(headerOf(file_->points()))}; }

 private:
  std::unique_ptr<PointFile> file_;
};

SCSLAM_REGISTER(MapExporter, PcdExporter, "pcd", "point cloud, binary PCD with intensity")

}  // namespace
}  // namespace scslam
