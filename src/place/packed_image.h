// A descriptor in a byte per bin, for images kept only to ask again later: fine near the ground, 254 m at most.
#pragma once
#include <cstdint>
#include <vector>

#include "scslam/place/place_recogniser.h"

namespace scslam {

using PackedImage = std::vector<std::uint8_t>;

/// Heights as (byte / 16)^2 m, rounded up: what is not empty stays so.
PackedImage pack(const Descriptor& image);
Descriptor unpack(const PackedImage& packed, Eigen::Index rows, Eigen::Index columns);

}  // namespace scslam
