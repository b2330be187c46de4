// Wheel odometry alone: the motion that the recording itself carries (CObservationOdometry, actions), step by step.
//
// Only the steps count, so that encoders which start anew are not a leap of the robot, and what a gap in them leaves
// open is bridged when they are back. As a prior, every other front-end takes the same (use_recorded_odometry).
#include <algorithm>
#include <cmath>

#include "scslam/core/deskew.h"
#include "scslam/odometry/odometry.h"

namespace scslam {
namespace {

class Wheel : public Odometry {
 public:
  struct Params : ParamSetOf<Params> {
    double max_speed_mps = 60;
    bool deskew = true;
    // What wheels are off by: some slip, more in turns, and nothing known of slopes.
    double slip = 0.02, turn_slip = 0.05;
    double sigma_m = 0.005, sigma_deg = 0.1, slope_deg = 3;
    void describe(ParamVisitor& visitor) override {
      visitor.field("max_speed_mps", max_speed_mps,
                    "a step that is faster is no motion: the encoders were set to something else [m/s]", 0.1, 1000.0);
      visitor.field("deskew", deskew, "compensate motion within a sweep where points carry times");
      visitor.field("slip", slip, "error of a step, one sigma, as a share of its length", 0.0, 1.0);
      visitor.field("turn_slip", turn_slip, "and of its turn", 0.0, 1.0);
      visitor.field("sigma_m", sigma_m, "noise of any step, one sigma [m]", 1e-6, 10.0);
      visitor.field("sigma_deg", sigma_deg, "and in heading [deg]", 1e-6, 90.0);
      visitor.field("slope_deg", slope_deg, "change of slope that wheels do not see, one sigma over 1 m [deg]", 0.0,
                    45.0);
    }
  };
  Wheel(const Params& params, const PluginContext&) : params_(params) {}

  OdometryStep step(const Scan& scan) override;
  void save(ByteWriter& state) const override;
  void load(ByteReader& state) override;

 private:
  struct Step {
    Pose T_odom_base = Pose::Identity();
    std::string why_guessed;  ///< empty: it was measured
  };
  Step stepTo(const Scan& scan) const;
  Pose atLastSpeed(Stamp stamp) const;
  Matrix6d covarianceOf(const Pose& T_previous_base, bool guessed, bool planar) const;

  Params params_;
  bool first_ = true;
  Pose T_odom_base_ = Pose::Identity();
  Stamp stamp_{};
  Pose T_recorded_ = Pose::Identity();       ///< the last pose of the wheels, in their own world
  Stamp recorded_stamp_{};                   ///< and its time
  Pose T_odom_recorded_ = Pose::Identity();  ///< what was reported for it
  Vector6d twist_ = Vector6d::Zero();        ///< of the last measured step, frame base
};

OdometryStep Wheel::step(const Scan& scan) {
  const bool recorded = scan.T_odom_base && isRigid(*scan.T_odom_base);
  if (first_ && !recorded)
    throw inputError(
        "scan {} at {} s has no wheel odometry (CObservationOdometry, actions); --odometry voxel_icp needs none, "
        "--skip N leaves scans before it out",
        scan.index, formatStamp(scan.stamp));
  OdometryStep out;
  if (!first_) {
    const Step moved = stepTo(scan);
    const bool guessed = !moved.why_guessed.empty();
    const Pose T_previous_base = T_odom_base_.inverse() * moved.T_odom_base;
    const double dt = secondsBetween(stamp_, scan.stamp);
    if (!guessed && dt > 1e-4) twist_ = local(Pose::Identity(), T_previous_base) / dt;
    T_odom_base_ = moved.T_odom_base;
    out.covariance = covarianceOf(T_previous_base, guessed, scan.planar);
    if (guessed) out.quality = {.ok = false, .inlier_ratio = 0, .note = moved.why_guessed};
  }
  first_ = false;
  stamp_ = scan.stamp;
  if (recorded) T_recorded_ = *scan.T_odom_base, recorded_stamp_ = scan.stamp, T_odom_recorded_ = T_odom_base_;

  out.T_odom_base = T_odom_base_;
  out.cloud = scan.cloud;
  dropNonFinite(out.cloud);
  transformInPlace(out.cloud, scan.T_base_sensor);
  if (params_.deskew && !scan.deskewed && out.cloud.hasTime()) deskew(out.cloud, twist_);
  if (out.cloud.empty()) out.quality = {.ok = false, .inlier_ratio = 0, .note = "the scan has no points"};
  return out;
}

Pose Wheel::atLastSpeed(Stamp stamp) const {
  constexpr double kLongest = 1.0;  // [s]; beyond, nobody knows what the speed was
  return retract(T_odom_base_, std::clamp(secondsBetween(stamp_, stamp), 0.0, kLongest) * twist_);
}

Wheel::Step Wheel::stepTo(const Scan& scan) const {
  constexpr double kJitter = 1.0;  // [m]: stamps may lie
  if (!scan.T_odom_base || !isRigid(*scan.T_odom_base))
    return {atLastSpeed(scan.stamp), "no wheel odometry for this scan"};
  const Pose T_since = orthonormalised(T_recorded_.inverse() * *scan.T_odom_base);
  const double metres = T_since.translation().norm(), seconds = secondsBetween(recorded_stamp_, scan.stamp);
  if (metres > kJitter + params_.max_speed_mps * std::max(seconds, 0.0))
    return {atLastSpeed(scan.stamp), fmt::format("the wheel odometry leaps by {:.1f} m: it was set anew", metres)};
  return {T_odom_recorded_ * T_since, ""};
}

Matrix6d Wheel::covarianceOf(const Pose& T_previous_base, bool guessed, bool planar) const {
  const double rad = M_PI / 180, metres = T_previous_base.translation().norm(), turn = rotationAngle(T_previous_base);
  // A guessed step keeps what constant velocity is worth: half the motion itself.
  const double along = guessed ? 0.1 + 0.5 * metres : params_.sigma_m + params_.slip * metres;
  const double yaw = guessed ? 0.05 + 0.5 * turn : params_.sigma_deg * rad + params_.turn_slip * turn;
  // A slope that changes by a random walk: over d metres by sqrt(d), and half of that on the way.
  const double slope = planar ? 1e-4 : params_.sigma_deg * rad + params_.slope_deg * rad * std::sqrt(metres);
  const double up = planar ? 1e-4 : params_.sigma_m + 0.5 * metres * slope;
  Vector6d sigma;
  sigma << along, along, up, slope, slope, yaw;
  return sigma.cwiseAbs2().asDiagonal();
}

void Wheel::save(ByteWriter& state) const {
  state.put(first_);
  state.put(T_odom_base_);
  state.put(std::int64_t{stamp_.time_since_epoch().count()});
  state.put(T_recorded_);
  state.put(std::int64_t{recorded_stamp_.time_since_epoch().count()});
  state.put(T_odom_recorded_);
  state.put(twist_);
}

void Wheel::load(ByteReader& state) {
  state.get(first_);
  state.get(T_odom_base_);
  stamp_ = Stamp(Stamp::duration(state.get<std::int64_t>()));
  state.get(T_recorded_);
  recorded_stamp_ = Stamp(Stamp::duration(state.get<std::int64_t>()));
  state.get(T_odom_recorded_);
  state.get(twist_);
}

}  // namespace

SCSLAM_REGISTER(Odometry, Wheel, "wheel", "wheel odometry alone: the motion the recording itself carries")

}  // namespace scslam
