#include "scslam/pipeline/slam_params.h"
#include "verb.h"

namespace scslam::cli {

Verb configVerb() {
  return {"config", "dump the configuration, check a file, print the schema", [](CLI::App& app) {
            auto action = std::make_shared<std::string>();
            auto configs = std::make_shared<std::vector<std::string>>();
            auto sets = std::make_shared<std::vector<std::string>>();
            app.add_option(
                   "ACTION", *action,
                   "dump: all keys with their values and documentation; check: is FILE right; schema: JSON schema")
                ->required()
                ->check(CLI::IsMember({"dump", "check", "schema"}));
            app.add_option("FILE", *configs, "configuration files or shipped names, later ones win");
            app.add_option("--set", *sets, "section.key=value");
            return [=](const GlobalOptions&) {
              SlamParams params;
              if (*action == "check" && configs->empty()) throw usageError("config check: which FILE?");
              for (const auto& config : *configs) loadConfig(params, config);
              for (const auto& assignment : *sets) setParam(params, assignment);
              if (*action == "dump") fmt::print("{}", dumpYaml(params, true));
              if (*action == "schema") fmt::print("{}", schemaJson(params));
              if (*action == "check") fmt::print("{}: sound\n", fmt::join(*configs, ", "));
              return 0;
            };
          }};
}

}  // namespace scslam::cli
