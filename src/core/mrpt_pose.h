// The one place where our poses meet MRPT's: MRPT orders 6-vectors as (x y z yaw pitch roll), ours are SE(3) tangents.
#pragma once
#include <mrpt/poses/CPose3D.h>
#include <mrpt/poses/CPose3DPDFGaussianInf.h>

#include "scslam/core/pose.h"

namespace scslam {

mrpt::poses::CPose3D toMrpt(const Pose& T);
Pose fromMrpt(const mrpt::poses::CPose3D& T);

/// Mean and information (of our tangent (translation, rotation vector), right perturbation) to MRPT's Gaussian over
/// (x y z yaw pitch roll), first order. Undefined at pitch = +-90 deg, as MRPT's parametrisation is.
mrpt::poses::CPose3DPDFGaussianInf toMrpt(const Pose& mean, const Matrix6d& information);
/// The inverse of the above.
void fromMrpt(const mrpt::poses::CPose3DPDFGaussianInf& pdf, Pose& mean, Matrix6d& information);

}  // namespace scslam
