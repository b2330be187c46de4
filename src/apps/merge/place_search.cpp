#include "scslam/apps/merge/place_search.h"

#include <algorithm>

#include "scslam/core/parallel.h"

namespace scslam {
namespace {

/// Keyframes whose scans are in memory at a time: enough for all cores, few enough for any scan.
constexpr std::size_t kBatch = 16;

using Recognisers = std::vector<std::unique_ptr<PlaceRecogniser>>;

struct Described {
  std::vector<Descriptor> descriptors;  ///< one per recogniser
  std::shared_ptr<const Cloud> thinned;
  std::vector<std::vector<FoundPlace>> found;  ///< by earlier session
};

class Searcher {
 public:
  Searcher(const std::vector<SavedMap>& maps, const PlaceParams& params, const PluginContext& context)
      : maps_(maps), params_(params), context_(context) {
    for (std::size_t s = 0; s < maps.size(); ++s) recognisers_.push_back(params.recognisers.create(context));
  }

  /// Keyframes begin .. end of session s: described, looked for in the sessions before.
  std::vector<Described> batch(std::size_t s, std::size_t begin, std::size_t end) const {
    std::vector<Described> results(end - begin);
    context_.threads.forEachChunk(results.size(), 1, [&](std::size_t i, std::size_t, std::size_t) {
      results[i] = described(s, static_cast<KeyframeId>(begin + i));
    });
    return results;
  }

  void add(std::size_t s, KeyframeId k, const Described& described) {
    for (std::size_t r = 0; r < recognisers_[s].size(); ++r)
      recognisers_[s][r]->add(maps_[s].keyframes()[k], described.descriptors[r],
                              recognisers_[s][r]->usesScans() ? *described.thinned : Cloud());
  }

 private:
  Described described(std::size_t s, KeyframeId k) const {
    const Keyframe& keyframe = maps_[s].keyframes()[k];
    Described result;
    result.thinned = maps_[s].cloud(k);
    const Cloud whole = maps_[s].wholeCloud(k);
    for (const auto& recogniser : recognisers_[s])
      result.descriptors.push_back(recogniser->usesScans() ? recogniser->describe(keyframe, whole) : Descriptor());
    result.found.resize(s);
    for (std::size_t earlier = 0; earlier < s; ++earlier)
      for (std::size_t r = 0; r < recognisers_[earlier].size(); ++r)
        for (const PlaceCandidate& candidate :
             recognisers_[earlier][r]->find(keyframe, result.descriptors[r], *result.thinned))
          result.found[earlier].push_back({k, candidate, params_.recognisers.names[r]});
    return result;
  }

  const std::vector<SavedMap>& maps_;
  const PlaceParams& params_;
  const PluginContext& context_;
  std::vector<Recognisers> recognisers_;  ///< by session: its own places
};

}  // namespace

PlaceSearch searchPlaces(const std::vector<SavedMap>& maps, const PlaceParams& params, const PluginContext& context,
                         const std::function<void(std::size_t)>& progress) {
  Searcher searcher(maps, params, context);
  PlaceSearch search;
  search.descriptors.resize(maps.size());
  search.found.resize(maps.size());
  std::size_t done = 0;
  for (std::size_t s = 0; s < maps.size(); ++s) {
    search.found[s].resize(s);
    const std::size_t n = maps[s].keyframes().size();
    for (std::size_t begin = 0; begin < n; begin += kBatch) {
      const std::size_t end = std::min(begin + kBatch, n);
      std::vector<Described> batch = searcher.batch(s, begin, end);
      for (std::size_t i = 0; i < batch.size(); ++i) {
        searcher.add(s, static_cast<KeyframeId>(begin + i), batch[i]);
        search.descriptors[s].push_back(batch[i].descriptors.empty() ? Descriptor() : batch[i].descriptors.front());
        for (std::size_t a = 0; a < s; ++a)
          search.found[s][a].insert(search.found[s][a].end(), batch[i].found[a].begin(), batch[i].found[a].end());
      }
      progress(done += end - begin);
    }
  }
  return search;
}

}  // namespace scslam
