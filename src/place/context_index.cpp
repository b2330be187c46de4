#include "scslam/place/context_index.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

namespace scslam {
namespace {

/// Squared length of the weighted columns among `columns`.
double length2Within(const ContextProbe& image, std::uint64_t columns) {
  double length2 = image.length2;
  for (std::uint64_t hidden = image.seen & ~columns; hidden != 0; hidden &= hidden - 1)
    length2 -= image.lengths2[static_cast<std::size_t>(std::countr_zero(hidden))];
  return length2;
}

}  // namespace

ContextIndex::ContextIndex(const ContextLayout& layout)
    : layout_(layout),
      period_(layout.circular ? layout.columns : layout.columns + layout.max_shift),
      spectra_(layout.rows, period_),
      keys_(layout.rows) {}

ContextProbe ContextIndex::probe(const Descriptor& image) const {
  ContextProbe probe;
  std::vector<float> columns(layout_.rows * period_, 0.0f);  // row-major
  probe.lengths2.assign(layout_.columns, 0.0f);
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
    const double weight = std::pow(norm2, 0.5 * layout_.column_weight);
    const auto scale = static_cast<float>(weight / std::sqrt(norm2));
    probe.lengths2[j] = static_cast<float>(weight * weight);
    probe.length2 += probe.lengths2[j];
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

std::uint64_t ContextIndex::shifted(std::uint64_t columns, std::size_t shift) const {
  const std::uint64_t all = period_ == 64 ? ~std::uint64_t{0} : (std::uint64_t{1} << period_) - 1;
  return shift == 0 ? columns : (columns >> shift | columns << (period_ - shift)) & all;
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
    const std::uint64_t common = allowed ? probe.seen & shifted(other.seen, s) : 0;
    distance[s] = 1;
    if (std::popcount(common) >= enough) {
      const double lengths2 =
          length2Within(probe, common) * length2Within(other, shifted(common, (period_ - s) % period_));
      distance[s] = std::clamp(1 - static_cast<double>(similarity[s]) / std::sqrt(lengths2), 0.0, 1.0);
    }
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
