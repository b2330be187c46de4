#include "scslam/core/lzf.h"

#include <cstdint>

namespace scslam {

bool lzfDecompress(std::string_view packed, std::size_t size, std::string& result) {
  // A back reference of three bytes makes at most 264: a larger claim is a lie, refused before memory is taken for it.
  if (size / 264 > packed.size() / 3 + 1) return false;
  result.clear();
  result.reserve(size);
  std::size_t i = 0;
  const auto byte = [&packed](std::size_t at) { return static_cast<std::uint8_t>(packed[at]); };
  while (i < packed.size()) {
    const std::size_t control = byte(i++);
    if (control < 32) {  // control + 1 literal bytes
      const std::size_t length = control + 1;
      if (length > packed.size() - i || length > size - result.size()) return false;
      result.append(packed.substr(i, length));
      i += length;
      continue;
    }
    std::size_t length = control >> 5;  // 3 bits length - 2 (7: a byte more follows), 13 bits distance - 1
    if (length == 7) {
      if (i >= packed.size()) return false;
      length += byte(i++);
    }
    if (i >= packed.size()) return false;
    const std::size_t distance = ((control & 31) << 8 | byte(i++)) + 1;
    length += 2;
    if (distance > result.size() || length > size - result.size()) return false;
    for (std::size_t k = 0; k < length; ++k) result.push_back(result[result.size() - distance]);  // may overlap itself
  }
  return result.size() == size;
}

}  // namespace scslam
