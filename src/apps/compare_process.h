// A program run to its end, with what it used.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

namespace scslam {

struct ProcessResult {
  int exit_code = 0;      ///< 128 + signal number when a signal ended it
  double cpu_s = 0;       ///< user and system time
  std::string last_line;  ///< of what it wrote to stderr
};

/// Runs `program` (a path) with `arguments`; its stdout is dropped, its stderr goes to `log`.
/// @throw inputError when it cannot be started or the log cannot be written.
ProcessResult runProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                         const std::filesystem::path& log);

}  // namespace scslam
