// A fixed-lag smoother as the estimator of an inertial front-end (the LIO-SAM class: Shan et al., IROS 2020).
//
// The last few scans are nodes; between them lie the preintegrated IMU, the biases' walk, and the wheels' steps, on
// them the poses that scan matching found, with a robust kernel: a wrong match is outvoted by its neighbours, where a
// filter would keep it for good. What leaves the window stays as a Gaussian on its oldest node (Schur complement).
//
// The systems are dense and small (2 + 15 a node), and marginals are needed of them as much as solutions, so it is
// Gauss-Newton by a dense Cholesky decomposition and not Ceres (which only the graph folder knows). Every direction has
// a prior, and a step that is not finite is not taken: there is no ill-posed system. A step without IMU is a guess with
// a robust kernel of its own, that gives way to whatever is seen.
#pragma once
#include <deque>
#include <optional>

#include "scslam/odometry/imu_factors.h"

namespace scslam {

class ImuSmoother : public ImuEstimator {
 public:
  /// @param lag nodes that stay in the window, >= 2.
  explicit ImuSmoother(int lag) : lag_(lag) {}
  std::unique_ptr<ImuEstimator> clone() const override { return std::make_unique<ImuSmoother>(*this); }

  void begin(const Pose& T_odom_base, const Pose& T_base_imu, const Eigen::Vector3d& gravity,
             const Eigen::Vector3d& velocity, const Start& start) override;
  void beginStep() override;
  void predict(const ImuPreintegration& imu, const ImuNoise& noise) override;
  void predictAtSpeed(const Vector6d& twist, double duration_s) override;
  void measureRest(const Eigen::Vector3d& accel, double accel_sigma, const Eigen::Vector3d& gyro,
                   double gyro_sigma) override;
  /// Beyond 5 sigma it is not taken.
  void measureStep(const Pose& T_previous_base, const Matrix6d& information) override;
  void measurePose(const Pose& T_odom_base, const Matrix6d& information) override;

  Pose basePose() const override { return newest().pose() * T_base_imu_.inverse(); }
  /// Zero: the match stands alone, what is believed comes in by the window.
  Matrix6d poseInformation() const override { return Matrix6d::Zero(); }
  Matrix6d stepCovariance() const override;
  NavState nav() const override { return newest().nav; }
  ImuBias bias() const override { return newest().bias; }
  Eigen::Vector3d gravity() const override { return gravity_; }
  Pose mounting() const override { return T_base_imu_; }
  void save(ByteWriter& state) const override;
  void load(ByteReader& state) override;

  std::size_t nodes() const { return window_.size(); }

 private:
  using System = Eigen::MatrixXd;  ///< [H | g]: the last column is the gradient

  struct Measured {
    Pose T = Pose::Identity();
    Matrix6d information = Matrix6d::Zero();
  };
  struct Entry {
    ImuNode node;
    double duration_s = 0;  ///< since the entry before
    std::optional<ImuPreintegration>
        imu;  ///< from the entry before; none at the oldest and where there were no readings
    Matrix9d imu_information = Matrix9d::Zero();
    ImuNoise noise;                 ///< it was integrated with; of the walk of the biases
    std::optional<Measured> guess;  ///< T_before_this of the IMU at constant speed, where there is no imu
    std::optional<Measured> step;   ///< T_before_this of the IMU
    std::optional<Measured> pose;   ///< T_odom_imu
  };

  const ImuNode& newest() const { return window_.back().node; }
  static void integrate(const std::vector<ImuReading>& readings, const ImuBias& bias, Entry& entry);
  /// Everything that touches the first `count` nodes and no later one, linearised.
  System linearised(std::size_t count) const;
  void addPrior(System& system) const;
  void addLink(std::size_t k, System& system) const;
  void addGuess(std::size_t k, System& system) const;
  void optimise();
  void marginaliseOldest();
  Matrix6d toImu(const Matrix6d& information_base) const;

  int lag_;
  Pose T_base_imu_ = Pose::Identity();
  Eigen::Vector3d gravity_ = Eigen::Vector3d(0, 0, -9.81);
  std::deque<Entry> window_;

  // The prior on (gravity, oldest node), at the values it was taken at.
  static constexpr int kPrior = 2 + ImuNode::kSize;
  Eigen::Matrix<double, kPrior, kPrior> prior_H_ = Eigen::Matrix<double, kPrior, kPrior>::Zero();
  Eigen::Matrix<double, kPrior, 1> prior_g_ = Eigen::Matrix<double, kPrior, 1>::Zero();
  ImuNode prior_node_;
  Eigen::Vector3d prior_gravity_ = Eigen::Vector3d(0, 0, -9.81);
};

}  // namespace scslam
