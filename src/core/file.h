// Files that are either the old or the new content, never half of one; and reading with limits.
#pragma once
#include <filesystem>
#include <string>
#include <string_view>

namespace scslam {

/// Replaces `file` by `content`: temporary name beside it, fsync, rename, fsync of the folder.
/// @throw Error(kInput) "cannot write FILE: No space left on device" …; the old content then still stands.
void writeFileAtomically(const std::filesystem::path& file, std::string_view content);

/// The whole file. @throw inputError when it cannot be opened or read, or is larger than max_bytes.
std::string readFile(const std::filesystem::path& file, std::size_t max_bytes = std::size_t{1} << 32);

/// An append-only file, unbuffered in user space: what append() returned from survives a kill -9 of the process.
class AppendFile {
 public:
  AppendFile() = default;
  /// Opens or creates; with truncate_to, cuts the file to that length first.
  explicit AppendFile(const std::filesystem::path& file, std::size_t truncate_to);
  AppendFile(AppendFile&&) noexcept;
  AppendFile& operator=(AppendFile&&) noexcept;
  ~AppendFile();
  void append(std::string_view bytes);
  /// To the disk (survives a power cut).
  void sync();
  std::size_t size() const { return size_; }

 private:
  int fd_ = -1;
  std::size_t size_ = 0;
  std::filesystem::path file_;
};

}  // namespace scslam
