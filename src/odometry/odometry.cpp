#include "scslam/odometry/odometry.h"

namespace scslam {

SCSLAM_DEFINE_REGISTRY(Odometry)

}  // namespace scslam
