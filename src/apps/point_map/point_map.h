// A map that somebody else made (PLY, PCD), as a session: what the verbs that compare sessions can then do with it.
#pragma once
#include <atomic>
#include <filesystem>
#include <functional>
#include <optional>

#include "scslam/apps/partial_folder.h"
#include "scslam/core/params.h"
#include "scslam/core/registry.h"

namespace scslam {

struct PointMapParams : ParamSetOf<PointMapParams> {
  double spacing_m = 4, height_m = 1.8, range_m = 80, voxel_m = 0.1;
  void describe(ParamVisitor& v) override;
};

/// Is this a file that holds a cloud of points?
bool isPointMap(const std::filesystem::path& path);

/// The input format of such a session, in its manifest. Its keyframes do not move against each other.
inline constexpr const char* kPointMap = "point map";

/// Writes a session into `folder`: the map as it is seen from places on its ground, one keyframe each, frame map = the
/// file's; stamps are whole seconds from 0 on and mean nothing.
/// @param progress called with the views done and all; may throw to end.
/// @throw inputError for a file that cannot be read, holds coordinates so large that float32 cannot resolve them, or
/// has no ground to stand on.
void writeMapSession(const std::filesystem::path& file, const std::filesystem::path& folder,
                     const PointMapParams& params, const PluginContext& context,
                     const std::function<void(std::size_t, std::size_t)>& progress);

/// Sessions of point maps beside a result that is being made; they go when this does.
class PointMapSessions {
 public:
  /// @param result they lie beside it.
  explicit PointMapSessions(const std::filesystem::path& result) : beside_(result.string() + ".maps") {}

  /// The path itself, or where it is a point map the folder of its session, with a progress bar.
  /// @param stop set: throws Error(kStopped).
  std::filesystem::path sessionFor(const std::filesystem::path& session_or_map, const PointMapParams& params,
                                   const PluginContext& context, bool quiet, const std::atomic<bool>* stop);

 private:
  std::filesystem::path beside_;
  std::optional<PartialFolder> folder_;  ///< made when the first point map comes
  std::size_t count_ = 0;
};

}  // namespace scslam
