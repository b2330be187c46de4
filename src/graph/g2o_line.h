// One line of a g2o file, taken apart strictly.
#pragma once
#include <cstdint>
#include <string>
#include <string_view>

#include "scslam/core/pose.h"

namespace scslam::detail {

/// Reads blank-separated fields from the left. Every error is inputError "file:line: …".
class G2oLine {
 public:
  G2oLine(std::string_view text, const std::string& file, std::size_t number)
      : rest_(text), file_(file), number_(number) {}

  /// The first field; empty for a blank line.
  std::string_view tag() { return field(); }
  std::int64_t id();
  double number();
  Pose pose3d();  ///< x y z qx qy qz qw; the quaternion is normalised, its length must be within 1 % of 1
  Pose pose2d();  ///< x y yaw, lifted
  /// Upper triangle, row-major: 21 numbers, or 6 over (x, y, yaw); identity when the line ends here.
  Matrix6d information(bool planar);
  bool atEnd();
  /// @throw inputError when something is left.
  void end();

 private:
  std::string_view field();
  std::string_view rest_;
  const std::string& file_;
  std::size_t number_;
};

}  // namespace scslam::detail
