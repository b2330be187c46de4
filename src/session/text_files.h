// The text files of a session folder, all made from its records alone.
#pragma once
#include <filesystem>

#include "scslam/session/journal.h"
#include "scslam/session/session_writer.h"

namespace scslam {

/// Replaces each text file atomically; the manifest, which counts the others, last.
/// @param graph over T_map_base.
void writeTextFiles(const std::filesystem::path& folder, const SessionInfo& info, const JournalContents& contents,
                    const PoseGraph& graph, bool complete);

/// Name and content of each text file that the records alone decide; not the graph and the manifest, which know more
/// (factors the graph left out at the end; the state).
std::vector<std::pair<std::string, std::string>> textFiles(const SessionInfo& info, const JournalContents& contents);

/// The manifest's text for these records.
std::string manifestText(const SessionInfo& info, const JournalContents& contents, bool complete);

}  // namespace scslam
