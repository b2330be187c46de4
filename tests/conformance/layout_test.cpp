// The architecture, checked: who includes whom, how long files are, which plug-ins there are.
#include <algorithm>
#include <fstream>
#include <regex>

#include "scslam/core/embedded_configs.h"
#include "scslam/mapping/map_exporter.h"
#include "scslam/odometry/odometry.h"
#include "scslam/pipeline/slam_params.h"
#include "scslam/place/place_recogniser.h"
#include "scslam/registration/registration.h"
#include "scslam/sensor/radar_extractor.h"
#include "scslam/sensor/scan_source.h"
#include "sim/scenario.h"
#include "support/support.h"

namespace scslam {
namespace {

namespace fs = std::filesystem;

const std::vector<std::string> kFolders = {"core",         "sensor", "odometry", "keyframe", "place",
                                           "registration", "graph",  "session",  "mapping",  "pipeline",
                                           "apps",         "view",   "cli"};
const std::vector<std::string> kPluginFolders = {"readers",     "extractors", "frontends",
                                                 "recognisers", "methods",    "exporters"};

struct Include {
  fs::path file;
  std::string folder, text;
  bool in_plugin;
};

std::vector<Include> allIncludes() {
  std::vector<Include> result;
  const fs::path root = fs::path(SCSLAM_SOURCE_DIR) / "src";
  static const std::regex pattern(R"(^\s*#\s*include\s*[<"]scslam/([^>"]+)[>"])");
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    const auto extension = entry.path().extension();
    if (extension != ".h" && extension != ".cpp") continue;
    const fs::path relative = fs::relative(entry.path(), root);
    const std::string folder = relative.begin()->string();
    const std::string second = std::next(relative.begin())->string();
    const bool in_plugin = std::find(kPluginFolders.begin(), kPluginFolders.end(), second) != kPluginFolders.end();
    std::ifstream file(entry.path());
    std::smatch match;
    for (std::string line; std::getline(file, line);)
      if (std::regex_search(line, match, pattern)) result.push_back({relative, folder, match[1], in_plugin});
  }
  return result;
}

std::size_t rank(const std::string& folder) {
  return static_cast<std::size_t>(std::find(kFolders.begin(), kFolders.end(), folder) - kFolders.begin());
}

TEST(Layout, AFolderIncludesOnlyItselfAndFoldersToItsLeft) {
  const auto includes = allIncludes();
  ASSERT_GT(includes.size(), 100u) << "the source tree was not found";
  for (const auto& include : includes) {
    const std::string target = fs::path(include.text).begin()->string();
    ASSERT_LT(rank(target), kFolders.size()) << include.file << " includes " << include.text;
    EXPECT_LE(rank(target), rank(include.folder)) << include.file << " includes " << include.text;
  }
}

TEST(Layout, PlaceRegistrationAndGraphDoNotKnowEachOther) {
  const std::vector<std::string> strangers = {"place", "registration", "graph"};
  for (const auto& include : allIncludes()) {
    const std::string target = fs::path(include.text).begin()->string();
    const auto stranger = [&](const std::string& f) {
      return std::find(strangers.begin(), strangers.end(), f) != strangers.end();
    };
    EXPECT_FALSE(stranger(include.folder) && stranger(target) && target != include.folder)
        << include.file << " includes " << include.text;
  }
}

TEST(Layout, APluginIncludesItsInterfaceAndCoreAndNobodyIncludesAPlugin) {
  for (const auto& include : allIncludes()) {
    const fs::path target(include.text);
    const std::string folder = target.begin()->string();
    if (include.in_plugin) {
      EXPECT_TRUE(folder == "core" || folder == include.folder) << include.file << " includes " << include.text;
    }
    const std::string second = std::next(target.begin())->string();
    const bool is_plugin = std::find(kPluginFolders.begin(), kPluginFolders.end(), second) != kPluginFolders.end();
    if (is_plugin) {
      EXPECT_TRUE(include.in_plugin && include.folder == folder) << include.file << " includes " << include.text;
    }
  }
}

TEST(Layout, OnlyTheGraphFolderIncludesCeres) {
  for (const auto& entry : fs::recursive_directory_iterator(fs::path(SCSLAM_SOURCE_DIR) / "src")) {
    if (!entry.is_regular_file()) continue;
    std::ifstream file(entry.path());
    for (std::string line; std::getline(file, line);)
      if (line.starts_with("#include <ceres")) {
        EXPECT_EQ(entry.path().parent_path().filename(), "graph") << entry.path();
      }
  }
}

TEST(Layout, TheSimulatorIncludesCoreAndSensorAloneAndOnlyItKnowsEmbree) {
  static const std::regex ours(R"(^\s*#\s*include\s*"scslam/([^/]+)/)"),
      embree(R"(^\s*#\s*include\s*<(embree|assimp))");
  for (const char* top : {"src", "sim"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(SCSLAM_SOURCE_DIR) / top)) {
      if (entry.path().extension() != ".h" && entry.path().extension() != ".cpp") continue;
      std::ifstream file(entry.path());
      std::smatch match;
      for (std::string line; std::getline(file, line);) {
        if (std::regex_search(line, match, embree)) {
          EXPECT_STREQ(top, "sim") << entry.path();
        }
        if (std::string_view(top) == "sim" && std::regex_search(line, match, ours)) {
          EXPECT_TRUE(match[1] == "core" || match[1] == "sensor") << entry.path() << ": " << line;
        }
      }
    }
}

TEST(Layout, NoFileIsLongerThan400Lines) {
  for (const char* top : {"src", "sim", "tests"})
    for (const auto& entry : fs::recursive_directory_iterator(fs::path(SCSLAM_SOURCE_DIR) / top)) {
      const auto extension = entry.path().extension();
      if (extension != ".h" && extension != ".cpp") continue;
      std::ifstream file(entry.path());
      const auto lines = std::count(std::istreambuf_iterator<char>(file), {}, '\n');
      EXPECT_LE(lines, 400) << entry.path();
    }
}

TEST(Plugins, NothingVanishedSilently) {
  EXPECT_EQ(Registry<ScanFormat>::instance().names(),
            (std::vector<std::string>{"clouds", "kitti", "mulran", "mulran_radar", "oxford_radar", "radiate", "rawlog",
                                      "session"}));
  EXPECT_EQ(Registry<RadarExtractor>::instance().names(),
            (std::vector<std::string>{"bfar", "ca_cfar", "cen2018", "cen2019", "k_strongest", "os_cfar"}));
  EXPECT_EQ(Registry<Odometry>::instance().names(),
            (std::vector<std::string>{"gicp", "lego", "lio", "lio_smoother", "loam", "poses", "radar_features",
                                      "radar_surface", "voxel_icp", "wheel"}));
  EXPECT_EQ(Registry<PlaceRecogniser>::instance().names(),
            (std::vector<std::string>{"cart_context", "radius", "scan_context"}));
  EXPECT_EQ(Registry<Registration>::instance().names(), (std::vector<std::string>{"voxel_planes"}));
  EXPECT_EQ(Registry<MapExporter>::instance().names(),
            (std::vector<std::string>{"g2o", "grid", "kitti", "octomap", "pcd", "ply", "radar_power", "tum"}));
  EXPECT_EQ(Registry<sim::WorldGenerator>::instance().names(),
            (std::vector<std::string>{"blocks", "bridge", "corridor", "field", "garage", "hills", "mesh", "roundabout",
                                      "town", "tunnel", "unit"}));
}

TEST(Scenarios, EveryShippedOneLoadsAndSaysWhatItIsAbout) {
  const auto scenarios = sim::scenarioNames();
  EXPECT_GE(scenarios.size(), 19u);
  for (const auto& [name, summary] : scenarios) {
    EXPECT_FALSE(summary.empty()) << name;
    const sim::Scenario scenario = sim::loadScenario(name);
    EXPECT_LE(scenario.drive.duration_s, 60) << name << ": the shipped variant is the short one";
  }
}

TEST(Scenarios, EveryRadarTableLoads) {
  for (const std::string name : {"cts350-x", "cir204-h"}) {
    sim::RadarParams params;
    params.sensor = name;
    EXPECT_EQ(params.model().azimuths, 400) << name;
  }
}

TEST(Configs, EveryShippedOneLoadsAndStatesWhatItIsForInItsFirstLine) {
  ASSERT_FALSE(embeddedConfigs().empty());
  for (const auto& [name, text] : embeddedConfigs()) {
    EXPECT_TRUE(text.starts_with("# ")) << name;
    if (name.starts_with("sensors/")) {
      SensorModel sensor;
      EXPECT_NO_THROW(loadYaml(sensor, text, name)) << name;
      EXPECT_TRUE(sensor.elevation_deg.empty() || sensor.elevation_deg.size() == static_cast<std::size_t>(sensor.rings))
          << name;
      EXPECT_TRUE(std::is_sorted(sensor.elevation_deg.begin(), sensor.elevation_deg.end()))
          << name << ": lowest ring first";
    } else {
      SlamParams params;
      EXPECT_NO_THROW(loadConfig(params, name)) << name;
    }
  }
}

TEST(Configs, DumpOfTheDefaultsReadsBackToTheSame) {
  SlamParams params, back;
  loadYaml(back, dumpYaml(params, true), "dump");
  EXPECT_EQ(dumpYaml(back), dumpYaml(params));
}

}  // namespace
}  // namespace scslam
