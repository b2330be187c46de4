// Where scans come from. One file in readers/ per format.
#pragma once
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "scslam/core/registry.h"
#include "scslam/core/trajectory.h"
#include "scslam/sensor/scan.h"
#include "scslam/sensor/sensor_model.h"

namespace scslam {

/// A stream of scans in time order. Memory does not grow with its length.
class ScanSource {
 public:
  virtual ~ScanSource() = default;
  /// The next scan; nullopt at the clean end. @throw inputError (what, file, byte) where the input is damaged or ends
  /// in the middle of a record; everything before it was handed over, and next() afterwards returns nullopt.
  virtual std::optional<Scan> next() = 0;
  /// Passes over the next n scans without decoding more than needed (resume). The following next() behaves as if they
  /// had been taken, T_odom_base included.
  virtual void skip(std::size_t n);
  /// Number of scans, where it is known without reading all.
  virtual std::optional<std::size_t> size() const { return std::nullopt; }
  /// True poses T_map_base where the layout has them.
  virtual std::optional<Trajectory> groundTruth() const { return std::nullopt; }
  /// Frame that pose files beside this data speak of: base when identity (KITTI with calib.txt: the left camera).
  virtual Pose T_base_reference() const { return Pose::Identity(); }
  /// One line for people: format, what was found, what was guessed or made up (times, rings).
  virtual std::string description() const = 0;
  /// Are the scans planar (2-D)? Decides the default configuration. Known before the first next().
  virtual bool planar() const { return false; }
};

struct OpenOptions {
  std::optional<SensorModel> sensor;  ///< overrides what the reader would take (rings, times, extrinsic)
  std::string label;                  ///< only the scans of this sensor label; empty: the first label with scans
  bool radar = false;                 ///< where there is a radar beside a LiDAR, take the radar
};

/// A format that can be read. Plug-in interface of sensor/readers.
class ScanFormat {
 public:
  static constexpr const char* kKind = "input format";
  struct Guess {
    int confidence = 0;  ///< 0 = not this format … 100 = certain
    std::string why;     ///< "velodyne/*.bin and times.txt"
    bool radar = false;  ///< images of a spinning radar
  };
  virtual ~ScanFormat() = default;
  /// Looks at names and the first bytes only. Never throws for foreign data.
  virtual Guess probe(const std::filesystem::path& uri) const = 0;
  virtual std::unique_ptr<ScanSource> open(const std::filesystem::path& uri, const OpenOptions& options) const = 0;
};
SCSLAM_DECLARE_REGISTRY(ScanFormat);

struct OpenedSource {
  std::unique_ptr<ScanSource> source;
  std::string format;  ///< registered name
  std::string why;     ///< why this format was taken
};

/// Opens `uri` with the format of highest confidence.
/// @throw inputError when it does not exist, is empty, or no format knows it (the message lists what was looked for).
OpenedSource openSource(const std::filesystem::path& uri, const PluginContext& context,
                        const OpenOptions& options = {});

}  // namespace scslam
