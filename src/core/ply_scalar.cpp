#include "scslam/core/ply_scalar.h"

#include <cstdint>
#include <cstring>
#include <iterator>

namespace scslam {

std::optional<PlyScalar> plyScalar(std::string_view word) {
  constexpr std::string_view kNames[][2] = {{"char", "int8"},     {"uchar", "uint8"},   {"short", "int16"},
                                            {"ushort", "uint16"}, {"int", "int32"},     {"uint", "uint32"},
                                            {"float", "float32"}, {"double", "float64"}};
  for (std::size_t i = 0; i < std::size(kNames); ++i)
    if (word == kNames[i][0] || word == kNames[i][1]) return static_cast<PlyScalar>(i);
  return std::nullopt;
}

std::size_t sizeOf(PlyScalar type) {
  constexpr std::size_t kSizes[] = {1, 1, 2, 2, 4, 4, 4, 8};
  return kSizes[static_cast<std::size_t>(type)];
}

double plyValue(const char* bytes, PlyScalar type) {
  const auto as = [bytes]<class T>(T value) {
    std::memcpy(&value, bytes, sizeof value);
    return static_cast<double>(value);
  };
  switch (type) {
    case PlyScalar::kI8:
      return as(std::int8_t{});
    case PlyScalar::kU8:
      return as(std::uint8_t{});
    case PlyScalar::kI16:
      return as(std::int16_t{});
    case PlyScalar::kU16:
      return as(std::uint16_t{});
    case PlyScalar::kI32:
      return as(std::int32_t{});
    case PlyScalar::kU32:
      return as(std::uint32_t{});
    case PlyScalar::kF32:
      return as(0.F);
    default:
      return as(0.0);
  }
}

}  // namespace scslam
