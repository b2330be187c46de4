// Meshes from files of other programs: PLY, OBJ, STL, COLLADA (.dae), glTF (.gltf, .glb); PLY by ourselves,
// the others by assimp.
#pragma once
#include <filesystem>
#include <string>

#include "scslam/core/params.h"
#include "sim/mesh.h"

namespace mrpt::system {
class COutputLogger;
}

namespace scslam::sim {

struct MeshFileOptions : ParamSetOf<MeshFileOptions> {
  /// Which axis of the file points up. "auto": what the format or its metadata says (glTF, COLLADA), else z.
  std::string up = "auto";
  double scale = 1;                  ///< metres per unit of the file (of COLLADA: after its own unit)
  std::string material = "default";  ///< of triangles whose material in the file is none of materials()
  bool strict_materials = false;     ///< such triangles are an error

  void describe(ParamVisitor& v) override;
};

/// The triangles of a file, moved by its nodes' transforms, in metres, z up. Polygons are cut into triangles. Materials
/// by materialLike() of their names; each mesh group is an instance, from 1.
/// Faces that are no triangles with finite corners and an area are left out and counted in a warning, as are materials
/// that are not known and sizes that look like another unit.
/// @throw inputError when the file cannot be read or no triangle is left; usageError for options that do not fit it.
Mesh readMesh(const std::filesystem::path& file, const MeshFileOptions& options, mrpt::system::COutputLogger& log);

}  // namespace scslam::sim
