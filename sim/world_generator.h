// Procedural worlds: one file per kind in generators/, registered by name.
#pragma once
#include "scslam/core/registry.h"
#include "sim/world.h"

namespace scslam::sim {

/// Plug-in interface of sim/generators. Parameters come from the scenario's YAML (world.<name>: …).
class WorldGenerator {
 public:
  static constexpr const char* kKind = "world generator";
  virtual ~WorldGenerator() = default;
  /// The same seed gives the same world, to the bit. It has at least one route (world.h); each generator's file says
  /// which, where they start and which way they head. @throw usageError for parameters that make no world.
  virtual World generate(std::uint64_t seed) const = 0;
};

}  // namespace scslam::sim

namespace scslam {
SCSLAM_DECLARE_REGISTRY(sim::WorldGenerator);
}
