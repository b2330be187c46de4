#include <cmath>
#include <limits>

#include "scslam/graph/initial_guess.h"

namespace scslam::detail {

std::string chooseStart(PoseGraph& graph, const GraphStructure& structure, const std::string& init,
                        const Weighting& judge, bool odometry_first) {
  const std::vector<Pose> given = graph.poses;
  std::vector<Pose> best = given;
  double lowest = std::numeric_limits<double>::infinity();
  std::string start = "file";
  const auto consider = [&](const char* name) {
    const double cost = judge.cost(graph);
    if (std::isfinite(cost) && cost < lowest) {
      lowest = cost;
      best = graph.poses;
      start = name;
    }
    graph.poses = given;
  };
  const bool any = init == "auto";
  if (any || init == "file") consider("file");
  if (any || init == "spanning") {
    spanningTree(graph, structure.parts, odometry_first, judge.weights);
    consider("spanning");
  }
  if (any || init == "chordal")
    if (chordal(graph, structure, judge.weights)) consider("chordal");
  graph.poses = best;
  return start;
}

}  // namespace scslam::detail
