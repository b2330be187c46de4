// One file per verb. A verb adds its sub-command to the parser and returns what to run when it was chosen.
#pragma once
#include <mrpt/system/COutputLogger.h>

#include <CLI/CLI.hpp>
#include <atomic>
#include <functional>
#include <string>
#include <vector>

namespace scslam::cli {

/// Flags that every verb takes.
struct GlobalOptions {
  bool quiet = false, verbose = false;
};

struct Verb {
  std::string name;
  std::string summary;
  /// Declares the flags on `app` (storage owned by the returned closure) and gives the action; the action returns the
  /// exit code and throws scslam::Error for anything a user can act on.
  std::function<std::function<int(const GlobalOptions&)>(CLI::App& app)> declare;
};

/// What goes to stderr.
mrpt::system::VerbosityLevel verbosity(const GlobalOptions& global);
/// @param asked by the user; 0 or less: all cores.
int threadsOr(int asked);
/// Set by SIGINT or SIGTERM from now on: the job ends orderly. A second one ends the program at once.
const std::atomic<bool>* stopOnSignals();

/// The verbs of this binary, in the order of --help (verbs.cpp).
const std::vector<Verb>& verbs();

Verb runVerb();
Verb evalVerb();
Verb placesVerb();
Verb compareVerb();
Verb optimizeVerb();
Verb exportVerb();
Verb infoVerb();
Verb listVerb();
Verb configVerb();
Verb doctorVerb();
Verb changesVerb();
Verb cleanVerb();
Verb mergeVerb();
Verb localizeVerb();
Verb learnVerb();
Verb simVerb();
Verb realismVerb();

}  // namespace scslam::cli
