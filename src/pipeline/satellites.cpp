#include "scslam/pipeline/satellites.h"

#include <cmath>

#include "scslam/session/georeference.h"

namespace scslam {
namespace {

/// The map is level as far as the first scan was: the satellites' frame may be tilted against it by so much.
constexpr double kTilt_rad = 3 * M_PI / 180;

bool usable(const GnssFix& fix) {
  return std::isfinite(fix.height_m) && std::abs(fix.latitude_deg) <= 90 && std::abs(fix.longitude_deg) <= 360 &&
         fix.covariance_m2.allFinite() && fix.covariance_m2.diagonal().minCoeff() > 0;
}

}  // namespace

std::vector<GnssRecord> Satellites::take(const Scan& scan, const Pose& T_odom_base, const Keyframe* newest) {
  std::vector<GnssRecord> records;
  for (const GnssFix& fix : scan.gnss)
    if (usable(fix)) waiting_.push_back(fix);
  std::vector<GnssFix> later;
  for (const GnssFix& fix : waiting_) {
    if (fix.stamp > scan.stamp) {
      later.push_back(fix);
      continue;
    }
    if (!has_scan_ || fix.stamp < last_stamp_ || newest == nullptr) continue;
    const auto taken = [&](const std::vector<GnssRecord>& some) {
      return !some.empty() && some.back().keyframe == newest->id;
    };
    if (taken(records) || taken(records_)) continue;
    const double u = secondsBetween(last_stamp_, fix.stamp) / secondsBetween(last_stamp_, scan.stamp);
    const Pose T_odom_then = interpolate(T_odom_base_, T_odom_base, u);
    records.push_back({newest->id, fix, newest->T_odom_base.inverse() * (T_odom_then * fix.antenna_in_base_m)});
  }
  waiting_ = std::move(later);
  has_scan_ = true, last_stamp_ = scan.stamp, T_odom_base_ = T_odom_base;
  return records;
}

void Satellites::add(const GnssRecord& record) { records_.push_back(record); }

void Satellites::appendTo(PoseGraph& graph) {
  solved_ = records_.size();
  if (!params_.enabled) return;
  const auto found =
      georeference(records_, graph.poses, {static_cast<std::size_t>(params_.min_fixes), params_.min_spread_m});
  if (!found) return;
  const LocalEnu enu(found->origin);
  const auto frame = static_cast<std::uint32_t>(graph.poses.size());
  graph.poses.push_back(found->T_map_enu);
  Factor level;
  level.kind = FactorKind::kGravity;
  level.i = level.j = frame;
  level.arm = Eigen::Vector3d::UnitZ();
  level.information = Matrix6d::Identity() / (kTilt_rad * kTilt_rad);
  graph.factors.push_back(level);
  const Eigen::Vector3d floor(params_.floor_m, params_.floor_m, params_.floor_up_m);
  for (const GnssRecord& record : records_) {
    Factor fix;
    fix.kind = FactorKind::kPosition;
    fix.i = frame, fix.j = record.keyframe;
    fix.arm = record.antenna_in_keyframe_m;
    fix.T_i_j.translation() =
        enu.fromGeodetic({record.fix.latitude_deg, record.fix.longitude_deg, record.fix.height_m});
    Eigen::Matrix3d covariance = record.fix.covariance_m2;
    covariance.diagonal() += floor.cwiseAbs2();
    fix.information = Matrix6d::Zero();
    fix.information.topLeftCorner<3, 3>() = covariance.inverse();
    graph.factors.push_back(fix);
  }
}

void Satellites::save(ByteWriter& state) const {
  state.put(std::uint64_t{solved_});
  state.put(std::uint8_t{has_scan_});
  state.put(std::int64_t{last_stamp_.time_since_epoch().count()});
  state.put(T_odom_base_);
  state.put(std::uint64_t{waiting_.size()});
  for (const GnssFix& fix : waiting_) {
    state.put(std::int64_t{fix.stamp.time_since_epoch().count()});
    state.put(fix.latitude_deg);
    state.put(fix.longitude_deg);
    state.put(fix.height_m);
    state.put(fix.covariance_m2);
    state.put(fix.antenna_in_base_m);
  }
}

void Satellites::load(ByteReader& state) {
  solved_ = state.get<std::uint64_t>();
  has_scan_ = state.get<std::uint8_t>() != 0;
  last_stamp_ = Stamp(Stamp::duration(state.get<std::int64_t>()));
  state.get(T_odom_base_);
  waiting_.clear();
  for (auto n = state.get<std::uint64_t>(); n > 0; --n) {
    GnssFix fix;
    fix.stamp = Stamp(Stamp::duration(state.get<std::int64_t>()));
    state.get(fix.latitude_deg);
    state.get(fix.longitude_deg);
    state.get(fix.height_m);
    state.get(fix.covariance_m2);
    state.get(fix.antenna_in_base_m);
    waiting_.push_back(fix);
  }
}

}  // namespace scslam
