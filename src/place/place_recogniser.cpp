#include "scslam/place/place_recogniser.h"

namespace scslam {

SCSLAM_DEFINE_REGISTRY(PlaceRecogniser)

}  // namespace scslam
