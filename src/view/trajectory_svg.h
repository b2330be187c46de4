#pragma once
#include "scslam/session/session.h"
namespace scslam { inline std::string trajectorySvg(const Session&, const std::optional<Trajectory>&){return "";} }
