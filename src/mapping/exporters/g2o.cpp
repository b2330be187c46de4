// The pose graph as g2o, over T_map_base (the session keeps one over the sensor for the classic tools).
#include "scslam/core/file.h"
#include "scslam/mapping/map_exporter.h"

namespace scslam {
namespace {

class G2oExporter final : public MapExporter {
 public:
  struct Params : ParamSetOf<Params> {
    void describe(ParamVisitor&) override {}
  };
  G2oExporter(const Params&, const PluginContext&) {}

  Tiles tiles() const override { return Tiles::kNone; }
  void begin(const MapInfo& info) override { info_ = info; }
  void add(const MapTile&) override {}
  std::vector<std::filesystem::path> end() override {
    const auto file = info_.folder / "posegraph.g2o";
    writeFileAtomically(file, formatG2o(info_.graph, info_.planar));
    return {file};
  }

 private:
  MapInfo info_;
};

SCSLAM_REGISTER(MapExporter, G2oExporter, "g2o", "pose graph of the keyframes")

}  // namespace
}  // namespace scslam
