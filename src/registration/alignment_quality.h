// Is a registered pose right? Judged by figures that people can read, weighed by logistic regression. The weights are
// data: `scslam learn` finds them from sessions whose truth is known.
//
// Points of two scans that are laid on each other well are as crisp together as each scan is alone; laid wrongly, they
// blur: the entropy of the joint cloud against that of the single ones (D. Adolfsson et al., "CorAl: Introspection for
// robust radar and lidar perception in diverse environments using differential entropy", RAS 2022).
#pragma once
#include <string>

#include "scslam/core/params.h"
#include "scslam/registration/registration.h"

namespace scslam {

struct AlignmentFeatures {
  double blur = 0;    ///< entropy of both together above that of each alone, mean over the scan's points [nat]
  double shared = 0;  ///< share of the scan's points with points of the target around them
  double rmse_m = 0;  ///< RegistrationResult's
};

/// @param radius_m of the surroundings of a point. @param planar 2-D data: entropy in the plane.
AlignmentFeatures alignmentFeatures(const Cloud& query, const Cloud& target, const RegistrationResult& result,
                                    double radius_m, bool planar);

/// Weights of the features, and from which probability on a pose is believed.
struct QualityParams : ParamSetOf<QualityParams> {
  bool on = false;
  double min_probability = 0.5;
  double radius_m = 1.5;
  double bias = 0, blur = 0, shared = 0, rmse_m = 0;
  void describe(ParamVisitor& v) override;
};

/// That the pose is right, 0..1.
double probabilityOf(const AlignmentFeatures& features, const QualityParams& params);
/// Empty when it is believed.
std::string refusal(const AlignmentFeatures& features, const QualityParams& params);

}  // namespace scslam
