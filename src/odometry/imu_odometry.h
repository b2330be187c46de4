// LiDAR-inertial odometry, but for the estimator: what `lio` (a filter) and `lio_smoother` (a smoother) share.
//
// One step: integrate the IMU to the scan's stamp, compensate the sweep along the IMU's motion, match the points to the
// planes of an incremental voxel map without features, hand the pose to the estimator. The recording's own odometry
// (wheels), where there is one, is a measurement of the step.
//
// Without an IMU, during a gap in it, or when its readings make no sense, the step is predicted at constant speed, and
// that is said.
#pragma once
#include <optional>

#include "scslam/odometry/imu_check.h"
#include "scslam/odometry/imu_deskew.h"
#include "scslam/odometry/imu_estimator.h"
#include "scslam/odometry/imu_scan_map.h"
#include "scslam/odometry/imu_stream.h"

namespace scslam {

class ImuOdometry : public Odometry {
 public:
  struct Params : ParamSetOf<Params> {
    ImuScanMap::Params map;
    ImuNoise noise;
    double gravity_m_s2 = 9.81;
    double max_tilt_deg = 60;
    double max_imu_gap_s = 0.1;
    double imu_time_offset_s = 0;
    bool estimate_time_offset = true;
    bool use_recorded_odometry = true;
    bool deskew = true;
    bool estimate_mounting = false;  ///< not described here: a smoother cannot
    void describe(ParamVisitor& visitor) override;
  };

  /// @param name of the front-end, for messages.
  ImuOdometry(const Params& params, const PluginContext& context, std::unique_ptr<ImuEstimator> estimator,
              std::string name);

  OdometryStep step(const Scan& scan) override;
  void save(ByteWriter& state) const override;
  void load(ByteReader& state) override;

 private:
  /// What was said already, once a run.
  enum Said : std::uint32_t { kNoImu = 1, kStart = 2, kNoTimes = 4, kClock = 8, kDisagrees = 16, kPlanar = 32 };
  struct Fit {
    Cloud thin;  ///< compensated
    SweepMotion sweep;
    MatchResult match;
    bool searched = false;
    bool jumped = false;  ///< found far from the prediction: it says nothing about the speed
  };

  // ---- the IMU (imu_odometry_readings.cpp) ----
  /// Takes the scan's readings; begins the estimator with the first ones that make sense.
  void takeReadings(const Scan& scan);
  void beginInertial(const Scan& scan, const ImuStart& start);
  void stopInertial();
  bool inertial() const { return inertial_; }
  /// Moves the estimator to the scan's stamp.
  void predict(const Scan& scan);
  void watchImu(const Scan& scan, const Pose& T_previous_base);
  SweepMotion sweepOf(const Scan& scan, double sweep_s, const ImuEstimator& estimator) const;
  void say(Said what, const std::string& line);

  // ---- the scan ----
  void measureRecorded(const Scan& scan);
  Fit fit(const Scan& scan, const Cloud& thin_raw);
  /// The map of the first sweep anew, compensated with the speed that the second one shows, and the second's fit to it.
  void beginAgain(const Scan& scan, const Cloud& thin_raw, Fit& found);
  /// Too long without a fit, a scan and a measured motion to know where the robot might be.
  bool adrift(const Scan& scan) const;
  void searchAbout(const Cloud& thin, Fit& fit) const;
  void searchAdrift(const Cloud& thin, Fit& fit) const;
  void accept(const Scan& scan, const Fit& fit, OdometryStep& out);
  void lose(const Scan& scan, const std::string& why, OdometryStep& out);
  int patience() const;
  Matrix6d reportedCovariance() const;

  Params params_;
  PluginContext context_;
  std::string name_;

  // The state, all of it saved.
  ImuScanMap map_;
  Cloud first_;  ///< the map's only scan as it was seen; empty once a speed is known
  ImuStream stream_;
  std::unique_ptr<ImuEstimator> estimator_;
  ImuCheck check_;
  bool inertial_ = false;  ///< the IMU is believed
  bool refused_ = false;   ///< it was tried and makes no sense
  bool speed_known_ = false;
  Vector6d twist_ = Vector6d::Zero();  ///< of the last step, frame base
  Stamp stamp_{};
  std::optional<Pose> T_recorded_;      ///< the recording's own pose at stamp_
  Pose T_previous_ = Pose::Identity();  ///< T_odom_base at the scan before
  Pose T_fitted_ = Pose::Identity();    ///< T_odom_base at the last scan that fitted
  Eigen::Vector3d gyro_turn_ = Eigen::Vector3d::Zero(), rate_begin_ = Eigen::Vector3d::Zero(),
                  rate_end_ = Eigen::Vector3d::Zero();  ///< of the last prediction, frame base
  bool by_imu_ = false, by_wheels_ = false;             ///< the last prediction was
  int lost_ = 0;                                        ///< scans in a row without a fit
  std::uint32_t said_ = 0;
  std::string note_;  ///< for this step
};

}  // namespace scslam
