#include "scslam/sensor/folder_source.h"

#include <algorithm>
#include <utility>

#include "scslam/sensor/scan_files.h"

namespace scslam {
namespace {

class FolderSource final : public ScanSource {
 public:
  explicit FolderSource(FolderScans scans) : scans_(std::move(scans)) {}

  std::optional<Scan> next() override {
    if (next_ >= scans_.files.size()) return std::nullopt;
    const std::size_t i = std::exchange(next_, scans_.files.size());  // a damaged file ends the stream
    Scan scan;
    scan.cloud = scans_.load(scans_.files[i]);
    if (scans_.table) completeFromTable(scan.cloud, *scans_.table);
    scan.index = i;
    scan.stamp = scans_.stamps[i];
    scan.T_base_sensor = scans_.T_base_sensor;
    scan.planar = scans_.planar;
    scan.deskewed = scans_.deskewed;
    scan.label = scans_.label;
    if (!scans_.T_odom_base.empty()) scan.T_odom_base = scans_.T_odom_base[i];
    next_ = i + 1;
    return scan;
  }
  void skip(std::size_t n) override { next_ += std::min(n, scans_.files.size() - next_); }
  std::optional<std::size_t> size() const override { return scans_.files.size(); }
  std::optional<Trajectory> groundTruth() const override { return scans_.truth; }
  Pose T_base_reference() const override { return scans_.T_base_reference; }
  std::string description() const override { return scans_.description; }
  bool planar() const override { return scans_.planar; }

 private:
  FolderScans scans_;
  std::size_t next_ = 0;
};

}  // namespace

std::unique_ptr<ScanSource> makeFolderSource(FolderScans scans) {
  return std::make_unique<FolderSource>(std::move(scans));
}

std::optional<Trajectory> trajectoryOf(const std::vector<Stamp>& stamps,
                                       const std::vector<std::optional<Pose>>& poses) {
  Trajectory trajectory;
  for (std::size_t i = 0; i < poses.size(); ++i)
    if (poses[i] && (trajectory.poses.empty() || stamps[i] > trajectory.poses.back().stamp))
      trajectory.poses.push_back({stamps[i], *poses[i]});
  return trajectory.poses.empty() ? std::nullopt : std::optional(std::move(trajectory));
}

std::vector<Stamp> madeUpStamps(const std::vector<std::filesystem::path>& files) {
  constexpr double kPeriod = 0.1;
  constexpr std::uint64_t kLongestDrive = 10'000'000;  // larger numbers are not counters
  bool numbered = true;
  for (std::size_t i = 0; i < files.size() && numbered; ++i) {
    const auto number = numberOf(files[i]);
    numbered = number && *number < kLongestDrive && (i == 0 || *number > *numberOf(files[i - 1]));
  }
  std::vector<Stamp> stamps;
  for (std::size_t i = 0; i < files.size(); ++i)
    stamps.push_back(stampFromSeconds(kPeriod * static_cast<double>(numbered ? *numberOf(files[i]) : i)));
  return stamps;
}

}  // namespace scslam
