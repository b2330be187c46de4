#include "scslam/session/session_folder.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <utility>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/session/layout.h"

namespace scslam {
namespace fs = std::filesystem;
namespace {

/// Runs a file-system operation; its error becomes one line for the user.
template <class Operation>
void orExplain(const char* what, const fs::path& path, const Operation& operation) {
  std::error_code error;
  operation(error);
  if (error) throw inputError("cannot {} {}: {}", what, path.string(), error.message());
}

bool isLeftover(const fs::path& file) { return file.extension() == ".tmp"; }

/// Empty but for what a kill leaves of a session that was never begun.
bool isEmpty(const fs::path& folder) {
  return std::all_of(fs::directory_iterator(folder), fs::directory_iterator(),
                     [](const auto& entry) { return isLeftover(entry.path()); });
}

bool liesIn(const fs::path& path, const fs::path& folder) {
  std::error_code error;
  const fs::path relative = fs::relative(fs::canonical(path, error), fs::canonical(folder, error), error);
  return !error && !relative.empty() && *relative.begin() != "..";
}

void removeSession(const fs::path& folder) {
  for (const auto& entry : fs::directory_iterator(folder))
    if (isLeftover(entry.path())) orExplain("remove", entry.path(), [&](auto& e) { fs::remove(entry.path(), e); });
  for (const std::string& name : layout::allNames())
    orExplain("remove", folder / name, [&](auto& e) { fs::remove_all(folder / name, e); });
}

}  // namespace

FolderLock::FolderLock(const fs::path& folder) : fd_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC)) {
  if (fd_ >= 0 && ::flock(fd_, LOCK_EX | LOCK_NB) != 0 && errno == EWOULDBLOCK) {
    ::close(fd_);
    throw usageError("{}: another scslam is writing this session", folder.string());
  }
}
FolderLock::FolderLock(FolderLock&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
FolderLock& FolderLock::operator=(FolderLock&& other) noexcept {
  std::swap(fd_, other.fd_);
  return *this;
}
FolderLock::~FolderLock() {
  if (fd_ >= 0) ::close(fd_);
}

FolderLock prepareFolder(const fs::path& folder, const fs::path& input, bool overwrite) {
  if (fs::exists(folder) && !fs::is_directory(folder))
    throw usageError("{} is a file; give another folder with -o", folder.string());
  orExplain("create", folder, [&](auto& e) { fs::create_directories(folder, e); });
  FolderLock lock(folder);
  if (isEmpty(folder)) {
    removeSession(folder);  // leftovers
    return lock;
  }
  if (!fs::is_regular_file(folder / layout::kManifest))
    throw usageError(
        "{} holds files but no session ({} is missing), so neither -w nor --resume applies; give another "
        "folder with -o",
        folder.string(), layout::kManifest);
  if (!overwrite)
    throw usageError("{} already holds a session; -w replaces it, --resume goes on with one that was not completed",
                     folder.string());
  if (liesIn(input, folder))
    throw usageError("{} lies in {}, which -w would remove first; give another folder with -o", input.string(),
                     folder.string());
  removeSession(folder);
  return lock;
}

void removeFilesBeyond(const fs::path& folder, std::size_t keyframes) {
  for (const auto& entry : fs::directory_iterator(folder))
    if (isLeftover(entry.path())) orExplain("remove", entry.path(), [&](auto& e) { fs::remove(entry.path(), e); });
  for (const char* sub : {layout::kScans, layout::kDescriptors}) {
    orExplain("create", folder / sub, [&](auto& e) { fs::create_directories(folder / sub, e); });
    std::vector<fs::path> surplus;
    for (const auto& entry : fs::directory_iterator(folder / sub)) {
      const std::string stem = entry.path().stem().string();
      std::size_t number = 0;
      const auto [end, error] = std::from_chars(stem.data(), stem.data() + stem.size(), number);
      const bool numbered = error == std::errc() && end == stem.data() + stem.size();
      if (isLeftover(entry.path()) || (numbered && number >= keyframes)) surplus.push_back(entry.path());
    }
    for (const fs::path& file : surplus) orExplain("remove", file, [&](auto& e) { fs::remove(file, e); });
  }
}

void replaceFile(const fs::path& file, std::string_view content) {
  const fs::path temporary = file.string() + ".tmp";
  try {
    AppendFile(temporary, 0).append(content);
  } catch (const Error&) {
    std::error_code ignored;
    fs::remove(temporary, ignored);
    throw;
  }
  orExplain("write", file, [&](auto& e) { fs::rename(temporary, file, e); });
}

}  // namespace scslam
