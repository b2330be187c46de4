// Is a session folder sound? What can be made good from the journal?
#pragma once
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

namespace scslam {

struct DoctorCheck {
  std::string what;  ///< "Scans", "journal.bin", …
  bool sound = true;
  std::string finding;      ///< one line: what was checked, or what is wrong and where
  bool repairable = false;  ///< a text file that the journal can rebuild
};

/// Checks every file of a session against its journal: record checksums, counts, sizes and checksums of scans and
/// descriptors, rigid poses, a g2o file that parses. An open session (killed, or still running) is sound when its
/// journal reads up to a torn last record. Classic folders: files against each other. Reads everything, writes nothing.
/// @param progress called with the keyframes done.
/// @throw inputError when the folder is no session at all.
std::vector<DoctorCheck> examine(const std::filesystem::path& session,
                                 const std::function<void(std::size_t)>& progress = {});

/// Rewrites the text files from the journal. A journal damaged in the middle is first cut to its readable part; the
/// session then holds that part and is complete.
/// @throw inputError when there is no journal to repair from.
void repair(const std::filesystem::path& session);

}  // namespace scslam
