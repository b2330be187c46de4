#include "scslam/core/file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>
#include <utility>

#include "scslam/core/error.h"

namespace scslam {
namespace {

[[noreturn]] void failWriting(const std::filesystem::path& file, int error) {
  throw inputError("cannot write {}: {}", file.string(), std::strerror(error));
}

/// @return 0 or errno.
int writeAll(int fd, std::string_view bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(fd, bytes.data(), bytes.size());
    if (written < 0) {
      if (errno == EINTR) continue;
      return errno;
    }
    bytes.remove_prefix(static_cast<std::size_t>(written));
  }
  return 0;
}

void syncFolderOf(const std::filesystem::path& file) {
  const auto folder = file.has_parent_path() ? file.parent_path() : std::filesystem::path(".");
  const int fd = ::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  if (fd < 0) return;  // the rename itself has happened
  ::fsync(fd);
  ::close(fd);
}

}  // namespace

void writeFileAtomically(const std::filesystem::path& file, std::string_view content) {
  const std::filesystem::path temporary = file.string() + ".tmp";
  const int fd = ::open(temporary.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0644);
  if (fd < 0) failWriting(file, errno);
  int error = writeAll(fd, content);
  if (error == 0 && ::fsync(fd) != 0 && errno != EINVAL) error = errno;  // EINVAL: not a disk file system
  if (::close(fd) != 0 && error == 0) error = errno;
  if (error == 0 && ::rename(temporary.c_str(), file.c_str()) != 0) error = errno;
  if (error != 0) {
    ::unlink(temporary.c_str());
    failWriting(file, error);
  }
  syncFolderOf(file);
}

std::string readFile(const std::filesystem::path& file, std::size_t max_bytes) {
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC);
  if (fd < 0) throw inputError("cannot open {}: {}", file.string(), std::strerror(errno));
  struct stat info {};
  int error = ::fstat(fd, &info) != 0 ? errno : 0;
  if (error == 0 && S_ISDIR(info.st_mode)) error = EISDIR;
  std::string content;
  if (error == 0) {
    const auto size = static_cast<std::size_t>(info.st_size);
    if (size > max_bytes) {
      ::close(fd);
      throw inputError("{} holds {} bytes, more than the {} this kind of file may have", file.string(), size,
                       max_bytes);
    }
    content.resize(size);
    std::size_t done = 0;
    while (done < size) {
      const ssize_t got = ::read(fd, content.data() + done, size - done);
      if (got < 0 && errno == EINTR) continue;
      if (got < 0) error = errno;
      if (got <= 0) break;
      done += static_cast<std::size_t>(got);
    }
    content.resize(done);
  }
  ::close(fd);
  if (error != 0) throw inputError("cannot read {}: {}", file.string(), std::strerror(error));
  return content;
}

AppendFile::AppendFile(const std::filesystem::path& file, std::size_t truncate_to) : file_(file) {
  fd_ = ::open(file.c_str(), O_WRONLY | O_CREAT | O_CLOEXEC, 0644);
  if (fd_ < 0) failWriting(file, errno);
  if (::ftruncate(fd_, static_cast<off_t>(truncate_to)) != 0) failWriting(file, errno);
  if (::lseek(fd_, 0, SEEK_END) < 0) failWriting(file, errno);
  size_ = truncate_to;
}

AppendFile::AppendFile(AppendFile&& other) noexcept
    : fd_(std::exchange(other.fd_, -1)), size_(other.size_), file_(std::move(other.file_)) {}

AppendFile& AppendFile::operator=(AppendFile&& other) noexcept {
  std::swap(fd_, other.fd_);
  std::swap(size_, other.size_);
  std::swap(file_, other.file_);
  return *this;
}

AppendFile::~AppendFile() {
  if (fd_ >= 0) ::close(fd_);
}

void AppendFile::append(std::string_view bytes) {
  if (const int error = writeAll(fd_, bytes); error != 0) {
    // Half a record would end the readable part for good: take it back, so that a later append can still succeed.
    if (::ftruncate(fd_, static_cast<off_t>(size_)) == 0) ::lseek(fd_, 0, SEEK_END);
    failWriting(file_, error);
  }
  size_ += bytes.size();
}

void AppendFile::sync() {
  if (::fdatasync(fd_) != 0 && errno != EINVAL) failWriting(file_, errno);
}

}  // namespace scslam
