// Names of the files of a session folder and the text forms of the classic ones.
#pragma once
#include <filesystem>
#include <string>
#include <vector>

#include "scslam/place/place_recogniser.h"
#include "scslam/session/records.h"

namespace scslam::layout {

inline constexpr const char* kManifest = "session.yaml";
inline constexpr const char* kConfig = "config.yaml";
inline constexpr const char* kJournal = "journal.bin";
inline constexpr const char* kCheckpoint = "checkpoint.bin";
inline constexpr const char* kLog = "run.log";
inline constexpr const char* kMetrics = "metrics.json";
inline constexpr const char* kScans = "Scans";
inline constexpr const char* kDescriptors = "SCDs";
inline constexpr const char* kOptimisedPoses = "optimized_poses.txt";
inline constexpr const char* kOdometryPoses = "odom_poses.txt";
inline constexpr const char* kTimes = "times.txt";
inline constexpr const char* kPoseGraph = "singlesession_posegraph.g2o";
inline constexpr const char* kTrajectory = "trajectory.tum";
inline constexpr const char* kOdometry = "odometry.tum";
inline constexpr const char* kLoops = "loops.csv";
inline constexpr const char* kGnss = "gnss.csv";                   ///< only where there were fixes
inline constexpr const char* kGeoreference = "georeference.yaml";  ///< only where they place the map on Earth

inline constexpr const char* kParents = "parents.csv";  ///< of a merged session: whose keyframes are which
inline constexpr const char* kKeyframeParents = "parent_keyframes.csv";  ///< and each one's number there
inline constexpr const char* kLtMapper = "lt_mapper";  ///< poses of each parent as LT-mapper reads them

/// Everything a session consists of, the manifest last; what else lies in its folder is the user's.
std::vector<std::string> allNames();

std::filesystem::path scanFile(const std::filesystem::path& folder, KeyframeId k);        ///< Scans/000000.pcd
std::filesystem::path descriptorFile(const std::filesystem::path& folder, KeyframeId k);  ///< SCDs/000000.scd

/// Rows = rings, single spaces, no newline after the last row; shortest digits that read back to the same floats.
std::string formatDescriptor(const Descriptor& descriptor);
/// @throw inputError "FILE:line: …" for ragged rows or words that are no numbers.
Descriptor readDescriptor(const std::filesystem::path& file);

/// Seconds, one a line, 17 significant digits.
std::string formatTimes(const std::vector<Keyframe>& keyframes);
/// One row per fix, with a header row: degrees, metres, the sigmas east, north, up.
std::string formatGnss(const std::vector<GnssRecord>& gnss);
/// One row per candidate, with a header row; figures of a registration that was not tried stay empty.
std::string formatLoops(const std::vector<LoopRecord>& loops);

}  // namespace scslam::layout
