// The program's log: to stderr and, once a session is open, to its run.log. stdout is for data and the final table.
#pragma once
#include <fmt/format.h>
#include <mrpt/system/COutputLogger.h>

#include <filesystem>
#include <string>

namespace scslam {

/// An mrpt::system::COutputLogger that writes plain lines to stderr ("warning: …") and never to stdout.
/// run.log carries no wall-clock time, so it is the same for the same input.
class Log : public mrpt::system::COutputLogger {
 public:
  /// @param verbosity what reaches stderr: LVL_WARN (-q), LVL_INFO (default), LVL_DEBUG (-v).
  explicit Log(mrpt::system::VerbosityLevel verbosity = mrpt::system::LVL_INFO);
  ~Log() override;
};

template <class... Args>
void logInfo(mrpt::system::COutputLogger& log, fmt::format_string<Args...> format, Args&&... args) {
  log.logStr(mrpt::system::LVL_INFO, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void logWarn(mrpt::system::COutputLogger& log, fmt::format_string<Args...> format, Args&&... args) {
  log.logStr(mrpt::system::LVL_WARN, fmt::format(format, std::forward<Args>(args)...));
}
template <class... Args>
void logDebug(mrpt::system::COutputLogger& log, fmt::format_string<Args...> format, Args&&... args) {
  log.logStr(mrpt::system::LVL_DEBUG, fmt::format(format, std::forward<Args>(args)...));
}

}  // namespace scslam
