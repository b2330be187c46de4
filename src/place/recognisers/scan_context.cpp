// Augmented Polar Context (A-PC): G. Kim, S. Choi, A. Kim, "Scan Context++" (T-RO 2021), Sec. IV and V; re-implemented
// from the paper.
//
// Turning the robot shifts the columns of its polar image, so the best shift of the column-wise cosine distance is both
// the similarity and the heading difference. The image changes with the position across the street, so the query asks
// as well as if it stood some metres to the left and to the right; heading and offset of the best copy are where the
// registration starts.
#include <cmath>
#include <deque>

#include "scslam/place/context_image.h"
#include "scslam/place/context_index.h"
#include "scslam/place/packed_image.h"
#include "scslam/place/place_choice.h"

namespace scslam {
namespace {

class ScanContext : public PlaceRecogniser {
 public:
  struct Params : ParamSetOf<Params> {
    PolarGrid grid;
    int candidates_by_key = 50;
    double lateral_reach_m = 4, lateral_step_m = 1, min_common = 0.5, column_weight = 0.5, outline_cell_m = 0.5;
    bool log_heights = false;
    PlaceChoiceParams choice;
    void describe(ParamVisitor& v) override {
      v.field("rings", grid.rings, "bins along the range", 4, 200);
      v.field("sectors", grid.sectors, "bins around the sensor", 8, 64);
      v.field("max_radius_m", grid.max_radius_m, "range of the outermost bin [m]", 1, 500);
      v.field("lateral_reach_m", lateral_reach_m,
              "places are also recognised this far to the left and right; 0: only near the same line [m]", 0, 50);
      v.field("lateral_step_m", lateral_step_m, "distance of the shifted copies within that reach [m]", 0.1, 50);
      v.field("outline_cell_m", outline_cell_m, "cells whose highest points make the shifted copies [m]", 0.1, 10);
      v.field("candidates_by_key", candidates_by_key, "places compared in full, for each copy", 1, 100000);
      v.field("min_common", min_common, "share of the narrower view that both scans must have seen", 0.01, 1);
      v.field("log_heights", log_heights, "compare log(1 + height) instead of heights");
      v.field("column_weight", column_weight,
              "power of its length by which a column counts: 0 all alike, as in the paper; 1 as it is", 0, 1);
      choice.describe(v);
    }
  };

  ScanContext(const Params& params, const PluginContext&)
      : params_(params),
        places_(params.choice),
        index_({.rows = static_cast<std::size_t>(params.grid.rings),
                .columns = static_cast<std::size_t>(params.grid.sectors),
                .circular = true,
                .max_shift = 0,
                .logarithmic = params.log_heights,
                .min_common = params.min_common,
                .column_weight = params.column_weight}) {
    const int steps = static_cast<int>(std::floor(params.lateral_reach_m / params.lateral_step_m + 1e-9));
    for (int step = 1; step <= steps; ++step)
      for (const int side : {1, -1}) shifts_left_m_.push_back(side * step * params.lateral_step_m);
  }

  Descriptor describe(const Keyframe& keyframe, const Cloud& cloud_base) const override {
    return polarContext(cloud_base, uprightOf(keyframe, cloud_base), params_.grid);
  }

  void add(const Keyframe& keyframe, const Descriptor& descriptor, const Cloud& cloud_base) override {
    const Descriptor image = imageOf(keyframe, descriptor, cloud_base);
    places_.add(keyframe);
    index_.add(index_.probe(image));
    copies_.push_back(shiftedCopies(keyframe, image, cloud_base));
  }

  std::vector<PlaceCandidate> query(KeyframeId k) const override {
    const std::size_t eligible = places_.eligibleBefore(k);
    return eligible == 0 ? std::vector<PlaceCandidate>() : among(eligible, places_[k], index_.place(k), copies_[k]);
  }

  std::vector<PlaceCandidate> find(const Keyframe& keyframe, const Descriptor& descriptor,
                                   const Cloud& cloud_base) const override {
    if (places_.size() == 0) return {};
    const Descriptor image = imageOf(keyframe, descriptor, cloud_base);
    return among(places_.size(), keyframe, index_.probe(image), shiftedCopies(keyframe, image, cloud_base));
  }

 private:
  Descriptor imageOf(const Keyframe& keyframe, const Descriptor& descriptor, const Cloud& cloud_base) const {
    Descriptor image = descriptor.size() > 0 ? descriptor : describe(keyframe, cloud_base);
    if (image.rows() != params_.grid.rings || image.cols() != params_.grid.sectors)
      throw inputError("keyframe {}: the descriptor is {} x {}, the configuration says {} x {}", keyframe.id,
                       image.rows(), image.cols(), params_.grid.rings, params_.grid.sectors);
    return image;
  }

  std::vector<PlaceCandidate> among(std::size_t eligible, const Keyframe& query, const ContextProbe& seen,
                                    const std::vector<PackedImage>& copies) const {
    std::vector<PlaceCandidate> ranking;
    rank(seen, 0, eligible, ranking);
    for (std::size_t i = 0; i < copies.size(); ++i)
      rank(index_.probe(unpack(copies[i], params_.grid.rings, params_.grid.sectors)), shifts_left_m_[i], eligible,
           ranking);
    return places_.inBaseFrames(places_.choose(std::move(ranking)), query);
  }

  std::vector<PackedImage> shiftedCopies(const Keyframe& keyframe, const Descriptor& image,
                                         const Cloud& cloud_base) const {
    std::vector<PackedImage> copies;
    if (shifts_left_m_.empty()) return copies;
    const double reach = params_.grid.max_radius_m + params_.lateral_reach_m;
    const Cloud tops = cloud_base.empty()
                           ? Cloud()
                           : outline(cloud_base, uprightOf(keyframe, cloud_base), params_.outline_cell_m, reach);
    for (const double left_m : shifts_left_m_)
      copies.push_back(pack(cloud_base.empty() ? polarContext(image, params_.grid, left_m)
                                               : polarContext(tops, Upright(), params_.grid, left_m)));
    return copies;
  }

  /// Compares a copy of the query, seen from left_m to its left, with the eligible places.
  void rank(const ContextProbe& probe, double left_m, std::size_t eligible,
            std::vector<PlaceCandidate>& ranking) const {
    std::vector<ContextIndex::Match> matches;
    index_.search(probe, eligible, static_cast<std::size_t>(params_.candidates_by_key), matches);
    for (const auto& match : matches) {
      const double yaw = match.shift * 2 * M_PI / params_.grid.sectors;
      const Eigen::Vector3d t(left_m * std::sin(yaw), -left_m * std::cos(yaw), 0);  // base, seen from the copy, turned
      ranking.push_back({static_cast<KeyframeId>(match.id), match.distance, poseFromYaw(yaw, t), 0});
    }
  }

  Params params_;
  VisitedPlaces places_;
  ContextIndex index_;
  std::vector<double> shifts_left_m_;
  std::deque<std::vector<PackedImage>> copies_;  ///< of each place, one per shift
};

}  // namespace

SCSLAM_REGISTER(PlaceRecogniser, ScanContext, "scan_context",
                "Scan Context++, polar 20 x 60 with laterally shifted copies: any heading, nearby lanes")

}  // namespace scslam
