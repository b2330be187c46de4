#include "scslam/graph/g2o_line.h"

#include <charconv>
#include <cmath>

#include "scslam/core/error.h"
#include "scslam/graph/factor_error.h"

namespace scslam::detail {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

}  // namespace

std::string_view G2oLine::field() {
  const std::size_t begin = std::min(rest_.find_first_not_of(kBlanks), rest_.size());
  const std::size_t end = std::min(rest_.find_first_of(kBlanks, begin), rest_.size());
  const std::string_view result = rest_.substr(begin, end - begin);
  rest_.remove_prefix(end);
  return result;
}

bool G2oLine::atEnd() { return rest_.find_first_not_of(kBlanks) == std::string_view::npos; }

void G2oLine::end() {
  if (!atEnd())
    throw inputError("{}:{}: '{}' follows where the line should end", file_, number_, field().substr(0, 40));
}

std::int64_t G2oLine::id() {
  const std::string_view text = field();
  if (text.empty()) throw inputError("{}:{}: the line ends where a vertex number should be", file_, number_);
  std::int64_t value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc{} || stop != text.data() + text.size())
    throw inputError("{}:{}: '{}' is no vertex number (64-bit integer)", file_, number_, text.substr(0, 40));
  return value;
}

double G2oLine::number() {
  std::string_view text = field();
  if (text.empty()) throw inputError("{}:{}: the line ends where a number should be", file_, number_);
  const std::string_view whole = text;
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  double value = 0;
  const auto [stop, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  // out_of_range also stands for 1e-400: such a number is 0 for every purpose here, but 1e400 is not infinity.
  if (stop != text.data() + text.size() || (error != std::errc{} && error != std::errc::result_out_of_range))
    throw inputError("{}:{}: '{}' is not a number", file_, number_, whole.substr(0, 40));
  if (error == std::errc::result_out_of_range || !std::isfinite(value))
    throw inputError("{}:{}: '{}' is not a finite number", file_, number_, whole.substr(0, 40));
  return value;
}

Pose G2oLine::pose3d() {
  double v[7];
  for (double& value : v) value = number();
  const Eigen::Quaterniond q(v[6], v[3], v[4], v[5]);
  if (std::abs(q.norm() - 1) > 0.01)
    throw inputError("{}:{}: the quaternion (qx qy qz qw) has length {:.4g}, not 1", file_, number_, q.norm());
  Pose T = Pose::Identity();
  T.linear() = q.normalized().toRotationMatrix();
  T.translation() << v[0], v[1], v[2];
  return T;
}

Pose G2oLine::pose2d() {
  const double x = number(), y = number(), yaw = number();
  return poseFromYaw(yaw, {x, y, 0});
}

Matrix6d G2oLine::information(bool planar) {
  if (atEnd()) return Matrix6d::Identity();
  Matrix6d information = Matrix6d::Identity();  // a planar graph does not read the other axes
  const int axes = planar ? 3 : 6;
  for (int r = 0; r < axes; ++r)
    for (int c = r; c < axes; ++c) {
      const int row = planar ? kPlanarAxes[r] : r, column = planar ? kPlanarAxes[c] : c;
      information(row, column) = information(column, row) = number();
    }
  return information;
}

}  // namespace scslam::detail
