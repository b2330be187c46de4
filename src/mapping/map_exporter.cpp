#include "scslam/mapping/map_exporter.h"

#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace scslam {

SCSLAM_DEFINE_REGISTRY(MapExporter)

PointFile::PointFile(std::filesystem::path file, std::size_t header_bytes)
    : file_(std::move(file)), temporary_(file_.string() + ".tmp"), header_bytes_(header_bytes) {
  stream_ = std::fopen(temporary_.c_str(), "wb");
  check(stream_ != nullptr);
  const std::string room(header_bytes, ' ');
  check(std::fwrite(room.data(), 1, room.size(), stream_) == room.size());
}

PointFile::~PointFile() {
  if (stream_ == nullptr) return;
  std::fclose(stream_);
  ::unlink(temporary_.c_str());
}

void PointFile::check(bool ok) const {
  if (!ok) throw inputError("cannot write {}: {}", file_.string(), std::strerror(errno));
}

void PointFile::append(const Cloud& cloud) {
  std::vector<float> records(4 * cloud.size());
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    float* record = &records[4 * i];
    record[0] = cloud.x[i];
    record[1] = cloud.y[i];
    record[2] = cloud.z[i];
    record[3] = cloud.hasIntensity() ? cloud.intensity[i] : 0.0f;
  }
  check(std::fwrite(records.data(), sizeof(float), records.size(), stream_) == records.size());
  points_ += cloud.size();
}

std::filesystem::path PointFile::close(const std::string& header) {
  if (header.size() != header_bytes_)
    throw Error(ExitCode::kBug, fmt::format("a header of {} bytes in room for {}", header.size(), header_bytes_));
  check(std::fseek(stream_, 0, SEEK_SET) == 0);
  check(std::fwrite(header.data(), 1, header.size(), stream_) == header.size());
  check(std::fflush(stream_) == 0 && (::fsync(::fileno(stream_)) == 0 || errno == EINVAL));
  std::FILE* stream = stream_;
  stream_ = nullptr;
  const bool ok = std::fclose(stream) == 0 && std::rename(temporary_.c_str(), file_.c_str()) == 0;
  if (!ok) {
    const int error = errno;
    ::unlink(temporary_.c_str());
    errno = error;
  }
  check(ok);
  return file_;
}

}  // namespace scslam
