// The objects of an MRPT rawlog, one after the other, read as if the file were hostile.
#pragma once
#include <mrpt/serialization/CSerializable.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>

namespace scslam {

/// MRPT 2.5.8 trusts the element counts in a file, fills what a short or damaged gzip stream lacks with zeros, and
/// writes through null when an aligned buffer cannot be had. Here every short read and every checksum error is an error
/// with its byte, counts of the classes with aligned buffers are compared with what is left of the file before MRPT
/// acts on them, and the rest is read under a MemoryLimit.
class RawlogObjects {
 public:
  /// Plain or gzip. @throw inputError when it cannot be opened.
  explicit RawlogObjects(const std::filesystem::path& file);
  ~RawlogObjects();

  /// The next object; null at the clean end.
  /// @throw inputError "FILE: damaged at byte B of the uncompressed data (in the CSensoryFrame that began at byte A):
  /// why"; afterwards the end.
  mrpt::serialization::CSerializable::Ptr next();

  /// Class name of the first object in `file`; empty when the file does not begin like a rawlog. Never throws.
  static std::string firstClassName(const std::filesystem::path& file);

 private:
  class Archive;
  std::unique_ptr<Archive> archive_;
};

}  // namespace scslam
