// A front-end from outside the tree: a robot that never moves.
#include <scslam/odometry/odometry.h>

namespace {

class StandingStill : public scslam::Odometry {
 public:
  struct Params : scslam::ParamSetOf<Params> {
    void describe(scslam::ParamVisitor&) override {}
  };
  StandingStill(const Params&, const scslam::PluginContext&) {}
  scslam::OdometryStep step(const scslam::Scan& scan) override {
    scslam::OdometryStep result;
    result.cloud = scan.cloud;
    return result;
  }
  void save(scslam::ByteWriter&) const override {}
  void load(scslam::ByteReader&) override {}
};

SCSLAM_REGISTER(scslam::Odometry, StandingStill, "standing_still", "a robot that never moves")

}  // namespace
