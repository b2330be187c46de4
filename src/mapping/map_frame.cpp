#include "scslam/mapping/map_frame.h"

#include <fmt/format.h>

#include <Eigen/SVD>
#include <cmath>

#include "scslam/core/error.h"
#include "scslam/session/georeference.h"

namespace scslam {

using Eigen::Vector3d;

MapFrame::MapFrame(const Session& session, MapFrameKind kind) {
  if (kind == MapFrameKind::kMap) return;
  const auto placed = georeference(session.gnss(), session.poses());
  if (!placed)
    throw inputError("{} is not placed on Earth: it needs {} satellite fixes over {} m of way and holds {}",
                     session.folder().string(), GeoreferenceLimits{}.min_fixes, GeoreferenceLimits{}.min_spread_m,
                     session.gnss().size());
  const Pose T_enu_map = placed->T_map_enu.inverse();
  if (kind == MapFrameKind::kEnu) {
    name_ = "enu";
    to_ = [T_enu_map](const Vector3d& p) -> Vector3d { return T_enu_map * p; };
    description_ = "# The map's x, y, z are east, north, up [m] at the origin.\nframe: enu\n";
  } else {
    const Utm origin = toUtm(placed->origin);
    name_ = fmt::format("epsg:{}", origin.epsg());
    offset_m_ = {1000 * std::floor(origin.easting_m / 1000), 1000 * std::floor(origin.northing_m / 1000), 0};
    to_ = [zone = origin.zone, enu = LocalEnu(placed->origin), T_enu_map,
           offset = offset_m_](const Vector3d& p) -> Vector3d {
      const Geodetic g = enu.toGeodetic(T_enu_map * p);
      const Utm utm = toUtm(g, zone);
      return Vector3d(utm.easting_m, utm.northing_m, g.height_m) - offset;
    };
    description_ = fmt::format(
        "# x + offset is the easting, y + offset the northing, z the height over the WGS-84 ellipsoid [m]. World "
        "files\n"
        "# (.pgw) hold the sum.\nframe: utm\nepsg: {}\noffset_m: [{:.0f}, {:.0f}, 0]\n",
        origin.epsg(), offset_m_.x(), offset_m_.y());
  }
  description_ += "\n# How the session's own frame lies:\n" + formatGeoreference(*placed);
}

Vector3d MapFrame::operator()(const Vector3d& p_map) const { return to_ ? to_(p_map) : p_map; }

Eigen::Affine3d MapFrame::around(const Vector3d& p_map) const {
  Eigen::Affine3d A = Eigen::Affine3d::Identity();
  if (!to_) return A;
  constexpr double kStep_m = 10;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d step = kStep_m * Vector3d::Unit(axis);
    A.linear().col(axis) = (to_(p_map + step) - to_(p_map - step)) / (2 * kStep_m);
  }
  A.translation() = to_(p_map) - A.linear() * p_map;
  return A;
}

Pose MapFrame::operator()(const Pose& T_map_body) const {
  if (!to_) return T_map_body;
  const Eigen::Matrix3d turn = around(T_map_body.translation()).linear();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(turn, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Pose T = Pose::Identity();
  T.linear() = svd.matrixU() * svd.matrixV().transpose() * T_map_body.linear();
  T.translation() = to_(T_map_body.translation());
  return T;
}

}  // namespace scslam
