// Long-term data association, first half (paper, Sec. III-B2): which earlier place does this one look like?
#pragma once
#include <Eigen/Core>
#include <vector>

#include "scslam/core/registry.h"
#include "scslam/keyframe/keyframe.h"

namespace scslam {

/// Row-major so that row r of a .scd file is ring r.
using Descriptor = Eigen::Matrix<float, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

struct PlaceCandidate {
  KeyframeId match = 0;
  double distance = 0;  ///< descriptor distance, smaller = more alike
  /// First guess of the query's base in the match's base: heading, and where the method finds it the shift.
  Pose T_match_query = Pose::Identity();
  double runner_up = 0;  ///< distance of the best candidate at a different place; 0: there was none
};

/// Plug-in interface of place/recognisers.
class PlaceRecogniser {
 public:
  static constexpr const char* kKind = "place recogniser";
  virtual ~PlaceRecogniser() = default;
  /// @param cloud_base of the keyframe; gravity-levelled inside with the roll and pitch of keyframe.T_odom_base.
  virtual Descriptor describe(const Keyframe& keyframe, const Cloud& cloud_base) const = 0;
  /// False for recognisers that look at poses only: describe() is then not called and add() gets an empty descriptor.
  virtual bool usesScans() const { return true; }
  /// Stores the keyframe (ids in order, from 0).
  /// @param descriptor what describe() gave, perhaps read back from a session; empty: made from the cloud here.
  /// @param cloud_base the keyframe's cloud as the session keeps it (so that a resumed run gets the same), for what a
  /// recogniser needs besides its descriptor; empty: it does with the descriptor.
  virtual void add(const Keyframe& keyframe, const Descriptor& descriptor, const Cloud& cloud_base) = 0;
  void add(const Keyframe& keyframe, const Descriptor& descriptor) { add(keyframe, descriptor, Cloud()); }
  /// Candidates for keyframe k among the earlier ones that are at least min_travel away along the path, best first.
  virtual std::vector<PlaceCandidate> query(KeyframeId k) const = 0;
  /// Candidates among all keyframes, best first, for a scan that is none of them: of another session, or of a robot
  /// that looks for itself in a map. Only T_odom_base (its roll and pitch) and planar count of `keyframe`. Nothing is
  /// stored.
  /// @param descriptor what describe() gave; empty: made from the cloud here.
  /// @return nothing from recognisers that look at poses only: between two sessions there is no common frame yet.
  virtual std::vector<PlaceCandidate> find(const Keyframe& /*keyframe*/, const Descriptor& /*descriptor*/,
                                           const Cloud& /*cloud_base*/) const {
    return {};
  }
  /// The present estimate of all keyframes, before a query: for recognisers that look where the robot is believed to
  /// be.
  virtual void setPoses(const std::vector<Pose>& /*T_map_base*/) {}
};
SCSLAM_DECLARE_REGISTRY(PlaceRecogniser);

}  // namespace scslam
