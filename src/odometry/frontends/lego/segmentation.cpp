#include "scslam/odometry/frontends/lego/segmentation.h"

#include <algorithm>
#include <cmath>

namespace scslam::lego {

void SegmentationParams::describe(ParamVisitor& visitor) {
  visitor.field("columns", columns, "columns of the range image, a full turn; 0: as dense as the fullest ring", 0,
                16384);
  visitor.field("ground_slope_deg", ground_slope_deg, "ground is flatter than this between one ring and the next", 0.0,
                89.0);
  visitor.field("ground_elevation_deg", ground_elevation_deg, "ground is looked for below this elevation", -90.0, 90.0);
  visitor.field("cluster_angle_deg", cluster_angle_deg,
                "neighbours belong together when the line through both is steeper than this to the beam", 1.0, 89.0);
  visitor.field("cluster_points", cluster_points, "a cluster has so many points …", 1, 100000);
  visitor.field("thin_points", thin_points, "… or so many …", 1, 100000);
  visitor.field("thin_rows", thin_rows, "… that span so many rings", 1, 512);
}

namespace {

constexpr std::uint32_t kEmpty = ~std::uint32_t{0};

/// The scan as an image: rows are rings, columns directions of the sensor's turn. A cell holds its nearest point.
class RangeImage {
 public:
  RangeImage(const Cloud& cloud_base, const ScanRings& rings, const Pose& T_base_sensor, int columns)
      : rows_(rings.count()), p_(cloud_base.size()), turn_(cloud_base.size()) {
    const Eigen::Isometry3f T_sensor_base = T_base_sensor.inverse().cast<float>();
    for (std::size_t i = 0; i < p_.size(); ++i) {
      p_[i] = T_sensor_base * cloud_base.point(i);
      turn_[i] = turnOf(p_[i]);
    }
    columns_ = columns > 0 ? static_cast<std::size_t>(columns) : densest(rings);
    cells_.assign(rows_ * columns_, kEmpty);
    for (std::size_t r = 0; r < rows_; ++r) {
      for (std::size_t k = 0; k < rings.size(r); ++k) {
        const std::uint32_t i = rings.ring(r)[k];
        const auto column = static_cast<std::size_t>(turn_[i] * 0.25f * static_cast<float>(columns_));
        std::uint32_t& cell = cells_[r * columns_ + std::min(column, columns_ - 1)];
        if (cell == kEmpty || p_[i].squaredNorm() < p_[cell].squaredNorm()) cell = i;
      }
    }
  }
  std::size_t rows() const { return rows_; }
  std::size_t columns() const { return columns_; }
  std::uint32_t at(std::size_t row, std::size_t column) const { return cells_[row * columns_ + column]; }
  /// The point in the sensor frame.
  const Eigen::Vector3f& point(std::uint32_t i) const { return p_[i]; }

 private:
  /// Place in the turn, in quarters [0, 4): monotone in the azimuth, without an arc tangent.
  static float turnOf(const Eigen::Vector3f& p) {
    const float sum = std::abs(p.x()) + std::abs(p.y());
    const float u = sum > 0 ? p.y() / sum : 0.0f;
    return p.x() < 0 ? 2.0f - u : u >= 0 ? u : 4.0f + u;
  }
  std::size_t densest(const ScanRings& rings) const {
    std::size_t fullest = 0;
    for (std::size_t r = 1; r < rows_; ++r)
      if (rings.size(r) > rings.size(fullest)) fullest = r;
    std::vector<float> steps;
    for (std::size_t k = 1; k < rings.size(fullest); ++k)
      steps.push_back(std::abs(turn_[rings.ring(fullest)[k]] - turn_[rings.ring(fullest)[k - 1]]));
    if (steps.empty()) return 360;
    std::nth_element(steps.begin(), steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2), steps.end());
    return static_cast<std::size_t>(std::clamp(4.0f / std::max(steps[steps.size() / 2], 1e-6f), 180.0f, 4096.0f));
  }

  std::size_t rows_, columns_ = 0;
  std::vector<Eigen::Vector3f> p_;
  std::vector<float> turn_;
  std::vector<std::uint32_t> cells_;
};

void findGround(const Cloud& cloud_base, const RangeImage& image, const Eigen::Vector3f& origin,
                const SegmentationParams& params, std::vector<Segment>& segments) {
  const auto slope = static_cast<float>(std::tan(params.ground_slope_deg * M_PI / 180));
  const auto elevation = static_cast<float>(std::tan(params.ground_elevation_deg * M_PI / 180));
  const auto low = [&](std::uint32_t i) {
    const Eigen::Vector3f p = cloud_base.point(i) - origin;
    return p.z() < elevation * p.head<2>().norm();
  };
  for (std::size_t column = 0; column < image.columns(); ++column) {
    for (std::size_t row = 0; row + 1 < image.rows(); ++row) {
      const std::uint32_t a = image.at(row, column), b = image.at(row + 1, column);
      if (a == kEmpty || b == kEmpty || !low(a) || !low(b)) continue;
      const Eigen::Vector3f step = cloud_base.point(b) - cloud_base.point(a);
      if (std::abs(step.z()) > slope * step.head<2>().norm()) continue;
      segments[a] = segments[b] = Segment::kGround;
    }
  }
}

/// Grows clusters from cell to neighbouring cell; small ones stay clutter.
class Clusters {
 public:
  Clusters(const RangeImage& image, const SegmentationParams& params, std::vector<Segment>& segments)
      : image_(image),
        params_(params),
        segments_(segments),
        tangent_(static_cast<float>(std::tan(params.cluster_angle_deg * M_PI / 180))),
        seen_(image.rows() * image.columns()) {}

  void find() {
    for (std::size_t row = 0; row < image_.rows(); ++row)
      for (std::size_t column = 0; column < image_.columns(); ++column)
        if (open(row, column)) grow(row, column);
  }

 private:
  bool open(std::size_t row, std::size_t column) const {
    const std::uint32_t i = image_.at(row, column);
    return i != kEmpty && segments_[i] != Segment::kGround && seen_[row * image_.columns() + column] == 0;
  }

  /// Is the line through both points steep enough to the longer beam?
  bool together(std::uint32_t i, std::uint32_t j) const {
    const Eigen::Vector3f &a = image_.point(i), &b = image_.point(j);
    const float far2 = std::max(a.squaredNorm(), b.squaredNorm());
    return a.cross(b).norm() > tangent_ * (far2 - a.dot(b));
  }

  void visit(std::size_t row, std::size_t column) {
    seen_[row * image_.columns() + column] = 1;
    queue_.push_back(static_cast<std::uint32_t>(row * image_.columns() + column));
  }

  void grow(std::size_t first_row, std::size_t first_column) {
    const std::size_t columns = image_.columns();
    queue_.clear();
    visit(first_row, first_column);
    std::size_t lowest = first_row, highest = first_row;
    for (std::size_t next = 0; next < queue_.size();) {  // it grows
      const std::size_t pixel = queue_[next++], row = pixel / columns, column = pixel % columns;
      lowest = std::min(lowest, row), highest = std::max(highest, row);
      const std::uint32_t i = image_.at(row, column);
      const auto reach = [&](std::size_t r, std::size_t c) {
        if (open(r, c) && together(i, image_.at(r, c))) visit(r, c);
      };
      if (row > 0) reach(row - 1, column);
      if (row + 1 < image_.rows()) reach(row + 1, column);
      reach(row, (column + 1) % columns);
      reach(row, (column + columns - 1) % columns);
    }
    const auto least = [](int n) { return static_cast<std::size_t>(n); };
    const bool thin = queue_.size() >= least(params_.thin_points) && highest - lowest + 1 >= least(params_.thin_rows);
    if (queue_.size() < least(params_.cluster_points) && !thin) return;
    for (const std::uint32_t cell : queue_) segments_[image_.at(cell / columns, cell % columns)] = Segment::kCluster;
  }

  const RangeImage& image_;
  const SegmentationParams& params_;
  std::vector<Segment>& segments_;
  float tangent_;
  std::vector<std::uint8_t> seen_;
  std::vector<std::uint32_t> queue_;  ///< cells of the cluster that grows
};

}  // namespace

std::vector<Segment> segment(const Cloud& cloud_base, const ScanRings& rings, const Pose& T_base_sensor,
                             const SegmentationParams& params) {
  std::vector<Segment> segments(cloud_base.size(), Segment::kClutter);
  const RangeImage image(cloud_base, rings, T_base_sensor, params.columns);
  findGround(cloud_base, image, T_base_sensor.translation().cast<float>(), params, segments);
  Clusters(image, params, segments).find();
  return segments;
}

}  // namespace scslam::lego
