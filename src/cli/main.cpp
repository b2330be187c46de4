// scslam VERB …: finds the verb, runs it, turns what was thrown into one line and an exit code.
#include <fmt/format.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <new>
#include <system_error>

#include "scslam/core/error.h"
#include "verb.h"

namespace {

using scslam::ExitCode;

int usage(const CLI::App& app, const CLI::ParseError& error) {
  if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
  fmt::print(stderr, "error: {}; 'scslam {}--help' shows the flags\n", error.what(),
             app.get_subcommands().empty() ? "" : app.get_subcommands().front()->get_name() + " ");
  return static_cast<int>(ExitCode::kUsage);
}

int run(int argc, char** argv) {
  CLI::App app{"scslam: any odometry + any LiDAR or radar in, one loop-closed, checked, crash-safe map session out",
               "scslam"};
  app.set_version_flag("--version", "scslam " SCSLAM_VERSION);
  app.require_subcommand(1);
  app.footer(
      "Exit codes: 0 done, 1 bug, 2 usage or configuration, 3 input unreadable, 4 input ended early (results kept),\n"
      "            5 a stated quality gate failed, 130 stopped by the user (session flushed)");
  scslam::cli::GlobalOptions global;
  std::vector<std::pair<CLI::App*, std::function<int(const scslam::cli::GlobalOptions&)>>> actions;
  for (const auto& verb : scslam::cli::verbs()) {
    CLI::App* sub = app.add_subcommand(verb.name, verb.summary);
    sub->add_flag("-q,--quiet", global.quiet, "only warnings and errors on stderr");
    sub->add_flag("-v,--verbose", global.verbose, "more on stderr");
    actions.emplace_back(sub, verb.declare(*sub));
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return usage(app, error);
  }
  for (const auto& [sub, action] : actions)
    if (sub->parsed()) return action(global);
  return static_cast<int>(ExitCode::kUsage);
}

}  // namespace

int main(int argc, char** argv) {
  try {
    const int code = run(argc, argv);
    // What is still in the buffer may not fit on the disk.
    if (std::fflush(stdout) != 0)
      throw scslam::inputError("cannot write to the standard output: {}", std::strerror(errno));
    return code;
  } catch (const scslam::Error& error) {
    fmt::print(stderr, "error: {}\n", error.what());
    return static_cast<int>(error.code());
  } catch (const std::system_error& error) {  // of a disk, a pipe, a permission
    fmt::print(stderr, "error: {}\n", error.what());
    return static_cast<int>(ExitCode::kInput);
  } catch (const std::bad_alloc&) {
    fmt::print(stderr, "error: out of memory\n");
    return static_cast<int>(ExitCode::kBug);
  } catch (const std::exception& error) {
    fmt::print(stderr, "error: {} (this is a bug in scslam; please report it with the command line)\n", error.what());
    return static_cast<int>(ExitCode::kBug);
  }
}
