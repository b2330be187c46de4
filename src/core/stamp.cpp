#include "scslam/core/stamp.h"

#include <fmt/format.h>

#include <chrono>
#include <cmath>

namespace scslam {
namespace {

constexpr std::int64_t kTicksPerSecond = 10'000'000;                                 // of mrpt::Clock: 100 ns
constexpr std::int64_t kUnixEpochTicks = std::int64_t{116'444'736} * 1'000'000'000;  // 1601 to 1970

std::int64_t unixTicks(Stamp stamp) { return stamp.time_since_epoch().count() - kUnixEpochTicks; }
Stamp fromUnixTicks(std::int64_t ticks) { return Stamp(Stamp::duration(ticks + kUnixEpochTicks)); }

}  // namespace

Stamp stampFromSeconds(double seconds) {
  return fromUnixTicks(static_cast<std::int64_t>(std::llround(seconds * double{kTicksPerSecond})));
}

Stamp stampFromNanoseconds(std::int64_t nanoseconds) { return fromUnixTicks(nanoseconds / 100); }

double toSeconds(Stamp stamp) { return static_cast<double>(unixTicks(stamp)) / double{kTicksPerSecond}; }

double secondsBetween(Stamp earlier, Stamp later) {
  return static_cast<double>((later - earlier).count()) / double{kTicksPerSecond};
}

std::string formatStamp(Stamp stamp) {
  const std::int64_t ticks = unixTicks(stamp);
  const std::int64_t magnitude = std::abs(ticks);
  return fmt::format("{}{}.{:07d}00", ticks < 0 ? "-" : "", magnitude / kTicksPerSecond, magnitude % kTicksPerSecond);
}

bool parseStamp(const std::string& text, Stamp& stamp) {
  const bool negative = !text.empty() && text[0] == '-';
  std::size_t i = negative || (!text.empty() && text[0] == '+') ? 1 : 0;
  std::int64_t whole = 0, fraction = 0, scale = kTicksPerSecond;
  bool any = false;
  for (; i < text.size() && text[i] >= '0' && text[i] <= '9'; ++i, any = true) {
    if (whole > 100'000'000'000) return false;
    whole = whole * 10 + (text[i] - '0');
  }
  if (i < text.size() && text[i] == '.') {
    for (++i; i < text.size() && text[i] >= '0' && text[i] <= '9'; ++i, any = true) {
      if (scale == 1) continue;  // below a tick
      scale /= 10;
      fraction += scale * (text[i] - '0');
    }
  }
  if (!any) return false;
  if (i != text.size()) {  // exponents ("1.3176177351e+09", as numpy writes) lose nothing a double has
    char* end = nullptr;
    const double seconds = std::strtod(text.c_str(), &end);
    if (end != text.c_str() + text.size() || !std::isfinite(seconds) || std::abs(seconds) > 1e11) return false;
    stamp = stampFromSeconds(seconds);
    return true;
  }
  const std::int64_t ticks = whole * kTicksPerSecond + fraction;
  stamp = fromUnixTicks(negative ? -ticks : ticks);
  return true;
}

}  // namespace scslam
