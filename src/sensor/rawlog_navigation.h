// The inertial and satellite readings of a rawlog, shared out among its scans.
#pragma once
#include <mrpt/obs/CObservation.h>

#include <deque>
#include <string>

#include "scslam/sensor/scan.h"

namespace scslam {

/// Collects readings as the file is read and gives each scan those that belong to it (scan.h): the ones that were not
/// handed over yet, up to and including the first at or after the next scan's stamp, so that a front-end can integrate
/// over the whole way to the next scan. What a scan gets depends on the file alone, not on how it was read (skip()).
class RawlogNavigation {
 public:
  /// Takes a CObservationIMU with rates and accelerations, or a CObservationGPS with a GGA message that has a fix. Of
  /// several IMUs or receivers the first label counts; readings without a time, not finite, or not later than the one
  /// before are dropped; so is every other class.
  /// @return it is of one of these two classes, even if it was not taken.
  void take(const mrpt::obs::CObservation& observation);

  bool hasImu() const { return !imu_label_.empty(); }
  bool hasGnss() const { return !gnss_label_.empty(); }

  /// Have all readings been seen that a scan gets when the next one begins at `next_scan`? True without any.
  bool covers(Stamp next_scan) const;
  /// Gives `scan` its readings. @param next_scan nullptr: there is none, it gets all.
  void handTo(Scan& scan, const Stamp* next_scan);
  /// "imu 'xsens'", "gnss 'trimble'", both, or empty.
  std::string description() const;

 private:
  /// Readings that no scan takes (a rawlog without scans for hours) must not fill the memory: the oldest go.
  static constexpr std::size_t kMost = 1 << 16;

  std::deque<ImuSample> imu_;
  std::deque<GnssFix> gnss_;
  std::string imu_label_, gnss_label_;
  Pose T_base_imu_ = Pose::Identity();
  Stamp last_imu_{}, last_gnss_{};      ///< newest reading taken
  Stamp handed_imu_{}, handed_gnss_{};  ///< newest reading handed over
};

}  // namespace scslam
