#include "scslam/apps/doctor.h"

#include <algorithm>

#include "scslam/core/bytes.h"
#include "scslam/core/error.h"
#include "scslam/core/pcd.h"
#include "scslam/graph/g2o.h"
#include "scslam/session/checkpoint.h"
#include "scslam/session/journal.h"
#include "scslam/session/layout.h"
#include "scslam/session/manifest.h"
#include "scslam/session/session.h"
#include "scslam/session/session_folder.h"
#include "scslam/session/session_graph.h"
#include "scslam/session/text_files.h"

namespace scslam {
namespace fs = std::filesystem;
namespace {

/// Runs a check; what it throws becomes the finding.
DoctorCheck check(const std::string& what, bool repairable, const std::function<std::string()>& body) {
  DoctorCheck result{what, true, {}, false};
  try {
    result.finding = body();
  } catch (const Error& error) {
    result = {what, false, error.what(), repairable};
  }
  return result;
}

Manifest readSoundManifest(const fs::path& folder) {
  Manifest manifest = readManifest(folder);
  if (manifest.config_digest != digestOf(manifest.info.config_yaml))
    throw inputError("{} is missing or was edited after the run (its digest differs from {})", layout::kConfig,
                     layout::kManifest);
  return manifest;
}

std::string checkCounts(const Manifest& manifest, const JournalContents& contents) {
  const auto accepted = static_cast<std::size_t>(std::count_if(contents.loops.begin(), contents.loops.end(),
                                                               [](const LoopRecord& loop) { return loop.accepted; }));
  if (manifest.complete && (manifest.scans != contents.scans.size() ||
                            manifest.keyframes != contents.keyframes.size() || manifest.loops_accepted != accepted))
    throw inputError("{} counts {} scans, {} keyframes, {} loops; the journal holds {}, {}, {}", layout::kManifest,
                     manifest.scans, manifest.keyframes, manifest.loops_accepted, contents.scans.size(),
                     contents.keyframes.size(), accepted);
  return fmt::format("{}, {} scans, {} keyframes, {} loops", manifest.complete ? "complete" : "open",
                     contents.scans.size(), contents.keyframes.size(), accepted);
}

void checkBytes(const fs::path& file, std::uint64_t bytes, std::uint32_t crc) {
  const std::string content = readFile(file);
  if (content.size() != bytes) throw inputError("{} has {} bytes, not {}", file.string(), content.size(), bytes);
  if (crc32Of(content) != crc) throw inputError("{} was changed (its checksum is wrong)", file.string());
}

std::string checkScans(const fs::path& folder, const JournalContents& contents,
                       const std::function<void(std::size_t)>& progress) {
  std::uint64_t points = 0;
  for (std::size_t k = 0; k < contents.keyframes.size(); ++k) {
    const KeyframeFiles& files = contents.files[k];
    const fs::path file = layout::scanFile(folder, static_cast<KeyframeId>(k));
    checkBytes(file, files.scan_bytes, files.scan_crc);
    if (const std::size_t found = readPcd(file).size(); found != files.points)
      throw inputError("{} holds {} points, not {}", file.string(), found, files.points);
    points += files.points;
    if (progress) progress(k + 1);
  }
  return fmt::format("{} files, {} points, checksums right", contents.keyframes.size(), points);
}

std::string checkDescriptors(const fs::path& folder, const JournalContents& contents) {
  for (std::size_t k = 0; k < contents.keyframes.size(); ++k) {
    const fs::path file = layout::descriptorFile(folder, static_cast<KeyframeId>(k));
    checkBytes(file, contents.files[k].descriptor_bytes, contents.files[k].descriptor_crc);
    layout::readDescriptor(file);
  }
  return fmt::format("{} files, checksums right", contents.keyframes.size());
}

std::string checkPoses(const std::vector<Pose>& T_map_base) {
  for (std::size_t k = 0; k < T_map_base.size(); ++k)
    if (!isRigid(T_map_base[k])) throw inputError("the pose of keyframe {} is no rigid motion", k);
  return fmt::format("{} optimised poses, all rigid", T_map_base.size());
}

/// A text file of a complete session is exactly what the journal makes.
std::string checkText(const fs::path& file, const std::string& expected) {
  const std::string found = readFile(file);
  if (found == expected) return "as the journal says";
  const auto lines = [](const std::string& text) { return std::count(text.begin(), text.end(), '\n'); };
  if (lines(found) != lines(expected))
    throw inputError("{} has {} lines, the journal makes {}", file.string(), lines(found), lines(expected));
  const auto differs = std::mismatch(found.begin(), found.end(), expected.begin(), expected.end()).first;
  throw inputError("{}:{}: not what the journal says", file.string(), std::count(found.begin(), differs, '\n') + 1);
}

std::string checkGraph(const fs::path& file, std::size_t keyframes) {
  const PoseGraph graph = readG2o(file).graph;
  if (graph.poses.size() != keyframes)
    throw inputError("{} has {} vertices for {} keyframes", file.string(), graph.poses.size(), keyframes);
  return fmt::format("{} vertices, {} edges", graph.poses.size(), graph.factors.size());
}

void checkTexts(const fs::path& folder, const SessionInfo& info, const JournalContents& contents,
                std::vector<DoctorCheck>& checks) {
  for (const auto& [name, text] : textFiles(info, contents)) {
    const fs::path file = folder / name;
    checks.push_back(check(name, true, [&, &expected = text] { return checkText(file, expected); }));
  }
  const fs::path graph = folder / layout::kPoseGraph;
  checks.push_back(check(layout::kPoseGraph, true, [&] { return checkGraph(graph, contents.keyframes.size()); }));
}

std::vector<DoctorCheck> examineClassic(const fs::path& folder) {
  std::vector<DoctorCheck> checks;
  checks.push_back(check("poses and times", false, [&] {
    const Session session = Session::open(folder);
    return fmt::format("{} keyframes, {} loops in its g2o file; {}", session.keyframes().size(), session.loops().size(),
                       checkPoses(session.poses()));
  }));
  if (!checks.back().sound) return checks;
  checks.push_back(check(layout::kScans, false, [&] {
    const Session session = Session::open(folder);
    std::size_t found = 0;
    for (const Keyframe& keyframe : session.keyframes()) {
      if (!session.hasCloud(keyframe.id)) continue;
      session.cloud(keyframe.id);
      ++found;
    }
    if (found != session.keyframes().size())
      throw inputError("{} scans for {} keyframes", found, session.keyframes().size());
    return fmt::format("{} files", found);
  }));
  return checks;
}

}  // namespace

std::vector<DoctorCheck> examine(const fs::path& session, const std::function<void(std::size_t)>& progress) {
  if (!fs::exists(session / layout::kManifest)) {
    Session::open(session);  // @throw when it is no session at all
    return examineClassic(session);
  }
  std::vector<DoctorCheck> checks;
  Manifest manifest;
  checks.push_back(check(layout::kManifest, false, [&] {
    manifest = readSoundManifest(session);
    return fmt::format("from {}", manifest.info.input);
  }));
  JournalContents contents;
  checks.push_back(check(layout::kJournal, false, [&] {
    contents = readJournal(session / layout::kJournal);
    if (!contents.problem.empty() && manifest.complete)
      throw inputError("{}; readable: {} scans, {} keyframes", contents.problem, contents.scans.size(),
                       contents.keyframes.size());
    return checkCounts(manifest, contents) + (contents.problem.empty() ? "" : "; its last record is torn (a kill)");
  }));
  checks.push_back(check("poses", false, [&] { return checkPoses(contents.T_map_base); }));
  checks.push_back(check(layout::kScans, false, [&] { return checkScans(session, contents, progress); }));
  checks.push_back(check(layout::kDescriptors, false, [&] { return checkDescriptors(session, contents); }));
  if (fs::exists(session / layout::kCheckpoint))
    checks.push_back(check(layout::kCheckpoint, false, [&] {
      const auto checkpoint = readCheckpoint(session / layout::kCheckpoint);
      if (checkpoint->journal_bytes > contents.valid_bytes)
        throw inputError("it needs {} bytes of the journal, {} are readable", checkpoint->journal_bytes,
                         contents.valid_bytes);
      return fmt::format("--resume goes on from keyframe {}", checkpoint->T_map_base.size());
    }));
  if (manifest.complete) checkTexts(session, manifest.info, contents, checks);
  return checks;
}

void repair(const fs::path& session) {
  if (!fs::exists(session / layout::kJournal))
    throw inputError("{} has no {}, there is nothing to repair from", session.string(), layout::kJournal);
  const FolderLock lock(session);
  const Manifest manifest = readManifest(session);
  const fs::path journal = session / layout::kJournal;
  const JournalContents contents = readJournal(journal);
  if (!contents.problem.empty()) {
    if (manifest.complete) fs::copy_file(journal, journal.string() + ".damaged", fs::copy_options::overwrite_existing);
    fs::resize_file(journal, contents.valid_bytes);
  }
  writeTextFiles(session, manifest.info, contents,
                 buildGraph(contents.keyframes, contents.loops, contents.T_map_base, manifest.info.planar),
                 manifest.complete);
}

}  // namespace scslam
