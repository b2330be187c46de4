// LiDAR-inertial odometry of the LIO-SAM class: preintegrated IMU and scan matches in a fixed-lag smoother.
//
// Other than there, scan matching is point-to-plane on voxel planes and not on edge and plane features, needs neither
// rings nor an IMU with attitude, and a step is never more than the window's own dense system.
#include "scslam/odometry/imu_odometry.h"
#include "scslam/odometry/imu_smoother.h"

namespace scslam {
namespace {

class LioSmoother : public ImuOdometry {
 public:
  struct Params : ParamSetOf<Params> {
    ImuOdometry::Params odometry;
    int lag = 5;
    void describe(ParamVisitor& visitor) override {
      odometry.describe(visitor);
      visitor.field("lag", lag, "scans that are smoothed together", 2, 50);
    }
  };
  LioSmoother(const Params& params, const PluginContext& context)
      : ImuOdometry(params.odometry, context, std::make_unique<ImuSmoother>(params.lag), "lio_smoother") {}
};

}  // namespace

SCSLAM_REGISTER(Odometry, LioSmoother, "lio_smoother",
                "LiDAR-inertial, LIO-SAM class: preintegrated IMU and scan matches in a fixed-lag smoother")

}  // namespace scslam
