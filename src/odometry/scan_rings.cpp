#include "scslam/odometry/scan_rings.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace scslam {
namespace {

constexpr std::size_t kFewestRings = 4;

/// What the sensor sees of each point: its place along the sweep, in quarter turns [0, 4) (monotone in the azimuth, and
/// no arc tangent), and its steepness.
struct Directions {
  std::vector<float> turn, slope;
};

Directions directionsOf(const Cloud& cloud_base, const Pose& T_base_sensor) {
  const Eigen::Isometry3f T_sensor_base = T_base_sensor.inverse().cast<float>();
  Directions d;
  d.turn.resize(cloud_base.size());
  d.slope.resize(cloud_base.size());
  for (std::size_t i = 0; i < cloud_base.size(); ++i) {
    const Eigen::Vector3f p = T_sensor_base * cloud_base.point(i);
    const float sum = std::abs(p.x()) + std::abs(p.y());
    const float u = sum > 0 ? p.y() / sum : 0.0f;
    d.turn[i] = p.x() < 0 ? 2.0f - u : u >= 0 ? u : 4.0f + u;
    d.slope[i] = p.z() / std::max(p.head<2>().norm(), 1e-6f);
  }
  return d;
}

/// Elevations of some of the points [rad], sorted, without the outermost strays.
std::vector<float> someElevations(const std::vector<float>& slope) {
  constexpr std::size_t kSample = 30000;
  std::vector<float> angles;
  const std::size_t step = std::max<std::size_t>(1, slope.size() / kSample);
  for (std::size_t i = 0; i < slope.size(); i += step) angles.push_back(std::atan(slope[i]));
  std::sort(angles.begin(), angles.end());
  const auto strays = static_cast<std::ptrdiff_t>(angles.size() / 500);
  return {angles.begin() + strays, angles.end() - strays};
}

/// Levels of steepness at which the points lie, where there are gaps between them.
std::vector<float> separateLevels(const std::vector<float>& slope) {
  const std::vector<float> angles = someElevations(slope);
  if (angles.size() < 100) return {};
  const float gap = (angles.back() - angles.front()) / 600;
  std::vector<float> centres, widths;
  std::size_t covered = 0;
  for (std::size_t begin = 0, i = 1; i <= angles.size(); ++i) {
    if (i < angles.size() && angles[i] - angles[i - 1] <= gap) continue;
    const std::size_t n = i - begin;
    if (n >= std::max<std::size_t>(5, angles.size() / 10000)) {
      centres.push_back(angles[begin + n / 2]);
      widths.push_back(angles[begin + n * 95 / 100] - angles[begin + n * 5 / 100]);
      covered += n;
    }
    begin = i;
  }
  if (centres.size() < kFewestRings || centres.size() > RingFinder::kMostRings) return {};
  if (covered * 100 < angles.size() * 95) return {};
  for (std::size_t k = 0; k < centres.size(); ++k) {
    const float below = k > 0 ? centres[k] - centres[k - 1] : centres[1] - centres[0];
    const float above = k + 1 < centres.size() ? centres[k + 1] - centres[k] : below;
    if (widths[k] > 0.6f * std::min(below, above)) return {};
  }
  for (float& angle : centres) angle = std::tan(angle);
  return centres;
}

/// `count` levels in equal steps over what is seen.
std::vector<float> equalLevels(const std::vector<float>& slope, int count) {
  const std::vector<float> angles = someElevations(slope);
  std::vector<float> levels;
  for (int k = 0; k < count && !angles.empty(); ++k)
    levels.push_back(std::tan(angles.front() + (angles.back() - angles.front()) * (static_cast<float>(k) + 0.5f) /
                                                   static_cast<float>(count)));
  return levels;
}

std::vector<std::uint16_t> nearestLevels(const std::vector<float>& slope, const std::vector<float>& levels) {
  std::vector<float> borders(levels.size() - 1);
  for (std::size_t k = 0; k < borders.size(); ++k) borders[k] = 0.5f * (levels[k] + levels[k + 1]);
  std::vector<std::uint16_t> ring(slope.size());
  for (std::size_t i = 0; i < slope.size(); ++i)
    ring[i] = static_cast<std::uint16_t>(std::upper_bound(borders.begin(), borders.end(), slope[i]) - borders.begin());
  return ring;
}

/// The azimuth at which rows of a file begin: where its steepness jumps most often.
float seamOf(const Directions& d) {
  constexpr float kJump = 0.0017f;  // 0.1 deg; along a row the elevation creeps
  constexpr std::size_t kBins = 256;
  std::vector<int> jumps(kBins);
  for (std::size_t i = 1; i < d.turn.size(); ++i)
    if (std::abs(d.slope[i] - d.slope[i - 1]) > kJump)
      ++jumps[std::min(kBins - 1, static_cast<std::size_t>(d.turn[i] * (kBins / 4.0f)))];
  std::size_t best = 0;
  int most = -1;
  for (std::size_t k = 0; k < kBins; ++k) {
    const int sum = jumps[(k + kBins - 1) % kBins] + jumps[k] + jumps[(k + 1) % kBins];
    if (sum > most) most = sum, best = k;
  }
  // The seam proper is the lower border of the busiest of the three: a row's first points lie just after it.
  std::size_t bin = best;
  for (const std::size_t k : {(best + kBins - 1) % kBins, (best + 1) % kBins})
    if (jumps[k] > jumps[bin]) bin = k;
  return static_cast<float>(bin) * (4.0f / kBins);
}

/// Rows of a file that holds one ring after the other, each a turn in the same direction. Empty when it does not.
std::vector<std::uint16_t> rowsOfFile(const Directions& d) {
  const std::size_t n = d.turn.size();
  std::size_t ahead = 0, back = 0;
  for (std::size_t i = 1; i < n; ++i) {
    const float step = d.turn[i] - d.turn[i - 1];
    ahead += step > 0 && step < 0.2f;
    back += step < 0 && step > -0.2f;
  }
  if (std::max(ahead, back) * 100 < 95 * n) return {};
  const float sign = ahead > back ? 1.0f : -1.0f, seam = seamOf(d);
  // Only a small step against the direction is jitter; any other is what is missing of a turn.
  constexpr double kJitter = 0.1;
  const auto sinceSeam = [&](std::size_t i) {
    const double turn = std::fmod(static_cast<double>(sign * (d.turn[i] - seam)) + 8.0, 4.0);
    return turn;
  };
  double unwrapped = sinceSeam(0);
  std::vector<std::uint16_t> row(n);
  for (std::size_t i = 0; i < n; ++i) {
    if (i > 0) {
      const double step = std::fmod(sinceSeam(i) - sinceSeam(i - 1) + 4.0, 4.0);
      unwrapped += step > 4.0 - kJitter ? step - 4.0 : step;
    }
    const double turns = std::floor(unwrapped / 4.0);
    if (turns >= static_cast<double>(RingFinder::kMostRings)) return {};
    row[i] = static_cast<std::uint16_t>(std::max(turns, 0.0));
  }
  return row;
}

/// Mean steepness of each row; rows without points take the one before.
std::vector<double> rowSlopes(const std::vector<std::uint16_t>& row, const std::vector<float>& slope) {
  const std::size_t rows = 1u + *std::max_element(row.begin(), row.end());
  std::vector<double> sum(rows), count(rows);
  for (std::size_t i = 0; i < row.size(); ++i) sum[row[i]] += static_cast<double>(slope[i]), count[row[i]] += 1;
  for (std::size_t r = 0; r < rows; ++r) sum[r] = count[r] > 0 ? sum[r] / count[r] : r > 0 ? sum[r - 1] : 0.0;
  return sum;
}

/// Rows numbered from the lowest. @return false when their steepness does not rise or fall row by row.
bool sortRows(std::vector<std::uint16_t>& row, const std::vector<float>& slope) {
  const std::vector<double> mean = rowSlopes(row, slope);
  std::size_t up = 0, down = 0;
  for (std::size_t r = 1; r < mean.size(); ++r) mean[r] > mean[r - 1] ? ++up : ++down;
  if (mean.size() < kFewestRings || std::max(up, down) * 10 < 8 * (mean.size() - 1)) return false;
  if (down > up)
    for (std::uint16_t& r : row) r = static_cast<std::uint16_t>(mean.size() - 1 - r);
  return true;
}

/// Points in the order of the sweep. The order of the file is that of time and wins where it goes round once.
void sortRing(std::uint32_t* begin, std::uint32_t* end, const std::vector<float>& turn) {
  std::size_t ahead = 0, back = 0;
  for (const std::uint32_t* p = begin; p + 1 < end; ++p) {
    const float step = turn[p[1]] - turn[p[0]];
    if (std::abs(step) > 2.0f) continue;  // past zero
    ahead += step > 0;
    back += step < 0;
  }
  if (std::min(ahead, back) * 50 <= static_cast<std::size_t>(end - begin)) return;
  std::sort(begin, end,
            [&turn](std::uint32_t a, std::uint32_t b) { return turn[a] != turn[b] ? turn[a] < turn[b] : a < b; });
}

ScanRings gathered(const std::vector<std::uint16_t>& ring, const std::vector<float>& turn) {
  ScanRings rings;
  std::size_t count = 0;
  for (const std::uint16_t r : ring)
    if (r < RingFinder::kMostRings) count = std::max<std::size_t>(count, r + 1u);
  rings.begin.assign(count + 1, 0);
  for (const std::uint16_t r : ring)
    if (r < count) ++rings.begin[r + 1u];
  std::partial_sum(rings.begin.begin(), rings.begin.end(), rings.begin.begin());
  rings.points.resize(rings.begin.back());
  std::vector<std::uint32_t> next(rings.begin.begin(), rings.begin.end() - 1);
  for (std::size_t i = 0; i < ring.size(); ++i)
    if (ring[i] < count) rings.points[next[ring[i]]++] = static_cast<std::uint32_t>(i);
  for (std::size_t r = 0; r < count; ++r)
    sortRing(rings.points.data() + rings.begin[r], rings.points.data() + rings.begin[r + 1], turn);
  return rings;
}

}  // namespace

void RingParams::describe(ParamVisitor& visitor) {
  visitor.field("elevation_deg", elevation_deg,
                "elevations of the beams in the sensor frame [deg], for clouds without rings; empty: from the data");
  visitor.field("virtual_rings", virtual_rings,
                "where no rings are found, cut the elevations seen into so many; 0: an error", 0, 512);
}

RingFinder::RingFinder(const RingParams& params) : virtual_rings_(params.virtual_rings) {
  for (const double elevation : params.elevation_deg)
    levels_.push_back(static_cast<float>(std::tan(elevation * M_PI / 180)));
  std::sort(levels_.begin(), levels_.end());
}

std::string RingFinder::find(const Cloud& cloud_base, const Pose& T_base_sensor, ScanRings& rings) {
  const Directions directions = directionsOf(cloud_base, T_base_sensor);
  if (cloud_base.hasRing()) {
    rings = gathered(cloud_base.ring, directions.turn);
    return rings.count() > 0 ? "" : "its ring numbers are none";
  }
  std::vector<std::uint16_t> ring;
  if (levels_.empty() && !by_rows_) levels_ = separateLevels(directions.slope);
  if (levels_.empty()) {
    ring = rowsOfFile(directions);
    if (!ring.empty() && !sortRows(ring, directions.slope)) ring.clear();
    by_rows_ = !ring.empty() || by_rows_;
  } else {
    ring = nearestLevels(directions.slope, levels_);
  }
  if (ring.empty() && virtual_rings_ > 0 && !by_rows_) {
    levels_ = equalLevels(directions.slope, virtual_rings_);
    if (!levels_.empty()) ring = nearestLevels(directions.slope, levels_);
  }
  if (ring.empty())
    return "its points carry no ring (laser number) and lie neither on levels of elevation nor row by row";
  rings = gathered(ring, directions.turn);
  return "";
}

std::string RingFinder::ringsOf(const Cloud& cloud_base, const Scan& scan, const std::string& name, bool first,
                                ScanRings& rings) {
  constexpr std::size_t kWholeScan = 1000;  // of fewer points nothing can be said
  if (scan.planar)
    throw inputError("odometry {}: it needs a 3-D scanner, the scans of '{}' are planar; use --odometry voxel_icp",
                     name, scan.label);
  const std::string why = find(cloud_base, scan.T_base_sensor, rings);
  if (!why.empty() && first && cloud_base.size() >= kWholeScan)
    throw inputError(
        "odometry {}: it needs the rings of a spinning LiDAR, but {}; give the beams "
        "(odometry.{}.rings.elevation_deg), cut it into levels (odometry.{}.rings.virtual_rings=64) or use "
        "--odometry voxel_icp",
        name, why, name, name);
  return why;
}

void RingFinder::save(ByteWriter& state) const {
  state.put(levels_);
  state.put(by_rows_);
}
void RingFinder::load(ByteReader& state) {
  state.get(levels_);
  state.get(by_rows_);
}

}  // namespace scslam
