#include "sim/world_generator.h"

namespace scslam {
SCSLAM_DEFINE_REGISTRY(sim::WorldGenerator)
}
