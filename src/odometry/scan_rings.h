// Which laser saw a point, and which points are its neighbours along that laser's sweep.
#pragma once
#include <string>
#include <vector>

#include "scslam/core/bytes.h"
#include "scslam/core/cloud.h"
#include "scslam/core/params.h"
#include "scslam/sensor/scan.h"

namespace scslam {

/// The points of a scan by laser, lowest first, each ring in the order of its sweep.
struct ScanRings {
  std::vector<std::uint32_t> points;  ///< numbers of points
  std::vector<std::uint32_t> begin;   ///< ring r is points[begin[r]] … points[begin[r + 1] - 1]

  std::size_t count() const { return begin.empty() ? 0 : begin.size() - 1; }
  std::size_t size(std::size_t ring) const { return begin[ring + 1] - begin[ring]; }
  const std::uint32_t* ring(std::size_t r) const { return &points[begin[r]]; }
};

struct RingParams : ParamSetOf<RingParams> {
  std::vector<double> elevation_deg;  ///< of the beams in the sensor frame (configs/sensors/*.yaml)
  int virtual_rings = 0;
  void describe(ParamVisitor& visitor) override;
};

/// Finds the rings of scans of one sensor: from the cloud's ring field; or from the elevations of the beams, given or
/// seen as separate levels in the data; or from the order of the file (one ring after the other, as KITTI has them).
/// Where all of that fails, virtual rings (when asked for) cut what the first scan sees into equal steps of elevation.
class RingFinder {
 public:
  static constexpr std::size_t kMostRings = 512;

  explicit RingFinder(const RingParams& params = {});

  /// @param cloud_base frame base; no NaN. @return empty, or why no rings were found.
  std::string find(const Cloud& cloud_base, const Pose& T_base_sensor, ScanRings& rings);

  /// find() for the front-end `name`.
  /// @param first nothing was made of any scan yet: a sensor without rings is then an error of the choice made.
  /// @throw inputError that says what to do instead.
  std::string ringsOf(const Cloud& cloud_base, const Scan& scan, const std::string& name, bool first, ScanRings& rings);

  void save(ByteWriter& state) const;
  void load(ByteReader& state);

 private:
  int virtual_rings_;
  std::vector<float> levels_;  ///< tan(elevation) of the beams, ascending; empty: not known (yet)
  bool by_rows_ = false;       ///< the first scan had no levels and lay row by row: so do the others
};

}  // namespace scslam
