// From a scenario to a rawlog with its truth, and back through the readers.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <set>

#include "scslam/core/file.h"
#include "scslam/core/trajectory.h"
#include "scslam/sensor/scan_source.h"
#include "sim/rawlog_writer.h"
#include "sim/simulation.h"
#include "support/support.h"

namespace scslam::sim {
namespace {

namespace fs = std::filesystem;

Scenario shortDrive(const std::vector<std::string>& more = {}) {
  std::vector<std::string> sets = {"drive.duration_s=2", "drive.start_pause_s=0", "lidar.sensor=vlp16",
                                   "truth.pictures=false"};
  sets.insert(sets.end(), more.begin(), more.end());
  return loadScenario("s01", sets);
}

SimulationSummary simulated(const Scenario& scenario, const fs::path& file, int threads = 1) {
  SimulateOptions options;
  options.output = file, options.quiet = true;
  return simulate(scenario, options, test::context(threads));
}

TEST(Simulate, WritesALogThatTheReadersUnderstand) {
  const fs::path folder = test::freshFolder();
  const Scenario scenario = shortDrive({"truth.labels=true", "truth.firings=true", "imu.enabled=true",
                                        "gnss.enabled=true", "radar.on=true", "radar.png=true"});
  const SimulationSummary summary = simulated(scenario, folder / "drive.rawlog");
  auto opened = openSource(folder / "drive.rawlog", test::context());
  EXPECT_EQ(opened.format, "rawlog");
  const auto truth = opened.source->groundTruth();
  ASSERT_TRUE(truth);
  std::size_t scans = 0, points = 0;
  while (const auto scan = opened.source->next()) {
    EXPECT_TRUE(scan->cloud.hasRing() && scan->cloud.hasTime() && scan->cloud.hasIntensity());
    EXPECT_TRUE(truth->at(scan->stamp)) << "no truth at the stamp of scan " << scans;
    EXPECT_TRUE(scan->T_odom_base) << "the wheels are in the log";
    const auto labels = fs::file_size(folder / "drive.labels" / fmt::format("{:06}.label", scans));
    EXPECT_EQ(labels, 4 * scan->cloud.size());
    ++scans, points += scan->cloud.size();
  }
  EXPECT_EQ(scans, summary.scans);
  EXPECT_EQ(points, summary.points);
  EXPECT_EQ(summary.radar_scans, 8u);
  EXPECT_THAT(opened.source->description(),
              ::testing::HasSubstr("scenario s01_loop, world town, seed 1, sensors vlp16, "
                                   "cts350-x, imu, wheels, gnss"));
  EXPECT_EQ(std::distance(fs::directory_iterator(folder / "drive.radar"), {}), 8);
  EXPECT_EQ(readTrajectory(folder / "drive.firings.tum").poses.size(), scans * 1808);
}

TEST(Simulate, GivesTheSameFileForAnyNumberOfThreads) {
  const fs::path folder = test::freshFolder();
  const Scenario scenario = shortDrive({"radar.on=true", "imu.enabled=true", "drive.duration_s=0.6"});
  Scenario other = scenario;
  other.seed = 2;
  const std::string one = simulated(scenario, folder / "1.rawlog", 1).sha256;
  EXPECT_EQ(one, simulated(scenario, folder / "2.rawlog", 2).sha256);
  EXPECT_NE(one, simulated(other, folder / "3.rawlog", 1).sha256);
  for (const char* suffix : {".gt.tum", ".loops.csv"})
    EXPECT_EQ(readFile(folder / ("1" + std::string(suffix))), readFile(folder / ("2" + std::string(suffix))));
}

TEST(Simulate, TellsRevisitsAndTheirOverlap) {
  const fs::path folder = test::freshFolder();
  const Scenario scenario = loadScenario(
      "s04", {"truth.pictures=false", "lidar.sensor=vlp16", "drive.duration_s=60", "lidar.effects.beam_width=false"});
  Simulation simulation(scenario, test::context());
  const auto places = placesOf(simulation.drive(), poseFromYaw(0, {0, 0, 1.8}), 0.1, simulation.recorded(), 2);
  ThreadPool threads(2);
  const auto found = revisits(places, simulation.scene(), 100, 20, threads);
  ASSERT_FALSE(found.empty());
  std::vector<double> lateral, overlap;
  for (const Revisit& r : found) {
    EXPECT_LE(r.distance_m, 10);
    EXPECT_GE(r.overlap_a, 0);
    EXPECT_LE(r.overlap_b, 1);
    if (std::abs(r.heading_deg) > 5 || r.distance_m > 4.2) continue;
    lateral.push_back(std::abs(r.lateral_m)), overlap.push_back(std::min(r.overlap_a, r.overlap_b));
  }
  ASSERT_GT(lateral.size(), 20u);
  const auto median = [](std::vector<double>& values) {
    std::nth_element(values.begin(), values.begin() + std::ssize(values) / 2, values.end());
    return values[values.size() / 2];
  };
  EXPECT_NEAR(median(lateral), 3.5, 0.2) << "the second lap is 3.5 m to the left";
  EXPECT_GT(median(overlap), 0.6);
}

TEST(Simulate, FindsPlacesThatOnlyLookAlike) {
  const Scenario scenario = loadScenario("s06", {"drive.duration_s=30"});
  Simulation simulation(scenario, test::context());
  ThreadPool threads(2);
  const auto places = placesOf(simulation.drive(), poseFromYaw(0, {0, 0, 1.8}), 0.1, simulation.recorded(), 2);
  const auto found = aliases(places, simulation.scene(), 100, threads);
  EXPECT_GT(found.size(), places.size() / 4) << "the blocks repeat every 40 m";
}

TEST(Simulate, ReportsADriveThroughAWall) {
  const Scenario scenario =
      shortDrive({"drive.points=[0, 0, 40, 25]", "drive.duration_s=10", "drive.turn_radius_m=1", "world.town.cars=0"});
  Simulation simulation(scenario, test::context());
  EXPECT_THAT(simulation.collision(), ::testing::HasSubstr("drives through"));
}

TEST(Simulate, ReportsAWheelOnAParkedCar) {
  const auto collision = [](const char* lane) {
    return Simulation(loadScenario("s18", {lane, "drive.duration_s=8"}), test::context()).collision();
  };
  EXPECT_THAT(collision("drive.lane_m=-2.2"), ::testing::HasSubstr("car_"));
  EXPECT_EQ(collision("drive.lane_m=-1.5"), "");
}

TEST(Simulate, ListsRevisitedPlacesOfARadarAlone) {
  const fs::path folder = test::freshFolder();
  const Scenario scenario =
      loadScenario("s19", {"truth.loops=true", "world.unit.size_m=60", "lidar.on=false", "radar.on=true",
                           "truth.pictures=false", "drive.duration_s=8", "drive.start_pause_s=0", "drive.speed_mps=8",
                           "drive.points=[-4, -4, 4, -4, 4, 4, -4, 4]", "drive.closed=true", "drive.laps=2",
                           "drive.turn_radius_m=1", "drive.accelerate_mps2=10", "drive.corner_mps2=10"});
  const SimulationSummary summary = simulated(scenario, folder / "drive.rawlog", 2);
  EXPECT_EQ(summary.radar_scans, 32u);
  EXPECT_GT(summary.revisits, 5u);
  EXPECT_GT(readFile(folder / "drive.loops.csv").size(), 300u);
}

TEST(Simulate, LosesWhatTheFaultsSay) {
  Simulation whole(shortDrive({"drive.duration_s=30"}), test::context());
  Simulation faulty(shortDrive({"drive.duration_s=30", "faults.lost_scans=0.2", "faults.lost_rings=0.5"}),
                    test::context());
  EXPECT_NEAR(static_cast<double>(faulty.recorded().size()) / static_cast<double>(whole.recorded().size()), 0.8, 0.1);
  ThreadPool threads(1);
  const LidarScan scan = faulty.sweep(faulty.recorded()[0], threads);
  std::set<int> rings(scan.cloud.ring.begin(), scan.cloud.ring.end());
  EXPECT_EQ(rings.size(), 8u);
  EXPECT_EQ(scan.labels.size(), scan.cloud.size());
}

TEST(Simulate, NothingIsMeasuredWhileTheSensorsAreOff) {
  const fs::path folder = test::freshFolder();
  int drives = 0;
  const Scenario scenario = shortDrive({"faults.off_s=[0.3, 1.8]"});
  const auto bytes = [&](const Scenario& s, std::uint32_t scans) {
    EXPECT_EQ(simulated(s, folder / fmt::format("{}.rawlog", ++drives)).scans, scans);
    return static_cast<double>(fs::file_size(folder / fmt::format("{}.rawlog", drives)));
  };
  const double of_imu = bytes(shortDrive({"imu.enabled=true"}), 20) - bytes(shortDrive(), 20);
  const double left = bytes(shortDrive({"imu.enabled=true", "faults.off_s=[0.3, 1.8]"}), 5) - bytes(scenario, 5);
  EXPECT_NEAR(left / of_imu, 0.25, 0.1);
  EXPECT_FALSE(scenario.faults.off(0.29));
  EXPECT_TRUE(scenario.faults.off(0.3));
  EXPECT_FALSE(scenario.faults.off(1.8));
}

TEST(Simulate, RefusesWhatMakesNoDrive) {
  EXPECT_THROW(Simulation(shortDrive({"drive.duration_s=0"}), test::context()), Error);
  EXPECT_THROW(Simulation(shortDrive({"drive.route=nowhere"}), test::context()), Error);
  EXPECT_THROW(Simulation(shortDrive({"drive.points=[1, 2, 3]"}), test::context()), Error);
  EXPECT_THROW(Simulation(shortDrive({"lidar.sensor=vpl16"}), test::context()), Error);
  EXPECT_THROW(Simulation(shortDrive({"lidar.translation_m=[1]"}), test::context()), Error);
  EXPECT_THROW(Simulation(shortDrive({"faults.off_s=[1, 2, 3]"}), test::context()), Error);
  EXPECT_THROW(Simulation(shortDrive({"faults.dirty_deg=[100]"}), test::context()), Error);
  EXPECT_THROW(loadScenario("s99"), Error);
  EXPECT_THROW(loadScenario("s01", {"drive.sped_mps=3"}), Error);
}

TEST(Simulate, KeepsWhatIsThereUnlessTold) {
  const fs::path folder = test::freshFolder();
  std::ofstream(folder / "drive.rawlog") << "mine";
  EXPECT_THROW(simulated(shortDrive(), folder / "drive.rawlog"), Error);
  EXPECT_EQ(readFile(folder / "drive.rawlog"), "mine");
}

TEST(Simulate, CommandLineSaysWhatIsWrong) {
  const auto bad = test::runScslam("sim s01 --set drive.sped_mps=3");
  EXPECT_EQ(bad.exit_code, 2);
  EXPECT_THAT(bad.err, ::testing::HasSubstr("speed_mps"));
  const auto list = test::runScslam("sim --list");
  EXPECT_EQ(list.exit_code, 0);
  EXPECT_THAT(list.out, ::testing::HasSubstr("s19_unit"));
}

}  // namespace
}  // namespace scslam::sim
