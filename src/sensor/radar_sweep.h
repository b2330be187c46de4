// From a sweep as it was recorded to a Scan that can be relied on.
#pragma once
#include "scslam/sensor/scan.h"

namespace scslam {

/// Marks as not measured what cannot be: azimuths that point where the one measured before pointed, or back (the
/// encoder stands), or whose stamp is before it or more than a minute after it. Gives all azimuths that were not
/// measured stamps and angles between those of their neighbours, at the pace of the sweep where there is none.
/// @return how many azimuths are not measured.
std::size_t mendSweep(RadarScan& sweep);

/// A planar scan without points whose stamp is its first azimuth's. The sweep is mended.
Scan scanOfSweep(RadarScan sweep);

}  // namespace scslam
