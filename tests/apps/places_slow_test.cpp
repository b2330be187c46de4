// Recognition alone in simulated streets: the same lane, the other direction, the lane beside.
#include <iostream>

#include "scslam/apps/place_recognition_source.h"
#include "support/simulated_drive.h"

namespace scslam::test {
namespace {

namespace fs = std::filesystem;

/// Figures of scan_context on the scenario's keyframes at their true places.
PlaceFigures figuresOn(const std::string& scenario, const fs::path& folder) {
  simulateDrive(sim::loadScenario(scenario, {"truth.pictures=false"}), folder);
  const SlamParams params;
  PlaceOptions options;
  options.registration = params.registration;
  PlaceExperiment experiment({placeVariant("scan_context", params, options)}, options, context(2));
  const auto source = openSource((folder / "drive.rawlog").string(), context(2)).source;
  addInput(experiment, *source, readTrajectory(folder / "drive.gt.tum"), true, params, context(2), std::nullopt, true);
  return experiment.figures().front();
}

struct Shares {
  std::size_t revisits = 0;
  double first = 0, sure = 0;  ///< recall@1; recall at the threshold that lets no false one pass
};

/// Of the revisits with this difference of headings and at most `to_m` aside.
Shares within(const PlaceFigures& figures, int heading_deg, double to_m) {
  Shares all;
  for (const SplitCell& cell : figures.split) {
    if (cell.heading_deg != heading_deg || cell.to_m > to_m || cell.revisits == 0) continue;
    const auto n = static_cast<double>(cell.revisits);
    all.first += n * *cell.recall_at_1, all.sure += n * *cell.recall_full;
    all.revisits += cell.revisits;
  }
  all.first /= static_cast<double>(all.revisits), all.sure /= static_cast<double>(all.revisits);
  return all;
}

TEST(PlacesInTown, FourOfFiveRevisitsAreRecognisedWithoutAFalseOneFromTheSameLaneTheOtherWayAndTheLaneBeside) {
  struct Case {
    const char* scenario;
    int heading_deg;
    double aside_m;
  };
  for (const auto& [scenario, heading_deg, aside_m] :
       {Case{"s01_loop", 0, 1}, Case{"s03_reverse", 180, 3}, Case{"s04_lane_change", 0, 5}}) {
    const Shares shares = within(figuresOn(scenario, freshFolder() / scenario), heading_deg, aside_m);
    std::cout << fmt::format("{}, {} deg, {} m aside: recall@1 {:.2f}, at full precision {:.2f} of {}\n", scenario,
                             heading_deg, aside_m, shares.first, shares.sure, shares.revisits);
    EXPECT_GE(shares.revisits, 30u);
    EXPECT_GE(shares.sure, 0.8) << scenario;
  }
}

}  // namespace
}  // namespace scslam::test
