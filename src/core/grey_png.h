// 8-bit grey pictures as PNG files.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

namespace scslam {

struct GreyImage {
  std::size_t rows = 0, columns = 0;
  std::vector<std::uint8_t> pixels;  ///< row by row from the top
};

/// @param name of the file, for messages.
/// @throw inputError for what is no whole, 8-bit grey, not interlaced PNG of at most 16384 rows of 65536 columns.
/// Memory grows with what is there, not with what the file states.
GreyImage decodeGreyPng(std::string_view png, const std::string& name);

/// The bytes of the file; the same picture gives the same bytes.
/// @param filtered whether rows are predicted from their neighbours: smaller for pictures, a waste of time for noise.
std::string encodeGreyPng(const GreyImage& image, bool filtered);

}  // namespace scslam
