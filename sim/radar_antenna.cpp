#include "sim/radar_antenna.h"

#include <algorithm>
#include <cmath>

namespace scslam::sim {

namespace {

const double kWidthToSigma = 1 / std::sqrt(8 * std::log(2.0));
constexpr int kCells = 1024;

double gaussian(double x, double sigma) { return std::exp(-x * x / (2 * sigma * sigma)); }

}  // namespace

RadarAntenna::RadarAntenna(double beam_azimuth, double beam_elevation, double lowest)
    : azimuth_sigma_(beam_azimuth * kWidthToSigma),
      elevation_sigma_(beam_elevation * kWidthToSigma),
      half_power_(beam_elevation / 2),
      lowest_(lowest) {
  const double reach = std::min(3.5 * elevation_sigma_, M_PI / 2);
  first_ = -std::max(reach, lowest);
  cell_ = (reach - first_) / kCells;
  cumulative_.resize(kCells);
  double sum = 0;
  for (int i = 0; i < kCells; ++i)
    cumulative_[static_cast<std::size_t>(i)] = sum += elevationGain(first_ + (i + 0.5) * cell_);
  for (double& c : cumulative_) c /= sum;
}

double RadarAntenna::azimuthGain(double azimuth) const { return gaussian(azimuth, azimuth_sigma_); }

double RadarAntenna::elevationGain(double elevation) const {
  const double main = gaussian(elevation, elevation_sigma_);
  if (elevation > -half_power_ || elevation < -lowest_) return main;
  const double tail = std::sin(half_power_) / std::sin(elevation);
  return std::max(main, 0.5 * tail * tail);
}

RadarAntenna::Elevation RadarAntenna::draw(double u) const {
  const auto found = std::lower_bound(cumulative_.begin(), cumulative_.end(), u);
  const auto i = std::min(found - cumulative_.begin(), std::ptrdiff_t{kCells - 1});
  const double before = i > 0 ? cumulative_[static_cast<std::size_t>(i - 1)] : 0;
  const double mass = cumulative_[static_cast<std::size_t>(i)] - before;
  return {first_ + (static_cast<double>(i) + (u - before) / mass) * cell_, mass / cell_};
}

}  // namespace scslam::sim
