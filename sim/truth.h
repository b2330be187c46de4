// What is true about a drive through a world: which places are revisited, how much of them is seen again, and which
// places only look alike.
#pragma once
#include <string>
#include <vector>

#include "scslam/core/parallel.h"
#include "sim/ray_scene.h"
#include "sim/scenario.h"
#include "sim/trajectory.h"

namespace scslam::sim {

struct Place {
  std::uint32_t scan = 0;  ///< index in the rawlog of the scan taken there
  double t = 0;            ///< [s] into the drive
  double travel_m = 0;
  Pose T_world_base, T_world_sensor;
};

struct Revisit {
  std::size_t a = 0, b = 0;                ///< places, a earlier
  double distance_m = 0, heading_deg = 0;  ///< heading of b minus that of a, -180 … 180
  double lateral_m = 0;                    ///< of b to the left of a
  double overlap_a = 0, overlap_b = 0;     ///< share of what a (b) sees that b (a) sees, too
};

struct Alias {
  std::size_t a = 0, b = 0;
  double difference = 0;  ///< mean |ln(range of a / range of b)| around both: 0 = the same
};

/// Scans at least `every_m` of way apart. @param sweeps numbers of the sweeps in the rawlog; a place's scan is the
/// index into them.
std::vector<Place> placesOf(const Trajectory& drive, const Pose& T_base_sensor, double sweep_s,
                            const std::vector<std::uint32_t>& sweeps, double every_m);
/// Pairs within 10 m of each other with more than min_travel_m of way between them, sorted by (a, b).
std::vector<Revisit> revisits(const std::vector<Place>& places, const RayScene& scene, double max_range_m,
                              double min_travel_m, ThreadPool& threads);
/// Pairs more than 10 m apart that see nearly the same shape around them (any heading in steps of 5 deg), sorted.
std::vector<Alias> aliases(const std::vector<Place>& places, const RayScene& scene, double max_range_m,
                           ThreadPool& threads);

std::string revisitsCsv(const std::vector<Place>& places, const std::vector<Revisit>& revisits);
std::string aliasesCsv(const std::vector<Place>& places, const std::vector<Alias>& aliases);

}  // namespace scslam::sim
