#include "scslam/registration/registration.h"

namespace scslam {

SCSLAM_DEFINE_REGISTRY(Registration)

}  // namespace scslam
