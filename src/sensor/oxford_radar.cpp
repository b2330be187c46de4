#include "scslam/sensor/oxford_radar.h"

#include <png.h>

#include <cmath>
#include <cstring>

#include "scslam/core/error.h"
#include "scslam/core/file.h"

namespace scslam {
namespace {

constexpr std::size_t kHead = 11;                                 // bytes of a row before its first bin
constexpr std::size_t kMaxRows = 1 << 14, kMaxColumns = 1 << 16;  // what a file may state
constexpr std::size_t kMaxFileBytes = std::size_t{1} << 28;       // a real one has half a megabyte
constexpr std::int64_t kMaxMicroseconds = 9'000'000'000'000'000;  // year 2255: nanoseconds still fit 64 bits
constexpr double kRadPerCount = 2 * M_PI / kNavtechEncoderCounts;

/// libpng wants to be left by an exception, a long jump, or never.
struct PngError {
  std::string message;
};
[[noreturn]] void onError(png_structp, png_const_charp message) { throw PngError{message}; }
void onWarning(png_structp, png_const_charp) {}

/// Reads from memory.
class PngReader {
 public:
  explicit PngReader(std::string_view bytes) : bytes_(bytes) {
    png_ = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, onError, onWarning);
    if (png_ != nullptr) info_ = png_create_info_struct(png_);
    if (info_ == nullptr) throw std::bad_alloc();
    png_set_user_limits(png_, kMaxColumns, kMaxRows);
    png_set_read_fn(png_, this, [](png_structp png, png_bytep to, png_size_t count) {
      static_cast<PngReader*>(png_get_io_ptr(png))->take(png, to, count);
    });
  }
  ~PngReader() { png_destroy_read_struct(&png_, &info_, nullptr); }
  PngReader(const PngReader&) = delete;
  PngReader& operator=(const PngReader&) = delete;

  /// @return rows x columns bytes.
  std::vector<std::uint8_t> grey(std::size_t& rows, std::size_t& columns) {
    png_read_info(png_, info_);
    rows = png_get_image_height(png_, info_), columns = png_get_image_width(png_, info_);
    if (png_get_color_type(png_, info_) != PNG_COLOR_TYPE_GRAY || png_get_bit_depth(png_, info_) != 8)
      throw PngError{"not 8-bit grey"};
    if (png_get_interlace_type(png_, info_) != PNG_INTERLACE_NONE) throw PngError{"interlaced"};
    std::vector<std::uint8_t> pixels;
    for (std::size_t row = 0; row < rows; ++row) {  // grows with what is there, not with what is stated
      pixels.resize(pixels.size() + columns);
      png_read_row(png_, pixels.data() + row * columns, nullptr);
    }
    png_read_end(png_, nullptr);
    return pixels;
  }

 private:
  void take(png_structp png, png_bytep to, std::size_t count) {
    if (count > bytes_.size()) png_error(png, "the file ends too early");
    std::memcpy(to, bytes_.data(), count);
    bytes_.remove_prefix(count);
  }

  std::string_view bytes_;
  png_structp png_ = nullptr;
  png_infop info_ = nullptr;
};

void appendBytes(png_structp png, png_bytep bytes, png_size_t count) {
  static_cast<std::string*>(png_get_io_ptr(png))->append(reinterpret_cast<const char*>(bytes), count);
}

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

void readHead(const std::uint8_t* head, std::size_t row, const std::string& name, RadarScan& scan) {
  const auto microseconds = static_cast<std::int64_t>(littleEndian(head, 8));
  const auto encoder = littleEndian(head + 8, 2);
  scan.valid[row] = head[10];
  const bool counts = scan.valid[row] != 0;  // what a row states that was not measured is left alone
  if (counts && encoder >= kNavtechEncoderCounts)
    throw inputError("{}: row {} has encoder {}, beyond {}: no radar image of the Oxford layout", name, row, encoder,
                     kNavtechEncoderCounts - 1);
  if (microseconds < 0 || microseconds > kMaxMicroseconds)
    throw inputError("{}: row {} has an absurd stamp ({} us)", name, row, microseconds);
  scan.stamps[row] = stampFromNanoseconds(microseconds * 1000);
  scan.angles[row] = static_cast<double>(encoder % kNavtechEncoderCounts) * kRadPerCount;
  if (counts && row > 0 && scan.valid[row - 1] != 0 && scan.stamps[row] < scan.stamps[row - 1])
    throw inputError("{}: the stamp of row {} is before that of the row above", name, row);
}

}  // namespace

RadarScan decodeOxfordRadar(std::string_view png, const std::string& name, const OxfordRadarFormat& format) {
  std::vector<std::uint8_t> pixels;
  std::size_t rows = 0, columns = 0;
  try {
    pixels = PngReader(png).grey(rows, columns);
  } catch (const PngError& error) {
    throw inputError("{}: no radar image of the Oxford layout: {}", name, error.message);
  }
  if (columns <= kHead) throw inputError("{}: {} columns are too few for a radar image", name, columns);
  RadarScan scan;
  scan.resize(rows, columns - kHead);
  for (std::size_t row = 0; row < rows; ++row) {
    const std::uint8_t* bytes = pixels.data() + row * columns;
    readHead(bytes, row, name, scan);
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
  const std::size_t columns = kHead + scan.bins;
  if (!scan.consistent() || scan.azimuths == 0 || scan.bins == 0 || scan.azimuths > kMaxRows || columns > kMaxColumns)
    throw inputError("a radar scan of {} x {} cannot be written as PNG", scan.azimuths, scan.bins);
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, onError, onWarning);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, &bytes, appendBytes, nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(columns), static_cast<png_uint_32>(scan.azimuths), 8,
               PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, PNG_FILTER_NONE);  // noise does not repeat: filters only cost time
  png_set_compression_level(png, 6);
  png_write_info(png, info);
  std::vector<std::uint8_t> row(columns);
  for (std::size_t i = 0; i < scan.azimuths; ++i) {
    const std::int64_t microseconds = microsecondsOf(scan.stamps[i]);
    if (microseconds < 0 || microseconds > kMaxMicroseconds || !std::isfinite(scan.angles[i])) {
      png_destroy_write_struct(&png, &info);
      throw inputError("row {} of a radar scan has no stamp or angle that a PNG can hold", i);
    }
    const double turn = scan.angles[i] / (2 * M_PI);
    const auto encoder = static_cast<std::uint64_t>(std::lround((turn - std::floor(turn)) * kNavtechEncoderCounts));
    putLittleEndian(static_cast<std::uint64_t>(microseconds), 8, row.data());
    putLittleEndian(encoder % kNavtechEncoderCounts, 2, row.data() + 8);
    row[10] = scan.valid[i];
    std::memcpy(row.data() + kHead, scan.row(i).data(), scan.bins);
    png_write_row(png, row.data());
  }
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

}  // namespace scslam
