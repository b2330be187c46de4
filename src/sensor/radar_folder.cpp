#include "scslam/sensor/radar_folder.h"

#include <algorithm>
#include <utility>

#include "scslam/sensor/radar_sweep.h"

namespace scslam {
namespace {

class RadarSource final : public ScanSource {
 public:
  explicit RadarSource(RadarFolder folder) : folder_(std::move(folder)) {}

  std::optional<Scan> next() override {
    if (next_ >= folder_.files.size()) return std::nullopt;
    const std::size_t i = std::exchange(next_, folder_.files.size());  // a damaged file ends the stream
    Scan scan = scanOfSweep(folder_.load(folder_.files[i]));
    scan.index = i;
    next_ = i + 1;
    return scan;
  }
  void skip(std::size_t n) override { next_ += std::min(n, folder_.files.size() - next_); }
  std::optional<std::size_t> size() const override { return folder_.files.size(); }
  std::optional<Trajectory> groundTruth() const override { return folder_.truth; }
  std::string description() const override { return folder_.description; }
  bool planar() const override { return true; }

 private:
  RadarFolder folder_;
  std::size_t next_ = 0;
};

}  // namespace

std::unique_ptr<ScanSource> makeRadarSource(RadarFolder folder) {
  return std::make_unique<RadarSource>(std::move(folder));
}

}  // namespace scslam
