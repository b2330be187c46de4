#include "scslam/core/trajectory.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <string_view>

#include "scslam/core/error.h"
#include "scslam/core/file.h"

namespace scslam {
namespace {

std::vector<std::string> splitWords(std::string_view line) {
  std::vector<std::string> words;
  std::size_t i = 0;
  const auto separator = [](char c) { return c == ' ' || c == '\t' || c == '\r' || c == ','; };
  while (i < line.size()) {
    while (i < line.size() && separator(line[i])) ++i;
    const std::size_t begin = i;
    while (i < line.size() && !separator(line[i])) ++i;
    if (i > begin) words.emplace_back(line.substr(begin, i - begin));
  }
  return words;
}

double number(const std::string& word, const std::string& where) {
  char* end = nullptr;
  const double value = std::strtod(word.c_str(), &end);
  if (end != word.c_str() + word.size() || !std::isfinite(value))
    throw inputError("{}: '{}' is not a finite number", where, word);
  return value;
}

Pose poseOf(const Eigen::Vector3d& t, const Eigen::Quaterniond& q, const std::string& where) {
  if (std::abs(q.norm() - 1) > 0.01) throw inputError("{}: the quaternion's length is {:.4g}, not 1", where, q.norm());
  Pose T = Pose::Identity();
  T.linear() = q.normalized().toRotationMatrix();
  T.translation() = t;
  return T;
}

StampedPose tumPose(const std::vector<std::string>& words, const std::string& where) {
  double v[7];
  for (int i = 0; i < 7; ++i) v[i] = number(words[static_cast<std::size_t>(i) + 1], where);
  StampedPose pose;
  if (!parseStamp(words[0], pose.stamp)) throw inputError("{}: '{}' is not a time in seconds", where, words[0]);
  pose.T = poseOf({v[0], v[1], v[2]}, {v[6], v[3], v[4], v[5]}, where);
  return pose;
}

/// EuRoC: nanoseconds, position, quaternion with w first; what follows (velocity, biases) does not matter here.
StampedPose eurocPose(const std::vector<std::string>& words, const std::string& where) {
  double v[7];
  for (int i = 0; i < 7; ++i) v[i] = number(words[static_cast<std::size_t>(i) + 1], where);
  StampedPose pose;
  errno = 0;
  pose.stamp = stampFromNanoseconds(std::strtoll(words[0].c_str(), nullptr, 10));
  if (errno != 0) throw inputError("{}: '{}' is not a time in nanoseconds", where, words[0]);
  pose.T = poseOf({v[0], v[1], v[2]}, {v[3], v[4], v[5], v[6]}, where);
  return pose;
}

Pose kittiPose(const std::vector<std::string>& words, const std::string& where) {
  Pose T = Pose::Identity();
  for (int i = 0; i < 12; ++i) T.matrix()(i / 4, i % 4) = number(words[static_cast<std::size_t>(i)], where);
  const Eigen::Matrix3d R = T.linear();
  if ((R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() > 0.02 || R.determinant() < 0)
    throw inputError("{}: the 3x3 part is not a rotation", where);
  return orthonormalised(T);
}

enum class Form { kTum, kKitti, kEuroc };

Form formOf(const std::vector<std::string>& words, bool commas, const std::string& where) {
  // Seconds have at most ten digits before the point for centuries to come; nanoseconds since 1970 have 19.
  const bool nanoseconds = words[0].size() >= 15 && words[0].find_first_not_of("0123456789") == std::string::npos;
  if (commas && nanoseconds && words.size() >= 8) return Form::kEuroc;
  if (words.size() == 8) return Form::kTum;
  if (words.size() == 12) return Form::kKitti;
  throw inputError(
      "{}: {} columns; a trajectory has 8 (TUM: time x y z qx qy qz qw), 12 (KITTI: 3x4 matrix), or is an EuRoC table "
      "(ns,x,y,z,qw,qx,qy,qz,…)",
      where, words.size());
}

}  // namespace

std::optional<Pose> Trajectory::at(Stamp stamp, double tolerance_s, double max_gap_s) const {
  if (poses.empty()) return std::nullopt;
  const auto after =
      std::lower_bound(poses.begin(), poses.end(), stamp, [](const StampedPose& p, Stamp s) { return p.stamp < s; });
  if (after == poses.end())
    return secondsBetween(poses.back().stamp, stamp) <= tolerance_s ? std::optional(poses.back().T) : std::nullopt;
  if (after->stamp == stamp) return after->T;
  if (after == poses.begin())
    return secondsBetween(stamp, after->stamp) <= tolerance_s ? std::optional(after->T) : std::nullopt;
  const StampedPose& before = *(after - 1);
  const double gap = secondsBetween(before.stamp, after->stamp);
  if (gap > max_gap_s) {
    if (secondsBetween(before.stamp, stamp) <= tolerance_s) return before.T;
    if (secondsBetween(stamp, after->stamp) <= tolerance_s) return after->T;
    return std::nullopt;
  }
  return interpolate(before.T, after->T, secondsBetween(before.stamp, stamp) / gap);
}

Trajectory readTrajectory(const std::filesystem::path& file) {
  const std::string text = readFile(file);
  Trajectory result;
  std::size_t columns = 0, line_number = 0;
  Form form = Form::kTum;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string_view line = std::string_view(text).substr(begin, end - begin);
    begin = end + 1;
    ++line_number;
    const auto words = splitWords(line);
    if (words.empty() || words[0][0] == '#') continue;
    const std::string where = fmt::format("{}:{}", file.string(), line_number);
    if (columns == 0) {
      columns = words.size();
      form = formOf(words, line.find(',') != std::string_view::npos, where);
      result.timed = form != Form::kKitti;
    }
    if (words.size() != columns)
      throw inputError("{}: {} columns, the lines above have {}", where, words.size(), columns);
    StampedPose pose;
    if (form == Form::kKitti)
      pose.T = kittiPose(words, where);
    else
      pose = form == Form::kTum ? tumPose(words, where) : eurocPose(words, where);
    if (result.timed && !result.poses.empty() && pose.stamp <= result.poses.back().stamp)
      throw inputError("{}: time {} does not come after the line above", where, words[0]);
    result.poses.push_back(pose);
  }
  if (result.poses.empty()) throw inputError("{} holds no poses", file.string());
  return result;
}

Trajectory inBaseFrame(Trajectory trajectory, const Pose& T_base_reference) {
  const Pose T_reference_base = T_base_reference.inverse();
  for (StampedPose& pose : trajectory.poses) pose.T = pose.T * T_reference_base;
  return trajectory;
}

std::string formatTum(const std::vector<StampedPose>& poses) {
  std::string text;
  for (const auto& [stamp, T] : poses) {
    Eigen::Quaterniond q(T.linear());
    q.normalize();
    if (q.w() < 0) q.coeffs() = -q.coeffs();
    const auto& t = T.translation();
    text += fmt::format("{} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g} {:.17g}\n", formatStamp(stamp), t.x(),
                        t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  }
  return text;
}

std::string formatKitti(const std::vector<Pose>& poses) {
  std::string text;
  for (const Pose& T : poses)
    for (int i = 0; i < 12; ++i) text += fmt::format("{:.17g}{}", T.matrix()(i / 4, i % 4), i == 11 ? '\n' : ' ');
  return text;
}

}  // namespace scslam
