// How long is a metre in a picture of a map?
#pragma once
#include "scslam/core/image.h"

namespace scslam {

/// A bar of a round length, about an eighth of the picture, with its length over it, in the lower left corner.
void drawScaleBar(Image& image, double pixel_m);

}  // namespace scslam
