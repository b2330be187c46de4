#include "scslam/apps/run_job.h"
#include "scslam/core/embedded_configs.h"
#include "scslam/mapping/map_exporter.h"
#include "scslam/odometry/odometry.h"
#include "scslam/place/place_recogniser.h"
#include "scslam/registration/registration.h"
#include "scslam/sensor/radar_extractor.h"
#include "scslam/sensor/scan_source.h"
#include "verb.h"

namespace scslam::cli {
namespace {

template <class Interface>
void printPlugins(const char* title) {
  fmt::print("{}:\n", title);
  for (const auto& name : Registry<Interface>::instance().names())
    fmt::print("  {:<14} {}\n", name, Registry<Interface>::instance().find(name).summary);
}

void printConfigs(const char* title, bool sensors) {
  fmt::print("{}:\n", title);
  for (const auto& [name, text] : embeddedConfigs()) {
    if (name.starts_with("sensors/") != sensors) continue;
    const std::string first_line = text.substr(0, text.find('\n'));  // "# what it is for"
    fmt::print("  {:<14} {}\n", sensors ? name.substr(8) : name,
               first_line.starts_with("# ") ? first_line.substr(2) : "");
  }
}

const std::vector<std::pair<std::string, std::function<void()>>>& kinds() {
  static const std::vector<std::pair<std::string, std::function<void()>>> all = {
      {"formats", [] { printPlugins<ScanFormat>("input formats"); }},
      {"extractors", [] { printPlugins<RadarExtractor>("radar point extractors"); }},
      {"odometry", [] { printPlugins<Odometry>("odometry front-ends"); }},
      {"recognisers", [] { printPlugins<PlaceRecogniser>("place recognisers"); }},
      {"registration", [] { printPlugins<Registration>("registration methods"); }},
      {"exporters", [] { printPlugins<MapExporter>("map exporters"); }},
      {"configs", [] { printConfigs("shipped configurations", false); }},
      {"sensors", [] { printConfigs("sensor tables", true); }},
  };
  return all;
}

}  // namespace

Verb listVerb() {
  return {"list", "what there is: formats, odometry, recognisers, registration, exporters, configs, sensors",
          [](CLI::App& app) {
            auto kind = std::make_shared<std::string>();
            app.add_option("KIND", *kind, "one of them; all when left out");
            auto plugins = std::make_shared<std::vector<std::string>>();
            app.add_option("--plugin", *plugins, "load a library with plug-ins of your own first");
            return [kind, plugins](const GlobalOptions&) {
              for (const auto& plugin : *plugins) loadPlugin(plugin);
              std::vector<std::string> names;
              bool printed = false;
              for (const auto& [name, print] : kinds()) {
                names.push_back(name);
                if (!kind->empty() && *kind != name) continue;
                print();
                printed = true;
              }
              if (!printed) throw usageError("there is no list of '{}'{}", *kind, didYouMean(*kind, names));
              return 0;
            };
          }};
}

}  // namespace scslam::cli
