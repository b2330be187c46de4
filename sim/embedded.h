#pragma once
#include <map>
#include <string>

namespace scslam::sim {

/// The YAML files shipped with the simulator, by "folder/name" without extension: scenarios, radars, targets.
const std::map<std::string, std::string>& embeddedFiles();

}  // namespace scslam::sim
