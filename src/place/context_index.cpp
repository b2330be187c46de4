#include "scslam/place/context_index.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace scslam {

ContextIndex::ContextIndex(const ContextLayout& layout)
    : layout_(layout),
      period_(layout.circular ? layout.columns : layout.columns + layout.max_shift),
      spectra_(layout.rows, period_),
      keys_(layout.rows) {}

ContextProbe ContextIndex::probe(const Descriptor& image) const {
  ContextProbe probe;
  std::vector<float> columns(layout_.rows * period_, 0.0f);  // row-major, unit columns
  std::vector<double> key(layout_.rows, 0.0);
  std::vector<float> column(layout_.rows);
  for (std::size_t j = 0; j < layout_.columns; ++j) {
    double norm2 = 0;
    for (std::size_t r = 0; r < layout_.rows; ++r) {
      const float height = std::max(0.0f, image(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(j)));
      column[r] = layout_.logarithmic ? std::log1p(height) : height;
      key[r] += column[r];
      norm2 += column[r] * column[r];
    }
    if (!(norm2 > 0)) continue;
    probe.seen |= std::uint64_t{1} << j;
    const auto scale = static_cast<float>(1 / std::sqrt(norm2));
    for (std::size_t r = 0; r < layout_.rows; ++r) columns[r * period_ + j] = column[r] * scale;
  }
  // The mean over what was seen: a blind sector does not make a place look flat.
  const double seen = std::max(1, std::popcount(probe.seen));
  for (const double sum : key) probe.key.push_back(static_cast<float>(sum / seen));
  probe.spectrum.resize(spectra_.size());
  spectra_.transform(columns.data(), probe.spectrum);
  return probe;
}

void ContextIndex::add(ContextProbe place) {
  if (keys_.size() % kBlock == 0) places_.emplace_back().reserve(kBlock);
  keys_.add(place.key.data());
  places_.back().push_back(std::move(place));
}

void ContextIndex::search(const ContextProbe& probe, std::size_t n, std::size_t count,
                          std::vector<Match>& matches) const {
  std::vector<KeyIndex::Neighbour> nearest;
  nearest.reserve(std::min(n, count));
  keys_.nearest(probe.key.data(), n, count, nearest);
  for (const auto& neighbour : nearest) matches.push_back(compare(probe, neighbour.id));
}

int ContextIndex::commonColumns(std::uint64_t probe, std::uint64_t place, std::size_t shift) const {
  const std::uint64_t all = period_ == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << period_) - 1;
  const std::uint64_t shifted = shift == 0 ? place : (place >> shift | place << (period_ - shift));
  return std::popcount(probe & shifted & all);
}

ContextIndex::Match ContextIndex::compare(const ContextProbe& probe, std::size_t id) const {
  const ContextProbe& other = place(id);
  float similarity[ColumnSpectra::kMaxColumns];
  spectra_.correlate(probe.spectrum.data(), other.spectrum.data(), similarity);
  const int seen = std::min(std::popcount(probe.seen), std::popcount(other.seen));
  const int enough = std::max(1, static_cast<int>(std::ceil(layout_.min_common * seen)));
  std::array<double, ColumnSpectra::kMaxColumns> distance;
  std::size_t best = 0;
  for (std::size_t s = 0; s < period_; ++s) {
    const bool allowed = layout_.circular || s <= layout_.max_shift || s >= period_ - layout_.max_shift;
    const int common = allowed ? commonColumns(probe.seen, other.seen, s) : 0;
    distance[s] = common < enough ? 1 : std::clamp(1 - static_cast<double>(similarity[s]) / common, 0.0, 1.0);
    if (distance[s] < distance[best]) best = s;
  }
  const double left = distance[(best + period_ - 1) % period_], right = distance[(best + 1) % period_];
  const double curvature = left - 2 * distance[best] + right;
  const double between = curvature > 1e-9 ? std::clamp(0.5 * (left - right) / curvature, -0.5, 0.5) : 0;
  const double shift = static_cast<double>(best) + between;
  const double period = static_cast<double>(period_);
  return {id, distance[best], shift > 0.5 * period ? shift - period : shift};
}

}  // namespace scslam
