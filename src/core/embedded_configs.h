#pragma once
#include <map>
#include <string>

namespace scslam {

/// The shipped configs by name without ".yaml": "laser2d", "sensors/hdl64", … (compiled in from configs/).
const std::map<std::string, std::string>& embeddedConfigs();

}  // namespace scslam
