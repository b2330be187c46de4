#include "sim/mesh_file.h"

#include <assimp/config.h>
#include <assimp/scene.h>

#include <algorithm>
#include <assimp/Importer.hpp>
#include <cmath>
#include <cstring>
#include <set>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/log.h"
#include "scslam/core/suggest.h"
#include "sim/material.h"
#include "sim/ply_mesh.h"

namespace scslam::sim {

using Eigen::Vector3d;
using Eigen::Vector3f;

namespace {

std::string extensionOf(const std::filesystem::path& file) {
  std::string extension = file.extension().string();
  std::transform(extension.begin(), extension.end(), extension.begin(),
                 [](unsigned char c) { return static_cast<char>(std::tolower(c)); });
  return extension;
}

void checkFile(const std::filesystem::path& file) {
  std::error_code error;
  if (!std::filesystem::exists(file, error)) throw inputError("cannot read mesh {}: no such file", file.string());
  if (!std::filesystem::is_regular_file(file, error))
    throw inputError("cannot read mesh {}: not a file", file.string());
  const std::set<std::string> known = {".dae", ".glb", ".gltf", ".obj", ".ply", ".stl"};
  if (!known.contains(extensionOf(file)))
    throw inputError("cannot read mesh {}: its name must end in .dae, .glb, .gltf, .obj, .ply or .stl", file.string());
}

/// A group of a scene: polygons of one material, in one place.
struct Group {
  PolygonMesh polygons;
  Eigen::Affine3d T_world_group = Eigen::Affine3d::Identity();
  std::string material;  ///< as the file calls it; empty: none
};

/// COLLADA's index lists must be whole numbers: on others assimp never comes back.
void checkColladaIndices(const std::filesystem::path& file) {
  const std::string text = readFile(file);
  for (const char* tag : {"<p>", "<v>", "<vcount>"})
    for (std::size_t at = text.find(tag); at != std::string::npos; at = text.find(tag, at)) {
      at += std::strlen(tag);
      const std::size_t end = std::min(text.find_first_not_of("-0123456789 \t\r\n", at), text.size());
      if (end == text.size() || text[end] != '<')
        throw inputError("cannot read mesh {}: byte {} within {} is no index", file.string(), end, tag);
      at = end;
    }
}

PolygonMesh polygonsOf(const aiMesh& mesh) {
  PolygonMesh polygons;
  polygons.vertices.reserve(mesh.mNumVertices);
  for (unsigned i = 0; i < mesh.mNumVertices; ++i)
    polygons.vertices.emplace_back(mesh.mVertices[i].x, mesh.mVertices[i].y, mesh.mVertices[i].z);
  for (unsigned i = 0; i < mesh.mNumFaces; ++i) {
    const aiFace& face = mesh.mFaces[i];
    polygons.corners.insert(polygons.corners.end(), face.mIndices, face.mIndices + face.mNumIndices);
    polygons.face_end.push_back(polygons.corners.size());
  }
  return polygons;
}

Eigen::Affine3d fromAssimp(const aiMatrix4x4& m) {
  Eigen::Matrix4d T;
  T << m.a1, m.a2, m.a3, m.a4, m.b1, m.b2, m.b3, m.b4, m.c1, m.c2, m.c3, m.c4, 0, 0, 0, 1;
  return Eigen::Affine3d(T);
}

/// The meshes of a scene's nodes, depth first.
std::vector<Group> groupsOf(const aiScene& scene, const Eigen::Affine3d& T_world_file) {
  std::vector<Group> groups;
  std::vector<std::pair<const aiNode*, Eigen::Affine3d>> open = {{scene.mRootNode, T_world_file}};
  while (!open.empty()) {
    const auto [node, T_world_parent] = open.back();
    open.pop_back();
    const Eigen::Affine3d T_world_node = T_world_parent * fromAssimp(node->mTransformation);
    for (unsigned m = 0; m < node->mNumMeshes; ++m) {
      const aiMesh& mesh = *scene.mMeshes[node->mMeshes[m]];
      std::string material =
          mesh.mMaterialIndex < scene.mNumMaterials ? scene.mMaterials[mesh.mMaterialIndex]->GetName().C_Str() : "";
      if (material == AI_DEFAULT_MATERIAL_NAME) material.clear();  // what assimp calls triangles without one
      groups.push_back({polygonsOf(mesh), T_world_node, std::move(material)});
    }
    for (unsigned c = node->mNumChildren; c > 0; --c) open.emplace_back(node->mChildren[c - 1], T_world_node);
  }
  return groups;
}

std::vector<Group> readGroups(const std::filesystem::path& file, const MeshFileOptions& options) {
  const std::string extension = extensionOf(file);
  // glTF is y up; assimp turns COLLADA so.
  const bool y_is_up = options.up == "y" ||
                       (options.up == "auto" && (extension == ".gltf" || extension == ".glb" || extension == ".dae"));
  Eigen::Affine3d T_world_file = Eigen::Affine3d::Identity();
  if (y_is_up) T_world_file.linear() = Eigen::AngleAxisd(M_PI / 2, Vector3d::UnitX()).toRotationMatrix();
  T_world_file.linear() *= options.scale;
  if (extension == ".ply") return {{readPlyMesh(file), T_world_file, ""}};
  if (extension == ".dae") checkColladaIndices(file);
  Assimp::Importer importer;
  importer.SetPropertyBool(AI_CONFIG_IMPORT_COLLADA_IGNORE_UP_DIRECTION, options.up != "auto");
  try {
    const aiScene* scene = importer.ReadFile(file.string(), 0);
    if (scene != nullptr && scene->mRootNode != nullptr) return groupsOf(*scene, T_world_file);
  } catch (const std::exception& e) {
    throw inputError("cannot read mesh {}: {}", file.string(), e.what());
  }
  throw inputError("cannot read mesh {}: {}", file.string(), importer.GetErrorString());
}

/// Joins at most ten names.
std::string listed(const std::set<std::string>& names) {
  std::string text;
  std::size_t i = 0;
  for (const std::string& name : names) {
    if (i == 10) return text + fmt::format(" and {} more", names.size() - i);
    text += (i++ == 0 ? "'" : ", '") + name + "'";
  }
  return text;
}

/// Material of each group.
std::vector<std::uint16_t> materialsOf(const std::vector<Group>& groups, const std::string& file,
                                       const MeshFileOptions& options, mrpt::system::COutputLogger& log) {
  const std::uint16_t fallback = materialIndex(options.material);
  std::vector<std::uint16_t> result;
  std::set<std::string> unknown;
  for (const Group& group : groups) {
    const int like = group.material.empty() ? -1 : materialLike(group.material);
    if (!group.material.empty() && like < 0) unknown.insert(group.material);
    result.push_back(like < 0 ? fallback : static_cast<std::uint16_t>(like));
  }
  if (unknown.empty()) return result;
  if (options.strict_materials) {
    std::vector<std::string> known;
    for (const Material& material : materials()) known.push_back(material.name);
    throw usageError("mesh {}: unknown materials {}{}", file, listed(unknown), didYouMean(*unknown.begin(), known));
  }
  logWarn(log, "mesh {}: '{}' stands for the unknown materials {}", file, options.material, listed(unknown));
  return result;
}

/// What was left out.
struct Dropped {
  std::size_t points_and_lines = 0, bad_indices = 0, not_finite = 0, without_area = 0, too_many_corners = 0;
};

/// Puts the triangles of groups into one mesh.
class Collector {
 public:
  void add(const Group& group, std::uint16_t material) {
    constexpr int kLastInstance = 65535;
    material_ = material;
    instance_ = static_cast<std::uint16_t>(std::min(instance_ + 1, kLastInstance));
    mirrored_ = group.T_world_group.linear().determinant() < 0;
    index_of_.assign(group.polygons.vertices.size(), kNotYet);
    for (std::size_t i = 0; i < group.polygons.faces(); ++i) addFace(group, group.polygons.face(i));
  }
  const Dropped& dropped() const { return dropped_; }
  Mesh take() { return std::move(mesh_); }

 private:
  static constexpr std::uint32_t kNotYet = 0xFFFFFFFF;

  void addFace(const Group& group, std::span<const std::uint32_t> face) {
    constexpr std::size_t kMostCorners = 10'000;
    const auto& vertices = group.polygons.vertices;
    if (face.size() < 3) return static_cast<void>(++dropped_.points_and_lines);
    if (face.size() > kMostCorners) return static_cast<void>(++dropped_.too_many_corners);
    corners_.clear();
    for (const std::uint32_t index : face) {
      if (index >= vertices.size()) return static_cast<void>(++dropped_.bad_indices);
      corners_.push_back(group.T_world_group * vertices[index]);
      if (!corners_.back().cast<float>().allFinite()) return static_cast<void>(++dropped_.not_finite);
    }
    if (face.size() == 3) return addTriangle(face, {0, 1, 2});
    for (const auto& triangle : cutPolygon(corners_)) addTriangle(face, triangle);
  }

  /// @param which of the corners of the face.
  void addTriangle(std::span<const std::uint32_t> face, std::array<std::uint32_t, 3> which) {
    if (!hasArea(corners_[which[0]].cast<float>(), corners_[which[1]].cast<float>(), corners_[which[2]].cast<float>()))
      return static_cast<void>(++dropped_.without_area);
    if (mirrored_) std::swap(which[1], which[2]);
    std::array<std::uint32_t, 3> triangle;
    for (std::size_t k = 0; k < 3; ++k) {
      std::uint32_t& index = index_of_[face[which[k]]];
      if (index == kNotYet) {
        index = static_cast<std::uint32_t>(mesh_.vertices.size());
        mesh_.vertices.emplace_back(corners_[which[k]].cast<float>());
      }
      triangle[k] = index;
    }
    mesh_.triangles.push_back(triangle);
    mesh_.material.push_back(material_);
    mesh_.instance.push_back(instance_);
  }

  /// Not a line, within single precision.
  static bool hasArea(const Vector3f& p, const Vector3f& q, const Vector3f& r) {
    const Vector3d a = (q - p).cast<double>(), b = (r - p).cast<double>();
    return a.cross(b).norm() > 1e-7 * std::max({a.squaredNorm(), b.squaredNorm(), (a - b).squaredNorm()});
  }

  Dropped dropped_;
  Mesh mesh_;
  std::uint16_t material_ = 0, instance_ = 0;
  bool mirrored_ = false;
  std::vector<std::uint32_t> index_of_;  ///< in mesh_, of each vertex of the group
  std::vector<Vector3d> corners_;        ///< of the face at hand, world
};

void reportDropped(const Dropped& dropped, const Mesh& mesh, const std::string& file,
                   mrpt::system::COutputLogger& log) {
  std::string text;
  const auto part = [&text](std::size_t n, const char* what) {
    if (n > 0) text += fmt::format("{}{} {}", text.empty() ? "" : ", ", n, what);
  };
  part(dropped.not_finite, "with corners that are not finite numbers");
  part(dropped.bad_indices, "that point to vertices that do not exist");
  part(dropped.without_area, "without an area");
  part(dropped.points_and_lines, "points or lines");
  part(dropped.too_many_corners, "with more than 10000 corners");
  if (mesh.empty()) throw inputError("mesh {} has no triangles{}", file, text.empty() ? "" : ", only faces: " + text);
  if (!text.empty()) logWarn(log, "mesh {}: faces left out: {}", file, text);
}

void reportSize(const Mesh& mesh, const std::string& file, mrpt::system::COutputLogger& log) {
  const Eigen::AlignedBox3f box = mesh.bounds();
  const double diagonal = box.diagonal().cast<double>().norm();
  constexpr double kSmallest = 2, kLargest = 100e3, kPreciseWithin = 32768;  // [m]; a float resolves 4 mm there
  if (diagonal < kSmallest)
    logWarn(log, "mesh {} is only {:.3g} m across: if its unit is the kilometre, set scale: 1000", file, diagonal);
  if (diagonal > kLargest)
    logWarn(log, "mesh {} is {:.0f} km across: if its unit is the millimetre, set scale: 0.001", file, diagonal / 1e3);
  const double farthest =
      static_cast<double>(std::max(box.min().cwiseAbs().maxCoeff(), box.max().cwiseAbs().maxCoeff()));
  if (farthest > kPreciseWithin && diagonal <= kLargest)
    logWarn(log, "mesh {} lies {:.0f} km from the origin, where single precision resolves {:.0f} mm: move it there",
            file, farthest / 1e3, std::ldexp(1e3, std::ilogb(farthest) - 23));
}

}  // namespace

void MeshFileOptions::describe(ParamVisitor& v) {
  v.field("up", up, "axis of the file that points up; auto: as glTF and COLLADA say, else z", {"auto", "z", "y"});
  v.field("scale", scale, "metres per unit of the file", 1e-6, 1e6);
  v.field("material", material, "for triangles whose material is not known");
  v.field("strict_materials", strict_materials, "refuse files with materials that are not known");
}

Mesh readMesh(const std::filesystem::path& file, const MeshFileOptions& options, mrpt::system::COutputLogger& log) {
  checkFile(file);
  const std::vector<Group> groups = readGroups(file, options);
  const std::vector<std::uint16_t> material = materialsOf(groups, file.string(), options, log);
  Collector collector;
  for (std::size_t i = 0; i < groups.size(); ++i) collector.add(groups[i], material[i]);
  const Dropped dropped = collector.dropped();
  Mesh mesh = collector.take();
  reportDropped(dropped, mesh, file.string(), log);
  reportSize(mesh, file.string(), log);
  return mesh;
}

}  // namespace scslam::sim
