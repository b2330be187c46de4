// Instants: 100 ns ticks of mrpt::Clock, never a double inside the program.
#pragma once
#include <mrpt/core/Clock.h>

#include <cstdint>
#include <string>

namespace scslam {

using Stamp = mrpt::Clock::time_point;

/// @param seconds since 1970-01-01 UTC (or since the start of a recording that has no calendar time).
Stamp stampFromSeconds(double seconds);
Stamp stampFromNanoseconds(std::int64_t nanoseconds);
/// Seconds since 1970-01-01 UTC; a double keeps about 0.2 us for today's dates.
double toSeconds(Stamp stamp);
/// later - earlier [s], exact to a tick.
double secondsBetween(Stamp earlier, Stamp later);
/// "1317617735.123456700": nine decimals, exact, the form of a TUM file.
std::string formatStamp(Stamp stamp);
/// Reads what formatStamp wrote, to the tick. @return false when the text is not a finite decimal number.
bool parseStamp(const std::string& text, Stamp& stamp);

}  // namespace scslam
