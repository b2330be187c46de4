#include "scslam/core/grey_png.h"

#include <png.h>

#include <cstring>
#include <new>

#include "scslam/core/error.h"

namespace scslam {
namespace {

constexpr std::size_t kMaxRows = 1 << 14, kMaxColumns = 1 << 16;  // what a file may state

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

  GreyImage read() {
    png_read_info(png_, info_);
    GreyImage image;
    image.rows = png_get_image_height(png_, info_), image.columns = png_get_image_width(png_, info_);
    if (png_get_color_type(png_, info_) != PNG_COLOR_TYPE_GRAY || png_get_bit_depth(png_, info_) != 8)
      throw PngError{"not 8-bit grey"};
    if (png_get_interlace_type(png_, info_) != PNG_INTERLACE_NONE) throw PngError{"interlaced"};
    for (std::size_t row = 0; row < image.rows; ++row) {  // grows with what is there
      image.pixels.resize(image.pixels.size() + image.columns);
      png_read_row(png_, image.pixels.data() + row * image.columns, nullptr);
    }
    png_read_end(png_, nullptr);
    return image;
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

}  // namespace

GreyImage decodeGreyPng(std::string_view png, const std::string& name) {
  try {
    return PngReader(png).read();
  } catch (const PngError& error) {
    throw inputError("{}: no 8-bit grey PNG: {}", name, error.message);
  }
}

std::string encodeGreyPng(const GreyImage& image, bool filtered) {
  std::string bytes;
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, onError, onWarning);
  png_infop info = png_create_info_struct(png);
  png_set_write_fn(png, &bytes, appendBytes, nullptr);
  png_set_IHDR(png, info, static_cast<png_uint_32>(image.columns), static_cast<png_uint_32>(image.rows), 8,
               PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE, PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  png_set_filter(png, PNG_FILTER_TYPE_BASE, filtered ? PNG_ALL_FILTERS : PNG_FILTER_NONE);
  png_set_compression_level(png, 6);
  png_write_info(png, info);
  for (std::size_t row = 0; row < image.rows; ++row) png_write_row(png, image.pixels.data() + row * image.columns);
  png_write_end(png, info);
  png_destroy_write_struct(&png, &info);
  return bytes;
}

}  // namespace scslam
