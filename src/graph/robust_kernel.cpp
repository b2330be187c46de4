#include "scslam/graph/robust_kernel.h"

#include <cmath>

namespace scslam {

RobustKernel::RobustKernel(KernelKind kind, double gate) : kind_(kind) {
  // Solves weight(gate) = 1/2 for each kernel's parameter.
  if (kind == KernelKind::kHuber) width2_ = gate / 4;
  if (kind == KernelKind::kCauchy) width2_ = gate;
  if (kind == KernelKind::kDcs) width2_ = gate / (2 * std::sqrt(2.0) - 1);
  if (kind == KernelKind::kGemanMcClure) width2_ = gate / (std::sqrt(2.0) - 1);
}

RobustKernel::Value RobustKernel::operator()(double s) const {
  switch (kind_) {
    case KernelKind::kHuber: {
      if (s <= width2_) return {s, 1};
      const double root = std::sqrt(width2_ * s);
      return {2 * root - width2_, width2_ / root};
    }
    case KernelKind::kCauchy:
      return {width2_ * std::log1p(s / width2_), 1 / (1 + s / width2_)};
    case KernelKind::kDcs: {
      // Minimum over the switch x of x^2 s + phi (1 - x)^2 with x <= 1, as DCS scales it: x = 2 phi / (phi + s).
      if (s <= width2_) return {s, 1};
      const double x = 2 * width2_ / (width2_ + s);
      return {width2_ * (3 * s - width2_) / (width2_ + s), x * x};
    }
    case KernelKind::kGemanMcClure: {
      const double x = width2_ / (width2_ + s);
      return {s * x, x * x};
    }
    case KernelKind::kNone:
      break;
  }
  return {s, 1};
}

double truncatedWeight(double s, double gate, double mu) {
  if (s >= (mu + 1) / mu * gate) return 0;
  if (s <= mu / (mu + 1) * gate) return 1;
  return std::sqrt(gate * mu * (mu + 1) / s) - mu;
}

double defaultGate(bool planar) { return planar ? 11.345 : 16.812; }

double certainGate(bool planar) { return planar ? 25.902 : 33.107; }

}  // namespace scslam
