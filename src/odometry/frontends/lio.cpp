// LiDAR-inertial odometry of the FAST-LIO2 class: a tightly coupled, iterated error-state Kalman filter.
//
// The scan match (imu_scan_map.h) starts from the filter's prediction and holds on to it with the filter's own
// covariance: its Gauss-Newton iterations are the iterations of the filter's update.
#include "scslam/odometry/imu_filter.h"
#include "scslam/odometry/imu_odometry.h"

namespace scslam {
namespace {

class Lio : public ImuOdometry {
 public:
  struct Params : ParamSetOf<Params> {
    ImuOdometry::Params odometry;
    void describe(ParamVisitor& visitor) override {
      odometry.describe(visitor);
      visitor.field("estimate_mounting", odometry.estimate_mounting,
                    "estimate T_base_imu; it needs turns about all axes");
    }
  };
  Lio(const Params& params, const PluginContext& context)
      : ImuOdometry(params.odometry, context, std::make_unique<ImuFilter>(), "lio") {}
};

}  // namespace

SCSLAM_REGISTER(Odometry, Lio, "lio",
                "LiDAR-inertial, FAST-LIO2 class: iterated Kalman filter, IMU deskew, point-to-plane on a voxel map")

}  // namespace scslam
