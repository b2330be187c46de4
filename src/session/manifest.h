// session.yaml: what the session is, how far it got.
#pragma once
#include <cstddef>
#include <filesystem>
#include <string>

#include "scslam/session/session_writer.h"

namespace scslam {

struct Manifest {
  SessionInfo info;
  std::string config_digest;
  bool complete = false;
  std::size_t scans = 0, keyframes = 0, loops_accepted = 0;
};

/// 64-bit FNV-1a as 16 hex digits: tells configurations apart, protects against nothing.
std::string digestOf(std::string_view text);
std::string formatManifest(const Manifest& manifest);
/// Also reads config.yaml beside it into info.config_yaml, where it exists. @throw inputError "FILE:line:column: …".
Manifest readManifest(const std::filesystem::path& folder);

}  // namespace scslam
