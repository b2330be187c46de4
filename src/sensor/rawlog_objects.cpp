#include "scslam/sensor/rawlog_objects.h"

#include <mrpt/io/CMemoryStream.h>
#include <mrpt/maps/registerAllClasses.h>
#include <mrpt/poses/CPose3D.h>
#include <mrpt/serialization/CArchive.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <optional>
#include <string_view>
#include <vector>

#include "scslam/core/error.h"
#include "scslam/sensor/memory_limit.h"

namespace scslam {

using mrpt::serialization::CArchive;

namespace {

constexpr std::size_t kWindow = 1 << 16;
constexpr std::uint64_t kDeflateRatio = 1032;  // deflate cannot expand more than this

/// What went wrong while MRPT was reading, thrown through it. MRPT wraps it in its own words; ours are kept aside.
struct Damage : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Number of elements the prefix of such an object states, and the least bytes each takes in the file.
struct Stated {
  std::uint64_t count = 0, bytes_each = 1;
};

/// A CMatrixF by hand: MRPT's own reading would take memory for whatever size it states.
void skipMatrix(CArchive& in) {
  const std::size_t name = in.ReadAs<std::uint8_t>();
  const bool old_format = (name & 0x80U) == 0;
  std::vector<char> bytes((name & 0x7FU) + (old_format ? 7 : 1));  // zeros, name, version
  in.ReadBuffer(bytes.data(), bytes.size());
  const std::uint64_t rows = in.ReadAs<std::uint32_t>(), columns = in.ReadAs<std::uint32_t>();
  if (rows * columns > 36) throw Damage("the covariance of a pose is 6 x 6");
  bytes.resize(rows * columns * sizeof(float) + (old_format ? 0 : 1));
  if (!bytes.empty()) in.ReadBuffer(bytes.data(), bytes.size());
}

Stated statedByRangeScan(CArchive& in, int version) {
  float aperture = 0, max_range = 0;
  bool right_to_left = false;
  mrpt::poses::CPose3D pose;
  in >> aperture >> right_to_left >> max_range >> pose;
  if (version < 6) skipMatrix(in);
  return {in.ReadAs<std::uint32_t>(), version == 0 ? 4U : 5U};
}

Stated statedByDepthImage(CArchive& in, int version) {
  float max_range = 0;
  mrpt::poses::CPose3D pose;
  in >> max_range >> pose;
  if (version > 0 && !in.ReadAs<bool>()) return {};
  return {in.ReadAs<std::uint32_t>(), 12};
}

/// "mrpt::obs::CSensoryFrame" (newer files) and "CSensoryFrame" (older ones) are the same.
std::string_view withoutNamespace(std::string_view name) {
  const std::size_t colon = name.rfind(':');
  return colon == std::string_view::npos ? name : name.substr(colon + 1);
}

bool isClassName(std::string_view name) {
  return std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == ':';
  });
}

/// The classes that keep what a count announces in MRPT's aligned buffers.
std::optional<Stated> stated(std::string_view class_name, CArchive& in, int version) {
  if (class_name == "CObservation2DRangeScan") return statedByRangeScan(in, version);
  if (class_name == "CObservation3DRangeScan") return statedByDepthImage(in, version);
  if (class_name == "CMatrixF" || class_name == "CMatrix" || class_name == "CMatrixD") {
    const std::uint64_t rows = in.ReadAs<std::uint32_t>(), columns = in.ReadAs<std::uint32_t>();
    return Stated{rows * columns, class_name == "CMatrixD" ? 8U : 4U};
  }
  for (const char* map : {"CSimplePointsMap", "CPointsMapXYZI", "CColouredPointsMap", "CWeightedPointsMap"})
    if (class_name == map) return Stated{in.ReadAs<std::uint32_t>(), 12};
  return std::nullopt;
}

/// The telling line of MRPT's exception texts, which are call traces.
std::string firstReason(const std::string& text) {
  const std::size_t end = std::min(text.find('\n'), text.size());
  std::string line = text.substr(0, end);
  if (const std::size_t begin = line.find("Message:"); begin != std::string::npos) line.erase(0, begin + 8);
  line.erase(0, std::min(line.find_first_not_of(" \t"), line.size()));
  return line.empty() ? "unreadable object" : line;
}

}  // namespace

class RawlogObjects::Archive final : public CArchive {
 public:
  explicit Archive(const std::filesystem::path& file) : file_(file.string()), window_(kWindow) {
    std::error_code error;
    size_ = std::filesystem::file_size(file, error);
    if (!error) gz_ = gzopen(file.c_str(), "rbe");
    if (gz_ == nullptr) throw inputError("cannot open {}", file_);
    gzbuffer(gz_, 1 << 17);
  }
  ~Archive() override { gzclose_r(gz_); }

  bool atEnd() { return available(1) == 0; }
  const std::string& file() const { return file_; }
  const std::string& failure() const { return failure_; }
  std::uint64_t position() const { return position_; }
  bool compressed() { return gzdirect(gz_) == 0; }
  std::string getArchiveDescription() const override { return file_; }

  /// Upper bound of the uncompressed bytes that still follow.
  std::uint64_t bytesLeft() {
    const auto offset = gzoffset(gz_);
    const std::uint64_t behind =
        size_ - std::min<std::uint64_t>(size_, offset < 0 ? 0 : static_cast<std::uint64_t>(offset));
    // Of what zlib has taken from the file already, up to its own buffer's worth is not unpacked yet.
    const std::uint64_t packed = compressed() ? (behind + (1 << 17)) * kDeflateRatio : behind + (1 << 18);
    return compressed() ? (end_ - begin_) + packed
                        : std::min(packed + (end_ - begin_), size_ - std::min(size_, position_));
  }

  /// Up to n of the bytes that follow. Damage behind them is left for the read() that comes to it.
  std::string_view peek(std::size_t n) {
    try {
      available(n);
    } catch (const Damage&) {
      failure_.clear();
    }
    return {window_.data() + begin_, std::min(n, end_ - begin_)};
  }

 protected:
  std::size_t read(void* to, std::size_t count) override {
    auto* bytes = static_cast<char*>(to);
    std::size_t done = std::min(count, end_ - begin_);
    std::memcpy(bytes, window_.data() + begin_, done);
    begin_ += done;
    while (done < count) {
      const std::size_t got = fromFile(bytes + done, std::min<std::size_t>(count - done, 1U << 30));
      if (got == 0) fail(fmt::format("the file ends there, {} bytes are missing", count - done));
      done += got;
    }
    position_ += count;
    watchHeaders({bytes, count});
    return count;
  }
  std::size_t write(const void*, std::size_t) override { throw std::logic_error("a rawlog is only read here"); }

 private:
  [[noreturn]] void fail(const std::string& why) {
    if (failure_.empty()) failure_ = why;
    throw Damage(why);
  }

  std::size_t fromFile(char* to, std::size_t n) {
    const int got = gzread(gz_, to, static_cast<unsigned>(n));
    int code = Z_OK;
    if (got < 0 || static_cast<std::size_t>(got) < n) {
      const char* text = gzerror(gz_, &code);
      if (code == Z_BUF_ERROR && got == 0) fail("the compressed file ends too early");
      if (code != Z_OK && code != Z_BUF_ERROR && got <= 0) fail(fmt::format("damaged compressed data ({})", text));
    }
    return got > 0 ? static_cast<std::size_t>(got) : 0;
  }

  /// Makes up to n bytes visible in the window. @return how many are.
  std::size_t available(std::size_t n) {
    if (end_ - begin_ >= n) return end_ - begin_;
    std::memmove(window_.data(), window_.data() + begin_, end_ - begin_);
    end_ -= begin_, begin_ = 0;
    while (end_ < n) {
      const std::size_t got = fromFile(window_.data() + end_, window_.size() - end_);
      if (got == 0) break;
      end_ += got;
    }
    return end_;
  }

  /// Every object begins with one byte (length of the class name, 0x80 set; three zero bytes follow in files older than
  /// MRPT 0.5.5), the name and the version: seen here also for objects inside objects.
  void watchHeaders(std::string_view bytes) {
    if (in_rotating_scan_ && bytes.size() == 2) {  // rows and columns of an image, one after the other
      std::uint16_t size = 0;
      std::memcpy(&size, bytes.data(), 2);
      if (std::uint64_t{size} * last_u16_ > bytesLeft())
        fail(fmt::format("an image of {} x {} is stated, more than the rest of the file can hold", last_u16_, size));
      last_u16_ = size;
      return;
    }
    last_u16_ = 0;
    if (bytes.size() == 1) {
      name_length_ = static_cast<std::uint8_t>(bytes[0]) & 0x7FU;
      old_format_ = (static_cast<std::uint8_t>(bytes[0]) & 0x80U) == 0;
      return;
    }
    if (old_format_ && bytes == std::string_view("\0\0\0", 3)) return;
    const bool is_name = name_length_ == bytes.size() && bytes.size() > 6 && isClassName(bytes);
    name_length_ = 0;
    if (!is_name) return;
    const std::string_view class_name = withoutNamespace(bytes);
    if (class_name != "CPose3D") in_rotating_scan_ = class_name == "CObservationRotatingScan";
    checkCount(class_name);
  }

  void checkCount(std::string_view class_name) {
    const std::size_t version_bytes = old_format_ ? 4 : 1;
    const std::string_view ahead = peek(4096);
    if (ahead.size() <= version_bytes) return;  // the version's read will say so
    std::optional<Stated> found;
    try {  // most classes are none of these, and nothing is read for them
      mrpt::io::CMemoryStream memory;
      memory.assignMemoryNotOwn(ahead.data() + version_bytes, ahead.size() - version_bytes);
      auto in = mrpt::serialization::archiveFrom(memory);
      found = stated(class_name, in, static_cast<std::uint8_t>(ahead[0]));
    } catch (const std::exception&) {
      fail(fmt::format("the head of a {} is unreadable", class_name));
    }
    if (found && found->count * found->bytes_each > bytesLeft())
      fail(fmt::format("a {} states {} elements, more than the rest of the file can hold", class_name, found->count));
  }

  std::string file_, failure_;
  gzFile gz_ = nullptr;
  std::uint64_t size_ = 0, position_ = 0;
  std::vector<char> window_;
  std::size_t begin_ = 0, end_ = 0;
  std::size_t name_length_ = 0;
  std::uint16_t last_u16_ = 0;
  bool old_format_ = false, in_rotating_scan_ = false;
};

RawlogObjects::RawlogObjects(const std::filesystem::path& file) {
  static const bool registered = [] {  // the linker drops libraries nobody refers to, and their classes with them
    mrpt::maps::registerAllClasses_mrpt_maps();
    return true;
  }();
  static_cast<void>(registered);
  archive_ = std::make_unique<Archive>(file);
}

RawlogObjects::~RawlogObjects() = default;

mrpt::serialization::CSerializable::Ptr RawlogObjects::next() {
  if (!archive_) return nullptr;
  constexpr std::uint64_t kLeast = std::uint64_t{1} << 30, kMost = std::uint64_t{1} << 32;
  const std::uint64_t start = archive_->position();
  std::string why, class_name;
  try {
    if (archive_->atEnd()) {
      archive_.reset();
      return nullptr;
    }
    const std::string_view head = archive_->peek(130);
    const std::size_t length = static_cast<std::uint8_t>(head[0]) & 0x7FU;
    class_name = withoutNamespace(head.substr(std::min<std::size_t>(1, head.size()), length));
    const MemoryLimit limit(std::clamp(archive_->bytesLeft() * 8, kLeast, kMost));
    return archive_->ReadObject();
  } catch (const std::bad_alloc&) {
    why = "a size stated there is absurd";
  } catch (const std::exception& error) {
    why = archive_->failure().empty() ? firstReason(error.what()) : archive_->failure();
  }
  const bool named = !class_name.empty() && isClassName(class_name);
  const Error error = inputError("{}: damaged at byte {}{} (in the {} that began at byte {}): {}", archive_->file(),
                                 archive_->position(), archive_->compressed() ? " of the uncompressed data" : "",
                                 named ? class_name : "object", start, why);
  archive_.reset();
  throw error;
}

std::string RawlogObjects::firstClassName(const std::filesystem::path& file) {
  gzFile gz = gzopen(file.c_str(), "rbe");
  if (gz == nullptr) return "";
  char head[128] = {};
  const int got = gzread(gz, head, sizeof head);
  gzclose_r(gz);
  const auto length = static_cast<std::uint8_t>(head[0]);
  const std::size_t begin = (length & 0x80U) != 0 ? 1 : 4, n = length & 0x7FU;
  if (got < 1 || n < 4 || begin + n > static_cast<std::size_t>(got)) return "";
  const std::string name(head + begin, n);
  return isClassName(name) && (name[0] == 'C' || name.find("::C") != std::string::npos) ? name : "";
}

}  // namespace scslam
