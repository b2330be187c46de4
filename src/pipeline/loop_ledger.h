// The loops that passed their own gates, and which of them are believed at the moment.
#pragma once
#include <string>
#include <vector>

#include "scslam/graph/consistency.h"
#include "scslam/graph/optimiser.h"
#include "scslam/pipeline/slam_params.h"
#include "scslam/session/records.h"

namespace scslam {

/// A loop is accepted while it belongs to the largest set of loops that agree with each other and the graph does not
/// refuse it. Both may change with every loop that comes: judge() tells what changed.
class LoopLedger {
 public:
  explicit LoopLedger(const GraphParams& params) : params_(params), consistency_(params.consistency) {}

  void addNode(const Keyframe& keyframe);
  /// Numbers the candidate as the session does. A verified one joins the others; its verdict is then theirs to make.
  void add(LoopRecord& record);
  /// The same for a record of a session that goes on: its verdict stands.
  void restore(const LoopRecord& record);

  /// Adds the factors of the loops that agree with each other. Those the optimiser rejects go to note().
  void appendTo(PoseGraph& graph);
  void note(const std::vector<std::uint32_t>& rejected_edges);
  /// Loops whose verdict is another than what was last told.
  std::vector<LoopVerdict> judge();
  std::size_t candidates() const { return candidates_; }
  std::size_t accepted() const;
  bool hasAccepted(KeyframeId query) const;
  /// Adds the factors of the accepted loops alone.
  void appendAcceptedTo(PoseGraph& graph) const;

 private:
  struct Entry {
    std::uint32_t number;  ///< among the session's records
    KeyframeId query;
    Factor factor;
    bool refused_by_graph = false;
    std::string told_reason;
  };
  bool believed(std::size_t entry) const { return !params_.consistency.enabled || consistency_.believed()[entry] != 0; }
  std::string reasonOf(std::size_t entry) const;

  GraphParams params_;
  LoopConsistency consistency_;
  std::vector<Entry> entries_;
  std::uint32_t candidates_ = 0;
  std::vector<std::size_t> entry_of_factor_;  ///< of the graph last given to appendTo()
  std::size_t first_factor_ = 0;
};

}  // namespace scslam
