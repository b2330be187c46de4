#include "sim/mesh_file.h"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <cstring>
#include <fstream>
#include <set>

#include "scslam/core/counter_random.h"
#include "sim/material.h"
#include "sim/world_generator.h"
#include "support/support.h"

namespace scslam::sim {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::Not;
namespace fs = std::filesystem;

/// Writes files for one test and reads them back, keeping the warnings.
class MeshFile : public ::testing::Test {
 protected:
  MeshFile() : log_(mrpt::system::LVL_ERROR) {
    log_.logRegisterCallback(
        [this](std::string_view text, mrpt::system::VerbosityLevel level, std::string_view, mrpt::Clock::time_point) {
          if (level >= mrpt::system::LVL_WARN) warnings_ += std::string(text) + "\n";
        });
  }
  fs::path write(const std::string& name, const std::string& content) const {
    std::ofstream(folder_ / name, std::ios::binary) << content;
    return folder_ / name;
  }
  Mesh read(const fs::path& file, const MeshFileOptions& options = {}) {
    warnings_.clear();
    return readMesh(file, options, log_);
  }
  /// The one line and the exit code of the error.
  void expectError(const fs::path& file, ExitCode code, const std::string& text, const MeshFileOptions& options = {}) {
    try {
      read(file, options);
      ADD_FAILURE() << "no error for " << file;
    } catch (const Error& e) {
      EXPECT_EQ(e.code(), code) << e.what();
      EXPECT_THAT(e.what(), HasSubstr(text));
      EXPECT_THAT(e.what(), HasSubstr(file.filename().string()));
    }
  }

  fs::path folder_ = test::freshFolder();
  Log log_;
  std::string warnings_;
};

std::uint16_t materialAt(const Mesh& mesh, std::size_t triangle) { return mesh.material.at(triangle); }
const std::string& materialName(const Mesh& mesh, std::size_t triangle) {
  return materials().at(materialAt(mesh, triangle)).name;
}
double area(const Mesh& mesh) {
  double sum = 0;
  for (const auto& t : mesh.triangles)
    sum += 0.5 * static_cast<double>((mesh.vertices.at(t[1]) - mesh.vertices.at(t[0]))
                                         .cross(mesh.vertices.at(t[2]) - mesh.vertices.at(t[0]))
                                         .norm());
  return sum;
}
Eigen::Vector3f normal(const Mesh& mesh, std::size_t i) {
  const auto& t = mesh.triangles.at(i);
  return (mesh.vertices[t[1]] - mesh.vertices[t[0]]).cross(mesh.vertices[t[2]] - mesh.vertices[t[0]]).normalized();
}

constexpr const char* kSquare = "v 0 0 0\nv 4 0 0\nv 4 3 0\nv 0 3 0\n";

TEST_F(MeshFile, ObjGroupsCarryMaterialsAndInstances) {
  const Mesh mesh = read(write("town.obj", std::string(kSquare) + "o ground\nusemtl Asphalt_old.001\nf 1 2 3 4\n"
                                                                  "o wall\nusemtl red_brick\nf 1 2 3\nf 1 3 4\n"));
  ASSERT_EQ(mesh.size(), 4U);
  EXPECT_EQ(materialName(mesh, 0), "asphalt");
  EXPECT_EQ(materialName(mesh, 1), "asphalt");
  EXPECT_EQ(materialName(mesh, 3), "brick");
  EXPECT_EQ(mesh.instance, (std::vector<std::uint16_t>{1, 1, 2, 2}));
  EXPECT_NEAR(area(mesh), 24, 1e-5);
  EXPECT_EQ(normal(mesh, 0), Eigen::Vector3f(0, 0, 1));
  EXPECT_THAT(warnings_, IsEmpty());
}

TEST_F(MeshFile, PolygonsAreCutAlsoWhenTheyAreHollow) {
  // An L of area 7 whose first corner sees not all of it.
  const Mesh mesh =
      read(write("l.obj", "v 4 1 0\nv 1 1 0\nv 1 4 0\nv 0 4 0\nv 0 0 0\nv 4 0 0\nusemtl wood\nf 1 2 3 4 5 6\n"));
  EXPECT_EQ(mesh.size(), 4U);
  EXPECT_NEAR(area(mesh), 7, 1e-5);
}

TEST_F(MeshFile, UnknownMaterialsAreNamedAndReplaced) {
  const auto file = write("a.obj", std::string(kSquare) + "usemtl kryptonite\nf 1 2 3\nusemtl lead_7\nf 1 3 4\n");
  EXPECT_EQ(materialName(read(file), 0), "default");
  EXPECT_THAT(warnings_, HasSubstr("'default' stands for the unknown materials 'kryptonite', 'lead_7'"));
  MeshFileOptions options;
  options.material = "concrete";
  EXPECT_EQ(materialName(read(file, options), 1), "concrete");
  options.strict_materials = true;
  expectError(file, ExitCode::kUsage, "unknown materials 'kryptonite', 'lead_7'", options);
  options.material = "concret";
  EXPECT_THROW(read(write("plain.obj", std::string(kSquare) + "f 1 2 3\n"), options), Error);
}

TEST_F(MeshFile, ScaleAndUpAxisApply) {
  const auto file = write("y_up.obj", "v 0 0 0\nv 4000 0 0\nv 4000 3000 0\nusemtl brick\nf 1 2 3\n");
  MeshFileOptions options;
  options.up = "y", options.scale = 0.001;
  const auto box = read(file, options).bounds();
  EXPECT_LT((box.max() - Eigen::Vector3f(4, 0, 3)).norm(), 1e-5F);
  EXPECT_LT(box.min().norm(), 1e-5F);
  options.up = "auto";
  EXPECT_LT((read(file, options).bounds().max() - Eigen::Vector3f(4, 3, 0)).norm(), 1e-5F);
}

std::string plyHeader(const std::string& format, int vertices, int faces) {
  return "ply\nformat " + format + " 1.0\nelement vertex " + std::to_string(vertices) +
         "\nproperty float x\nproperty float y\nproperty float z\nelement face " + std::to_string(faces) +
         "\nproperty list uchar int vertex_indices\nend_header\n";
}

TEST_F(MeshFile, PlyAsciiAndBinaryGiveTheSameMesh) {
  const float xyz[] = {0, 0, 0, 4, 0, 0, 4, 3, 0, 0, 3, 1.5F};
  const std::int32_t faces[2][3] = {{0, 1, 2}, {0, 2, 3}};
  std::string binary = plyHeader("binary_little_endian", 4, 2);
  binary.append(reinterpret_cast<const char*>(xyz), sizeof xyz);
  for (const auto& face : faces) binary += '\3', binary.append(reinterpret_cast<const char*>(face), sizeof face);
  const Mesh from_binary = read(write("b.ply", binary));
  const Mesh from_ascii =
      read(write("a.ply", plyHeader("ascii", 4, 2) + "0 0 0\n4 0 0\n4 3 0\n0 3 1.5\n3 0 1 2\n3 0 2 3\n"));
  ASSERT_EQ(from_binary.size(), 2U);
  EXPECT_EQ(from_binary.triangles, from_ascii.triangles);
  EXPECT_EQ(from_binary.vertices, from_ascii.vertices);
  EXPECT_EQ(from_binary.vertices.back(), Eigen::Vector3f(0, 3, 1.5F));
  EXPECT_THAT(warnings_, IsEmpty()) << "a format without materials needs no warning";
  EXPECT_EQ(materialAt(from_ascii, 0), 0);
}

TEST_F(MeshFile, PlyPropertiesOfAnyTypeOrderAndByteOrderAreRead) {
  // Big-endian; doubles; other properties and elements around those that count; int32 list length; uint16 indices.
  std::string text =
      "ply\r\nformat binary_big_endian 1.0\r\ncomment by hand\r\nelement sensor 1\r\nproperty list uchar uchar name\r\n"
      "element vertex 3\r\nproperty uchar red\r\nproperty double z\r\nproperty double x\r\nproperty double y\r\n"
      "element face 1\r\nproperty short flags\r\nproperty list int ushort vertex_index\r\nend_header\r\n";
  const auto put = [&text](auto value) {
    char bytes[sizeof value];
    std::memcpy(bytes, &value, sizeof value);
    std::reverse(bytes, bytes + sizeof value);
    text.append(bytes, sizeof value);
  };
  put(std::uint8_t{2}), put(std::uint8_t{'o'}), put(std::uint8_t{'s'});
  for (const auto& [x, y, z] : {std::array{0.0, 0.0, 5.0}, {4.0, 0.0, 5.0}, {4.0, 3.0, 6.0}})
    put(std::uint8_t{200}), put(z), put(x), put(y);
  put(std::int16_t{-1}), put(std::int32_t{3});
  for (const std::uint16_t index : {0, 1, 2}) put(index);
  const Mesh mesh = read(write("a.ply", text));
  ASSERT_EQ(mesh.size(), 1U);
  EXPECT_EQ(mesh.vertices[2], Eigen::Vector3f(4, 3, 6));
}

TEST_F(MeshFile, FormatsWithoutMaterialsTakeTheOption) {
  MeshFileOptions options;
  options.material = "grass", options.strict_materials = true;
  EXPECT_EQ(materialName(read(write("a.ply", plyHeader("ascii", 3, 1) + "0 0 0\n4 0 0\n4 3 0\n3 0 1 2\n"), options), 0),
            "grass");
  EXPECT_EQ(materialName(read(write("a.obj", std::string(kSquare) + "f 1 2 3\n"), options), 0), "grass");
}

TEST_F(MeshFile, StlAsciiAndBinaryAreRead) {
  const std::string facet =
      "facet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 4 0 0\nvertex 0 3 0\nendloop\nendfacet\n";
  EXPECT_NEAR(area(read(write("a.stl", "solid wall\n" + facet + "endsolid wall\n"))), 6, 1e-6);
  EXPECT_THAT(warnings_, IsEmpty());
  std::string binary(80, ' ');
  const std::uint32_t n = 1;
  const float values[12] = {0, 0, 1, 0, 0, 0, 4, 0, 0, 0, 3, 0};
  binary.append(reinterpret_cast<const char*>(&n), 4);
  binary.append(reinterpret_cast<const char*>(values), sizeof values).append(2, '\0');
  EXPECT_NEAR(area(read(write("b.STL", binary))), 6, 1e-6);
}

/// One triangle (0 0 0) (4 0 0) (4 3 0) in a node that is moved by (0, 0, 10) and scaled by `scale`.
std::string gltf(const std::string& scale) {
  // Base64 of the nine floats.
  return R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
    "nodes":[{"translation":[0,0,10],"children":[1]},{"mesh":0,"scale":)" +
         scale + R"(}],
    "materials":[{"name":"Glass pane"}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0},"material":0}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3","min":[0,0,0],"max":[4,3,0]}],
    "bufferViews":[{"buffer":0,"byteLength":36}],
    "buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAQAAAAAAAAAAAAACAQAAAQEAAAAAA"}]})";
}

TEST_F(MeshFile, GltfIsYUpAndItsNodesMoveMeshes) {
  const Mesh mesh = read(write("a.gltf", gltf("[1,1,1]")));
  ASSERT_EQ(mesh.size(), 1U);
  EXPECT_EQ(materialName(mesh, 0), "glass");
  // (x, y, z) of glTF is (x, -z, y) here.
  EXPECT_LT((mesh.bounds().min() - Eigen::Vector3f(0, -10, 0)).norm(), 1e-5F);
  EXPECT_LT((mesh.bounds().max() - Eigen::Vector3f(4, -10, 3)).norm(), 1e-5F);
  EXPECT_LT((normal(mesh, 0) - Eigen::Vector3f(0, -1, 0)).norm(), 1e-5F);
}

TEST_F(MeshFile, MirroredNodesKeepTheOutsideOutside) {
  const Mesh mesh = read(write("a.gltf", gltf("[-1,1,1]")));
  EXPECT_LT((mesh.bounds().min() - Eigen::Vector3f(-4, -10, 0)).norm(), 1e-5F);
  EXPECT_LT((normal(mesh, 0) - Eigen::Vector3f(0, -1, 0)).norm(), 1e-5F);
}

std::string collada(const std::string& asset) {
  return R"(<?xml version="1.0" encoding="utf-8"?>
<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema" version="1.4.1"><asset>)" +
         asset + R"(</asset>
<library_geometries><geometry id="g" name="g"><mesh><source id="p"><float_array id="pa" count="9">0 0 0 400 0 0 400 0 300
</float_array><technique_common><accessor source="#pa" count="3" stride="3"><param name="X" type="float"/>
<param name="Y" type="float"/><param name="Z" type="float"/></accessor></technique_common></source>
<vertices id="v"><input semantic="POSITION" source="#p"/></vertices>
<triangles count="1"><input semantic="VERTEX" source="#v" offset="0"/><p>0 1 2</p></triangles></mesh></geometry>
</library_geometries><library_visual_scenes><visual_scene id="s"><node id="n"><instance_geometry url="#g"/></node>
</visual_scene></library_visual_scenes><scene><instance_visual_scene url="#s"/></scene></COLLADA>)";
}

TEST_F(MeshFile, ColladaStatesItsUnitAndUpAxis) {
  const std::string cm = R"(<unit meter="0.01" name="centimeter"/>)";
  EXPECT_LT(
      (read(write("z.dae", collada(cm + "<up_axis>Z_UP</up_axis>"))).bounds().max() - Eigen::Vector3f(4, 0, 3)).norm(),
      1e-5F);
  const auto y_up = write("y.dae", collada(cm + "<up_axis>Y_UP</up_axis>"));
  EXPECT_LT((read(y_up).bounds().min() - Eigen::Vector3f(0, -3, 0)).norm(), 1e-5F);
  MeshFileOptions options;
  options.up = "z";  // whatever the file says
  EXPECT_LT((read(y_up, options).bounds().max() - Eigen::Vector3f(4, 0, 3)).norm(), 1e-5F);
}

TEST_F(MeshFile, FilesThatCannotBeReadAreInputErrors) {
  expectError(folder_ / "none.ply", ExitCode::kInput, "no such file");
  fs::create_directories(folder_ / "folder.ply");
  expectError(folder_ / "folder.ply", ExitCode::kInput, "not a file");
  expectError(write("a.blend", "x"), ExitCode::kInput, "must end in .dae");
  expectError(write("empty.obj", ""), ExitCode::kInput, "cannot read mesh");
  for (const char* name : {"text.ply", "text.stl", "text.gltf", "text.glb", "text.dae", "text.obj"})
    expectError(write(name, "this is no mesh, however long it may be\n"), ExitCode::kInput, "mesh");
  std::string noise;
  RandomSequence random(CounterRandom(1, RandomStream::kFaults));
  for (int i = 0; i < 4000; ++i) noise += static_cast<char>(random.below(256));
  for (const char* name : {"noise.ply", "noise.stl", "noise.gltf", "noise.glb", "noise.dae", "noise.obj"})
    expectError(write(name, noise), ExitCode::kInput, "mesh");
}

TEST_F(MeshFile, TruncatedBinaryPlyIsAnInputErrorAtAnyLength) {
  std::string whole = plyHeader("binary_little_endian", 30, 20);
  for (int i = 0; i < 30; ++i) {
    const float p[3] = {static_cast<float>(i), static_cast<float>(i * i % 7), 1};
    whole.append(reinterpret_cast<const char*>(p), sizeof p);
  }
  for (std::int32_t i = 0; i < 20; ++i) {
    const std::int32_t face[3] = {i, i + 1, i + 2};
    whole += '\3', whole.append(reinterpret_cast<const char*>(face), sizeof face);
  }
  EXPECT_EQ(read(write("whole.ply", whole)).size(), 20U);
  for (std::size_t length = 4; length < whole.size(); ++length) {
    const auto file = write("cut.ply", whole.substr(0, length));
    EXPECT_THROW(read(file), Error) << length << " of " << whole.size() << " bytes";
  }
}

TEST_F(MeshFile, FacesThatAreNoTrianglesAreLeftOutAndCounted) {
  const Mesh mesh =
      read(write("a.ply", plyHeader("ascii", 6, 7) + "0 0 0\n4 0 0\n4 3 0\nnan 0 0\n0 inf 0\n2 0 0\n"
                                                     "3 0 1 2\n3 0 1 3\n3 4 1 2\n3 0 1 77\n3 0 1 1\n3 0 5 1\n2 0 1\n"));
  EXPECT_EQ(mesh.size(), 1U);
  EXPECT_EQ(mesh.vertices.size(), 3U) << "vertices that no triangle uses are not kept";
  EXPECT_THAT(warnings_, HasSubstr("2 with corners that are not finite"));
  EXPECT_THAT(warnings_, HasSubstr("1 that point to vertices that do not exist"));
  EXPECT_THAT(warnings_, HasSubstr("2 without an area"));
  EXPECT_THAT(warnings_, HasSubstr("1 points or lines"));
}

TEST_F(MeshFile, NoTriangleAtAllIsAnInputError) {
  expectError(write("nan.ply", plyHeader("ascii", 3, 1) + "nan 0 0\n4 0 0\n4 3 0\n3 0 1 2\n"), ExitCode::kInput,
              "no triangles, only faces: 1 with corners that are not finite");
  expectError(write("flat.ply", plyHeader("ascii", 3, 1) + "0 0 0\n4 0 0\n2 0 0\n3 0 1 2\n"), ExitCode::kInput,
              "1 without an area");
  expectError(write("cloud.ply", plyHeader("ascii", 3, 0) + "0 0 0\n4 0 0\n2 0 0\n"), ExitCode::kInput, "mesh");
}

TEST_F(MeshFile, SizesThatLookLikeAnotherUnitAreWarnedOf) {
  const auto sized = [this](const std::string& size) {
    return read(write("a.obj", "v 0 0 0\nv " + size + " 0 0\nv 0 " + size + " 0\nf 1 2 3\n"));
  };
  sized("0.5");
  EXPECT_THAT(warnings_, HasSubstr("scale: 1000"));
  sized("500000");
  EXPECT_THAT(warnings_, HasSubstr("scale: 0.001"));
  sized("300");
  EXPECT_THAT(warnings_, IsEmpty());
}

TEST_F(MeshFile, CoordinatesFarFromTheOriginAreWarnedOf) {
  read(write("utm.obj", "v 691000 5334000 500\nv 691100 5334000 500\nv 691000 5334100 500\nf 1 2 3\n"));
  EXPECT_THAT(warnings_, HasSubstr("lies 5334 km from the origin, where single precision resolves 500 mm"));
}

TEST_F(MeshFile, IsAWorldByName) {
  const auto file = write("yard.obj", std::string(kSquare) + "usemtl paving\nf 1 2 3 4\n");
  const auto& entry = Registry<WorldGenerator>::instance().find("mesh");
  const auto params = entry.defaults();
  loadYaml(*params, "file: " + file.string() + "\nscale: 2\nmaterial: grass", "test");
  const World world = entry.create(*params, test::context())->generate(1);
  EXPECT_EQ(world.name, "yard");
  EXPECT_EQ(world.mesh.size(), 2U);
  EXPECT_NEAR(area(world.mesh), 48, 1e-4);
  EXPECT_TRUE(world.actors.empty());
  EXPECT_THROW(entry.create(*entry.defaults(), test::context())->generate(1), Error) << "no file";
  EXPECT_THROW(loadYaml(*params, "up: x", "test"), Error);
}

TEST_F(MeshFile, TownOfAHundredThousandTrianglesIsWhole) {
  const fs::path file = fs::path(SCSLAM_SOURCE_DIR) / "../shared/tools/city_100k.ply";
  if (!fs::exists(file)) GTEST_SKIP() << "no city_100k.ply beside the checkout";
  const auto begin = std::chrono::steady_clock::now();
  const Mesh mesh = read(file);
  RecordProperty(
      "milliseconds",
      static_cast<int>(std::chrono::duration<double, std::milli>(std::chrono::steady_clock::now() - begin).count()));
  EXPECT_EQ(mesh.size(), 99578U);
  EXPECT_THAT(warnings_, IsEmpty());
  EXPECT_NEAR(mesh.bounds().min().x(), -200, 1e-3);
  EXPECT_NEAR(mesh.bounds().max().z(), 28.1967, 1e-3);
}

TEST_F(MeshFile, WarehouseModelsStandUprightInMetres) {
  SCSLAM_NEEDS_DATA(folder, "meshes/aws_warehouse/models");
  const fs::path shelf =
      folder / "aws_robomaker_warehouse_ShelfF_01/meshes/aws_robomaker_warehouse_ShelfF_01_visual.DAE";
  const Mesh mesh = read(shelf);
  EXPECT_EQ(mesh.size(), 334U + 1572 + 1020);
  EXPECT_THAT(warnings_, HasSubstr("unknown materials"));
  const Eigen::Vector3f size = mesh.bounds().sizes();
  EXPECT_NEAR(size.z(), 6.525, 0.01) << "the shelf's height";
  EXPECT_NEAR(mesh.bounds().min().z(), 0, 0.01);
  EXPECT_NEAR(std::max(size.x(), size.y()), 18.05, 0.01);
  const std::set<std::uint16_t> groups(mesh.instance.begin(), mesh.instance.end());
  EXPECT_EQ(groups.size(), 3U);
}

}  // namespace
}  // namespace scslam::sim
