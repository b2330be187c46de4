#include "scslam/sensor/oxford_radar.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/grey_png.h"

namespace scslam {
namespace {

constexpr std::size_t kHead = 11;                                    // bytes of a row before its first bin
constexpr std::size_t kMaxRows = 1 << 14, kMaxColumns = 1 << 16;     // what a file may state
constexpr std::size_t kMaxFileBytes = std::size_t{1} << 28;          // a real one has half a megabyte
constexpr std::int64_t kMaxMicroseconds = 9'000'000'000'000'000;     // year 2255: nanoseconds still fit 64 bits
constexpr std::int64_t kLeastNanoseconds = 100'000'000'000'000'000;  // 1973; as us it would be the year 5138
constexpr double kRadPerCount = 2 * M_PI / kNavtechEncoderCounts;

std::uint64_t littleEndian(const std::uint8_t* bytes, std::size_t count) {
  std::uint64_t value = 0;
  for (std::size_t i = count; i-- > 0;) value = value << 8 | bytes[i];
  return value;
}

void putLittleEndian(std::uint64_t value, std::size_t count, std::uint8_t* bytes) {
  for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::uint8_t>(value >> (8 * i));
}

std::int64_t microsecondsOf(Stamp stamp) {
  return std::chrono::floor<std::chrono::microseconds>(stamp - stampFromNanoseconds(0)).count();
}

/// MulRan's converter wrote nanoseconds where Oxford has microseconds.
Stamp stampOfHead(std::int64_t time, std::size_t row, const std::string& name) {
  if (time >= kLeastNanoseconds) return stampFromNanoseconds(time);
  if (time < 0 || time > kMaxMicroseconds) throw inputError("{}: row {} has an absurd stamp ({})", name, row, time);
  return stampFromNanoseconds(time * 1000);
}

void readHead(const std::uint8_t* head, std::size_t row, const std::string& name, const OxfordRadarFormat& format,
              RadarScan& scan) {
  const auto encoder = littleEndian(head + 8, 2);
  scan.valid[row] = format.validity ? head[10] : 255;
  const bool counts = scan.valid[row] != 0;  // what a row states that was not measured is left alone
  if (counts && encoder >= kNavtechEncoderCounts)
    throw inputError("{}: row {} has encoder {}, beyond {}: no radar image of the Oxford layout", name, row, encoder,
                     kNavtechEncoderCounts - 1);
  scan.stamps[row] = stampOfHead(static_cast<std::int64_t>(littleEndian(head, 8)), row, name);
  scan.angles[row] = static_cast<double>(encoder % kNavtechEncoderCounts) * kRadPerCount;
  if (counts && row > 0 && scan.valid[row - 1] != 0 && scan.stamps[row] < scan.stamps[row - 1])
    throw inputError("{}: the stamp of row {} is before that of the row above", name, row);
}

}  // namespace

RadarScan decodeOxfordRadar(std::string_view png, const std::string& name, const OxfordRadarFormat& format) {
  const GreyImage image = decodeGreyPng(png, name + " (a radar image of the Oxford layout)");
  if (image.columns <= kHead) throw inputError("{}: {} columns are too few for a radar image", name, image.columns);
  RadarScan scan;
  scan.resize(image.rows, image.columns - kHead);
  for (std::size_t row = 0; row < image.rows; ++row) {
    const std::uint8_t* bytes = image.pixels.data() + row * image.columns;
    readHead(bytes, row, name, format, scan);
    std::memcpy(scan.row(row).data(), bytes + kHead, scan.bins);
  }
  scan.range_resolution_m = format.range_resolution_m;
  scan.range_offset_m = format.range_offset_m;
  scan.label = format.label;
  scan.T_base_sensor = format.T_base_sensor;
  return scan;
}

RadarScan readOxfordRadar(const std::filesystem::path& file, const OxfordRadarFormat& format) {
  return decodeOxfordRadar(readFile(file, kMaxFileBytes), file.string(), format);
}

std::string encodeOxfordRadar(const RadarScan& scan) {
  GreyImage image;
  image.rows = scan.azimuths, image.columns = kHead + scan.bins;
  if (!scan.consistent() || scan.azimuths == 0 || scan.bins == 0 || image.rows > kMaxRows ||
      image.columns > kMaxColumns)
    throw inputError("a radar scan of {} x {} cannot be written as PNG", scan.azimuths, scan.bins);
  image.pixels.resize(image.rows * image.columns);
  for (std::size_t i = 0; i < scan.azimuths; ++i) {
    const std::int64_t microseconds = microsecondsOf(scan.stamps[i]);
    if (microseconds < 0 || microseconds > kMaxMicroseconds || !std::isfinite(scan.angles[i]))
      throw inputError("row {} of a radar scan has no stamp or angle that a PNG can hold", i);
    const double turn = scan.angles[i] / (2 * M_PI);
    const auto encoder = static_cast<std::uint64_t>(std::lround((turn - std::floor(turn)) * kNavtechEncoderCounts));
    std::uint8_t* row = image.pixels.data() + i * image.columns;
    putLittleEndian(static_cast<std::uint64_t>(microseconds), 8, row);
    putLittleEndian(encoder % kNavtechEncoderCounts, 2, row + 8);
    row[10] = scan.valid[i];
    std::memcpy(row + kHead, scan.row(i).data(), scan.bins);
  }
  return encodeGreyPng(image, false);
}

}  // namespace scslam
