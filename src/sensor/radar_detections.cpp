#include "scslam/sensor/radar_detections.h"

#include <algorithm>
#include <cmath>

namespace scslam {
namespace {

constexpr std::size_t kRowsPerChunk = 50;

struct AzimuthDetections {
  std::size_t azimuth = 0, count = 0;
};

struct Chunk {
  std::vector<AzimuthDetections> rows;
  std::vector<RadarDetection> detections;
};

void append(Cloud& cloud, const RadarScan& scan, const Chunk& chunk) {
  auto next = chunk.detections.begin();
  for (const auto& [azimuth, count] : chunk.rows) {
    const Eigen::Vector3d direction = scan.direction(azimuth);
    const auto dt = static_cast<float>(secondsBetween(scan.stamps.front(), scan.stamps[azimuth]));
    for (const auto end = next + static_cast<std::ptrdiff_t>(count); next != end; ++next) {
      const Eigen::Vector3d p = scan.rangeAt(static_cast<double>(next->position)) * direction;
      cloud.push(static_cast<float>(p.x()), static_cast<float>(p.y()), 0.F);
      cloud.intensity.push_back(next->power);
      cloud.dt.push_back(dt);
      cloud.ring.push_back(static_cast<std::uint16_t>(azimuth));
    }
  }
}

/// Two neighbouring peaks may have been refined to one place: the first stays.
void keepRising(std::vector<RadarDetection>& detections, std::size_t from) {
  std::size_t kept = from;
  for (std::size_t i = from; i < detections.size(); ++i)
    if (kept == from || detections[i].position > detections[kept - 1].position) detections[kept++] = detections[i];
  detections.resize(kept);
}

/// Middle of the run of equal bins around `at`.
float middleOfRun(std::span<const std::uint8_t> row, std::size_t at) {
  std::size_t first = at, last = at;
  while (first > 0 && row[first - 1] == row[at]) --first;
  while (last + 1 < row.size() && row[last + 1] == row[at]) ++last;
  return 0.5F * static_cast<float>(first + last + 1);
}

}  // namespace

void RadarWindowParams::describeWindow(ParamVisitor& v) {
  v.field("min_range_m", min_range_m, "nearer bins are not looked at [m]", 0, 1000);
  v.field("max_range_m", max_range_m, "nor are farther ones [m]", 1, 10'000);
  v.field("echo_width_m", echo_width_m, "width of a point target's echo; positions are fitted over it [m]", 0.001, 100);
}

RadarWindowParams::Bins RadarWindowParams::binsOf(const RadarScan& scan) const {
  if (!(scan.range_resolution_m > 0) || scan.bins < 3) return {};
  const auto bin = [&](double range_m) {
    const double position = (range_m - scan.range_offset_m) / scan.range_resolution_m;
    return static_cast<std::size_t>(std::clamp(std::ceil(position), 0.0, static_cast<double>(scan.bins)));
  };
  Bins bins;
  bins.begin = bin(min_range_m), bins.end = bin(max_range_m);
  const double half = 0.5 * echo_width_m / scan.range_resolution_m;
  bins.half_width = static_cast<std::size_t>(std::clamp(std::round(half), 1.0, static_cast<double>(scan.bins)));
  return bins;
}

RadarDetection refinedPeak(std::span<const std::uint8_t> row, std::size_t at, std::size_t half_width) {
  const float middle = middleOfRun(row, at);
  const auto centre = std::min(static_cast<std::size_t>(middle), row.size() - 1);
  const auto reach = static_cast<std::int64_t>(std::min({half_width, centre, row.size() - 1 - centre}));
  // Sums over x = -reach … reach of a symmetric window leave y ~ a + b x + c x^2 with b = sum(xy) / sum(x^2) and c from
  // the other two normal equations.
  std::int64_t n = 0, x2 = 0, x4 = 0, y = 0, xy = 0, x2y = 0;
  for (std::int64_t x = -reach; x <= reach; ++x) {
    const std::int64_t value = row[static_cast<std::size_t>(static_cast<std::int64_t>(centre) + x)];
    ++n, x2 += x * x, x4 += x * x * x * x;
    y += value, xy += x * value, x2y += x * x * value;
  }
  const std::int64_t curvature = n * x2y - x2 * y;  // c times a positive determinant
  if (reach > 0 && curvature < 0) {
    const auto determinant = static_cast<double>(n * x4 - x2 * x2);
    const double b = static_cast<double>(xy) / static_cast<double>(x2),
                 c = static_cast<double>(curvature) / determinant;
    const double vertex = -b / (2 * c);
    if (std::abs(vertex) <= std::max(1.0, 0.5 * static_cast<double>(reach)))
      return {static_cast<float>(static_cast<double>(centre) + 0.5 + vertex), static_cast<float>(row[at])};
  }
  return {middle, static_cast<float>(row[at])};
}

void findPeaks(std::span<const std::uint8_t> row, const RadarWindowParams::Bins& bins, int floor,
               std::vector<std::size_t>& peaks) {
  peaks.clear();
  for (std::size_t i = bins.begin; i < bins.end; ++i) {
    const std::uint8_t power = row[i];
    if (power < floor || (i > 0 && row[i - 1] >= power) || (i + 1 < row.size() && row[i + 1] > power)) continue;
    const std::size_t first = i - std::min(i, bins.half_width), last = std::min(row.size(), i + bins.half_width + 1);
    std::uint8_t before = 0, behind = 0;
    for (std::size_t k = first; k < i; ++k) before = std::max(before, row[k]);
    for (std::size_t k = i + 1; k < last; ++k) behind = std::max(behind, row[k]);
    if ((i == 0 || before < power) && behind <= power) peaks.push_back(i);
  }
}

Cloud radarCloud(const RadarScan& scan, ThreadPool& threads,
                 const std::function<void(std::size_t azimuth, std::vector<RadarDetection>& detections)>& detect) {
  Cloud cloud;
  if (!scan.consistent()) return cloud;
  std::vector<Chunk> chunks(chunkCount(scan.azimuths, kRowsPerChunk));
  threads.forEachChunk(scan.azimuths, kRowsPerChunk, [&](std::size_t begin, std::size_t end, std::size_t number) {
    Chunk& chunk = chunks[number];
    for (std::size_t azimuth = begin; azimuth < end; ++azimuth) {
      if (scan.valid[azimuth] == 0 || !std::isfinite(scan.angles[azimuth])) continue;
      const std::size_t before = chunk.detections.size();
      detect(azimuth, chunk.detections);
      keepRising(chunk.detections, before);
      chunk.rows.push_back({azimuth, chunk.detections.size() - before});
    }
  });
  for (const Chunk& chunk : chunks) append(cloud, scan, chunk);
  return cloud;
}

}  // namespace scslam
