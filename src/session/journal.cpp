#include "scslam/session/journal.h"

#include <algorithm>

#include "scslam/core/bytes.h"
#include "scslam/core/error.h"

namespace scslam {
namespace {

constexpr std::string_view kMagic = "SCSLAMJN";
constexpr std::uint32_t kVersion = 2;
constexpr std::size_t kHeaderBytes = 12;
constexpr std::size_t kFrameBytes = 8;  // length and CRC of a record

enum class RecordType : std::uint8_t {
  kScan = 1,
  kKeyframe = 2,
  kLoop = 3,
  kPoses = 4,
  kPosesDeferred = 5,
  kVerdict = 6,
  kGnss = 7
};

void putStamp(ByteWriter& out, Stamp stamp) { out.put(std::int64_t{stamp.time_since_epoch().count()}); }
Stamp getStamp(ByteReader& in) { return Stamp(Stamp::duration(in.get<std::int64_t>())); }

std::string header() {
  ByteWriter version;
  version.put(kVersion);
  return std::string(kMagic) + version.bytes();
}

ScanRecord getScan(ByteReader& in) {
  ScanRecord scan;
  scan.index = in.get<std::uint64_t>();
  scan.stamp = getStamp(in);
  in.get(scan.T_odom_base);
  in.get(scan.keyframe);
  return scan;
}

void getKeyframe(ByteReader& in, JournalContents& contents) {
  Keyframe keyframe;
  in.get(keyframe.id);
  keyframe.scan_index = in.get<std::uint64_t>();
  keyframe.stamp = getStamp(in);
  in.get(keyframe.T_odom_base);
  in.get(keyframe.travelled_m);
  in.get(keyframe.step_covariance);
  keyframe.planar = in.get<std::uint8_t>() != 0;
  Pose T_map_base;
  in.get(T_map_base);
  KeyframeFiles files;
  in.get(files.points);
  in.get(files.scan_bytes);
  in.get(files.descriptor_bytes);
  in.get(files.scan_crc);
  in.get(files.descriptor_crc);
  if (!in.done()) in.get(keyframe.step_passing);  // older sessions do not have it
  if (keyframe.id != contents.keyframes.size())
    throw inputError("keyframe {} follows keyframe {}", keyframe.id, contents.keyframes.size());
  if (contents.poses_deferred && !contents.keyframes.empty())  // T_map_base belongs to an unrecorded optimisation
    T_map_base = contents.T_map_base.back() * contents.keyframes.back().T_odom_base.inverse() * keyframe.T_odom_base;
  contents.keyframes.push_back(keyframe);
  contents.T_map_base.push_back(T_map_base);
  contents.files.push_back(files);
  contents.scan_bytes += files.scan_bytes;
}

LoopRecord getLoop(ByteReader& in, std::size_t keyframes) {
  LoopRecord loop;
  in.get(loop.query);
  in.get(loop.match);
  in.get(loop.recogniser);
  in.get(loop.distance);
  in.get(loop.yaw_guess_rad);
  in.get(loop.rmse_m);
  in.get(loop.inlier_ratio);
  in.get(loop.explained);
  in.get(loop.overlap);
  in.get(loop.unfixed_axes);
  loop.free_space_checked = in.get<std::uint8_t>() != 0;
  in.get(loop.target_overlap);
  in.get(loop.seen_through);
  in.get(loop.odometry_mahalanobis2);
  loop.registered = in.get<std::uint8_t>() != 0;
  loop.verified = in.get<std::uint8_t>() != 0;
  loop.accepted = in.get<std::uint8_t>() != 0;
  in.get(loop.reason);
  in.get(loop.T_match_query);
  in.get(loop.information);
  if (std::max(loop.query, loop.match) >= keyframes)
    throw inputError("a loop names keyframe {} of {}", std::max(loop.query, loop.match), keyframes);
  return loop;
}

void getVerdict(ByteReader& in, std::vector<LoopRecord>& loops) {
  LoopVerdict verdict;
  in.get(verdict.loop);
  verdict.accepted = in.get<std::uint8_t>() != 0;
  in.get(verdict.reason);
  if (verdict.loop >= loops.size()) throw inputError("a verdict on loop {} of {}", verdict.loop, loops.size());
  loops[verdict.loop].accepted = verdict.accepted;
  loops[verdict.loop].reason = verdict.reason;
}

GnssRecord getGnss(ByteReader& in, std::size_t keyframes) {
  GnssRecord gnss;
  in.get(gnss.keyframe);
  gnss.fix.stamp = getStamp(in);
  in.get(gnss.fix.latitude_deg);
  in.get(gnss.fix.longitude_deg);
  in.get(gnss.fix.height_m);
  in.get(gnss.fix.covariance_m2);
  in.get(gnss.fix.antenna_in_base_m);
  in.get(gnss.antenna_in_keyframe_m);
  if (gnss.keyframe >= keyframes) throw inputError("a satellite fix names keyframe {} of {}", gnss.keyframe, keyframes);
  return gnss;
}

void getPoses(ByteReader& in, JournalContents& contents) {
  if (in.get<std::uint64_t>() != contents.keyframes.size())
    throw inputError("a list of poses does not match the {} keyframes before it", contents.keyframes.size());
  std::vector<Pose> T_map_base(contents.keyframes.size());
  for (Pose& T : T_map_base) in.get(T);
  if (!in.done()) throw inputError("a list of poses is longer than it states");
  contents.T_map_base = std::move(T_map_base);
  contents.poses_deferred = false;
}

/// @throw Error when the body is not a record that may stand here; `contents` is then unchanged.
void apply(std::string_view body, JournalContents& contents) {
  ByteReader in(body);
  switch (in.get<RecordType>()) {
    case RecordType::kScan:
      contents.scans.push_back(getScan(in));
      break;
    case RecordType::kKeyframe:
      getKeyframe(in, contents);
      break;
    case RecordType::kLoop:
      contents.loops.push_back(getLoop(in, contents.keyframes.size()));
      break;
    case RecordType::kPoses:
      getPoses(in, contents);
      contents.pose_bytes += kFrameBytes + body.size();
      break;
    case RecordType::kVerdict:
      getVerdict(in, contents.loops);
      break;
    case RecordType::kGnss:
      contents.gnss.push_back(getGnss(in, contents.keyframes.size()));
      break;
    case RecordType::kPosesDeferred:
      contents.poses_deferred = true;
      break;
    default:
      throw inputError("a record of unknown type");
  }
}

}  // namespace

JournalContents readJournal(const std::filesystem::path& file, std::uint64_t max_bytes) {
  const std::string text = readFile(file);
  std::string_view bytes = std::string_view(text).substr(0, std::min<std::uint64_t>(max_bytes, text.size()));
  JournalContents contents;
  const std::string expected = header();
  if (bytes.substr(0, kHeaderBytes) != expected.substr(0, bytes.size()))
    throw inputError("{} is no session journal of this version", file.string());
  if (bytes.size() < kHeaderBytes) {
    contents.problem = "the file ends inside its header";
    return contents;
  }
  std::size_t at = kHeaderBytes;
  while (at < bytes.size()) {
    const std::size_t left = bytes.size() - at;
    std::uint32_t length = 0, crc = 0;
    if (left >= kFrameBytes) {
      ByteReader frame(bytes.substr(at, kFrameBytes));
      frame.get(length);
      frame.get(crc);
    }
    if (left < kFrameBytes || length > left - kFrameBytes) {
      contents.problem = fmt::format("the file ends inside the record at byte {}", at);
      break;
    }
    const std::string_view body = bytes.substr(at + kFrameBytes, length);
    try {
      if (crc32Of(body) != crc) throw inputError("its checksum is wrong");
      apply(body, contents);
    } catch (const Error& error) {
      contents.problem = fmt::format("the record at byte {}: {}", at, error.what());
      break;
    }
    at += kFrameBytes + length;
  }
  contents.valid_bytes = at;
  return contents;
}

Journal::Journal(const std::filesystem::path& file, std::uint64_t keep_bytes) : file_(file, keep_bytes) {
  if (keep_bytes == 0) file_.append(header());
}

void Journal::appendBody(const std::string& body) {
  ByteWriter record;
  record.put(static_cast<std::uint32_t>(body.size()));
  record.put(crc32Of(body));
  file_.append(record.bytes() + body);
}

void Journal::append(const ScanRecord& scan) {
  ByteWriter out;
  out.put(RecordType::kScan);
  out.put(std::uint64_t{scan.index});
  putStamp(out, scan.stamp);
  out.put(scan.T_odom_base);
  out.put(scan.keyframe);
  appendBody(out.bytes());
}

void Journal::append(const Keyframe& keyframe, const Pose& T_map_base, const KeyframeFiles& files) {
  ByteWriter out;
  out.put(RecordType::kKeyframe);
  out.put(keyframe.id);
  out.put(std::uint64_t{keyframe.scan_index});
  putStamp(out, keyframe.stamp);
  out.put(keyframe.T_odom_base);
  out.put(keyframe.travelled_m);
  out.put(keyframe.step_covariance);
  out.put(std::uint8_t{keyframe.planar});
  out.put(T_map_base);
  out.put(files.points);
  out.put(files.scan_bytes);
  out.put(files.descriptor_bytes);
  out.put(files.scan_crc);
  out.put(files.descriptor_crc);
  out.put(keyframe.step_passing);
  appendBody(out.bytes());
}

void Journal::append(const LoopRecord& loop) {
  ByteWriter out;
  out.put(RecordType::kLoop);
  out.put(loop.query);
  out.put(loop.match);
  out.put(loop.recogniser);
  out.put(loop.distance);
  out.put(loop.yaw_guess_rad);
  out.put(loop.rmse_m);
  out.put(loop.inlier_ratio);
  out.put(loop.explained);
  out.put(loop.overlap);
  out.put(loop.unfixed_axes);
  out.put(std::uint8_t{loop.free_space_checked});
  out.put(loop.target_overlap);
  out.put(loop.seen_through);
  out.put(loop.odometry_mahalanobis2);
  out.put(std::uint8_t{loop.registered});
  out.put(std::uint8_t{loop.verified});
  out.put(std::uint8_t{loop.accepted});
  out.put(loop.reason);
  out.put(loop.T_match_query);
  out.put(loop.information);
  appendBody(out.bytes());
}

void Journal::append(const LoopVerdict& verdict) {
  ByteWriter out;
  out.put(RecordType::kVerdict);
  out.put(verdict.loop);
  out.put(std::uint8_t{verdict.accepted});
  out.put(verdict.reason);
  appendBody(out.bytes());
}

void Journal::append(const GnssRecord& gnss) {
  ByteWriter out;
  out.put(RecordType::kGnss);
  out.put(gnss.keyframe);
  putStamp(out, gnss.fix.stamp);
  out.put(gnss.fix.latitude_deg);
  out.put(gnss.fix.longitude_deg);
  out.put(gnss.fix.height_m);
  out.put(gnss.fix.covariance_m2);
  out.put(gnss.fix.antenna_in_base_m);
  out.put(gnss.antenna_in_keyframe_m);
  appendBody(out.bytes());
}

void Journal::append(const std::vector<Pose>& T_map_base) {
  ByteWriter out;
  out.put(RecordType::kPoses);
  out.put(std::uint64_t{T_map_base.size()});
  for (const Pose& T : T_map_base) out.put(T);
  appendBody(out.bytes());
}

void Journal::appendPosesDeferred() {
  ByteWriter out;
  out.put(RecordType::kPosesDeferred);
  appendBody(out.bytes());
}

}  // namespace scslam
