// In which frame is a map written? The session's own, or one on Earth where its satellite fixes place it there.
#pragma once
#include <Eigen/Geometry>
#include <functional>
#include <string>

#include "scslam/session/session.h"

namespace scslam {

enum class MapFrameKind {
  kMap,  ///< the session's
  kEnu,  ///< east, north, up [m] at the first fix (WGS 84)
  kUtm,  ///< easting, northing of the first fix's zone, height over the ellipsoid [m], less offset_m()
};

class MapFrame {
 public:
  /// @throw inputError when the session's fixes do not place it on Earth.
  MapFrame(const Session& session, MapFrameKind kind);

  /// "map", "enu", "epsg:32632".
  const std::string& name() const { return name_; }
  /// To be added to every coordinate: whole kilometres, so that float32 keeps the millimetres.
  const Eigen::Vector3d& offset_m() const { return offset_m_; }
  /// Where a point of the map comes to lie there.
  Eigen::Vector3d operator()(const Eigen::Vector3d& p_map) const;
  /// The same for all points within some 100 m of p_map, to 0.1 mm: UTM is no rigid motion of the map, it turns and
  /// stretches from place to place.
  Eigen::Affine3d around(const Eigen::Vector3d& p_map) const;
  /// Rigid: without the stretch.
  Pose operator()(const Pose& T_map_body) const;
  /// georeference.yaml beside the map; empty for kMap.
  const std::string& description() const { return description_; }

 private:
  std::string name_ = "map", description_;
  Eigen::Vector3d offset_m_ = Eigen::Vector3d::Zero();
  std::function<Eigen::Vector3d(const Eigen::Vector3d&)> to_;  ///< empty: the map's own
};

}  // namespace scslam
