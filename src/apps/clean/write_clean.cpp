#include "scslam/apps/clean/write_clean.h"

#include "scslam/session/layout.h"
#include "scslam/session/session_graph.h"

namespace scslam {
namespace fs = std::filesystem;

CleanedSession::CleanedSession(const SavedMap& map, const fs::path& folder, const PlaceParams& place,
                               const PluginContext& context)
    : map_(map),
      recogniser_(std::move(place.recognisers.create(context).front())),
      writer_(SessionWriter::create(folder, map.session().info(), false)) {}

Descriptor CleanedSession::describe(KeyframeId k, const Cloud& cloud_sensor) const {
  if (!recogniser_->usesScans()) return {};
  return recogniser_->describe(map_.keyframes()[k], transformed(cloud_sensor, map_.session().info().T_base_sensor));
}

void CleanedSession::add(KeyframeId k, const Cloud& cloud_sensor, const Descriptor& descriptor) {
  writer_->addKeyframe(map_.keyframes()[k], map_.poses()[k], cloud_sensor, descriptor);
}

void CleanedSession::finish() {
  for (const ScanRecord& scan : map_.scans()) writer_->addScan(scan);
  for (const LoopRecord& loop : map_.loops()) writer_->addLoop(loop);
  for (const GnssRecord& fix : map_.gnss()) writer_->addGnss(fix);
  writer_->setPoses(map_.poses());
  writer_->finish(buildGraph(map_.keyframes(), map_.loops(), map_.poses(), map_.session().info().planar));
  if (map_.keyframesWithoutScan() > 0) return;  // their numbers would be wrong
  for (const char* name : {layout::kParents, layout::kKeyframeParents, layout::kLtMapper})
    if (const fs::path file = map_.session().folder() / name; fs::exists(file))
      fs::copy(file, writer_->folder() / name, fs::copy_options::recursive);
}

}  // namespace scslam
