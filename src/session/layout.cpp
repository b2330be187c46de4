#include "scslam/session/layout.h"

#include <charconv>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/stamp.h"

namespace scslam::layout {
namespace {

/// A CSV field; quoted where it must be.
std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\r\n") == std::string::npos) return text;
  std::string result = "\"";
  for (const char c : text) {
    if (c == '"') result += '"';
    result += c;
  }
  return result + '"';
}

std::string measurement(const LoopRecord& loop) {
  if (!loop.registered) return ",,,,,,,,,,,,,,";
  Eigen::Quaterniond q(loop.T_match_query.linear());
  if (q.w() < 0) q.coeffs() = -q.coeffs();
  const auto& t = loop.T_match_query.translation();
  const std::string free_space =
      loop.free_space_checked ? fmt::format("{:.6g},{:.6g}", loop.target_overlap, loop.seen_through) : ",";
  return fmt::format("{:.6g},{:.6g},{:.6g},{:.6g},{},{:.6g},{},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g},{:.9g}",
                     loop.rmse_m, loop.inlier_ratio, loop.explained, loop.overlap, free_space,
                     loop.odometry_mahalanobis2, loop.unfixed_axes, t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
}

std::vector<float> readRow(std::string_view line, const std::string& where) {
  std::vector<float> row;
  for (std::size_t i = 0; i < line.size();) {
    if (line[i] == ' ' || line[i] == '\t' || line[i] == '\r') {
      ++i;
      continue;
    }
    float value = 0;
    const auto [end, error] = std::from_chars(line.data() + i, line.data() + line.size(), value);
    const auto next = static_cast<std::size_t>(end - line.data());
    if (error != std::errc() || (next < line.size() && line[next] != ' ' && line[next] != '\t' && line[next] != '\r'))
      throw inputError("{}: word {} is not a number", where, row.size() + 1);
    row.push_back(value);
    i = next;
  }
  return row;
}

}  // namespace

std::vector<std::string> allNames() {
  return {kScans,           kDescriptors, kOptimisedPoses, kOdometryPoses, kTimes,   kPoseGraph,    kTrajectory,
          kOdometry,        kLoops,       kMetrics,        kConfig,        kLog,     kJournal,      kCheckpoint,
          "trajectory.svg", "map",        "clean",         "changes",      kGnss,    kGeoreference, kParents,
          kKeyframeParents, kLtMapper,    "merge.svg",     "map_top.png",  kManifest};
}

std::filesystem::path scanFile(const std::filesystem::path& folder, KeyframeId k) {
  return folder / kScans / fmt::format("{:06d}.pcd", k);
}

std::filesystem::path descriptorFile(const std::filesystem::path& folder, KeyframeId k) {
  return folder / kDescriptors / fmt::format("{:06d}.scd", k);
}

std::string formatDescriptor(const Descriptor& descriptor) {
  std::string text;
  char digits[32];
  for (Eigen::Index r = 0; r < descriptor.rows(); ++r) {
    if (r > 0) text += '\n';
    for (Eigen::Index c = 0; c < descriptor.cols(); ++c) {
      if (c > 0) text += ' ';
      text.append(digits, std::to_chars(digits, digits + sizeof digits, descriptor(r, c)).ptr);
    }
  }
  return text;
}

Descriptor readDescriptor(const std::filesystem::path& file) {
  const std::string text = readFile(file, std::size_t{1} << 26);
  std::vector<std::vector<float>> rows;
  for (std::size_t begin = 0; begin < text.size();) {
    const std::size_t end = std::min(text.find('\n', begin), text.size());
    const std::string where = fmt::format("{}:{}", file.string(), rows.size() + 1);
    rows.push_back(readRow(std::string_view(text).substr(begin, end - begin), where));
    if (rows.back().size() != rows.front().size())
      throw inputError("{}: {} numbers, the rows above have {}", where, rows.back().size(), rows.front().size());
    begin = end + 1;
  }
  Descriptor descriptor(rows.size(), rows.empty() ? 0 : rows.front().size());
  for (std::size_t r = 0; r < rows.size(); ++r)
    for (std::size_t c = 0; c < rows[r].size(); ++c)
      descriptor(static_cast<Eigen::Index>(r), static_cast<Eigen::Index>(c)) = rows[r][c];
  return descriptor;
}

std::string formatTimes(const std::vector<Keyframe>& keyframes) {
  std::string text;
  for (const Keyframe& keyframe : keyframes) text += fmt::format("{:.17g}\n", toSeconds(keyframe.stamp));
  return text;
}

std::string formatGnss(const std::vector<GnssRecord>& gnss) {
  std::string text =
      "keyframe,time_s,latitude_deg,longitude_deg,height_m,sigma_east_m,sigma_north_m,sigma_up_m,"
      "antenna_x_m,antenna_y_m,antenna_z_m\n";
  for (const GnssRecord& record : gnss) {
    const auto& fix = record.fix;
    const Eigen::Vector3d sigma = fix.covariance_m2.diagonal().cwiseSqrt(), &antenna = record.antenna_in_keyframe_m;
    text += fmt::format("{},{},{:.10f},{:.10f},{:.4f},{:.4g},{:.4g},{:.4g},{:.6g},{:.6g},{:.6g}\n", record.keyframe,
                        formatStamp(fix.stamp), fix.latitude_deg, fix.longitude_deg, fix.height_m, sigma.x(), sigma.y(),
                        sigma.z(), antenna.x(), antenna.y(), antenna.z());
  }
  return text;
}

std::string formatLoops(const std::vector<LoopRecord>& loops) {
  std::string text =
      "query,match,recogniser,distance,yaw_guess_deg,fitness_rmse_m,inlier_ratio,explained,overlap,target_overlap,"
      "seen_through,odometry_chi2,unfixed_axes,tx,ty,tz,qx,qy,qz,qw,verdict,reason\n";
  for (const LoopRecord& loop : loops)
    text += fmt::format("{},{},{},{:.9g},{:.6g},{},{},{}\n", loop.query, loop.match, quoted(loop.recogniser),
                        loop.distance, loop.yaw_guess_rad * 180 / M_PI, measurement(loop),
                        loop.accepted ? "accepted" : "refused", quoted(loop.reason));
  return text;
}

}  // namespace scslam::layout
