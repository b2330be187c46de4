// Augmented Cart Context (A-CC): G. Kim, S. Choi, A. Kim, "Scan Context++" (T-RO 2021), Sec. IV and V; re-implemented
// from the paper.
//
// Changing the lane shifts the columns of the Cartesian image, so lane changes wide enough to spoil the polar image are
// found here, with the offset as the registration's start. It stands for one driving direction; the copy flipped in
// both axes finds the street driven the other way.
#include <cmath>
#include <deque>

#include "scslam/place/context_image.h"
#include "scslam/place/context_index.h"
#include "scslam/place/packed_image.h"
#include "scslam/place/place_choice.h"

namespace scslam {
namespace {

class CartContext : public PlaceRecogniser {
 public:
  struct Params : ParamSetOf<Params> {
    CartGrid grid{.rows = 40, .columns = 40, .reach_ahead_m = 60, .reach_aside_m = 40};
    int candidates_by_key = 50;
    double max_offset_m = 10, min_common = 0.5, column_weight = 0.5;
    bool log_heights = true;
    PlaceChoiceParams choice;
    void describe(ParamVisitor& v) override {
      v.field("rows", grid.rows, "bins along the driving direction", 4, 200);
      v.field("columns", grid.columns, "bins across it; with those of max_offset_m at most 64", 4, 60);
      v.field("reach_ahead_m", grid.reach_ahead_m, "the image reaches this far ahead and back [m]", 1, 500);
      v.field("reach_aside_m", grid.reach_aside_m, "and this far to either side [m]", 1, 500);
      v.field("max_offset_m", max_offset_m, "widest lane change that is looked for [m]", 0, 100);
      v.field("candidates_by_key", candidates_by_key, "places compared in full, for each driving direction", 1, 100000);
      v.field("min_common", min_common, "share of the narrower view that both scans must have seen", 0.01, 1);
      v.field("log_heights", log_heights, "compare log(1 + height) instead of heights");
      v.field("column_weight", column_weight,
              "power of its length by which a column counts: 0 all alike, as in the paper; 1 as it is", 0, 1);
      choice.describe(v);
    }
  };

  CartContext(const Params& params, const PluginContext&)
      : params_(params), places_(params.choice), index_(layoutOf(params)) {}

  Descriptor describe(const Keyframe& keyframe, const Cloud& cloud_base) const override {
    return cartContext(cloud_base, uprightOf(keyframe, cloud_base), params_.grid);
  }

  void add(const Keyframe& keyframe, const Descriptor& descriptor, const Cloud& cloud_base) override {
    const Descriptor image = imageOf(keyframe, descriptor, cloud_base);
    places_.add(keyframe);
    index_.add(index_.probe(image));
    images_.push_back(pack(image));
  }

  std::vector<PlaceCandidate> query(KeyframeId k) const override {
    const std::size_t eligible = places_.eligibleBefore(k);
    if (eligible == 0) return {};
    return among(eligible, places_[k], index_.place(k), unpack(images_[k], params_.grid.rows, params_.grid.columns));
  }

  std::vector<PlaceCandidate> find(const Keyframe& keyframe, const Descriptor& descriptor,
                                   const Cloud& cloud_base) const override {
    if (places_.size() == 0) return {};
    const Descriptor image = imageOf(keyframe, descriptor, cloud_base);
    return among(places_.size(), keyframe, index_.probe(image), image);
  }

 private:
  Descriptor imageOf(const Keyframe& keyframe, const Descriptor& descriptor, const Cloud& cloud_base) const {
    Descriptor image = descriptor.size() > 0 ? descriptor : describe(keyframe, cloud_base);
    if (image.rows() != params_.grid.rows || image.cols() != params_.grid.columns)
      throw inputError("keyframe {}: the descriptor is {} x {}, the configuration says {} x {}", keyframe.id,
                       image.rows(), image.cols(), params_.grid.rows, params_.grid.columns);
    return image;
  }

  std::vector<PlaceCandidate> among(std::size_t eligible, const Keyframe& query, const ContextProbe& seen,
                                    const Descriptor& image) const {
    std::vector<PlaceCandidate> ranking;
    rank(seen, 0, eligible, ranking);
    rank(index_.probe(image.reverse()), M_PI, eligible, ranking);
    return places_.inBaseFrames(places_.choose(std::move(ranking)), query);
  }

  static ContextLayout layoutOf(const Params& params) {
    const double column_m = 2 * params.grid.reach_aside_m / params.grid.columns;
    const double shift = std::ceil(params.max_offset_m / column_m);
    if (params.grid.columns + shift > static_cast<double>(ColumnSpectra::kMaxColumns))
      throw usageError("cart_context: {} columns and {:.0f} for max_offset_m are more than {}: make the columns wider",
                       params.grid.columns, shift, ColumnSpectra::kMaxColumns);
    return {.rows = static_cast<std::size_t>(params.grid.rows),
            .columns = static_cast<std::size_t>(params.grid.columns),
            .circular = false,
            .max_shift = static_cast<std::size_t>(shift),
            .logarithmic = params.log_heights,
            .min_common = params.min_common,
            .column_weight = params.column_weight};
  }

  void rank(const ContextProbe& probe, double yaw, std::size_t eligible, std::vector<PlaceCandidate>& ranking) const {
    std::vector<ContextIndex::Match> matches;
    index_.search(probe, eligible, static_cast<std::size_t>(params_.candidates_by_key), matches);
    const double column_m = 2 * params_.grid.reach_aside_m / params_.grid.columns;
    for (const auto& match : matches)
      ranking.push_back(
          {static_cast<KeyframeId>(match.id), match.distance, poseFromYaw(yaw, {0, match.shift * column_m, 0}), 0});
  }

  Params params_;
  VisitedPlaces places_;
  ContextIndex index_;
  std::deque<PackedImage> images_;  ///< to be flipped
};

}  // namespace

SCSLAM_REGISTER(PlaceRecogniser, CartContext, "cart_context",
                "Scan Context++, Cartesian 40 x 40 and flipped: wide lane changes, the same street either way")

}  // namespace scslam
