// LeGO-LOAM (Shan & Englot, IROS 2018): ground and clusters first, then edges of the clusters and planes of the ground;
// the motion between two scans in two steps, z, roll and pitch from the ground and x, y and yaw from the edges.
#include "scslam/odometry/feature_odometry.h"
#include "scslam/odometry/frontends/lego/segmentation.h"

namespace scslam {

class Lego : public FeatureOdometry {
 public:
  struct Params : ParamSetOf<Params>, ScanToMapParams {
    lego::SegmentationParams segmentation;
    CurvatureParams features;
    RingParams rings;
    void describe(ParamVisitor& visitor) override {
      describeShared(visitor);
      visitor.group("segmentation", segmentation, "ground and clusters on the range image");
      visitor.group("features", features, "edge and plane features along each ring");
      visitor.group("rings", rings, "which laser saw a point, where the cloud does not say");
    }
  };
  Lego(const Params& params, const PluginContext& context)
      : FeatureOdometry(params, context), params_(params), finder_(params.rings) {}

 private:
  std::string extract(const Cloud& cloud, const Scan& scan, Features& features) override {
    ScanRings rings;
    const std::string why = finder_.ringsOf(cloud, scan, "lego", !started(), rings);
    if (!why.empty()) return why;
    const auto segments = lego::segment(cloud, rings, scan.T_base_sensor, params_.segmentation);
    std::vector<std::uint8_t> roles(cloud.size());
    for (std::size_t i = 0; i < roles.size(); ++i) roles[i] = roleOf(segments[i]);
    features = featuresOf(cloud, curvatureFeatures(cloud, rings, scan.T_base_sensor.translation().cast<float>(),
                                                   params_.features, threads(), roles));
    return "";
  }

  static std::uint8_t roleOf(lego::Segment segment) {
    if (segment == lego::Segment::kGround) return kMayBeFlat | kMayBeSurface;
    return segment == lego::Segment::kCluster ? kMayBeEdge | kMayBeSurface : 0;
  }

  MatchResult matchLastScan(const Sources& sources, const Pose& T_start, const MatchOptions& options) const override {
    const Cloud none;
    MatchOptions ground = options, edges = options;
    ground.held = {true, true, false, false, false, true};
    edges.held = {false, false, true, true, true, false};
    const MatchResult levelled =
        matchFeatures(lastScan().planes, lastScan().lines, {sources.surface, none}, T_start, ground);
    return matchFeatures(lastScan().planes, lastScan().lines, {none, sources.edges}, levelled.T_map_scan, edges);
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

SCSLAM_REGISTER(Odometry, Lego, "lego",
                "LeGO-LOAM: ground and clusters first, two steps from scan to scan, then scan to map")

}  // namespace scslam
