// The number types of PLY files.
#pragma once
#include <cstddef>
#include <optional>
#include <string_view>

namespace scslam {

enum class PlyScalar { kI8, kU8, kI16, kU16, kI32, kU32, kF32, kF64 };

/// By either of its names ("uchar", "uint8"); nullopt for another word.
std::optional<PlyScalar> plyScalar(std::string_view word);
std::size_t sizeOf(PlyScalar type);
/// The number at `bytes`, this machine's byte order.
double plyValue(const char* bytes, PlyScalar type);

}  // namespace scslam
