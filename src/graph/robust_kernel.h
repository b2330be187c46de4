// Robust kernels as functions of s = r^T Lambda r. Whatever the kernel, the weight falls below 1/2 exactly where s
// exceeds `gate`: such a factor counts as rejected.
#pragma once
#include <string>
#include <vector>

namespace scslam {

enum class KernelKind { kNone, kHuber, kCauchy, kDcs, kGemanMcClure };

class RobustKernel {
 public:
  explicit RobustKernel(KernelKind kind = KernelKind::kNone, double gate = 1);
  struct Value {
    double rho;     ///< cost in place of s
    double weight;  ///< rho'(s), in [0, 1]
  };
  /// Huber; Cauchy; dynamic covariance scaling (Agarwal et al., ICRA 2013) in its closed form; Geman-McClure.
  Value operator()(double s) const;
  KernelKind kind() const { return kind_; }

 private:
  KernelKind kind_;
  double width2_ = 1;  ///< the kernel's own parameter, squared
};

/// Truncated least squares of graduated non-convexity (Yang et al., RA-L 2020, Eq. 14): 1 for consistent factors, 0 for
/// inconsistent ones, a slope between that becomes a step as mu grows.
double truncatedWeight(double s, double gate, double mu);

/// 99 % quantile of the chi-square distribution for 6 (SE(3)) or 3 (SE(2)) degrees of freedom: where kernels weigh 1/2.
double defaultGate(bool planar);
/// The 99.999 % quantile: where a loop is thrown out for good. Of thousands of true loops none should be lost.
double certainGate(bool planar);

}  // namespace scslam
