#include "scslam/core/bytes.h"

#include <zlib.h>

namespace scslam {

static_assert(std::endian::native == std::endian::little, "records are little-endian as they lie in memory");

void ByteWriter::put(const std::string& text) {
  put(std::uint64_t{text.size()});
  bytes_.append(text);
}

void ByteWriter::put(const Pose& T) {
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) put(T.matrix()(r, c));
}

void ByteWriter::put(const Matrix6d& matrix) {
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 6; ++c) put(matrix(r, c));
}

const char* ByteReader::take(std::size_t n) {
  if (n > remaining()) throw inputError("the data ends inside a binary record ({} bytes missing)", n - remaining());
  const char* result = bytes_.data() + position_;
  position_ += n;
  return result;
}

void ByteReader::get(std::string& text) {
  const auto n = get<std::uint64_t>();
  if (n > remaining()) throw inputError("a binary record states a text of {} bytes, more than it holds", n);
  text.assign(take(n), n);
}

void ByteReader::get(Pose& T) {
  T = Pose::Identity();
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 4; ++c) get(T.matrix()(r, c));
}

void ByteReader::get(Matrix6d& matrix) {
  for (int r = 0; r < 6; ++r)
    for (int c = 0; c < 6; ++c) get(matrix(r, c));
}

std::uint32_t crc32Of(std::string_view bytes) {
  return static_cast<std::uint32_t>(
      crc32_z(crc32_z(0, nullptr, 0), reinterpret_cast<const unsigned char*>(bytes.data()), bytes.size()));
}

}  // namespace scslam
