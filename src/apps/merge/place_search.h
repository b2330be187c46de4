// Which places of one session look like places of another?
#pragma once
#include <functional>
#include <vector>

#include "scslam/apps/saved_map.h"

namespace scslam {

struct FoundPlace {
  KeyframeId query = 0;  ///< of the later session
  PlaceCandidate candidate;
  std::string recogniser;
};

struct PlaceSearch {
  std::vector<std::vector<Descriptor>> descriptors;  ///< by session and keyframe: the first recogniser's
  /// By session b and earlier session a < b: what of b was found in a.
  std::vector<std::vector<std::vector<FoundPlace>>> found;
};

/// Reads every scan once. @param progress called with the keyframes done; may throw to end.
PlaceSearch searchPlaces(const std::vector<SavedMap>& maps, const PlaceParams& params, const PluginContext& context,
                         const std::function<void(std::size_t)>& progress);

}  // namespace scslam
