// From a sweep as it was recorded to a Scan that can be relied on.
#pragma once
#include "scslam/sensor/scan.h"

namespace scslam {

/// Marks as not measured what cannot be: azimuths that point where the one measured before pointed, or back (the
/// encoder stands), or whose stamp is before it or more than a minute after it. Gives all azimuths that were not
/// measured stamps and angles between those of their neighbours, at the pace of the sweep where there is none.
/// @return how many azimuths are not measured.
std::size_t mendSweep(RadarScan& sweep);

/// Puts the stamps on the straight line through them (least squares over the measured azimuths): recorders stamp rows
/// by the packet, up to 8 ms late, while the antenna turns evenly. Left as they are where a row is more than a tenth of
/// the sweep off that line.
void evenStamps(RadarScan& sweep);

/// A planar scan without points whose stamp is its first azimuth's. The sweep is mended, its stamps are
/// evened.
Scan scanOfSweep(RadarScan sweep);

}  // namespace scslam
