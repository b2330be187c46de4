// One of the two sessions that cleaning makes of one.
#pragma once
#include <filesystem>
#include <memory>
#include <vector>

#include "scslam/apps/saved_map.h"

namespace scslam {

/// The same keyframes, poses, loops and fixes with other scans. Descriptors are made anew from them.
class CleanedSession {
 public:
  /// @param map outlives this. @param folder new. @param place of the session's configuration.
  CleanedSession(const SavedMap& map, const std::filesystem::path& folder, const PlaceParams& place,
                 const PluginContext& context);
  /// The descriptor of a cleaned scan; from several threads.
  Descriptor describe(KeyframeId k, const Cloud& cloud_sensor) const;
  /// In order of the keyframes, all of them.
  void add(KeyframeId k, const Cloud& cloud_sensor, const Descriptor& descriptor);
  void finish();

 private:
  const SavedMap& map_;
  std::unique_ptr<PlaceRecogniser> recogniser_;
  std::unique_ptr<SessionWriter> writer_;
};

}  // namespace scslam
