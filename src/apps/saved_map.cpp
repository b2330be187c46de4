#include "scslam/apps/saved_map.h"

#include <cmath>

#include "scslam/apps/point_map/point_map.h"
#include "scslam/core/bytes.h"
#include "scslam/core/error.h"
#include "scslam/core/log.h"
#include "scslam/session/layout.h"
#include "scslam/session/manifest.h"
#include "scslam/session/session_graph.h"

namespace scslam {
namespace {

Matrix6d variances(double sigma_m, double sigma_deg) {
  Vector6d sigma;
  sigma << Eigen::Vector3d::Constant(sigma_m), Eigen::Vector3d::Constant(sigma_deg * M_PI / 180);
  return sigma.cwiseAbs2().asDiagonal();
}

/// Classic sessions state no covariances; the same as their graphs take (session_graph.h).
const double kUnknownStep_m = 0.05, kUnknownStep_deg = 0.5;
/// Between the parents of a merged session its own verified loops stand in for odometry.
const double kParentsApart_m = 0.1, kParentsApart_deg = 0.5;

}  // namespace

bool beginsAnew(const Keyframe& keyframe) { return keyframe.step_covariance(0, 0) >= kOpenStep; }

SavedMap::SavedMap(Session session, const Pose& T_base_sensor, const RegistrationParams& registration,
                   std::size_t cache_bytes)
    : session_(std::move(session)),
      T_own_base_(session_.info().T_base_sensor * T_base_sensor.inverse()),
      T_base_sensor_(T_base_sensor),
      clouds_(std::make_unique<CloudStore>(session_.folder(), cache_bytes,
                                           [T_base_sensor, registration](const Cloud& cloud_sensor) {
                                             return transformed(loopScan(cloud_sensor, registration), T_base_sensor);
                                           })) {
  if (session_.info().T_base_sensor.isApprox(T_base_sensor, 0)) T_own_base_ = Pose::Identity();
  takeKeyframes();
  takeRecords();
}

std::string SavedMap::name() const {
  const std::filesystem::path folder = std::filesystem::absolute(session_.folder()).lexically_normal();
  return folder.has_filename() ? folder.filename().string() : folder.parent_path().filename().string();
}

bool SavedMap::rigid() const { return session_.info().input_format == kPointMap; }

std::filesystem::path SavedMap::origin() const {
  return rigid() ? std::filesystem::path(session_.info().input) : session_.folder();
}

void SavedMap::takeKeyframes() {
  const std::string where = session_.folder().string();
  if (session_.keyframes().empty()) throw inputError("{} holds no keyframes", where);
  const Matrix6d J = adjoint(Pose(T_own_base_.inverse()));
  Matrix6d step = Matrix6d::Zero();  // since the last one kept
  const Keyframe* before = nullptr;
  for (const Keyframe& keyframe : session_.keyframes()) {
    if (!isRigid(session_.poses()[keyframe.id]) || !isRigid(keyframe.T_odom_base))
      throw inputError("{}: the pose of keyframe {} is no rigid motion; see 'scslam doctor {}'", where, keyframe.id,
                       where);
    const bool known = keyframe.step_covariance.allFinite() && keyframe.step_covariance.diagonal().minCoeff() > 0;
    if (before != nullptr)
      step = composeCovariance(step, before->T_odom_base.inverse() * keyframe.T_odom_base,
                               known ? keyframe.step_covariance : variances(kUnknownStep_m, kUnknownStep_deg));
    before = &keyframe;
    if (!session_.hasCloud(keyframe.id)) {
      if (!session_.classic())
        throw inputError("{} is missing; see 'scslam doctor {}'", layout::scanFile(where, keyframe.id).string(), where);
      kept_.push_back(static_cast<std::int64_t>(keyframes_.size()) - 1);
      continue;
    }
    Keyframe here = keyframe;
    here.id = static_cast<KeyframeId>(keyframes_.size());
    here.T_odom_base = keyframe.T_odom_base * T_own_base_;
    here.step_covariance = J * step * J.transpose();
    here.step_passing = J.cwiseAbs2() * keyframe.step_passing;
    here.planar = session_.info().planar;
    step.setZero();
    kept_.push_back(here.id);
    own_.push_back(keyframe.id);
    keyframes_.push_back(here);
    T_map_base_.push_back(session_.poses()[keyframe.id] * T_own_base_);
  }
  if (keyframes_.empty()) throw inputError("{} holds no scan of any of its {} keyframes", where, kept_.size());
}

void SavedMap::takeRecords() {
  const auto kept = [this](KeyframeId own) {
    return kept_[own] >= 0 && own_[static_cast<std::size_t>(kept_[own])] == own;
  };
  const Pose T_base_own = T_own_base_.inverse();
  const Matrix6d A = adjoint(T_own_base_);
  for (LoopRecord loop : session_.loops()) {
    if (!kept(loop.match) || !kept(loop.query)) continue;
    loop.match = static_cast<KeyframeId>(kept_[loop.match]), loop.query = static_cast<KeyframeId>(kept_[loop.query]);
    loop.T_match_query = T_base_own * loop.T_match_query * T_own_base_;
    loop.information = A.transpose() * loop.information * A;
    loops_.push_back(std::move(loop));
  }
  for (ScanRecord scan : session_.scans()) {
    const auto newest = std::min(scan.keyframe, static_cast<std::int64_t>(kept_.size()) - 1);
    const std::int64_t here = newest < 0 ? -1 : kept_[static_cast<std::size_t>(newest)];
    scan.keyframe = std::max<std::int64_t>(here, 0);  // before the first one its correction is the nearest there is
    scan.T_odom_base = scan.T_odom_base * T_own_base_;
    scans_.push_back(scan);
  }
  for (GnssRecord record : session_.gnss()) {
    if (record.keyframe >= kept_.size() || !kept(record.keyframe)) continue;
    record.keyframe = static_cast<KeyframeId>(kept_[record.keyframe]);
    record.antenna_in_keyframe_m = T_base_own * record.antenna_in_keyframe_m;
    gnss_.push_back(record);
  }
}

Cloud SavedMap::wholeCloud(KeyframeId k) const { return transformed(session_.cloud(own_[k]), T_base_sensor_); }

std::string contentDigest(const Session& session) {
  ByteWriter bytes;
  for (const Keyframe& keyframe : session.keyframes()) {
    bytes.put(std::int64_t{keyframe.stamp.time_since_epoch().count()});
    bytes.put(keyframe.T_odom_base);
    bytes.put(session.poses()[keyframe.id]);
  }
  return digestOf(bytes.bytes());
}

void SavedMap::addNodesTo(LoopConsistency& consistency) const {
  double travelled_m = 0;
  for (std::size_t k = 0; k < keyframes_.size(); ++k) {
    const bool anew = k > 0 && beginsAnew(keyframes_[k]);
    if (k > 0 && !anew) travelled_m += keyframes_[k].travelled_m - keyframes_[k - 1].travelled_m;
    consistency.addNode(T_map_base_[k], travelled_m,
                        anew ? variances(kParentsApart_m, kParentsApart_deg) : keyframes_[k].step_covariance,
                        keyframes_[k].planar);
  }
}

void loadSessionConfig(ParamSet& params, const Session& session, const PluginContext& context) {
  if (session.info().config_yaml.empty()) return;
  const auto before = params.clone();
  try {
    loadYaml(params, session.info().config_yaml, (session.folder() / layout::kConfig).string());
  } catch (const Error& error) {
    logWarn(context.log, "the session's configuration is left out, defaults are taken: {}", error.what());
    loadYaml(params, dumpYaml(*before), "defaults");
  }
}

}  // namespace scslam
