// External odometry: a trajectory file beside the scans, or the poses the recording itself carries.
#include <cmath>

#include "scslam/core/deskew.h"
#include "scslam/core/trajectory.h"
#include "scslam/odometry/odometry.h"

namespace scslam {
namespace {

/// Two scans farther apart than this say nothing about the motion within the second one's sweep [s].
constexpr double kLongestStep = 1.0;

class ExternalPoses : public Odometry {
 public:
  struct Params : ParamSetOf<Params> {
    std::string file, frame = "reference", origin = "first";
    double time_offset_s = 0, max_gap_s = 2, tolerance_s = 0.001;
    bool deskew = true;
    double sigma_m_per_m = 0.03, sigma_deg_per_m = 0.1, sigma_m = 0.01, sigma_deg = 0.05;
    void describe(ParamVisitor& v) override {
      v.field(
          "file", file,
          "trajectory, TUM or EuRoC (interpolated at the scan's stamp) or KITTI (row i = scan i); empty: the poses in "
          "the recording");
      v.field(
          "frame", frame,
          "whose poses the file holds; reference: what pose files beside this input speak of (KITTI with calib.txt: "
          "the camera; otherwise the base)",
          {"reference", "base", "sensor"});
      v.field(
          "origin", origin,
          "first: positions count from the first pose (UTM and the like are too far away for float points); file: as "
          "they are",
          {"first", "file"});
      v.field("time_offset_s", time_offset_s, "added to the file's times to get the scans' [s]", -1e10, 1e10);
      v.field("max_gap_s", max_gap_s, "poses farther apart are not interpolated [s]", 0, 3600);
      v.field("tolerance_s", tolerance_s, "a scan may lie this far outside the file's times [s]", 0, 1);
      v.field("deskew", deskew, "compensate motion within a sweep where points carry times");
      v.field("sigma_m_per_m", sigma_m_per_m, "drift of a step, one sigma per square root of a metre [m/sqrt(m)]", 0,
              10);
      v.field("sigma_deg_per_m", sigma_deg_per_m, "and in angle [deg/sqrt(m)]", 0, 90);
      v.field("sigma_m", sigma_m, "noise of any step, one sigma [m]", 1e-6, 10);
      v.field("sigma_deg", sigma_deg, "and in angle [deg]", 1e-6, 90);
    }
  };

  ExternalPoses(const Params& params, const PluginContext&) : params_(params) {
    if (params_.file.empty()) return;
    trajectory_ = readTrajectory(params_.file);
    if (!trajectory_->timed && params_.time_offset_s != 0)
      throw usageError("odometry.poses.time_offset_s: {} has no times, row i belongs to scan i", params_.file);
    for (StampedPose& pose : trajectory_->poses)
      pose.stamp += std::chrono::duration_cast<Stamp::duration>(std::chrono::duration<double>(params_.time_offset_s));
  }

  void begin(std::optional<std::size_t> scan_count, const Pose& T_base_reference) override {
    T_base_reference_ = T_base_reference;
    if (trajectory_ && !trajectory_->timed && scan_count && trajectory_->poses.size() != *scan_count)
      throw inputError("{}: {} poses, but the input has {} scans; a KITTI file has one line per scan", params_.file,
                       trajectory_->poses.size(), *scan_count);
  }

  OdometryStep step(const Scan& scan) override {
    const Pose T_given_base = poseAt(scan);
    if (first_ && params_.origin == "first") origin_ = T_given_base.translation();
    OdometryStep result;
    result.T_odom_base = T_given_base;
    result.T_odom_base.translation() -= origin_;
    result.cloud = scan.cloud;
    dropNonFinite(result.cloud);
    transformInPlace(result.cloud, scan.T_base_sensor);
    if (params_.deskew && !scan.deskewed && result.cloud.hasTime())
      deskew(result.cloud, twistAt(scan, result.T_odom_base, sweepDuration(result.cloud)));
    if (!first_) result.covariance = covarianceOf(T_odom_base_.inverse() * result.T_odom_base);
    T_odom_base_ = result.T_odom_base;
    stamp_ = scan.stamp;
    first_ = false;
    if (result.cloud.empty()) result.quality = {.ok = false, .inlier_ratio = 0, .note = "the scan has no points"};
    return result;
  }

  void save(ByteWriter& state) const override {
    state.put(T_odom_base_);
    state.put(origin_);
    state.put(std::int64_t{stamp_.time_since_epoch().count()});
    state.put(std::uint8_t{first_});
  }
  void load(ByteReader& state) override {
    state.get(T_odom_base_);
    state.get(origin_);
    stamp_ = Stamp(Stamp::duration(state.get<std::int64_t>()));
    first_ = state.get<std::uint8_t>() != 0;
  }

 private:
  /// T_world_base in the file's or the recording's world.
  Pose poseAt(const Scan& scan) const {
    if (!trajectory_) {
      if (scan.T_odom_base) return *scan.T_odom_base;
      throw inputError(
          "scan {} at {} s has no pose in the recording; --poses FILE gives one, --odometry voxel_icp needs none",
          scan.index, formatStamp(scan.stamp));
    }
    if (!trajectory_->timed) {
      if (scan.index < trajectory_->poses.size()) return ofBase(trajectory_->poses[scan.index].T, scan);
      throw inputError("{}: {} poses, but the input goes on with scan {}", params_.file, trajectory_->poses.size(),
                       scan.index);
    }
    if (const auto T = trajectory_->at(scan.stamp, params_.tolerance_s, params_.max_gap_s)) return ofBase(*T, scan);
    throw noPose(scan);
  }

  Pose ofBase(const Pose& T_world_frame, const Scan& scan) const {
    if (params_.frame == "base") return T_world_frame;
    return T_world_frame * (params_.frame == "sensor" ? scan.T_base_sensor : T_base_reference_).inverse();
  }

  Error noPose(const Scan& scan) const {
    const Stamp from = trajectory_->poses.front().stamp, to = trajectory_->poses.back().stamp;
    const std::string what =
        fmt::format("{}: no pose at {} s (scan {})", params_.file, formatStamp(scan.stamp), scan.index);
    if (scan.stamp > from && scan.stamp < to)
      return inputError("{}: its poses are more than odometry.poses.max_gap_s = {:g} s apart there", what,
                        params_.max_gap_s);
    const double seconds = scan.stamp < from ? secondsBetween(scan.stamp, from) : secondsBetween(to, scan.stamp);
    const bool foreign = seconds > 60 && first_;
    return inputError("{}; it covers {} .. {} s{}", what, formatStamp(from), formatStamp(to),
                      foreign  ? ": another clock? --set odometry.poses.time_offset_s=… is added to its times"
                      : first_ ? "; --skip N leaves scans before it out"
                               : "");
  }

  /// Motion of the base during the sweep: between the file's poses at its begin and its end; else as since the last
  /// scan.
  Vector6d twistAt(const Scan& scan, const Pose& T_odom_base, double sweep_s) const {
    if (trajectory_ && trajectory_->timed && sweep_s > 0) {
      const Stamp end =
          scan.stamp + std::chrono::duration_cast<Stamp::duration>(std::chrono::duration<double>(sweep_s));
      if (const auto T = trajectory_->at(end, 0, params_.max_gap_s))
        return local(poseAt(scan), ofBase(*T, scan)) / sweep_s;
    }
    const double step_s = secondsBetween(stamp_, scan.stamp);
    if (first_ || !(step_s > 0) || step_s > kLongestStep) return Vector6d::Zero();
    return local(T_odom_base_, T_odom_base) / step_s;
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
  Pose T_base_reference_ = Pose::Identity();
  Eigen::Vector3d origin_ = Eigen::Vector3d::Zero();  ///< of odom, in the file's world
  Pose T_odom_base_ = Pose::Identity();               ///< of the last scan
  Stamp stamp_;
  bool first_ = true;
};

}  // namespace

SCSLAM_REGISTER(Odometry, ExternalPoses, "poses",
                "external: a TUM, KITTI or EuRoC file beside the scans, or the poses in the recording")

}  // namespace scslam
