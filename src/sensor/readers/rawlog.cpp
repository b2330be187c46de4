// MRPT rawlogs, plain or gzip, streamed: observations one by one, or pairs of actions and sensory frames.
#include <mrpt/obs/CActionCollection.h>
#include <mrpt/obs/CActionRobotMovement2D.h>
#include <mrpt/obs/CActionRobotMovement3D.h>
#include <mrpt/obs/CObservationComment.h>
#include <mrpt/obs/CObservationOdometry.h>
#include <mrpt/obs/CObservationRobotPose.h>
#include <mrpt/obs/CSensoryFrame.h>

#include <algorithm>
#include <deque>
#include <map>
#include <utility>

#include "scslam/core/error.h"
#include "scslam/core/mrpt_pose.h"
#include "scslam/sensor/pose_track.h"
#include "scslam/sensor/rawlog_navigation.h"
#include "scslam/sensor/rawlog_objects.h"
#include "scslam/sensor/rawlog_scans.h"
#include "scslam/sensor/scan_source.h"

namespace scslam {
namespace {

namespace fs = std::filesystem;
using mrpt::obs::CObservation;

std::string shortClassName(const mrpt::rtti::CObject& object) {
  const std::string name = object.GetRuntimeClass()->className;
  return name.substr(name.rfind(':') + 1);  // npos + 1 = 0
}

/// Motion of the robot in one action, as measured.
Pose incrementOf(const mrpt::obs::CActionRobotMovement2D& action) {
  using Action = mrpt::obs::CActionRobotMovement2D;
  const bool raw = action.estimationMethod == Action::emOdometry || !action.poseChange;
  return fromMrpt(mrpt::poses::CPose3D(raw ? action.rawOdometryIncrementReading : action.poseChange->getMeanVal()));
}
/// The raw reading of a 3-D action is not stored in files.
Pose incrementOf(const mrpt::obs::CActionRobotMovement3D& action) { return fromMrpt(action.poseChange.mean); }

class RawlogSource final : public ScanSource {
 public:
  RawlogSource(const fs::path& file, const OpenOptions& options)
      : file_(file), options_(options), label_(options.label), objects_(file) {
    while (!ended_ && pending_.size() < kLookAhead && !(hasPoses() && !pending_.empty())) readEntry();
    if (pending_.empty()) throw failure_ ? *failure_ : nothingUsable();
    planar_ = isPlanarScan(*pending_.front().observation);
    const fs::path truth = fs::path(file_).replace_extension(".gt.tum");
    if (fs::is_regular_file(truth)) truth_ = truth;
  }

  std::optional<Scan> next() override {
    if (!fetch()) return std::nullopt;
    Scan scan;
    const std::size_t number = index_;
    Scan readings;
    const auto pending = take(readings);
    try {
      scan = scanFrom(*pending.observation, options_.sensor, file_);
    } catch (const Error& error) {
      ended_ = true, pending_.clear(), failure_.reset();
      throw inputError("{}: scan {}: {}", file_.string(), number, error.what());
    }
    scan.index = number;
    scan.stamp = last_stamp_;
    scan.T_odom_base = odometryOf(pending);
    scan.imu = std::move(readings.imu), scan.gnss = std::move(readings.gnss), scan.T_base_imu = readings.T_base_imu;
    return scan;
  }

  void skip(std::size_t n) override {
    for (std::size_t i = 0; i < n; ++i) {
      fillOne();
      if (pending_.empty()) return;
      readWhatBelongsToFront();
      Scan readings;
      take(readings);
    }
  }

  std::optional<Trajectory> groundTruth() const override {
    return truth_ ? std::optional(readTrajectory(*truth_)) : std::nullopt;
  }
  bool planar() const override { return planar_; }

  std::string description() const override {
    std::string text = fmt::format("MRPT rawlog ({}), scans '{}' of {}",
                                   in_frames_ ? "actions and sensory frames" : "observations", label_, scan_class_);
    text += ", odometry " + (has_actions_ && in_frames_ ? std::string("from the actions")
                             : !robot_poses_.empty()    ? "from CObservationRobotPose"
                             : !wheel_poses_.empty()    ? "from CObservationOdometry"
                                                        : "none");
    if (const auto readings = navigation_.description(); !readings.empty()) text += ", " + readings;
    if (!simulated_.empty()) text += ", " + simulated_;
    if (truth_) text += ", truth from " + truth_->filename().string();
    if (made_up_ != 0) text += ", scans without a time: 0.1 s after the one before made up";
    std::string others;
    for (const auto& [label, count] : other_labels_) others += (others.empty() ? "'" : ", '") + label + "'";
    if (!others.empty()) text += ", not taken: " + others;
    return text;
  }

 private:
  /// How many scans are held back while poses that come after them in the file may follow.
  static constexpr std::size_t kLookAhead = 8;
  struct Pending {
    CObservation::Ptr observation;
    bool in_frame = false;
    Pose T_actions = Pose::Identity();
  };

  bool hasPoses() const { return has_actions_ || !robot_poses_.empty() || !wheel_poses_.empty(); }
  const PoseTrack& track() const { return robot_poses_.empty() ? wheel_poses_ : robot_poses_; }

  void fillOne() {
    while (pending_.empty() && !ended_) readEntry();
  }

  /// Makes pending_.front() ready to go. @return false at the end; throws what ended the file once all is handed over.
  bool fetch() {
    fillOne();
    if (pending_.empty()) {
      if (auto failure = std::exchange(failure_, std::nullopt)) throw *failure;
      return false;
    }
    readWhatBelongsToFront();
    return true;
  }

  /// Poses around the scan and inertial readings up to the next one lie behind it in the file.
  void readWhatBelongsToFront() {
    const auto waits = [this] {
      if (ended_ || pending_.size() >= kLookAhead) return false;
      if (pending_.size() < 2 || !navigation_.covers(stampOf(pending_[1], stampOf(pending_[0], last_stamp_))))
        return true;
      if (pending_.front().in_frame && has_actions_) return false;
      return !track().empty() && !track().covers(pending_.front().observation->timestamp);
    };
    while (waits()) readEntry();
  }

  /// A scan without a time comes 0.1 s after the one before.
  Stamp stampOf(const Pending& pending, Stamp before) const {
    if (pending.observation->timestamp != INVALID_TIMESTAMP) return pending.observation->timestamp;
    return before == Stamp() ? stampFromSeconds(0) : before + (stampFromSeconds(0.1) - stampFromSeconds(0));
  }

  /// @param readings gets the inertial and satellite readings of the scan.
  Pending take(Scan& readings) {
    Pending pending = std::move(pending_.front());
    pending_.pop_front();
    made_up_ += pending.observation->timestamp == INVALID_TIMESTAMP;
    last_stamp_ = stampOf(pending, last_stamp_);
    const Stamp next = pending_.empty() ? Stamp() : stampOf(pending_.front(), last_stamp_);
    navigation_.handTo(readings, pending_.empty() ? nullptr : &next);
    ++index_;
    robot_poses_.forgetBefore(last_stamp_);
    wheel_poses_.forgetBefore(last_stamp_);
    return pending;
  }

  std::optional<Pose> odometryOf(const Pending& pending) const {
    if (pending.in_frame && has_actions_) return pending.T_actions;
    return track().at(last_stamp_);
  }

  /// Reads one object of the file; a damaged one ends it, and the damage is kept until the scans before are handed
  /// over.
  void readEntry() {
    mrpt::serialization::CSerializable::Ptr object;
    try {
      object = objects_.next();
    } catch (const Error& error) {
      failure_ = error;
    }
    if (!object) {
      ended_ = true;
    } else if (auto observation = std::dynamic_pointer_cast<CObservation>(object)) {
      onObservation(observation, false);
    } else if (const auto frame = std::dynamic_pointer_cast<mrpt::obs::CSensoryFrame>(object)) {
      in_frames_ = true;
      for (const auto& in_frame : *frame)
        if (in_frame) onObservation(in_frame, true);
    } else if (const auto actions = std::dynamic_pointer_cast<mrpt::obs::CActionCollection>(object)) {
      onActions(*actions);
    } else {
      ++seen_[shortClassName(*object)];
    }
  }

  void onObservation(const CObservation::Ptr& observation, bool in_frame) {
    if (const auto* pose = dynamic_cast<const mrpt::obs::CObservationRobotPose*>(observation.get())) {
      if (pose->timestamp != INVALID_TIMESTAMP)
        robot_poses_.add(pose->timestamp, fromMrpt(pose->pose.mean) * fromMrpt(pose->sensorPose).inverse());
    } else if (const auto* wheels = dynamic_cast<const mrpt::obs::CObservationOdometry*>(observation.get())) {
      if (wheels->timestamp != INVALID_TIMESTAMP)
        wheel_poses_.add(wheels->timestamp, fromMrpt(mrpt::poses::CPose3D(wheels->odometry)));
    } else if (const auto* comment = dynamic_cast<const mrpt::obs::CObservationComment*>(observation.get())) {
      if (comment->text.starts_with("simulated: ")) simulated_ = comment->text.substr(0, comment->text.find('\n'));
    } else {
      onSensor(observation, in_frame);
    }
  }

  void onSensor(const CObservation::Ptr& observation, bool in_frame) {
    navigation_.take(*observation);
    const std::string class_name = shortClassName(*observation);
    const std::string& label = observation->sensorLabel;
    const bool scan = isScan(*observation, options_.sensor) && (!options_.radar || isRadarScan(*observation));
    if (scan && scan_class_.empty() && (options_.label.empty() || label == options_.label)) {
      label_ = label;
      scan_class_ = class_name;
    }
    if (scan && class_name == scan_class_ && label == label_) {
      pending_.push_back({observation, in_frame, T_actions_});
    } else {
      if (scan) ++other_labels_[label];
      if (scan_class_.empty()) ++seen_[fmt::format("{} '{}'", class_name, label)];
    }
  }

  void onActions(const mrpt::obs::CActionCollection& actions) {
    for (const auto& action : actions) {
      if (const auto* planar = dynamic_cast<const mrpt::obs::CActionRobotMovement2D*>(action.get_ptr().get()))
        T_actions_ = T_actions_ * incrementOf(*planar);
      else if (const auto* spatial = dynamic_cast<const mrpt::obs::CActionRobotMovement3D*>(action.get_ptr().get()))
        T_actions_ = T_actions_ * incrementOf(*spatial);
      else
        continue;
      has_actions_ = true;
      return;  // one motion an entry: the others are other estimates of the same
    }
  }

  Error nothingUsable() const {
    std::string found;
    for (const auto& [what, count] : seen_) found += fmt::format("{}{} x {}", found.empty() ? "" : ", ", count, what);
    if (found.empty()) found = "nothing but poses";
    if (!options_.label.empty())
      return inputError("{} has no scans with the label '{}'; it holds {}", file_.string(), options_.label, found);
    return inputError(
        "{} has no scans that can be used (2-D range scans, point clouds, Velodyne scans, rotating scans of a known "
        "sensor); it holds {}",
        file_.string(), found);
  }

  fs::path file_;
  OpenOptions options_;
  std::string label_, scan_class_;
  RawlogObjects objects_;
  std::deque<Pending> pending_;
  PoseTrack robot_poses_, wheel_poses_;
  RawlogNavigation navigation_;
  Pose T_actions_ = Pose::Identity();  ///< T_odom_base by the actions so far
  bool has_actions_ = false, in_frames_ = false, planar_ = false, ended_ = false;
  std::optional<Error> failure_;
  std::optional<fs::path> truth_;
  std::string simulated_;  ///< how a simulated log introduces itself
  std::size_t index_ = 0, made_up_ = 0;
  Stamp last_stamp_{};  ///< of the scan handed over last
  std::map<std::string, std::size_t> other_labels_, seen_;
};

struct RawlogFormat final : ScanFormat {
  struct Params : ParamSetOf<Params> {
    void describe(ParamVisitor&) override {}
  };
  RawlogFormat(const Params&, const PluginContext&) {}

  Guess probe(const fs::path& uri) const override {
    if (!fs::is_regular_file(uri)) return {};
    const std::string first = RawlogObjects::firstClassName(uri);
    if (!first.empty()) return {95, "begins with a " + first};
    return uri.extension() == ".rawlog" ? Guess{20, "named .rawlog"} : Guess{};
  }
  std::unique_ptr<ScanSource> open(const fs::path& uri, const OpenOptions& options) const override {
    return std::make_unique<RawlogSource>(uri, options);
  }
};

}  // namespace

SCSLAM_REGISTER(ScanFormat, RawlogFormat, "rawlog", "MRPT .rawlog, plain or gzip")

}  // namespace scslam
