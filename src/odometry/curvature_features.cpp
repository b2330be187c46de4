#include "scslam/odometry/curvature_features.h"

#include <algorithm>
#include <cmath>

#include "scslam/core/simd.h"

namespace scslam {

void CurvatureParams::describe(ParamVisitor& visitor) {
  visitor.field("sectors", sectors, "parts of a ring that give features each", 1, 360);
  visitor.field("sharp", sharp, "sharpest edges a sector, matched scan to scan", 0, 1000);
  visitor.field("less_sharp", less_sharp, "edges a sector, matched with the map", 0, 1000);
  visitor.field("flat", flat, "flattest points a sector, matched scan to scan", 0, 1000);
  visitor.field("edge_m", edge_m, "an edge stands out from its neighbours by more than this [m]", 0.0, 10.0);
  visitor.field("edge_share", edge_share, "and by more than this share of its neighbourhood's half length", 0.0, 2.0);
  visitor.field("flat_m", flat_m, "a flat point stands out from its neighbours by less than this [m]", 0.0, 10.0);
  visitor.field("hidden_m", hidden_m, "a step in range that hides what lies behind it [m]", 0.0, 100.0);
  visitor.field("grazing_share", grazing_share,
                "a beam grazes its surface where the ranges on both sides differ by more than this share", 0.0, 1.0);
}

namespace {

constexpr std::size_t kHalf = 5;  // neighbours on each side

/// One ring, gathered: what the selection looks at.
struct Ring {
  std::vector<float> x, y, z, range;
  std::vector<float> stands_out;   ///< o_i [m]
  std::vector<std::uint8_t> flaw;  ///< no edge may be here
  std::vector<std::uint8_t> role;  ///< FeatureRole
  std::size_t size() const { return x.size(); }
};

SCSLAM_KERNEL
void standOut(const float* x, const float* y, const float* z, std::size_t n, float* out) {
  for (std::size_t i = kHalf; i + kHalf < n; ++i) {
    float sx = 0, sy = 0, sz = 0;
    for (std::size_t k = i - kHalf; k <= i + kHalf; ++k) sx += x[k], sy += y[k], sz += z[k];
    constexpr float kAll = 2 * kHalf + 1;
    sx -= kAll * x[i], sy -= kAll * y[i], sz -= kAll * z[i];
    out[i] = std::sqrt(sx * sx + sy * sy + sz * sz) / (2 * kHalf);
  }
}

Ring gatherRing(const Cloud& cloud, const std::uint32_t* points, std::size_t n, const Eigen::Vector3f& origin,
                const std::vector<std::uint8_t>& roles) {
  Ring ring;
  ring.role.assign(n, kMayBeAll);
  for (std::size_t i = 0; i < n && !roles.empty(); ++i) ring.role[i] = roles[points[i]];
  for (auto* field : {&ring.x, &ring.y, &ring.z, &ring.range, &ring.stands_out}) field->assign(n, 0.0f);
  ring.flaw.assign(n, 0);
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Vector3f p = cloud.point(points[i]) - origin;
    ring.x[i] = p.x(), ring.y[i] = p.y(), ring.z[i] = p.z();
    ring.range[i] = p.norm();
  }
  standOut(ring.x.data(), ring.y.data(), ring.z.data(), n, ring.stands_out.data());
  return ring;
}

/// Marks what only looks like an edge.
void markFlaws(Ring& ring, const CurvatureParams& params) {
  constexpr float kNeighbours = 0.05f;  // [rad] farther apart, nothing is known of what lies between
  const auto hidden = static_cast<float>(params.hidden_m), grazing = static_cast<float>(params.grazing_share);
  const std::size_t n = ring.size();
  for (std::size_t i = kHalf; i + kHalf + 1 < n; ++i) {
    const float here = ring.range[i], next = ring.range[i + 1];
    const float chord2 = (ring.x[i] - ring.x[i + 1]) * (ring.x[i] - ring.x[i + 1]) +
                         (ring.y[i] - ring.y[i + 1]) * (ring.y[i] - ring.y[i + 1]) +
                         (ring.z[i] - ring.z[i + 1]) * (ring.z[i] - ring.z[i + 1]);
    const float across2 = chord2 - (here - next) * (here - next);  // squared length across the beams
    if (across2 < kNeighbours * kNeighbours * here * next) {
      // The farther side ends where the nearer one hides it: that border moves with the sensor.
      if (here - next > hidden) std::fill_n(&ring.flaw[i - kHalf], kHalf + 1, std::uint8_t{1});
      if (next - here > hidden) std::fill_n(&ring.flaw[i + 1], kHalf, std::uint8_t{1});
    }
    const float before = ring.range[i - 1];
    if (std::abs(here - before) > grazing * here && std::abs(here - next) > grazing * here) ring.flaw[i] = 1;
  }
}

/// Takes point i and leaves its near neighbours alone, so that one edge is not taken many times.
void take(std::vector<std::uint8_t>& taken, const Ring& ring, std::size_t i) {
  constexpr float kNear2 = 0.05f;  // [m^2] between neighbours
  const auto near = [&ring](std::size_t a, std::size_t b) {
    const float dx = ring.x[a] - ring.x[b], dy = ring.y[a] - ring.y[b], dz = ring.z[a] - ring.z[b];
    return dx * dx + dy * dy + dz * dz <= kNear2;
  };
  taken[i] = 1;
  for (std::size_t k = i + 1; k <= std::min(i + kHalf, ring.size() - 1) && near(k, k - 1); ++k) taken[k] = 1;
  for (std::size_t k = i; k > 0 && i - k < kHalf && near(k, k - 1); --k) taken[k - 1] = 1;
}

enum Label : std::uint8_t { kPlain, kEdge };

void selectSector(const Ring& ring, const std::uint32_t* points, std::size_t begin, std::size_t end, float half_length,
                  const CurvatureParams& params, std::vector<Label>& label, CurvatureFeatures& out) {
  std::vector<std::uint32_t> order(end - begin);
  for (std::size_t k = 0; k < order.size(); ++k) order[k] = static_cast<std::uint32_t>(begin + k);
  const auto by_curvature = [&ring](std::uint32_t a, std::uint32_t b) {
    return ring.stands_out[a] != ring.stands_out[b] ? ring.stands_out[a] < ring.stands_out[b] : a < b;
  };
  std::vector<std::uint8_t> taken(ring.flaw);

  // Only what stands out enough is sorted.
  const auto isEdge = [&](std::uint32_t i) {
    const float least = std::max(static_cast<float>(params.edge_m),
                                 static_cast<float>(params.edge_share) * half_length * ring.range[i]);
    return ring.stands_out[i] > least && !ring.flaw[i] && (ring.role[i] & kMayBeEdge) != 0;
  };
  std::vector<std::uint32_t> edges;
  std::copy_if(order.begin(), order.end(), std::back_inserter(edges), isEdge);
  std::sort(edges.begin(), edges.end(), by_curvature);
  int picked = 0;
  for (auto it = edges.rbegin(); it != edges.rend() && picked < params.less_sharp; ++it) {
    if (taken[*it]) continue;
    if (picked++ < params.sharp) out.sharp.push_back(points[*it]);
    out.less_sharp.push_back(points[*it]);
    label[*it] = kEdge;
    take(taken, ring, *it);
  }

  std::vector<std::uint32_t> flats;
  std::copy_if(order.begin(), order.end(), std::back_inserter(flats), [&](std::uint32_t i) {
    return ring.stands_out[i] < static_cast<float>(params.flat_m) && label[i] == kPlain &&
           (ring.role[i] & kMayBeFlat) != 0;
  });
  // A few times as many as are wanted: neighbours of one taken are passed over.
  const std::size_t enough = std::min(flats.size(), static_cast<std::size_t>(12 * params.flat));
  std::partial_sort(flats.begin(), flats.begin() + static_cast<std::ptrdiff_t>(enough), flats.end(), by_curvature);
  picked = 0;
  for (std::size_t k = 0; k < enough && picked < params.flat; ++k) {
    if (taken[flats[k]]) continue;
    ++picked;
    out.flat.push_back(points[flats[k]]);
    take(taken, ring, flats[k]);
  }
}

void addSurface(const Ring& ring, const std::uint32_t* points, const std::vector<Label>& label,
                CurvatureFeatures& out) {
  for (std::size_t i = 0; i < ring.size(); ++i)
    if (label[i] == kPlain && (ring.role[i] & kMayBeSurface) != 0) out.less_flat.push_back(points[i]);
}

CurvatureFeatures featuresOfRing(const Cloud& cloud, const std::uint32_t* points, std::size_t n,
                                 const Eigen::Vector3f& origin, const CurvatureParams& params,
                                 const std::vector<std::uint8_t>& roles) {
  CurvatureFeatures out;
  Ring ring = gatherRing(cloud, points, n, origin, roles);
  if (n < 4 * kHalf) {
    addSurface(ring, points, std::vector<Label>(n, kPlain), out);
    return out;
  }
  markFlaws(ring, params);
  std::vector<Label> label(n, kPlain);
  // Half the neighbourhood's length at a range of 1 m. The ring may have gaps: the usual spacing is the median.
  std::vector<float> spacing(n - 1);
  for (std::size_t i = 0; i + 1 < n; ++i)
    spacing[i] = std::hypot(ring.x[i + 1] / ring.range[i + 1] - ring.x[i] / ring.range[i],
                            ring.y[i + 1] / ring.range[i + 1] - ring.y[i] / ring.range[i]);
  std::nth_element(spacing.begin(), spacing.begin() + static_cast<std::ptrdiff_t>(n / 2), spacing.end());
  const float half_length = kHalf * spacing[n / 2];
  const std::size_t inner = n - 2 * kHalf, sectors = static_cast<std::size_t>(params.sectors);
  for (std::size_t s = 0; s < sectors; ++s)
    selectSector(ring, points, kHalf + inner * s / sectors, kHalf + inner * (s + 1) / sectors, half_length, params,
                 label, out);
  addSurface(ring, points, label, out);
  return out;
}

void append(const std::vector<std::uint32_t>& part, std::vector<std::uint32_t>& all) {
  all.insert(all.end(), part.begin(), part.end());
}

}  // namespace

CurvatureFeatures curvatureFeatures(const Cloud& cloud, const ScanRings& rings, const Eigen::Vector3f& origin,
                                    const CurvatureParams& params, ThreadPool& threads,
                                    const std::vector<std::uint8_t>& roles) {
  std::vector<CurvatureFeatures> parts(rings.count());
  threads.forEachChunk(rings.count(), 1, [&](std::size_t begin, std::size_t end, std::size_t) {
    for (std::size_t r = begin; r < end; ++r)
      if (rings.size(r) > 0) parts[r] = featuresOfRing(cloud, rings.ring(r), rings.size(r), origin, params, roles);
  });
  CurvatureFeatures all;
  for (const CurvatureFeatures& part : parts) {
    append(part.sharp, all.sharp);
    append(part.less_sharp, all.less_sharp);
    append(part.flat, all.flat);
    append(part.less_flat, all.less_flat);
  }
  return all;
}

}  // namespace scslam
