// The world in Embree: rays in, surfaces out. The only file that includes Embree (through embree.h).
#pragma once
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "sim/embree.h"
#include "sim/world.h"

namespace scslam::sim {

/// What a ray met.
struct Surface {
  const Material* material = nullptr;
  std::uint16_t material_index = 0;
  std::uint16_t label = 0;  ///< SemanticKITTI class, the moving one for actors
  std::uint16_t instance = 0;
  bool actor = false;  ///< of what moves about, not of the standing world
};

struct Hit {
  double range = 0;        ///< [m] for a unit direction
  Eigen::Vector3d normal;  ///< unit, world frame, against the ray
  Surface surface;
};

/// Sixteen rays at once. Fill org, dir, tnear, tfar, time; trace() does the rest. tfar is the range; geomID says hit.
using RayPacket = RTCRayHit16;

class RayScene {
 public:
  /// Builds the acceleration structure with RTC_SCENE_FLAG_ROBUST: hits do not depend on packing or threads.
  explicit RayScene(const World& world);
  ~RayScene();
  RayScene(const RayScene&) = delete;
  RayScene& operator=(const RayScene&) = delete;

  /// Puts the actors where they are between t0 and t1 [s]; a ray's time 0 … 1 lies between. No rebuild of what stands.
  /// Actors that would run into the robot are not there meanwhile: they do not see it coming.
  void poseActors(double t0, double t1, const std::optional<Eigen::Vector3d>& robot = std::nullopt);

  /// Traces the rays whose bit of `active` is set. Coherent rays (a tile of a scan) are fastest. Thread-safe.
  /// Origins and directions must be finite and time within 0 … 1: Debian's Embree aborts otherwise.
  void trace(RayPacket& rays, std::uint32_t active = 0xFFFF) const {
    alignas(64) int valid[16];
    for (int i = 0; i < 16; ++i) {
      valid[i] = (active >> i & 1U) != 0 ? -1 : 0;
      if (valid[i] == 0) blank(rays, i);
    }
    intersect16(valid, scene_, rays);
  }
  /// One ray. @param time 0 … 1 between the instants of poseActors().
  std::optional<Hit> first(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double max_range,
                           double time = 0) const;
  /// Is there nothing between a and b, but for the last and first 5 cm?
  bool sees(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double time = 0) const;

  /// The surface of ray i of a packet that hit.
  Surface surface(const RayPacket& rays, int i) const;
  /// Unit normal in the world, against the ray.
  Eigen::Vector3f normal(const RayPacket& rays, int i) const;
  /// Of each ray (of unit length) that hit, the cosine of the angle to the normal: 0 … 1; of the others, anything.
  void incidence(const RayPacket& rays, float (&cosine)[16]) const;
  std::uint16_t materialOf(const RayPacket& rays, int i) const {
    return meshes_[rays.hit.instID[0][i] == RTC_INVALID_GEOMETRY_ID ? 0 : rays.hit.instID[0][i]]
        ->material[rays.hit.primID[i]];
  }

 private:
  /// Normal in the world, of any length and sign.
  Eigen::Vector3f across(const RayPacket& rays, int i) const;
  /// A ray without length. Where the processor has no vectors of 16, Embree looks at the rays of a packet that are not
  /// valid, too, and aborts when there is garbage in them.
  static void blank(RayPacket& rays, int i) {
    rays.ray.org_x[i] = rays.ray.org_y[i] = rays.ray.org_z[i] = 0;
    rays.ray.dir_x[i] = rays.ray.dir_y[i] = 0, rays.ray.dir_z[i] = 1;
    rays.ray.tnear[i] = 0, rays.ray.tfar[i] = -1, rays.ray.time[i] = 0;
    rays.ray.mask[i] = rays.ray.flags[i] = rays.ray.id[i] = 0;
    rays.hit.geomID[i] = rays.hit.instID[0][i] = RTC_INVALID_GEOMETRY_ID;
  }

  const World& world_;
  const Material* materials_;  ///< materials(), without the check that they are made
  RTCDevice device_ = nullptr;
  RTCScene scene_ = nullptr;
  std::vector<RTCScene> parts_;  ///< per mesh, when there are actors
  std::vector<RTCGeometry> instances_;
  std::vector<const Mesh*> meshes_;                       ///< by instance number; 0 = what stands still
  std::vector<std::array<Eigen::Matrix3f, 2>> rotation_;  ///< of each instance at t0 and t1
};

}  // namespace scslam::sim
