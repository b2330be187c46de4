// What changed in a town between two days (S05, S16), held against the meshes of both days' worlds.
#include <algorithm>
#include <iostream>
#include <unordered_set>

#include "scslam/apps/alignment.h"
#include "scslam/apps/changes/changes.h"
#include "scslam/apps/merge/merge.h"
#include "scslam/core/trajectory.h"
#include "scslam/core/voxel_key.h"
#include "scslam/session/session.h"
#include "support/simulated_drive.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;

/// Where the surfaces of a mesh are, to half a cell.
class Surfaces {
 public:
  explicit Surfaces(const sim::Mesh& mesh) {
    for (const auto& triangle : mesh.triangles) {
      const Eigen::Vector3f &a = mesh.vertices[triangle[0]], ab = mesh.vertices[triangle[1]] - a,
                            ac = mesh.vertices[triangle[2]] - a;
      const int n = 1 + static_cast<int>(std::max({ab.norm(), ac.norm(), (ac - ab).norm()}) / (0.5F * kCell));
      for (int i = 0; i <= n; ++i)
        for (int j = 0; i + j <= n; ++j)
          cells_.insert(keyOf(a + ab * static_cast<float>(i) / static_cast<float>(n) +
                              ac * static_cast<float>(j) / static_cast<float>(n)));
    }
  }
  bool within(const Eigen::Vector3f& p, int cells) const {
    for (int x = -cells; x <= cells; ++x)
      for (int y = -cells; y <= cells; ++y)
        for (int z = -cells; z <= cells; ++z)
          if (cells_.contains(keyOf(p + kCell * Eigen::Vector3f(x, y, z).cast<float>()))) return true;
    return false;
  }
  static constexpr float kCell = 0.1F;  ///< [m]

 private:
  static VoxelKey keyOf(const Eigen::Vector3f& p) {
    return packVoxel(floorToInt(p.x() / kCell), floorToInt(p.y() / kCell), floorToInt(p.z() / kCell));
  }
  std::unordered_set<VoxelKey> cells_;
};

/// A scenario driven and mapped.
struct Day {
  fs::path session, truth;
  Surfaces surfaces;
};

Day dayOf(const std::string& scenario_name, const fs::path& folder) {
  const sim::Scenario scenario = sim::loadScenario(scenario_name, {"truth.pictures=false", "drive.duration_s=40"});
  simulateDrive(scenario, folder);
  mapDrive(folder);
  const fs::path session = folder / folder.filename();  // by which the merged session knows it
  fs::rename(folder / "session", session);
  return {session, folder / "drive.gt.tum", Surfaces(sim::Simulation(scenario, context()).world().mesh)};
}

/// Where the merged map lies in the world: the days' keyframes follow each other in it.
Pose placeOf(const fs::path& merged, const std::vector<const Day*>& days) {
  const Session session = Session::open(merged);
  std::vector<Pose> T_world_base;
  for (const auto& parent : session.info().parents) {  // in an order of merge's own
    const auto day = std::find_if(days.begin(), days.end(),
                                  [&parent](const Day* d) { return d->session.filename() == parent.name; });
    const Trajectory truth = readTrajectory((*day)->truth);
    const Session own = Session::open((*day)->session);
    for (const Keyframe& keyframe : own.keyframes()) T_world_base.push_back(truth.at(keyframe.stamp).value());
  }
  EXPECT_EQ(T_world_base.size(), session.poses().size());
  return alignPoses(T_world_base, session.poses());
}

/// Of the voxels of one kind, with the truth from the meshes; what is on no mesh of its own day moved or is noise.
struct Score {
  double found = 0, right = 0, truly = 0;
  double precision() const { return right / std::max(found, 1.0); }
  double recall() const { return right / std::max(truly, 1.0); }
};

Score scoreOf(const ChangeMap& map, Change kind, const Pose& T_world_map, const Surfaces& here, const Surfaces& there) {
  Score score;
  for (std::size_t i = 0; i < map.change.size(); ++i) {
    if (map.change[i] == Change::kUnseen) continue;
    const bool says = map.change[i] == kind;
    if (!says && map.change[i] != Change::kStayed) continue;
    const Eigen::Vector3f p = (T_world_map * map.cloud_map.point(i).cast<double>()).cast<float>();
    const bool is = here.within(p, 1) && !there.within(p, 3), is_not = there.within(p, 0);
    if (!is && !is_not && here.within(p, 1)) continue;  // too near to something that stayed to tell
    score.found += says, score.right += says && is, score.truly += is;
  }
  return score;
}

TEST(ChangesOfATown, AreThoseOfItsMeshes) {
  const fs::path folder = freshFolder();
  const Day summer = dayOf("s05_junction_grid", folder / "summer"), winter = dayOf("s16_winter", folder / "winter");
  MergeOptions merge;
  merge.sessions = {summer.session, winter.session};
  merge.output = folder / "both";
  merge.quiet = true;
  mergeSessions(merge, context(2));
  ChangesOptions options;
  options.older = "summer", options.newer = "winter";
  options.session = merge.output, options.output = folder / "changes", options.quiet = true;
  const ChangesSummary summary = findChanges(options, context(2));
  const Pose T_world_map = placeOf(merge.output, {&summer, &winter});
  const Score gone = scoreOf(summary.map, Change::kDisappeared, T_world_map, summer.surfaces, winter.surfaces);
  const Score come = scoreOf(summary.map, Change::kAppeared, T_world_map, winter.surfaces, summer.surfaces);
  std::cout << changesTable(summary)
            << fmt::format("disappeared: precision {:.3f}, recall {:.3f} of {:.0f} voxels\n", gone.precision(),
                           gone.recall(), gone.truly)
            << fmt::format("appeared:    precision {:.3f}, recall {:.3f} of {:.0f} voxels\n", come.precision(),
                           come.recall(), come.truly);
  EXPECT_GT(gone.truly, 500);
  EXPECT_GT(come.truly, 200);
  EXPECT_GT(gone.precision(), 0.93);
  EXPECT_GT(come.precision(), 0.75);  // few things came, and some of the traffic passes for them
  EXPECT_GT(gone.recall(), 0.9);
  EXPECT_GT(come.recall(), 0.9);
}

}  // namespace
}  // namespace scslam::test
