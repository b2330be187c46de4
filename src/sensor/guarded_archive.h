// An MRPT archive for reading what may be hostile.
#pragma once
#include <mrpt/serialization/CArchive.h>

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

namespace scslam {

/// MRPT 2.5.8 takes memory for whatever count a file states, and where an aligned buffer cannot be had it writes
/// through null. This archive recognises the headers of objects (also of objects inside objects) as they are read and
/// compares the counts that follow with what is left, before MRPT acts on them.
class GuardedArchive : public mrpt::serialization::CArchive {
 public:
  /// What is wrong, thrown through MRPT, which wraps it in words of its own: failure() keeps ours.
  struct Damage : std::runtime_error {
    using std::runtime_error::runtime_error;
  };
  const std::string& failure() const { return failure_; }

  /// Up to n of the bytes that follow, without taking them.
  virtual std::string_view peek(std::size_t n) = 0;
  /// Upper bound of the bytes that still follow.
  virtual std::uint64_t bytesLeft() = 0;

 protected:
  /// Exactly `count` bytes. @throw Damage (by fail()) when there are fewer.
  virtual void take(char* to, std::size_t count) = 0;
  [[noreturn]] void fail(const std::string& why);
  void forgetFailure() { failure_.clear(); }

 private:
  std::size_t read(void* to, std::size_t count) final;
  std::size_t write(const void*, std::size_t) final;
  void watch(std::string_view bytes);
  void watchImageSize(std::string_view bytes);
  void checkCounts(std::string_view class_name);

  std::string failure_;
  std::size_t name_length_ = 0;
  std::uint16_t last_u16_ = 0;
  bool old_format_ = false, in_rotating_scan_ = false;
};

/// "mrpt::obs::CSensoryFrame" (newer files) and "CSensoryFrame" (older ones) are the same class.
std::string_view withoutNamespace(std::string_view class_name);
/// Letters, digits, underscores and colons only.
bool isClassName(std::string_view name);

}  // namespace scslam
