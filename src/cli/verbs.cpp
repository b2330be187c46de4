#include <csignal>
#include <thread>

#include "verb.h"

namespace scslam::cli {
namespace {

std::atomic<bool> stop_requested{false};

void requestStop(int signal) {
  stop_requested = true;
  std::signal(signal, SIG_DFL);  // what was begun stays resumable, or is cleared away by the next run
}

}  // namespace

mrpt::system::VerbosityLevel verbosity(const GlobalOptions& global) {
  return global.verbose ? mrpt::system::LVL_DEBUG : global.quiet ? mrpt::system::LVL_WARN : mrpt::system::LVL_INFO;
}

int threadsOr(int asked) {
  return asked > 0 ? asked : std::max(1, static_cast<int>(std::thread::hardware_concurrency()));
}

const std::atomic<bool>* stopOnSignals() {
  std::signal(SIGINT, requestStop);
  std::signal(SIGTERM, requestStop);
  return &stop_requested;
}

const std::vector<Verb>& verbs() {
  static const std::vector<Verb> all = {runVerb(),    evalVerb(),   placesVerb(),  compareVerb(),  optimizeVerb(),
                                        exportVerb(), infoVerb(),   listVerb(),    configVerb(),   doctorVerb(),
                                        cleanVerb(),  mergeVerb(),  changesVerb(), localizeVerb(), learnVerb(),
                                        simVerb(),    realismVerb()};
  return all;
}

}  // namespace scslam::cli
