// Odometry by voxelised generalised ICP: distribution to distribution, scan to map (odometry/distribution_match.h).
#include "scslam/odometry/distribution_match.h"
#include "scslam/odometry/scan_to_map.h"

namespace scslam {

class Gicp : public ScanToMap {
 public:
  struct Params : ParamSetOf<Params>, ScanToMapParams {
    double spread = 6.0;  ///< standard deviation within a plane, in voxels
    void describe(ParamVisitor& visitor) override {
      describeShared(visitor);
      visitor.field("spread", spread, "standard deviation of a distribution within its plane [map voxels]", 0.1, 100.0);
    }
  };
  Gicp(const Params& params, const PluginContext& context) : ScanToMap(params, context), spread_(params.spread) {}

 private:
  std::string extract(const Cloud& cloud, const Scan& /*scan*/, Features& features) override {
    features = {thin(cloud, 0.4 * voxelSize())};
    return "";
  }

  MatchResult match(const Features& features, const Guess& guess, const Pose& T_start) const override {
    const MatchOptions options = matchOptions(guess);
    const PlanarPoints source = planarPoints(features[0], voxelSize(), voxelSize(), SurfelRules::of(planar()));
    MatchKernel first;
    first.gate_m = planes().level(options.levels.coarsest).voxelSize();
    first.width_m = 0.5 * first.gate_m;
    first.inlier_m = options.inlier_m;
    first.sigma_m = options.sigma_m;
    const auto distributions = [&](const Pose& T_odom_base, const MatchKernel& kernel) {
      return lineariseDistributions(planes(), options.levels, source, spread_ * voxelSize(), T_odom_base, kernel,
                                    threads());
    };
    return matchBy(distributions, T_start, first, leverOf(source.cloud), options);
  }

  double spread_;
};

SCSLAM_REGISTER(Odometry, Gicp, "gicp", "voxelised generalised ICP: distributions of the scan against those of the map")

}  // namespace scslam
