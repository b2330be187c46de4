#include <algorithm>
#include <cmath>

#include "sim/radar_echoes.h"

namespace scslam::sim {

double RadarSurface::reflectivity(double cos_incidence) const {
  if (material_.metal) return 1;
  const double n2 = std::max(1.0, static_cast<double>(material_.permittivity));
  const double c = std::clamp(cos_incidence, 0.0, 1.0), root = std::sqrt(n2 - 1 + c * c);
  const double s = (c - root) / (c + root + 1e-12), p = (n2 * c - root) / (n2 * c + root + 1e-12);
  return (s * s + p * p) / 2;
}

double RadarSurface::mirrored(double cos_incidence) const {
  return (1 - static_cast<double>(material_.radar_diffuse)) * reflectivity(cos_incidence);
}

double RadarSurface::scattered(const Eigen::Vector3d& incoming, const Eigen::Vector3d& leaving,
                               const Eigen::Vector3d& normal) const {
  const double cos_in = -normal.dot(incoming), cos_out = normal.dot(leaving);
  if (!(cos_in > 0) || !(cos_out > 0)) return 0;
  const double diffuse = static_cast<double>(material_.radar_diffuse);
  // Lommel-Seeliger: towards grazing, backscatter falls with the sine as ground clutter does ("constant gamma"), not
  // with its square as Lambert's. A share 1 - ln 2 of its albedo / 2 comes back at normal incidence.
  constexpr double kAlbedo = 2 / (1 - M_LN2), kMeanCosine = 0.7;
  const double rough = diffuse * reflectivity(kMeanCosine) * kAlbedo / (4 * M_PI * (cos_in + cos_out)) * cos_out;
  const Eigen::Vector3d half = (leaving - incoming).normalized();
  const double cos_half = normal.dot(half), c2 = cos_half * cos_half, s2 = slope_ * slope_;
  const double exponent = (1 - c2) / (2 * s2 * std::max(c2, 1e-9));
  if (exponent > 40) return rough;
  const double facets = std::exp(-exponent) / (2 * M_PI * s2 * c2 * c2);
  constexpr double kGrazing = 0.05;  // nearer to the horizon facets hide each other
  return rough + mirrored(half.dot(leaving)) * facets / (4 * std::max(cos_in, kGrazing));
}

}  // namespace scslam::sim
