#include "scslam/sensor/guarded_archive.h"

#include <fmt/format.h>
#include <mrpt/math/CMatrixF.h>
#include <mrpt/poses/CPose2D.h>
#include <mrpt/poses/CPose3D.h>

#include <algorithm>
#include <cstring>
#include <optional>

namespace scslam {

using mrpt::serialization::CArchive;

namespace {

using Damage = GuardedArchive::Damage;

/// The first bytes of an object, looked at in advance; the objects inside it are watched as well.
class Preview final : public GuardedArchive {
 public:
  explicit Preview(std::string_view bytes) : bytes_(bytes) {}
  std::string getArchiveDescription() const override { return "preview"; }
  std::string_view peek(std::size_t n) override { return bytes_.substr(0, n); }
  std::uint64_t bytesLeft() override { return bytes_.size(); }

 protected:
  void take(char* to, std::size_t count) override {
    if (count > bytes_.size()) fail("too short");
    std::memcpy(to, bytes_.data(), count);
    bytes_.remove_prefix(count);
  }

 private:
  std::string_view bytes_;
};

/// Number of elements an object states, and the least bytes each takes in the file.
struct Stated {
  std::uint64_t count = 0, bytes_each = 1;
};

Stated statedByRangeScan(CArchive& in, int version) {
  float aperture = 0, max_range = 0;
  bool right_to_left = false;
  mrpt::poses::CPose3D pose;
  in >> aperture >> right_to_left >> max_range >> pose;
  if (version < 6) {
    mrpt::math::CMatrixF covariance;
    in >> covariance;
  }
  return {in.ReadAs<std::uint32_t>(), version == 0 ? 4U : 5U};
}

Stated statedByDepthImage(CArchive& in, int version) {
  float max_range = 0;
  mrpt::poses::CPose3D pose;
  in >> max_range >> pose;
  if (version > 0 && !in.ReadAs<bool>()) return {};
  return {in.ReadAs<std::uint32_t>(), 12};
}

/// MRPT draws as many samples of a wheel-odometry action as the file states, and dereferences whatever it finds where a
/// distribution of poses should be.
void checkPlanarAction(CArchive& in, int version) {
  constexpr std::int32_t kOdometry = 0, kGaussian = 0, kMostSamples = 1'000'000;
  if (version < 2 || in.ReadAs<std::int32_t>() != kOdometry) {
    const std::size_t length = in.ReadAs<std::uint8_t>();
    std::string name((length & 0x7FU) + ((length & 0x80U) != 0 ? 0 : 3), '\0');
    if (!name.empty()) in.ReadBuffer(name.data(), name.size());
    if (name.find("CPosePDF") == std::string::npos) throw Damage("no distribution of poses");
    return;
  }
  if (version == 2) return;
  mrpt::poses::CPose2D increment;
  in >> increment;
  const bool gaussian = in.ReadAs<std::int32_t>() == kGaussian;
  for (int i = 0; i < (version == 3 ? 5 : 6); ++i) in.ReadAs<float>();
  const auto samples = in.ReadAs<std::int32_t>();
  if (!gaussian && (samples < 0 || samples > kMostSamples)) throw Damage("an absurd number of samples");
}

/// The classes that take memory for a count without asking, most of them in MRPT's aligned buffers.
std::optional<Stated> stated(std::string_view class_name, CArchive& in, int version) {
  if (class_name == "CObservation2DRangeScan") return statedByRangeScan(in, version);
  if (class_name == "CObservation3DRangeScan") return statedByDepthImage(in, version);
  if (class_name == "CSensoryFrame" || class_name == "CActionCollection") {
    if (class_name == "CSensoryFrame" && version < 2) in.ReadAs<std::uint64_t>();  // a stamp
    return Stated{in.ReadAs<std::uint32_t>(), 4};
  }
  if (class_name == "CActionRobotMovement2D") checkPlanarAction(in, version);
  if (class_name == "CPosePDFParticles" || class_name == "CPose3DPDFParticles")
    return Stated{in.ReadAs<std::uint32_t>(), 8};
  if (class_name == "CMatrixF" || class_name == "CMatrix" || class_name == "CMatrixD") {
    const std::uint64_t rows = in.ReadAs<std::uint32_t>(), columns = in.ReadAs<std::uint32_t>();
    constexpr std::uint64_t kMost = std::uint64_t{1} << 32;  // keeps count * bytes_each within 64 bits
    return Stated{std::min(rows * columns, kMost), class_name == "CMatrixD" ? 8U : 4U};
  }
  for (const char* map : {"CSimplePointsMap", "CPointsMapXYZI", "CColouredPointsMap", "CWeightedPointsMap"})
    if (class_name == map) return Stated{in.ReadAs<std::uint32_t>(), 12};
  return std::nullopt;
}

}  // namespace

std::string_view withoutNamespace(std::string_view class_name) {
  return class_name.substr(class_name.rfind(':') + 1);  // npos + 1 = 0
}

bool isClassName(std::string_view name) {
  return std::all_of(name.begin(), name.end(), [](char c) {
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '_' || c == ':';
  });
}

void GuardedArchive::fail(const std::string& why) {
  if (failure_.empty()) failure_ = why;
  throw Damage(why);
}

std::size_t GuardedArchive::read(void* to, std::size_t count) {
  take(static_cast<char*>(to), count);
  watch({static_cast<const char*>(to), count});
  return count;
}

std::size_t GuardedArchive::write(const void*, std::size_t) { throw std::logic_error("this archive is only read"); }

/// Every object begins with one byte (length of the class name, 0x80 set; three zero bytes follow in files older than
/// MRPT 0.5.5), the name and the version.
void GuardedArchive::watch(std::string_view bytes) {
  if (in_rotating_scan_ && bytes.size() == 2) return watchImageSize(bytes);
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
  checkCounts(class_name);
}

/// Rows and columns of a rotating scan's images come one after the other, two bytes each.
void GuardedArchive::watchImageSize(std::string_view bytes) {
  std::uint16_t size = 0;
  std::memcpy(&size, bytes.data(), sizeof size);
  if (std::uint64_t{size} * last_u16_ > bytesLeft())
    fail(fmt::format("an image of {} x {} is stated, more than the rest of the file can hold", last_u16_, size));
  last_u16_ = size;
}

void GuardedArchive::checkCounts(std::string_view class_name) {
  const std::size_t version_bytes = old_format_ ? 4 : 1;
  const std::string_view ahead = peek(4096);
  if (ahead.size() <= version_bytes) return;  // reading the version will say so
  std::optional<Stated> found;
  try {
    Preview preview(ahead.substr(version_bytes));
    found = stated(class_name, preview, static_cast<std::uint8_t>(ahead[0]));
  } catch (const std::exception&) {
    fail(fmt::format("the head of a {} is unreadable", class_name));
  }
  if (found && found->count * found->bytes_each > bytesLeft())
    fail(fmt::format("a {} states {} elements, more than the rest of the file can hold", class_name, found->count));
}

}  // namespace scslam
