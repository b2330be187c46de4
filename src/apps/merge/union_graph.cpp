#include "scslam/apps/merge/union_graph.h"

#include <algorithm>
#include <numeric>

#include "scslam/pipeline/factors.h"
#include "scslam/pipeline/satellites.h"

namespace scslam {
namespace {

constexpr const char* kRefused = "the graph refuses it: it contradicts the other loops and the odometry together";

class DisjointSets {
 public:
  explicit DisjointSets(std::size_t n) : parent_(n) { std::iota(parent_.begin(), parent_.end(), std::size_t{0}); }
  std::size_t root(std::size_t i) const { return parent_[i] == i ? i : root(parent_[i]); }
  bool join(std::size_t i, std::size_t j) {
    const std::size_t p = root(i), q = root(j);
    parent_[std::max(p, q)] = std::min(p, q);
    return p != q;
  }

 private:
  std::vector<std::size_t> parent_;
};

/// T_map_session of the members: along the pairs with the most loops.
std::vector<Pose> anchors(std::size_t sessions, const std::vector<SessionPair>& pairs,
                          const std::vector<std::size_t>& members) {
  std::vector<const SessionPair*> joined;
  for (const SessionPair& pair : pairs)
    if (pair.refusal.empty()) joined.push_back(&pair);
  std::stable_sort(joined.begin(), joined.end(), [](const SessionPair* p, const SessionPair* q) {
    return p->loops->accepted() > q->loops->accepted();
  });
  DisjointSets sets(sessions);
  std::vector<const SessionPair*> tree;
  for (const SessionPair* pair : joined)
    if (sets.join(pair->a, pair->b)) tree.push_back(pair);

  std::vector<Pose> T_map_session(sessions, Pose::Identity());
  std::vector<std::uint8_t> placed(sessions, 0);
  placed[members.front()] = 1;
  for (bool more = true; more;) {
    more = false;
    for (const SessionPair* pair : tree) {
      if (placed[pair->a] == placed[pair->b]) continue;
      const Pose T_a_b = pair->loops->placement();
      if (placed[pair->a] != 0)
        T_map_session[pair->b] = T_map_session[pair->a] * T_a_b;
      else
        T_map_session[pair->a] = T_map_session[pair->b] * T_a_b.inverse();
      placed[pair->a] = placed[pair->b] = 1;
      more = true;
    }
  }
  return T_map_session;
}

/// Builds the graph and keeps, for each loop in it, the record it came from.
class UnionGraph {
 public:
  UnionGraph(const std::vector<SavedMap>& maps, const SlamParams& slam)
      : maps_(maps), slam_(slam), first_(maps.size()) {}

  void addSession(std::size_t s, const Pose& T_map_session, std::vector<LoopRecord>& own_loops,
                  Satellites& satellites) {
    const SavedMap& map = maps_[s];
    first_[s] = static_cast<std::uint32_t>(graph_.poses.size());
    graph_.planar = map.keyframes().front().planar;
    const bool hold = map.rigid() && graph_.fixed.empty();  // two surveyed maps may yet move against each other
    for (std::size_t k = 0; k < map.keyframes().size(); ++k) {
      const auto node = static_cast<std::uint32_t>(first_[s] + k);
      if (k > 0 && !beginsAnew(map.keyframes()[k]))
        graph_.factors.push_back(
            odometryFactor(map.keyframes()[k - 1], map.keyframes()[k], node - 1, node, slam_.graph));
      graph_.poses.push_back(T_map_session * map.poses()[k]);
      if (hold) graph_.fixed.push_back(node);
    }
    for (LoopRecord& loop : own_loops) addLoop(loop, s, s);
    for (GnssRecord record : map.gnss()) {
      record.keyframe += first_[s];
      satellites.add(record);
    }
  }
  void addPair(SessionPair& pair) {
    for (LoopRecord& loop : pair.loops->records()) addLoop(loop, pair.a, pair.b);
  }

  /// Fills the poses and the graph of what is believed.
  void solve(const std::vector<std::size_t>& members, Satellites& satellites, SessionUnion& result) {
    const std::size_t nodes = graph_.poses.size();
    PoseGraph whole = graph_;
    satellites.appendTo(whole);
    const OptimiserSummary summary = optimise(whole, slam_.graph.optimiser);
    for (const std::uint32_t f : summary.rejected_edges)
      if (f < records_.size() && records_[f] != nullptr) records_[f]->accepted = false, records_[f]->reason = kRefused;
    result.graph.planar = graph_.planar;
    result.graph.poses.assign(whole.poses.begin(), whole.poses.begin() + static_cast<std::ptrdiff_t>(nodes));
    for (std::size_t f = 0; f < graph_.factors.size(); ++f)
      if (f >= records_.size() || records_[f] == nullptr || records_[f]->accepted)
        result.graph.factors.push_back(graph_.factors[f]);
    for (const std::size_t s : members) {
      const auto begin = result.graph.poses.begin() + first_[s];
      result.T_map_base[s].assign(begin, begin + static_cast<std::ptrdiff_t>(maps_[s].keyframes().size()));
    }
  }

 private:
  void addLoop(LoopRecord& loop, std::size_t a, std::size_t b) {
    if (!loop.accepted) return;
    Factor factor = loopFactor(loop, slam_.graph);
    factor.i += first_[a], factor.j += first_[b];
    records_.resize(graph_.factors.size(), nullptr);
    graph_.factors.push_back(factor);
    records_.push_back(&loop);
  }

  const std::vector<SavedMap>& maps_;
  const SlamParams& slam_;
  PoseGraph graph_;
  std::vector<std::uint32_t> first_;  ///< node of each session's first keyframe
  std::vector<LoopRecord*> records_;  ///< by factor; null: not a loop
};

}  // namespace

std::vector<std::vector<std::size_t>> connectedSessions(const std::vector<SavedMap>& maps,
                                                        const std::vector<SessionPair>& pairs) {
  DisjointSets sets(maps.size());
  for (const SessionPair& pair : pairs)
    if (pair.refusal.empty()) sets.join(pair.a, pair.b);
  std::vector<std::vector<std::size_t>> by_root(maps.size());
  for (std::size_t s = 0; s < maps.size(); ++s) by_root[sets.root(s)].push_back(s);
  std::erase_if(by_root, [](const auto& sessions) { return sessions.empty(); });
  const auto size = [&maps](const std::vector<std::size_t>& sessions) {
    std::size_t keyframes = 0;
    for (const std::size_t s : sessions) keyframes += maps[s].keyframes().size();
    return std::pair(sessions.size() > 1, keyframes);  // a lone session, however long, is no merge
  };
  std::stable_sort(by_root.begin(), by_root.end(), [&](const auto& p, const auto& q) { return size(p) > size(q); });
  return by_root;
}

SessionUnion solveUnion(const std::vector<SavedMap>& maps, std::vector<SessionPair>& pairs,
                        const std::vector<std::size_t>& members, const SlamParams& slam) {
  SessionUnion result;
  result.members = members;
  result.T_map_base.resize(maps.size());
  result.own_loops.resize(maps.size());
  const std::vector<Pose> T_map_session = anchors(maps.size(), pairs, members);
  UnionGraph graph(maps, slam);
  Satellites satellites(slam.graph.gnss);
  for (const std::size_t s : members) {
    result.own_loops[s] = maps[s].loops();
    graph.addSession(s, T_map_session[s], result.own_loops[s], satellites);
  }
  for (SessionPair& pair : pairs)
    if (pair.refusal.empty() && std::find(members.begin(), members.end(), pair.a) != members.end()) graph.addPair(pair);
  graph.solve(members, satellites, result);
  return result;
}

}  // namespace scslam
