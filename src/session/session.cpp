#include "scslam/session/session.h"

#include "scslam/core/error.h"
#include "scslam/core/pcd.h"
#include "scslam/session/journal.h"
#include "scslam/session/layout.h"
#include "scslam/session/manifest.h"
#include "scslam/session/session_graph.h"

namespace scslam {
namespace fs = std::filesystem;

Session Session::open(const fs::path& folder) {
  if (!fs::exists(folder)) throw inputError("{} does not exist", folder.string());
  Session session;
  session.folder_ = folder;
  if (fs::is_regular_file(folder / layout::kManifest))
    session.openOwn();
  else if (fs::is_regular_file(folder / layout::kOptimisedPoses))
    session.openClassic();
  else
    throw inputError("{} is no session: it has neither {} nor {}", folder.string(), layout::kManifest,
                     layout::kOptimisedPoses);
  return session;
}

void Session::openOwn() {
  const Manifest manifest = readManifest(folder_);
  info_ = manifest.info;
  complete_ = manifest.complete;
  const fs::path journal = folder_ / layout::kJournal;
  if (!complete_ && !fs::exists(journal)) return;  // killed before its first event
  JournalContents contents = readJournal(journal);
  if (complete_ && !contents.problem.empty())
    throw inputError("{}: {}; 'scslam doctor {}' shows what is left", journal.string(), contents.problem,
                     folder_.string());
  if (complete_ && (contents.keyframes.size() != manifest.keyframes || contents.scans.size() != manifest.scans))
    throw inputError("{} holds {} scans and {} keyframes, {} says {} and {}; see 'scslam doctor {}'", journal.string(),
                     contents.scans.size(), contents.keyframes.size(), layout::kManifest, manifest.scans,
                     manifest.keyframes, folder_.string());
  scans_ = std::move(contents.scans);
  keyframes_ = std::move(contents.keyframes);
  loops_ = std::move(contents.loops);
  gnss_ = std::move(contents.gnss);
  T_map_base_ = std::move(contents.T_map_base);
}

std::vector<StampedPose> Session::trajectory() const { return correctedTrajectory(scans_, keyframes_, T_map_base_); }
std::vector<StampedPose> Session::odometry() const { return odometryTrajectory(scans_); }
PoseGraph Session::graph() const { return buildGraph(keyframes_, loops_, T_map_base_, info_.planar); }
bool Session::hasCloud(KeyframeId k) const { return fs::exists(layout::scanFile(folder_, k)); }
Cloud Session::cloud(KeyframeId k) const { return readPcd(layout::scanFile(folder_, k)); }
Descriptor Session::descriptor(KeyframeId k) const {
  return layout::readDescriptor(layout::descriptorFile(folder_, k));
}

}  // namespace scslam
