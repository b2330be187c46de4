#include <cmath>
#include <cstdlib>
#include "scslam/core/trajectory.h"
#include "scslam/odometry/odometry.h"
namespace scslam {
namespace {
class Poses : public Odometry {
 public:
  struct Params : ParamSetOf<Params> {
    std::string file;
    void describe(ParamVisitor& v) override { v.field("file", file, "file"); }
  };
  Poses(const Params& p, const PluginContext&) {
    if (!p.file.empty()) t_ = readTrajectory(p.file);
  }
  OdometryStep step(const Scan& s) override {
    OdometryStep r;
    r.T_odom_base = t_ ? t_->poses.at(s.index).T : s.T_odom_base.value();
    { static Pose last=r.T_odom_base; double d=(last.inverse()*r.T_odom_base).translation().norm(); last=r.T_odom_base; auto e=[](const char*n,double v){const char*c=getenv(n);return c?atof(c):v;}; double st=e("ST",0.01)*std::sqrt(d)+1e-4, sr=e("SR",0.1)*0.01745*std::sqrt(d)+1e-5; r.covariance.setZero(); for(int i=0;i<3;++i){r.covariance(i,i)=st*st; r.covariance(3+i,3+i)=sr*sr;} }
    r.cloud = s.cloud;
    return r;
  }
  void save(ByteWriter&) const override {}
  void load(ByteReader&) override {}
  std::optional<Trajectory> t_;
};
}  // namespace
SCSLAM_REGISTER(Odometry, Poses, "poses", "temporary")
}  // namespace scslam
