#pragma once

namespace scslam {

/// The most memory this process has held so far [MB].
double peakRssMb();

}  // namespace scslam
