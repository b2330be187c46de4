// What may go wrong, and the exit code each kind ends in (README, "Exit codes").
#pragma once
#include <fmt/format.h>

#include <stdexcept>
#include <string>

namespace scslam {

enum class ExitCode : int {
  kDone = 0,
  kBug = 1,
  kUsage = 2,        ///< wrong flag, wrong configuration
  kInput = 3,        ///< input unreadable; nothing was made
  kEndedEarly = 4,   ///< input ended early; what came before is kept
  kQualityGate = 5,  ///< a stated quality gate failed
  kStopped = 130,    ///< stopped by the user; session flushed
};

/// An error a user can act on: one line that says what, where and what to do. main() prints it and exits with its code.
class Error : public std::runtime_error {
 public:
  Error(ExitCode code, const std::string& message) : std::runtime_error(message), code_(code) {}
  ExitCode code() const { return code_; }

 private:
  ExitCode code_;
};

/// Wrong flags or configuration. `usageError("{}:{}: unknown key '{}'", file, line, key)`.
template <class... Args>
Error usageError(fmt::format_string<Args...> format, Args&&... args) {
  return {ExitCode::kUsage, fmt::format(format, std::forward<Args>(args)...)};
}

/// Input that cannot be read. The pipeline turns it into kEndedEarly when scans before it were kept.
template <class... Args>
Error inputError(fmt::format_string<Args...> format, Args&&... args) {
  return {ExitCode::kInput, fmt::format(format, std::forward<Args>(args)...)};
}

}  // namespace scslam
