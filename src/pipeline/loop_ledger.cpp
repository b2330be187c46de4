#include "scslam/pipeline/loop_ledger.h"

#include <algorithm>

#include "scslam/pipeline/factors.h"

namespace scslam {
namespace {

constexpr const char* kAccepted = "accepted";
constexpr const char* kAlone = "contradicts the loops that agree with each other";
constexpr const char* kWaits = "odometry lost track between both, and too few loops agree yet to join them";
constexpr const char* kRefused = "the graph refuses it: it contradicts the other loops and the odometry together";

}  // namespace

void LoopLedger::addNode(const Keyframe& keyframe) {
  consistency_.addNode(keyframe.T_odom_base, keyframe.travelled_m, keyframe.step_covariance, keyframe.planar);
}

void LoopLedger::add(LoopRecord& record) {
  record.verified = record.accepted;
  if (record.verified) {
    Entry entry{candidates_, record.query, loopFactor(record, params_), false, {}};
    consistency_.addLoop(entry.factor);
    entries_.push_back(std::move(entry));
    record.reason = entries_.back().told_reason = reasonOf(entries_.size() - 1);
    record.accepted = record.reason == kAccepted;
  }
  ++candidates_;
}

void LoopLedger::restore(const LoopRecord& record) {
  if (record.verified) {
    entries_.push_back(
        {candidates_, record.query, loopFactor(record, params_), record.reason == kRefused, record.reason});
    consistency_.addLoop(entries_.back().factor);
  }
  ++candidates_;
}

std::string LoopLedger::reasonOf(std::size_t entry) const {
  if (!believed(entry)) return consistency_.waits(entry) ? kWaits : kAlone;
  return entries_[entry].refused_by_graph ? kRefused : kAccepted;
}

void LoopLedger::appendTo(PoseGraph& graph) {
  entry_of_factor_.clear();
  first_factor_ = graph.factors.size();
  for (std::size_t e = 0; e < entries_.size(); ++e) {
    if (!believed(e)) continue;
    graph.factors.push_back(entries_[e].factor);
    entry_of_factor_.push_back(e);
  }
}

void LoopLedger::note(const std::vector<std::uint32_t>& rejected_edges) {
  for (Entry& entry : entries_) entry.refused_by_graph = false;
  for (const std::uint32_t f : rejected_edges)
    if (f >= first_factor_ && f - first_factor_ < entry_of_factor_.size())
      entries_[entry_of_factor_[f - first_factor_]].refused_by_graph = true;
}

std::vector<LoopVerdict> LoopLedger::judge() {
  std::vector<LoopVerdict> changes;
  for (std::size_t e = 0; e < entries_.size(); ++e) {
    std::string reason = reasonOf(e);
    if (reason == entries_[e].told_reason) continue;
    changes.push_back({entries_[e].number, reason == kAccepted, reason});
    entries_[e].told_reason = std::move(reason);
  }
  return changes;
}

std::size_t LoopLedger::accepted() const {
  return static_cast<std::size_t>(std::count_if(entries_.begin(), entries_.end(),
                                                [](const Entry& entry) { return entry.told_reason == kAccepted; }));
}

bool LoopLedger::hasAccepted(KeyframeId query) const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [query](const Entry& entry) { return entry.query == query && entry.told_reason == kAccepted; });
}

void LoopLedger::appendAcceptedTo(PoseGraph& graph) const {
  for (const Entry& entry : entries_)
    if (entry.told_reason == kAccepted) graph.factors.push_back(entry.factor);
}

}  // namespace scslam
