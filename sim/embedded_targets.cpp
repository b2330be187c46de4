#include "sim/embedded_targets.h"

#include "sim/embedded.h"

namespace scslam::sim {

const std::map<std::string, std::string>& embeddedTargets() {
  static const std::map<std::string, std::string> targets = [] {
    const std::string folder = "targets/";
    std::map<std::string, std::string> found;
    for (const auto& [name, yaml] : embeddedFiles())
      if (name.starts_with(folder)) found[name.substr(folder.size())] = yaml;
    return found;
  }();
  return targets;
}

}  // namespace scslam::sim
