// TUM trajectory: stamp x y z qx qy qz qw of T_map_base, every scan.
#include "scslam/core/file.h"
#include "scslam/mapping/map_exporter.h"

namespace scslam {
namespace {

class TumExporter final : public MapExporter {
 public:
  struct Params : ParamSetOf<Params> {
    void describe(ParamVisitor&) override {}
  };
  TumExporter(const Params&, const PluginContext&) {}

  Tiles tiles() const override { return Tiles::kNone; }
  void begin(const MapInfo& info) override { info_ = info; }
  void add(const MapTile&) override {}
  std::vector<std::filesystem::path> end() override {
    const auto file = info_.folder / "trajectory.tum";
    writeFileAtomically(file, formatTum(info_.trajectory));
    return {file};
  }

 private:
  MapInfo info_;
};

SCSLAM_REGISTER(MapExporter, TumExporter, "tum", "trajectory of every scan, TUM text")

}  // namespace
}  // namespace scslam
