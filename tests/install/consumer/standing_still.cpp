// A front-end from outside the tree: a robot that believes it never moves.
#include <scslam/odometry/odometry.h>

namespace {

class StandingStill : public scslam::Odometry {
 public:
  struct Params : scslam::ParamSetOf<Params> {
    double sigma_m = 0.5;
    void describe(scslam::ParamVisitor& v) override {
      v.field("sigma_m", sigma_m, "how little a step is believed, one sigma [m]", 1e-6, 100);
    }
  };
  StandingStill(const Params& params, const scslam::PluginContext&) : params_(params) {}

  scslam::OdometryStep step(const scslam::Scan& scan) override {
    scslam::OdometryStep result;                                         // T_odom_base: the identity
    result.cloud = scslam::transformed(scan.cloud, scan.T_base_sensor);  // frame base
    scslam::dropNonFinite(result.cloud);
    result.quality.ok = !result.cloud.empty();
    if (!first_) result.covariance.diagonal().setConstant(params_.sigma_m * params_.sigma_m);
    first_ = false;
    return result;
  }
  void save(scslam::ByteWriter& state) const override { state.put(std::uint8_t{first_}); }
  void load(scslam::ByteReader& state) override { first_ = state.get<std::uint8_t>() != 0; }

 private:
  Params params_;
  bool first_ = true;
};

}  // namespace

SCSLAM_REGISTER(scslam::Odometry, StandingStill, "standing_still", "a robot that never moves")
