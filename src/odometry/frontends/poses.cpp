// External odometry: a trajectory file beside the scans, or the poses the recording itself carries.
#include <cmath>

#include "scslam/core/trajectory.h"
#include "scslam/odometry/odometry.h"

namespace scslam {
namespace {

class ExternalPoses : public Odometry {
 public:
  struct Params : ParamSetOf<Params> {
    std::string file;
    double sigma_m_per_m = 0.03, sigma_deg_per_m = 0.1, sigma_m = 0.01, sigma_deg = 0.05;
    void describe(ParamVisitor& v) override {
      v.field("file", file,
              "trajectory, TUM (interpolated at the scan's stamp) or KITTI (row i = scan i); empty: the poses in the "
              "recording");
      v.field("sigma_m_per_m", sigma_m_per_m, "drift of a step, one sigma per square root of a metre [m/sqrt(m)]", 0,
              10);
      v.field("sigma_deg_per_m", sigma_deg_per_m, "and in angle [deg/sqrt(m)]", 0, 90);
      v.field("sigma_m", sigma_m, "noise of any step, one sigma [m]", 1e-6, 10);
      v.field("sigma_deg", sigma_deg, "and in angle [deg]", 1e-6, 90);
    }
  };

  ExternalPoses(const Params& params, const PluginContext&) : params_(params) {
    if (!params_.file.empty()) trajectory_ = readTrajectory(params_.file);
  }

  void begin(std::optional<std::size_t> scan_count, const Pose& T_base_reference) override {
    if (!trajectory_) return;
    trajectory_ = inBaseFrame(std::move(*trajectory_), T_base_reference);
    if (!trajectory_->timed && scan_count && trajectory_->poses.size() != *scan_count)
      throw inputError("{}: {} poses, but the input has {} scans; a KITTI file has one line per scan", params_.file,
                       trajectory_->poses.size(), *scan_count);
  }

  OdometryStep step(const Scan& scan) override {
    OdometryStep result;
    result.T_odom_base = poseAt(scan);
    if (!first_) result.covariance = covarianceOf(T_odom_base_.inverse() * result.T_odom_base);
    T_odom_base_ = result.T_odom_base;
    first_ = false;
    result.cloud = scan.cloud;
    dropNonFinite(result.cloud);
    transformInPlace(result.cloud, scan.T_base_sensor);
    if (result.cloud.empty()) result.quality = {.ok = false, .inlier_ratio = 0, .note = "the scan has no points"};
    return result;
  }

  void save(ByteWriter& state) const override {
    state.put(T_odom_base_);
    state.put(std::uint8_t{first_});
  }
  void load(ByteReader& state) override {
    state.get(T_odom_base_);
    first_ = state.get<std::uint8_t>() != 0;
  }

 private:
  Pose poseAt(const Scan& scan) const {
    if (!trajectory_) {
      if (scan.T_odom_base) return *scan.T_odom_base;
      throw inputError(
          "scan {} at {} s has no pose in the recording; --poses FILE gives one, --odometry voxel_icp needs none",
          scan.index, formatStamp(scan.stamp));
    }
    if (!trajectory_->timed) {
      if (scan.index < trajectory_->poses.size()) return trajectory_->poses[scan.index].T;
      throw inputError("{}: {} poses, but the input goes on with scan {}", params_.file, trajectory_->poses.size(),
                       scan.index);
    }
    if (const auto pose = trajectory_->at(scan.stamp)) return *pose;
    throw inputError("{}: no pose at {} s (scan {}); it covers {} .. {} s", params_.file, formatStamp(scan.stamp),
                     scan.index, formatStamp(trajectory_->poses.front().stamp),
                     formatStamp(trajectory_->poses.back().stamp));
  }

  Matrix6d covarianceOf(const Pose& T_previous_base) const {
    const double metres = T_previous_base.translation().norm();
    const double rad = M_PI / 180;
    const double t2 = std::pow(params_.sigma_m, 2) + std::pow(params_.sigma_m_per_m, 2) * metres;
    const double r2 = std::pow(params_.sigma_deg * rad, 2) + std::pow(params_.sigma_deg_per_m * rad, 2) * metres;
    return (Vector6d() << t2, t2, t2, r2, r2, r2).finished().asDiagonal();
  }

  Params params_;
  std::optional<Trajectory> trajectory_;
  Pose T_odom_base_ = Pose::Identity();
  bool first_ = true;
};

}  // namespace

SCSLAM_REGISTER(Odometry, ExternalPoses, "poses",
                "external: a TUM or KITTI file beside the scans, or the poses in the recording")

}  // namespace scslam
