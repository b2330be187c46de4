// Changes from above.
#pragma once
#include <string>

#include "scslam/apps/changes/changes.h"

namespace scslam {

/// What stayed in grey, brighter where it is higher; what appeared in green, what disappeared in red, over it; a scale
/// bar. Ground that stayed hides nothing. @return the bytes of a PNG file.
std::string changesPng(const ChangeMap& map, int max_pixels = 1600);

}  // namespace scslam
