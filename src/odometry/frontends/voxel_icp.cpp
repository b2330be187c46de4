// LiDAR odometry by scan-to-map point-to-plane matching on voxel planes (core/scan_match.h): all points, thinned.
#include "scslam/core/voxel_filter.h"
#include "scslam/odometry/scan_to_map.h"

namespace scslam {

class VoxelIcp : public ScanToMap {
 public:
  struct Params : ParamSetOf<Params>, ScanToMapParams {
    void describe(ParamVisitor& visitor) override { describeShared(visitor); }
  };
  VoxelIcp(const Params& params, const PluginContext& context) : ScanToMap(params, context) {}

 private:
  std::string extract(const Cloud& cloud, const Scan& /*scan*/, Features& features) override {
    features = {thin(cloud, 0.4 * voxelSize())};
    return "";
  }
  MatchResult match(const Features& features, const Guess& guess, const Pose& T_start) const override {
    return matchScan(planes(), thin(features[0], voxelSize()), T_start, matchOptions(guess), threads());
  }
};

SCSLAM_REGISTER(Odometry, VoxelIcp, "voxel_icp",
                "scan-to-map point-to-plane ICP on voxel planes; finds itself again after a turn by search")

}  // namespace scslam
