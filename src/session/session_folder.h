// Making, claiming and cleaning a session folder.
#pragma once
#include <filesystem>

#include "scslam/session/session_writer.h"

namespace scslam {

/// Keeps a second scslam off the folder while this object lives; a killed process loses it at once.
class FolderLock {
 public:
  FolderLock() = default;
  /// @throw usageError when another process writes this session.
  explicit FolderLock(const std::filesystem::path& folder);
  FolderLock(FolderLock&& other) noexcept;
  FolderLock& operator=(FolderLock&& other) noexcept;
  ~FolderLock();

 private:
  int fd_ = -1;
};

/// Makes `folder` ready for a new session: creates it, or removes the session in it (with overwrite). Never removes
/// what is not a session's. @param input the run's input, which must not lie in a session that is to be removed.
FolderLock prepareFolder(const std::filesystem::path& folder, const std::filesystem::path& input, bool overwrite);

/// Removes the files of keyframes from `keyframes` on, and half-written files.
void removeFilesBeyond(const std::filesystem::path& folder, std::size_t keyframes);

/// Replaces the file atomically as seen by other processes; unlike writeFileAtomically() it is not forced to the disk.
void replaceFile(const std::filesystem::path& file, std::string_view content);

}  // namespace scslam
