// journal.bin: the append-only list of everything a session was told. All other files can be made from it and Scans/.
//
//   file   = "SCSLAMJN" u32 version { record }
//   record = u32 length of body, u32 CRC-32 of body, body = u8 type + fields (little endian, core/bytes.h)
#pragma once
#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "scslam/core/file.h"
#include "scslam/session/records.h"

namespace scslam {

/// What the journal keeps of a keyframe besides the keyframe: where it was and which bytes its files must have.
struct KeyframeFiles {
  std::uint64_t points = 0;
  std::uint64_t scan_bytes = 0, descriptor_bytes = 0;
  std::uint32_t scan_crc = 0, descriptor_crc = 0;
};

struct JournalContents {
  std::vector<ScanRecord> scans;
  std::vector<Keyframe> keyframes;
  std::vector<KeyframeFiles> files;  ///< per keyframe
  std::vector<LoopRecord> loops;     ///< as last judged
  std::vector<GnssRecord> gnss;
  std::vector<Pose> T_map_base;  ///< per keyframe: the last recorded optimisation, later keyframes chained by odometry
  bool poses_deferred = false;   ///< an optimisation happened that is not (yet) recorded
  std::uint64_t pose_bytes = 0, scan_bytes = 0;  ///< written so far, for PoseBudget
  std::uint64_t valid_bytes = 0;                 ///< length of the readable prefix
  std::string problem;                           ///< why reading stopped there; empty at the clean end
};

/// Reads the valid prefix of a journal. @param max_bytes ignores everything after it (resume).
/// @throw inputError only when the file cannot be read or is no journal at all; a torn or damaged record merely ends
/// the prefix. A file shorter than the header, which a kill while the session was created leaves, is an empty journal.
JournalContents readJournal(const std::filesystem::path& file, std::uint64_t max_bytes = UINT64_MAX);

class Journal {
 public:
  Journal() = default;
  /// Starts a new journal (keep_bytes == 0) or goes on after its first keep_bytes bytes.
  Journal(const std::filesystem::path& file, std::uint64_t keep_bytes);
  void append(const ScanRecord& scan);
  void append(const Keyframe& keyframe, const Pose& T_map_base, const KeyframeFiles& files);
  void append(const LoopRecord& loop);
  void append(const LoopVerdict& verdict);
  void append(const GnssRecord& gnss);
  void append(const std::vector<Pose>& T_map_base);
  /// An optimisation whose poses follow later: readers chain keyframes by odometry until then.
  void appendPosesDeferred();
  void sync() { file_.sync(); }
  std::uint64_t size() const { return file_.size(); }

 private:
  void appendBody(const std::string& body);
  AppendFile file_;
};

}  // namespace scslam
