// LOAM (Zhang & Singh, RSS 2014): edges and planes along each ring, matched scan to scan and then scan to map.
//
// Where the paper fits a line or a plane to five neighbours of each point in each iteration, the map's voxels carry the
// line or plane of all their points; the sweep is compensated, rings need no table of three sensors, and directions
// that the scene leaves open are reported.
#include "scslam/odometry/feature_odometry.h"

namespace scslam {

class Loam : public FeatureOdometry {
 public:
  struct Params : ParamSetOf<Params>, ScanToMapParams {
    CurvatureParams features;
    RingParams rings;
    void describe(ParamVisitor& visitor) override {
      describeShared(visitor);
      visitor.group("features", features, "edge and plane features along each ring");
      visitor.group("rings", rings, "which laser saw a point, where the cloud does not say");
    }
  };
  Loam(const Params& params, const PluginContext& context)
      : FeatureOdometry(params, context), params_(params), finder_(params.rings) {}

 private:
  std::string extract(const Cloud& cloud, const Scan& scan, Features& features) override {
    ScanRings rings;
    const std::string why = finder_.ringsOf(cloud, scan, "loam", !started(), rings);
    if (!why.empty()) return why;
    features = featuresOf(cloud, curvatureFeatures(cloud, rings, scan.T_base_sensor.translation().cast<float>(),
                                                   params_.features, threads()));
    return "";
  }
  void saveMap(ByteWriter& state) const override {
    FeatureOdometry::saveMap(state);
    finder_.save(state);
  }
  void loadMap(ByteReader& state) override {
    FeatureOdometry::loadMap(state);
    finder_.load(state);
  }

  Params params_;
  RingFinder finder_;
};

SCSLAM_REGISTER(Odometry, Loam, "loam", "LOAM: edges and planes along each ring, scan to scan and then scan to map")

}  // namespace scslam
