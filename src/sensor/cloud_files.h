// One scan in one file.
#pragma once
#include <filesystem>

#include "scslam/core/cloud.h"

namespace scslam {

/// float32 little-endian x y z intensity, 16 bytes a point (KITTI, MulRan). @throw inputError when the size is no
/// multiple of 16.
Cloud readXyziBin(const std::filesystem::path& file);

/// Text, one point a line: x y z [intensity …], blanks or commas. @throw inputError file:line.
Cloud readXyzText(const std::filesystem::path& file);

/// PLY, ascii or binary_little_endian: the vertex element's x y z and, where present, intensity ("intensity",
/// "reflectance", "scalar_intensity"), dt ("t", "time", "dt", "timestamp": seconds as a float, nanoseconds as an
/// integer, as they stand) and ring ("ring", "channel"); properties in any order and of any scalar type. Elements after
/// the vertices are not read, lists or elements before them are refused.
/// @throw inputError "FILE: …" with line or byte.
Cloud readPly(const std::filesystem::path& file);

/// By the extension: .pcd .ply .bin .xyz .txt .csv. @throw inputError for another one.
Cloud readCloudFile(const std::filesystem::path& file);

}  // namespace scslam
