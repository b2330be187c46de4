#include "sim/ray_scene.h"

#include <pmmintrin.h>

#include "scslam/core/error.h"
#include "scslam/core/simd.h"

namespace scslam::sim {

namespace {

constexpr double kClear = 5;    ///< an actor nearer to the robot's origin than this would run into it [m]
constexpr double kAway = 5000;  ///< so far below the ground it is out of the way [m]

RTCGeometry triangleGeometry(RTCDevice device, const Mesh& mesh) {
  RTCGeometry geometry = rtcNewGeometry(device, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* vertices = static_cast<float*>(rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                                               3 * sizeof(float), mesh.vertices.size()));
  auto* triangles = static_cast<std::uint32_t*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(std::uint32_t), mesh.triangles.size()));
  for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
    for (int k = 0; k < 3; ++k) vertices[3 * i + static_cast<std::size_t>(k)] = mesh.vertices[i][k];
  for (std::size_t i = 0; i < mesh.triangles.size(); ++i)
    for (std::size_t k = 0; k < 3; ++k) triangles[3 * i + k] = mesh.triangles[i][k];
  rtcCommitGeometry(geometry);
  return geometry;
}

RTCScene newScene(RTCDevice device) {
  RTCScene scene = rtcNewScene(device);
  rtcSetSceneFlags(scene, RTC_SCENE_FLAG_ROBUST);
  rtcSetSceneBuildQuality(scene, RTC_BUILD_QUALITY_MEDIUM);
  return scene;
}

RTCScene sceneOf(RTCDevice device, const Mesh& mesh) {
  RTCScene scene = newScene(device);
  RTCGeometry geometry = triangleGeometry(device, mesh);
  rtcAttachGeometryByID(scene, geometry, 0);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene);
  return scene;
}

RTCQuaternionDecomposition decomposed(const Pose& T) {
  RTCQuaternionDecomposition q;
  rtcInitQuaternionDecomposition(&q);
  const Eigen::Quaternionf r(T.linear().cast<float>());
  const Eigen::Vector3f t = T.translation().cast<float>();
  rtcQuaternionDecompositionSetQuaternion(&q, r.w(), r.x(), r.y(), r.z());
  rtcQuaternionDecompositionSetTranslation(&q, t.x(), t.y(), t.z());
  return q;
}

/// Of what stands still.
SCSLAM_KERNEL
void cosines(const RayPacket& rays, float (&cosine)[16]) {
  const auto& h = rays.hit;
  for (int i = 0; i < 16; ++i) {
    const float along = h.Ng_x[i] * rays.ray.dir_x[i] + h.Ng_y[i] * rays.ray.dir_y[i] + h.Ng_z[i] * rays.ray.dir_z[i];
    cosine[i] = std::abs(along) / std::sqrt(h.Ng_x[i] * h.Ng_x[i] + h.Ng_y[i] * h.Ng_y[i] + h.Ng_z[i] * h.Ng_z[i]);
  }
}

}  // namespace

RayScene::RayScene(const World& world) : world_(world), materials_(materials().data()) {
  if (world.mesh.empty()) throw usageError("the world '{}' has no triangles", world.name);
  _MM_SET_FLUSH_ZERO_MODE(_MM_FLUSH_ZERO_ON);
  _MM_SET_DENORMALS_ZERO_MODE(_MM_DENORMALS_ZERO_ON);
  // Building the tree may use all threads: the tree is the same for any number of them. The thread sanitizer does not
  // see how Embree's threads wait for each other.
#ifdef __SANITIZE_THREAD__
  device_ = rtcNewDevice("threads=1");
#else
  device_ = rtcNewDevice("threads=0");
#endif
  if (device_ == nullptr) throw Error(ExitCode::kBug, "Embree gives no device");
  meshes_.push_back(&world.mesh);
  if (world.actors.empty()) {
    scene_ = sceneOf(device_, world.mesh);
    return;
  }
  for (const Actor& actor : world.actors) meshes_.push_back(&actor.mesh);
  scene_ = newScene(device_);
  for (std::size_t i = 0; i < meshes_.size(); ++i) {
    parts_.push_back(sceneOf(device_, *meshes_[i]));
    RTCGeometry instance = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_INSTANCE);
    rtcSetGeometryInstancedScene(instance, parts_[i]);
    if (i > 0) rtcSetGeometryTimeStepCount(instance, 2);
    rtcAttachGeometryByID(scene_, instance, static_cast<unsigned>(i));
    rtcCommitGeometry(instance);
    instances_.push_back(instance);
  }
  rotation_.resize(meshes_.size());
  rotation_[0].fill(Eigen::Matrix3f::Identity());
  poseActors(0, 0);
}

RayScene::~RayScene() {
  for (RTCGeometry instance : instances_) rtcReleaseGeometry(instance);
  if (scene_ != nullptr) rtcReleaseScene(scene_);
  for (RTCScene part : parts_) rtcReleaseScene(part);
  if (device_ != nullptr) rtcReleaseDevice(device_);
}

void RayScene::poseActors(double t0, double t1, const std::optional<Eigen::Vector3d>& robot) {
  if (world_.actors.empty()) return;
  for (std::size_t i = 0; i < world_.actors.size(); ++i) {
    std::array<Pose, 2> T = {world_.actors[i].at(t0), world_.actors[i].at(t1)};
    const bool meets =
        robot && ((T[0].translation() - *robot).norm() < kClear || (T[1].translation() - *robot).norm() < kClear);
    if (meets) T[0].translation().z() -= kAway, T[1].translation().z() -= kAway;
    // One that jumps (back to the start of its path) is shown at its new place for the whole sweep.
    const bool jumps = (T[1].translation() - T[0].translation()).norm() > 5 + 60 * (t1 - t0);
    for (unsigned k = 0; k < 2; ++k) {
      const Pose& T_k = jumps ? T[1] : T[k];
      const auto q = decomposed(T_k);
      rtcSetGeometryTransformQuaternion(instances_[i + 1], k, &q);
      rotation_[i + 1][k] = T_k.linear().cast<float>();
    }
    rtcCommitGeometry(instances_[i + 1]);
  }
  rtcCommitScene(scene_);
}

Surface RayScene::surface(const RayPacket& rays, int i) const {
  const unsigned part = rays.hit.instID[0][i] == RTC_INVALID_GEOMETRY_ID ? 0 : rays.hit.instID[0][i];
  const std::uint16_t material = meshes_[part]->material[rays.hit.primID[i]];
  const Material& made_of = materials_[material];
  if (part == 0)
    return {&made_of, material, static_cast<std::uint16_t>(made_of.label), meshes_[0]->instance[rays.hit.primID[i]]};
  const Actor& actor = world_.actors[part - 1];
  const bool moves = actor.speed_mps > 0 && actor.path.size() > 1;
  return {&made_of, material, moves ? movingLabel(actor.label) : static_cast<std::uint16_t>(actor.label),
          actor.instance, true};
}

Eigen::Vector3f RayScene::across(const RayPacket& rays, int i) const {
  const Eigen::Vector3f n(rays.hit.Ng_x[i], rays.hit.Ng_y[i], rays.hit.Ng_z[i]);
  const unsigned part = rays.hit.instID[0][i];
  if (part == RTC_INVALID_GEOMETRY_ID || part == 0) return n;
  return rotation_[part][rays.ray.time[i] < 0.5F ? 0 : 1] * n;
}

void RayScene::incidence(const RayPacket& rays, float (&cosine)[16]) const {
  cosines(rays, cosine);
  if (world_.actors.empty()) return;
  for (int i = 0; i < 16; ++i) {
    if (rays.hit.instID[0][i] == RTC_INVALID_GEOMETRY_ID || rays.hit.instID[0][i] == 0) continue;
    const Eigen::Vector3f n = across(rays, i);
    const float along = n.x() * rays.ray.dir_x[i] + n.y() * rays.ray.dir_y[i] + n.z() * rays.ray.dir_z[i];
    cosine[i] = std::abs(along) / std::sqrt(n.squaredNorm());
  }
}

Eigen::Vector3f RayScene::normal(const RayPacket& rays, int i) const {
  const Eigen::Vector3f n = across(rays, i).normalized();
  const Eigen::Vector3f d(rays.ray.dir_x[i], rays.ray.dir_y[i], rays.ray.dir_z[i]);
  return n.dot(d) > 0 ? Eigen::Vector3f(-n) : n;
}

std::optional<Hit> RayScene::first(const Eigen::Vector3d& origin, const Eigen::Vector3d& direction, double max_range,
                                   double time) const {
  if (!origin.allFinite() || !direction.allFinite()) return std::nullopt;
  RayPacket rays;
  rays.ray.org_x[0] = static_cast<float>(origin.x()), rays.ray.org_y[0] = static_cast<float>(origin.y());
  rays.ray.org_z[0] = static_cast<float>(origin.z());
  rays.ray.dir_x[0] = static_cast<float>(direction.x()), rays.ray.dir_y[0] = static_cast<float>(direction.y());
  rays.ray.dir_z[0] = static_cast<float>(direction.z());
  rays.ray.tnear[0] = 0, rays.ray.tfar[0] = static_cast<float>(max_range), rays.ray.time[0] = static_cast<float>(time);
  rays.ray.mask[0] = 0xFFFFFFFF, rays.ray.flags[0] = 0, rays.ray.id[0] = 0;
  rays.hit.geomID[0] = rays.hit.instID[0][0] = RTC_INVALID_GEOMETRY_ID;
  trace(rays, 1);
  if (rays.hit.geomID[0] == RTC_INVALID_GEOMETRY_ID) return std::nullopt;
  return Hit{static_cast<double>(rays.ray.tfar[0]), normal(rays, 0).cast<double>(), surface(rays, 0)};
}

bool RayScene::sees(const Eigen::Vector3d& a, const Eigen::Vector3d& b, double time) const {
  constexpr double kSkin = 0.05;
  const Eigen::Vector3d d = b - a;
  const double length = d.norm();
  if (!(length > 2 * kSkin) || !std::isfinite(length)) return true;
  RTCRay ray{};
  ray.org_x = static_cast<float>(a.x()), ray.org_y = static_cast<float>(a.y()), ray.org_z = static_cast<float>(a.z());
  ray.dir_x = static_cast<float>(d.x() / length), ray.dir_y = static_cast<float>(d.y() / length);
  ray.dir_z = static_cast<float>(d.z() / length);
  ray.tnear = static_cast<float>(kSkin), ray.tfar = static_cast<float>(length - kSkin);
  ray.time = static_cast<float>(time), ray.mask = 0xFFFFFFFF;
  occluded1(scene_, ray);
  return ray.tfar >= 0;
}

}  // namespace scslam::sim
