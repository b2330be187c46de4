#include "scslam/sensor/radar_extractor.h"

namespace scslam {

SCSLAM_DEFINE_REGISTRY(RadarExtractor)

}  // namespace scslam
