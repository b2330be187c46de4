#include "scslam/place/packed_image.h"

#include <algorithm>
#include <cmath>

namespace scslam {

PackedImage pack(const Descriptor& image) {
  PackedImage packed(static_cast<std::size_t>(image.size()));
  std::transform(image.data(), image.data() + image.size(), packed.begin(), [](float height) {
    if (!(height > 0)) return std::uint8_t{0};
    return static_cast<std::uint8_t>(std::min(255.0f, std::ceil(16 * std::sqrt(height))));
  });
  return packed;
}

Descriptor unpack(const PackedImage& packed, Eigen::Index rows, Eigen::Index columns) {
  Descriptor image(rows, columns);
  std::transform(packed.begin(), packed.end(), image.data(), [](std::uint8_t code) {
    const float root = static_cast<float>(code) / 16;
    return root * root;
  });
  return image;
}

}  // namespace scslam
