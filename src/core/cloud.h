// A point cloud as a structure of arrays, the layout every kernel reads.
#pragma once
#include <cstddef>
#include <cstdint>
#include <vector>

#include "scslam/core/bytes.h"
#include "scslam/core/pose.h"

namespace scslam {

struct Cloud {
  std::vector<float> x, y, z;       ///< [m], in the frame its owner states
  std::vector<float> intensity;     ///< as the sensor gave it; empty or size()
  std::vector<float> dt;            ///< [s] after the scan's stamp; empty or size()
  std::vector<std::uint16_t> ring;  ///< laser number, 0 = lowest; empty or size()

  std::size_t size() const { return x.size(); }
  bool empty() const { return x.empty(); }
  bool hasIntensity() const { return !intensity.empty(); }
  bool hasTime() const { return !dt.empty(); }
  bool hasRing() const { return !ring.empty(); }
  Eigen::Vector3f point(std::size_t i) const { return {x[i], y[i], z[i]}; }

  void clear();
  void reserve(std::size_t n);
  void resize(std::size_t n);  ///< coordinates only; optional fields are resized where they are present
  void push(float px, float py, float pz) { x.push_back(px), y.push_back(py), z.push_back(pz); }
  /// Appends point i of `other` with the optional fields this cloud has (absent ones become 0).
  void pushFrom(const Cloud& other, std::size_t i);
  /// Keeps the points with keep[i] != 0, in order.
  void filter(const std::vector<std::uint8_t>& keep);
};

/// `cloud` with its coordinates mapped by T_a_b (from frame b to frame a); the other fields are copied.
Cloud transformed(const Cloud& cloud_b, const Pose& T_a_b);
void transformInPlace(Cloud& cloud, const Pose& T_a_b);
/// The same where the frames differ in scale, too.
void transformInPlace(Cloud& cloud, const Eigen::Affine3d& A_a_b);
/// All fields, for odometry's checkpoints.
void saveCloud(ByteWriter& state, const Cloud& cloud);
/// @throw inputError when the fields differ in length.
void loadCloud(ByteReader& state, Cloud& cloud);
/// Drops points with a NaN or infinite coordinate. @return how many were dropped.
std::size_t dropNonFinite(Cloud& cloud);

}  // namespace scslam
