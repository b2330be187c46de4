#include "scslam/apps/doctor.h"
#include "scslam/core/error.h"
#include "scslam/core/progress.h"
#include "verb.h"

namespace scslam::cli {
namespace {

struct DoctorFlags {
  std::string session;
  bool repair = false;
};

/// @return true when all is sound.
bool examineAndPrint(const std::string& session, bool& repairable, const GlobalOptions& global) {
  Progress progress("scans", std::nullopt, global.quiet);
  const auto checks = examine(session, [&progress](std::size_t done) { progress.update(done); });
  progress.finish();
  bool sound = true;
  for (const DoctorCheck& check : checks) {
    fmt::print("{:<8} {:<28} {}\n", check.sound ? "ok" : "DAMAGED", check.what, check.finding);
    sound &= check.sound;
    repairable |= check.repairable;
  }
  return sound;
}

int run(const DoctorFlags& flags, const GlobalOptions& global) {
  bool repairable = false;
  bool sound = examineAndPrint(flags.session, repairable, global);
  if (!sound && flags.repair) {
    repair(flags.session);
    fmt::print("text files rebuilt from the journal; again:\n");
    sound = examineAndPrint(flags.session, repairable, global);
  } else if (repairable) {
    fmt::print("--repair rebuilds the text files from the journal\n");
  }
  fmt::print("{}: {}\n", sound ? "sound" : "damaged", flags.session);
  return static_cast<int>(sound ? ExitCode::kDone : ExitCode::kInput);
}

}  // namespace

Verb doctorVerb() {
  return {"doctor", "is a session sound? checks every file; 0 sound, 3 damaged", [](CLI::App& app) {
            auto flags = std::make_shared<DoctorFlags>();
            app.add_option("SESSION", flags->session, "session folder, ours or classic")->required();
            app.add_flag("--repair", flags->repair,
                         "rebuild the text files from the journal; a damaged journal is cut to its readable part "
                         "(the whole is kept as journal.bin.damaged)");
            return [flags](const GlobalOptions& global) { return run(*flags, global); };
          }};
}

}  // namespace scslam::cli
