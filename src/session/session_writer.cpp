#include "scslam/session/session_writer.h"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <optional>

#include "scslam/core/bytes.h"
#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/pcd.h"
#include "scslam/session/checkpoint.h"
#include "scslam/session/journal.h"
#include "scslam/session/layout.h"
#include "scslam/session/manifest.h"
#include "scslam/session/session_folder.h"
#include "scslam/session/session_graph.h"
#include "scslam/session/text_files.h"

namespace scslam {
namespace fs = std::filesystem;
namespace {

/// Poses are recorded after each optimisation as long as all such records together stay below this share of the scans
/// (or this floor); then only at the end, and readers chain odometry in between. Otherwise n optimisations of n
/// keyframes would take O(n^2) disk.
constexpr std::uint64_t kPoseBytesFloor = 16u << 20;
constexpr std::uint64_t kPoseShare = 4;

class FolderWriter final : public SessionWriter {
 public:
  FolderWriter(fs::path folder, FolderLock lock, SessionInfo info, JournalContents contents, std::uint64_t log_bytes)
      : folder_(std::move(folder)),
        lock_(std::move(lock)),
        info_(std::move(info)),
        contents_(std::move(contents)),
        journal_(folder_ / layout::kJournal, contents_.valid_bytes),
        log_(folder_ / layout::kLog, log_bytes) {
    refreshTexts();
  }

  void addScan(const ScanRecord& scan) override {
    guarded([&] { journal_.append(scan); });
    contents_.scans.push_back(scan);
  }
  void addKeyframe(const Keyframe& keyframe, const Pose& T_map_base, const Cloud& cloud_sensor,
                   const Descriptor& descriptor) override;
  void addLoop(const LoopRecord& loop) override {
    guarded([&] { journal_.append(loop); });
    contents_.loops.push_back(loop);
  }
  void judgeLoop(const LoopVerdict& verdict) override {
    LoopRecord& loop = contents_.loops.at(verdict.loop);
    guarded([&] { journal_.append(verdict); });
    loop.accepted = verdict.accepted, loop.reason = verdict.reason;
  }
  void addGnss(const GnssRecord& gnss) override {
    guarded([&] { journal_.append(gnss); });
    contents_.gnss.push_back(gnss);
  }
  void setPoses(const std::vector<Pose>& T_map_base) override;
  void logLine(const std::string& line) override {
    guarded([&] { log_.append(line + "\n"); });
  }
  void checkpoint(const std::string& pipeline_state) override;
  void finish(const PoseGraph& graph) override;
  void writeMetrics(const std::string& json) override { writeFileAtomically(folder_ / layout::kMetrics, json); }
  void seal() override {
    std::error_code ignored;  // a checkpoint that cannot be removed does no harm
    fs::remove(folder_ / layout::kCheckpoint, ignored);
  }
  const fs::path& folder() const override { return folder_; }

 private:
  /// After a failed write the session stands as it is, resumable; every later call repeats that error.
  template <class Write>
  void guarded(const Write& write) {
    if (failure_) throw Error(*failure_);
    try {
      write();
    } catch (const Error& error) {
      failure_ = error;
      throw;
    }
  }
  void recordPoses();
  void syncToDisk();
  void refreshTexts();

  fs::path folder_;
  FolderLock lock_;
  SessionInfo info_;
  JournalContents contents_;
  Journal journal_;
  AppendFile log_;
  std::optional<Error> failure_;
  std::size_t next_refresh_ = 0;  ///< number of keyframes at which the text files are written again
  std::size_t synced_ = 0;        ///< keyframes whose files are on the disk
};

void FolderWriter::addKeyframe(const Keyframe& keyframe, const Pose& T_map_base, const Cloud& cloud_sensor,
                               const Descriptor& descriptor) {
  guarded([] {});
  if (keyframe.id != contents_.keyframes.size())
    throw Error(ExitCode::kBug, fmt::format("keyframe {} after {} keyframes", keyframe.id, contents_.keyframes.size()));
  const std::string scan = encodePcd(cloud_sensor);
  const std::string scd = layout::formatDescriptor(descriptor);
  const KeyframeFiles files{cloud_sensor.size(), scan.size(), scd.size(), crc32Of(scan), crc32Of(scd)};
  guarded([&] {
    replaceFile(layout::scanFile(folder_, keyframe.id), scan);
    replaceFile(layout::descriptorFile(folder_, keyframe.id), scd);
    journal_.append(keyframe, T_map_base, files);
  });
  contents_.keyframes.push_back(keyframe);
  contents_.T_map_base.push_back(T_map_base);
  contents_.files.push_back(files);
  contents_.scan_bytes += files.scan_bytes;
  if (contents_.keyframes.size() >= next_refresh_) guarded([this] { refreshTexts(); });
}

void FolderWriter::setPoses(const std::vector<Pose>& T_map_base) {
  guarded([] {});
  if (T_map_base.size() != contents_.keyframes.size())
    throw Error(ExitCode::kBug,
                fmt::format("{} poses for {} keyframes", T_map_base.size(), contents_.keyframes.size()));
  contents_.T_map_base = T_map_base;
  const std::uint64_t bytes = 17 + 96 * T_map_base.size();
  if (contents_.pose_bytes + bytes <= std::max(kPoseBytesFloor, contents_.scan_bytes / kPoseShare)) {
    guarded([this] { recordPoses(); });
  } else if (!contents_.poses_deferred) {
    guarded([this] { journal_.appendPosesDeferred(); });
    contents_.poses_deferred = true;
  }
}

void FolderWriter::recordPoses() {
  const std::uint64_t before = journal_.size();
  journal_.append(contents_.T_map_base);
  contents_.pose_bytes += journal_.size() - before;
  contents_.poses_deferred = false;
}

/// Everything recorded reaches the disk before a checkpoint that relies on it.
void FolderWriter::syncToDisk() {
  for (; synced_ < contents_.keyframes.size(); ++synced_) {
    const auto k = static_cast<KeyframeId>(synced_);
    for (const fs::path& file : {layout::scanFile(folder_, k), layout::descriptorFile(folder_, k)}) {
      const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
      if (fd < 0) continue;  // removed by the user; the doctor tells
      ::fdatasync(fd);
      ::close(fd);
    }
  }
  journal_.sync();
  log_.sync();
}

void FolderWriter::refreshTexts() {
  const std::size_t n = contents_.keyframes.size();
  next_refresh_ = std::max(n + 8, n + n / 4);
  writeTextFiles(folder_, info_, contents_,
                 buildGraph(contents_.keyframes, contents_.loops, contents_.T_map_base, info_.planar), false);
}

void FolderWriter::checkpoint(const std::string& pipeline_state) {
  guarded([&] {
    syncToDisk();
    writeCheckpoint(folder_ / layout::kCheckpoint,
                    {journal_.size(), log_.size(), contents_.T_map_base, pipeline_state});
    refreshTexts();
  });
}

void FolderWriter::finish(const PoseGraph& graph) {
  guarded([] {});
  if (graph.poses.size() != contents_.keyframes.size())
    throw Error(ExitCode::kBug,
                fmt::format("{} poses for {} keyframes", graph.poses.size(), contents_.keyframes.size()));
  const auto same = [](const Pose& a, const Pose& b) { return a.matrix() == b.matrix(); };
  guarded([&] {
    if (contents_.poses_deferred ||
        !std::equal(graph.poses.begin(), graph.poses.end(), contents_.T_map_base.begin(), same)) {
      contents_.T_map_base = graph.poses;
      recordPoses();
    }
    syncToDisk();
    writeTextFiles(folder_, info_, contents_, graph, true);
  });
}

/// The first line in which two configurations differ, for the message.
std::string difference(const std::string& before, const std::string& now) {
  std::size_t at = 0, begin = 0;
  while (at < before.size() && at < now.size() && before[at] == now[at])
    if (before[at++] == '\n') begin = at;
  const auto line = [&](const std::string& text) {
    return begin < text.size() ? text.substr(begin, text.find('\n', begin) - begin) : std::string("nothing");
  };
  return fmt::format("the session has '{}', now '{}'", line(before), line(now));
}

void checkSameRun(const fs::path& folder, const Manifest& manifest, const SessionInfo& info) {
  const std::string hint = "resume it with what it was begun with, or replace it with -w";
  if (manifest.complete && !fs::exists(folder / layout::kCheckpoint))
    throw usageError("{} is complete, there is nothing to resume; -w replaces it", folder.string());
  if (manifest.info.input_digest != info.input_digest || manifest.info.input_format != info.input_format)
    throw usageError("{} was made from another input ({}); {}", folder.string(), manifest.info.input, hint);
  if (manifest.config_digest != digestOf(info.config_yaml))
    throw usageError("{} was made with another configuration: {}; {}", folder.string(),
                     difference(manifest.info.config_yaml, info.config_yaml), hint);
}

/// @throw inputError when a file that the checkpoint relies on is gone or shorter.
void checkFiles(const fs::path& folder, const Checkpoint& checkpoint, const JournalContents& contents) {
  const auto holds = [](const fs::path& file, std::uint64_t bytes) {
    std::error_code error;
    return fs::file_size(file, error) >= bytes && !error;
  };
  const std::string hint = "the session cannot be resumed; 'scslam doctor' shows the damage, -w starts again";
  if (contents.valid_bytes != checkpoint.journal_bytes || contents.keyframes.size() != checkpoint.T_map_base.size())
    throw inputError("{}: readable up to byte {}, its checkpoint needs {}; {}", (folder / layout::kJournal).string(),
                     contents.valid_bytes, checkpoint.journal_bytes, hint);
  if (!holds(folder / layout::kLog, checkpoint.log_bytes))
    throw inputError("{} is shorter than its checkpoint says; {}", (folder / layout::kLog).string(), hint);
  for (const Keyframe& keyframe : contents.keyframes)
    if (const auto file = layout::scanFile(folder, keyframe.id); !holds(file, contents.files[keyframe.id].scan_bytes))
      throw inputError("{} is missing or too short; {}", file.string(), hint);
}

}  // namespace

std::unique_ptr<SessionWriter> SessionWriter::create(const fs::path& folder, const SessionInfo& info, bool overwrite) {
  FolderLock lock = prepareFolder(folder, info.input, overwrite);
  writeFileAtomically(folder / layout::kManifest, manifestText(info, {}, false));
  writeFileAtomically(folder / layout::kConfig, info.config_yaml);
  removeFilesBeyond(folder, 0);
  return std::make_unique<FolderWriter>(folder, std::move(lock), info, JournalContents{}, 0);
}

std::unique_ptr<SessionWriter> SessionWriter::resume(const fs::path& folder, const SessionInfo& info,
                                                     RecoveredSession& recovered) {
  if (!fs::is_regular_file(folder / layout::kManifest))
    throw usageError("{} holds no session to resume", folder.string());
  FolderLock lock(folder);
  const Manifest manifest = readManifest(folder);
  checkSameRun(folder, manifest, info);
  SessionInfo same = manifest.info;  // the input stays named as it was, so that the files end in the same bytes
  same.config_yaml = info.config_yaml;
  const auto checkpoint = readCheckpoint(folder / layout::kCheckpoint);
  JournalContents contents;
  recovered = {};
  if (checkpoint) {
    contents = readJournal(folder / layout::kJournal, checkpoint->journal_bytes);
    checkFiles(folder, *checkpoint, contents);
    contents.T_map_base = checkpoint->T_map_base;
    recovered = {contents.scans, contents.keyframes,        contents.loops, contents.T_map_base, {},
                 contents.gnss,  checkpoint->pipeline_state};
    for (const Keyframe& keyframe : contents.keyframes)
      recovered.descriptors.push_back(layout::readDescriptor(layout::descriptorFile(folder, keyframe.id)));
  }
  // Open again before anything is cut: killed from here on, it must not pass for a complete one.
  writeFileAtomically(folder / layout::kManifest, manifestText(same, contents, false));
  writeFileAtomically(folder / layout::kConfig, info.config_yaml);
  removeFilesBeyond(folder, contents.keyframes.size());
  return std::make_unique<FolderWriter>(folder, std::move(lock), same, std::move(contents),
                                        checkpoint ? checkpoint->log_bytes : 0);
}

}  // namespace scslam
