// PLY files with faces. (assimp's own PLY reader never ends on a cut header and takes half a file for a whole one.)
#pragma once
#include <filesystem>

#include "sim/polygon_mesh.h"

namespace scslam::sim {

/// Ascii or binary, either byte order: x y z of the element "vertex" and the list "vertex_indices" or "vertex_index" of
/// the element "face"; other elements and properties are skipped. Numbers are as they stand, NaN included; indices that
/// are no whole number from 0 to 2^32 - 2 become 2^32 - 1.
/// @throw inputError "cannot read mesh FILE: …" for a header that is none, and for data that end early or are no
/// numbers.
PolygonMesh readPlyMesh(const std::filesystem::path& file);

}  // namespace scslam::sim
