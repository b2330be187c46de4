// LZF, the compression of PCD's binary_compressed (format of Marc Lehmann's liblzf): decompression only.
#pragma once
#include <cstddef>
#include <string>
#include <string_view>

namespace scslam {

/// @param size what the packed bytes must unpack to.
/// @return false when they do not: damaged. Reads and writes nothing outside, allocates nothing beyond `size`.
bool lzfDecompress(std::string_view packed, std::size_t size, std::string& result);

}  // namespace scslam
