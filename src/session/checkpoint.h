// checkpoint.bin: from here a killed run goes on.
#pragma once
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "scslam/core/pose.h"

namespace scslam {

struct Checkpoint {
  std::uint64_t journal_bytes = 0, log_bytes = 0;  ///< what of these files belongs to it
  std::vector<Pose> T_map_base;                    ///< per keyframe
  std::string pipeline_state;
};

/// Replaces the file atomically.
void writeCheckpoint(const std::filesystem::path& file, const Checkpoint& checkpoint);
/// @return nullopt when there is none. @throw inputError when it is damaged.
std::optional<Checkpoint> readCheckpoint(const std::filesystem::path& file);

}  // namespace scslam
