#include "scslam/core/log.h"

#include <cstdio>

namespace scslam {

Log::Log(mrpt::system::VerbosityLevel verbosity) : COutputLogger("scslam") {
  // MRPT itself would print to stdout, which belongs to the data.
  logging_enable_console_output = false;
  logging_enable_keep_record = false;
  setMinLoggingLevel(mrpt::system::LVL_DEBUG);
  logRegisterCallback([verbosity](std::string_view message, const mrpt::system::VerbosityLevel level,
                                  std::string_view /*logger*/, const mrpt::Clock::time_point /*when*/) {
    if (level < verbosity) return;
    const char* prefix = level >= mrpt::system::LVL_ERROR  ? "error: "
                         : level == mrpt::system::LVL_WARN ? "warning: "
                                                           : "";
    std::string line = std::string(prefix) + std::string(message);
    if (line.empty() || line.back() != '\n') line += '\n';
    std::fwrite(line.data(), 1, line.size(), stderr);
  });
}

Log::~Log() = default;

}  // namespace scslam
