// Global localisation in a town of another day (the map of S05, a drive through S16) from two hundred places.
#include <deque>
#include <iostream>
#include <set>

#include "scslam/apps/localize/localiser.h"
#include "scslam/core/counter_random.h"
#include "scslam/core/trajectory.h"
#include "scslam/sensor/preprocess.h"
#include "scslam/sensor/scan_source.h"
#include "support/simulated_drive.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;

constexpr std::size_t kStarts = 200, kScans = 3;

/// Different numbers of scans at which a robot is switched on.
std::set<std::size_t> startsAmong(std::size_t scans) {
  RandomSequence random(CounterRandom(11, RandomStream::kWorld));
  std::set<std::size_t> starts;
  while (starts.size() < kStarts)
    starts.insert(static_cast<std::size_t>(random.uniform() * static_cast<double>(scans - kScans)));
  return starts;
}

fs::path drivenDay(const std::string& name, const fs::path& folder) {
  simulateDrive(sim::loadScenario(name, {"truth.pictures=false", "drive.duration_s=40"}), folder);
  return folder;
}

/// One robot: odometry from its first scan on, and a localiser that knows nothing.
std::optional<Whereabouts> firstFix(const std::deque<Scan>& scans, Localiser& localiser, std::size_t& scan) {
  localiser.reset();
  const auto odometry = SlamParams().odometry.frontend.create(context(2));
  odometry->begin(std::nullopt, Pose::Identity());
  for (scan = 0; scan < scans.size(); ++scan) {
    const Whereabouts where = localiser.step(odometry->step(scans[scan]));
    if (where.state != WhereState::kSearching) return where;
  }
  return std::nullopt;
}

TEST(Localize, OfTwoHundredStartsOnAnotherDayNearlyAllAreFoundWithinThreeScansAndNoneElsewhere) {
  const fs::path folder = freshFolder();
  const fs::path summer = drivenDay("s05_junction_grid", folder / "summer");
  const fs::path winter = drivenDay("s16_winter", folder / "winter");
  mapDrive(summer);
  Session session = Session::open(summer / "session");
  const Pose T_base_sensor = session.info().T_base_sensor;
  const SlamParams params;
  const SavedMap map(std::move(session), T_base_sensor, params.registration, std::size_t{1} << 28);
  const Trajectory truth = readTrajectory(summer / "drive.gt.tum"), here = readTrajectory(winter / "drive.gt.tum");
  Localiser localiser(map, params, LocalizeParams(), context(2));

  const auto source = openSource((winter / "drive.rawlog").string(), context(2)).source;
  const std::set<std::size_t> starts = startsAmong(400);
  std::deque<Scan> window;
  std::size_t found = 0, read = 0;
  while (auto next = source->next()) {
    preprocess(*next, params.preprocess);
    window.push_back(std::move(*next));
    if (window.size() > kScans) window.pop_front();
    if (!starts.contains(++read - kScans) || window.size() < kScans) continue;
    std::size_t scan = 0;
    const auto where = firstFix(window, localiser, scan);
    if (!where) continue;
    ++found;
    const KeyframeId near = where->keyframe.value();
    const Pose T_true = truth.at(map.keyframes()[near].stamp)->inverse() * *here.at(window[scan].stamp);
    EXPECT_THAT(Pose(map.poses()[near].inverse() * where->T_map_base), IsNear(T_true, 0.1, 1.0))
        << "scan " << window.front().index;
  }
  ASSERT_GE(read, 400u);
  std::cout << found << " of " << kStarts << " starts found within " << kScans << " scans\n";
  EXPECT_GE(found, kStarts * 95 / 100);
}

}  // namespace
}  // namespace scslam::test
