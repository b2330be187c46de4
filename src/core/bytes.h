// Little-endian binary records with bounds checks, for the journal and the checkpoint.
#pragma once
#include <bit>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "scslam/core/error.h"
#include "scslam/core/pose.h"

namespace scslam {

class ByteWriter {
 public:
  template <class T>
  void put(const T& value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    bytes_.append(reinterpret_cast<const char*>(&value), sizeof(T));
  }
  void put(const std::string& text);
  void put(const Pose& T);           ///< 12 doubles, row-major 3x4
  void put(const Matrix6d& matrix);  ///< 36 doubles
  template <int kRows, int kCols>
  void put(const Eigen::Matrix<double, kRows, kCols>& matrix) {
    for (const double value : matrix.reshaped()) put(value);
  }
  template <class T>
  void put(const std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    put(std::uint64_t{values.size()});
    bytes_.append(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
  }
  const std::string& bytes() const { return bytes_; }

 private:
  std::string bytes_;
};

/// @throw Error(kInput) "… ends inside a record" when more is asked for than there is.
class ByteReader {
 public:
  explicit ByteReader(std::string_view bytes) : bytes_(bytes) {}
  template <class T>
  void get(T& value) {
    static_assert(std::is_arithmetic_v<T> || std::is_enum_v<T>);
    std::memcpy(&value, take(sizeof(T)), sizeof(T));
  }
  template <class T>
  T get() {
    T value{};
    get(value);
    return value;
  }
  void get(std::string& text);
  void get(Pose& T);
  void get(Matrix6d& matrix);
  template <int kRows, int kCols>
  void get(Eigen::Matrix<double, kRows, kCols>& matrix) {
    for (double& value : matrix.reshaped()) get(value);
  }
  template <class T>
  void get(std::vector<T>& values) {
    static_assert(std::is_trivially_copyable_v<T>);
    const auto n = get<std::uint64_t>();
    if (n > remaining() / sizeof(T)) throw inputError("a binary record states {} elements, more than it holds", n);
    values.resize(n);
    if (n != 0) std::memcpy(values.data(), take(n * sizeof(T)), n * sizeof(T));
  }
  std::size_t remaining() const { return bytes_.size() - position_; }
  bool done() const { return remaining() == 0; }

 private:
  const char* take(std::size_t n);
  std::string_view bytes_;
  std::size_t position_ = 0;
};

/// CRC-32 (zlib's) of the bytes.
std::uint32_t crc32Of(std::string_view bytes);

}  // namespace scslam
