#include "scslam/sensor/rawlog_objects.h"

#include <mrpt/maps/registerAllClasses.h>
#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <new>
#include <string_view>
#include <vector>

#include "scslam/core/error.h"
#include "scslam/sensor/guarded_archive.h"
#include "scslam/sensor/memory_limit.h"

namespace scslam {
namespace {

constexpr std::size_t kWindow = 1 << 16;
constexpr unsigned kZlibBuffer = 1 << 17;
constexpr std::uint64_t kDeflateRatio = 1032;  // deflate cannot expand more than this

/// The telling line of MRPT's exception texts, which are call traces.
std::string firstReason(const std::string& text) {
  constexpr const char* kMark = "Message:";
  const std::size_t mark = text.rfind(kMark), begin = mark == std::string::npos ? 0 : mark + std::strlen(kMark);
  std::string line = text.substr(begin, text.find('\n', begin) - begin);
  line.erase(0, std::min(line.find_first_not_of(" \t"), line.size()));
  return line.empty() ? "unreadable object" : line;
}

}  // namespace

class RawlogObjects::Archive final : public GuardedArchive {
 public:
  explicit Archive(const std::filesystem::path& file) : file_(file.string()), window_(kWindow) {
    std::error_code error;
    size_ = std::filesystem::file_size(file, error);
    if (!error) gz_ = gzopen(file.c_str(), "rbe");
    if (gz_ == nullptr) throw inputError("cannot open {}", file_);
    gzbuffer(gz_, kZlibBuffer);
  }
  ~Archive() override { gzclose_r(gz_); }

  bool atEnd() { return available(1) == 0; }
  const std::string& file() const { return file_; }
  std::uint64_t position() const { return position_; }
  bool compressed() { return gzdirect(gz_) == 0; }
  std::string getArchiveDescription() const override { return file_; }

  std::uint64_t bytesLeft() override {
    if (!compressed()) return size_ - std::min(size_, position_);
    const auto offset = gzoffset(gz_);
    const std::uint64_t taken = offset < 0 ? 0 : std::min<std::uint64_t>(size_, static_cast<std::uint64_t>(offset));
    // Of what zlib has taken from the file, up to a buffer's worth is not unpacked yet.
    return (end_ - begin_) + (size_ - taken + kZlibBuffer) * kDeflateRatio;
  }

  /// Damage behind what can be had is left for the take() that comes to it.
  std::string_view peek(std::size_t n) override {
    try {
      available(n);
    } catch (const Damage&) {
      forgetFailure();
    }
    return {window_.data() + begin_, std::min(n, end_ - begin_)};
  }

 protected:
  void take(char* to, std::size_t count) override {
    std::size_t done = std::min(count, end_ - begin_);
    std::memcpy(to, window_.data() + begin_, done);
    begin_ += done;
    while (done < count) {
      const std::size_t got = fromFile(to + done, std::min<std::size_t>(count - done, 1U << 30));
      if (got == 0) fail(fmt::format("the file ends there, {} bytes are missing", count - done));
      done += got;
    }
    position_ += count;
  }

 private:
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

  std::string file_;
  gzFile gz_ = nullptr;
  std::uint64_t size_ = 0, position_ = 0;
  std::vector<char> window_;
  std::size_t begin_ = 0, end_ = 0;
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
  const std::uint64_t start = archive_->position();  // NOLINT(clang-analyzer-deadcode.DeadStores): for `error` below
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
