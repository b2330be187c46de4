// KITTI trajectory: row-major 3x4 T_map_base of every scan, and the stamps, which the format lacks, beside it.
#include "scslam/core/file.h"
#include "scslam/mapping/map_exporter.h"

namespace scslam {
namespace {

class KittiExporter final : public MapExporter {
 public:
  struct Params : ParamSetOf<Params> {
    void describe(ParamVisitor&) override {}
  };
  KittiExporter(const Params&, const PluginContext&) {}

  Tiles tiles() const override { return Tiles::kNone; }
  void begin(const MapInfo& info) override { info_ = info; }
  void add(const MapTile&) override {}
  std::vector<std::filesystem::path> end() override {
    std::vector<Pose> T_map_base;
    std::string times;
    for (const StampedPose& pose : info_.trajectory) {
      T_map_base.push_back(pose.T);
      times += formatStamp(pose.stamp) + "\n";
    }
    const auto file = info_.folder / "trajectory.kitti.txt", times_file = info_.folder / "trajectory.times.txt";
    writeFileAtomically(file, formatKitti(T_map_base));
    writeFileAtomically(times_file, times);
    return {file, times_file};
  }

 private:
  MapInfo info_;
};

SCSLAM_REGISTER(MapExporter, KittiExporter, "kitti", "trajectory of every scan, KITTI text and its times")

}  // namespace
}  // namespace scslam
