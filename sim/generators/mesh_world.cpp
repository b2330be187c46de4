// A world that somebody else made: a mesh file, and nothing that moves.
#include "sim/mesh_file.h"
#include "sim/world_generator.h"

namespace scslam::sim {
namespace {

class MeshWorld : public WorldGenerator {
 public:
  struct Params : ParamSetOf<Params> {
    std::string file;
    MeshFileOptions options;
    void describe(ParamVisitor& v) override {
      v.field("file", file, "mesh file: .dae, .glb, .gltf, .obj, .ply or .stl");
      options.describe(v);
    }
  };

  MeshWorld(const Params& params, const PluginContext& context) : params_(params), log_(context.log) {}

  World generate(std::uint64_t) const override {
    if (params_.file.empty()) throw usageError("the world 'mesh' needs a file: world.mesh.file");
    World world;
    world.name = std::filesystem::path(params_.file).stem().string();
    world.mesh = readMesh(params_.file, params_.options, log_);
    return world;
  }

 private:
  Params params_;
  mrpt::system::COutputLogger& log_;
};

}  // namespace

SCSLAM_REGISTER(WorldGenerator, MeshWorld, "mesh", "a mesh file (COLLADA, glTF, OBJ, PLY, STL) that stands still")

}  // namespace scslam::sim
