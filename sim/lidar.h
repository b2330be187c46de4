// A spinning LiDAR in a world: where its beams go, what they meet, what the sensor makes of it.
#pragma once
#include <vector>

#include "scslam/core/cloud.h"
#include "scslam/core/counter_random.h"
#include "scslam/core/parallel.h"
#include "scslam/sensor/sensor_model.h"
#include "sim/ray_scene.h"
#include "sim/trajectory.h"
#include "sim/weather.h"

namespace scslam::sim {

/// How the sensor is simulated; YAML group `lidar` of a scenario.
struct LidarEffects : ParamSetOf<LidarEffects> {
  bool rolling = true;     ///< the robot moves during the sweep
  bool noise = true;       ///< range noise and quantum
  bool dropout = true;     ///< echoes too weak are lost
  bool beam_width = true;  ///< several rays a beam where an edge may split it
  std::string returns = "strongest";
  void describe(ParamVisitor& visitor) override;
};

/// The directions and origins of a table's beams, in tiles of 16 that Embree traces together: 4 rings x 4 columns.
class BeamGrid {
 public:
  explicit BeamGrid(const SensorModel& sensor);
  int rings() const { return rings_; }
  int columns() const { return columns_; }
  std::size_t tiles() const { return tiles_; }
  std::size_t tilesAcross() const { return tiles_across_; }  ///< tiles that hold the same columns
  int tileColumns() const { return 1 << column_bits_; }
  /// Ring and column of a lane of a tile; ring >= rings() or column >= columns(): an empty lane.
  int ringOf(std::size_t tile, int lane) const {
    return (static_cast<int>(tile % tiles_across_) << ring_bits_) + (lane >> column_bits_);
  }
  int columnOf(std::size_t tile, int lane) const {
    return (static_cast<int>(tile / tiles_across_) << column_bits_) + (lane & ((1 << column_bits_) - 1));
  }
  std::size_t tileOf(int column, int ring) const {
    return static_cast<std::size_t>(column >> column_bits_) * tiles_across_ +
           static_cast<std::size_t>(ring >> ring_bits_);
  }
  int laneOf(int column, int ring) const {
    return (ring & ((1 << ring_bits_) - 1)) << column_bits_ | (column & ((1 << column_bits_) - 1));
  }
  /// Column in which `other` ring looks to where `ring` looks in `column` (beams of a column may be staggered).
  int sameAzimuth(int column, int ring, int other) const {
    const auto shift = [this](int r) { return shift_[static_cast<std::size_t>(r)]; };
    return (column + shift(other) - shift(ring) + columns_) % columns_;
  }
  bool isActive(int column, int ring) const {
    return (active_[tileOf(column, ring)] >> laneOf(column, ring) & 1U) != 0;
  }
  Eigen::Vector3f direction(int column, int ring) const { return lane(directions_, column, ring); }  ///< sensor frame
  Eigen::Vector3f origin(int column, int ring) const {
    return origins_.empty() ? Eigen::Vector3f::Zero() : lane(origins_, column, ring);
  }
  const float* directions(std::size_t tile) const { return &directions_[tile * 48]; }  ///< x[16] y[16] z[16], unit
  const float* times(std::size_t tile) const { return &shares_[tile * 16]; }  ///< of firing, as shares of the sweep
  const float* origins(std::size_t tile) const { return origins_.empty() ? nullptr : &origins_[tile * 48]; }
  std::uint32_t active(std::size_t tile) const { return active_[tile]; }  ///< lanes that exist and are not blind
  double columnTime(int column) const { return column * column_s_; }      ///< [s] after the start of the sweep
  double beamTime(int ring) const { return times_[static_cast<std::size_t>(ring)]; }  ///< [s] after its column began
  bool beamsHaveTimes() const { return beams_have_times_; }
  double sweep() const { return columns_ * column_s_; }  ///< [s]

 private:
  Eigen::Vector3f lane(const std::vector<float>& table, int column, int ring) const {
    const float* p = &table[tileOf(column, ring) * 48 + static_cast<std::size_t>(laneOf(column, ring))];
    return {p[0], p[16], p[32]};
  }
  void addBeam(std::size_t tile, int lane, const SensorModel& sensor);
  int rings_, columns_, ring_bits_, column_bits_;  ///< a tile has 1 << ring_bits_ rings, 16 lanes
  std::size_t tiles_across_, tiles_;
  double column_s_;
  bool beams_have_times_ = false;
  std::vector<float> directions_, origins_, shares_;
  std::vector<double> times_;
  std::vector<int> shift_;  ///< columns by which a ring's azimuth offset leads
  std::vector<std::uint32_t> active_;
};

/// One sweep as the sensor reports it, in firing order (column by column, lowest ring first).
struct LidarScan {
  Cloud cloud;                        ///< sensor frame, not deskewed; intensity, dt, ring
  std::vector<std::uint32_t> labels;  ///< per point: class in the low 16 bits, instance in the high (SemanticKITTI)
};

class Lidar {
 public:
  Lidar(SensorModel sensor, LidarEffects effects, Weather weather, std::uint64_t seed, std::uint32_t unit = 0);

  const SensorModel& sensor() const { return sensor_; }
  const BeamGrid& grid() const { return grid_; }
  std::uint64_t rays() const { return rays_; }  ///< traced so far

  /// The sweep that starts `start_s` into the drive. poseActors(start_s, start_s + sweep) is the caller's.
  /// @param number of the scan: random numbers depend on it and the seed alone.
  LidarScan scan(const RayScene& scene, const Trajectory& drive, double start_s, std::uint32_t number,
                 ThreadPool& threads);
  /// True ranges only [m], tile by tile (grid() tells which lane is which beam), infinity where nothing is met, from
  /// one pose of the sensor.
  void ranges(const RayScene& scene, const Pose& T_world_sensor, ThreadPool& threads, std::vector<float>& out) const;

  /// What the last scan() met, before the sensor's own effects: for tests and truth.
  struct Echo {
    float range = 0;   ///< [m]; 0: none
    float signal = 0;  ///< counts
    std::uint16_t label = 0, instance = 0;
  };
  const std::vector<Echo>& echoes() const { return echoes_; }  ///< [column * rings + ring]

 private:
  static constexpr std::size_t kAround = 2;  ///< rays beside the centre of a beam that may be split
  static constexpr std::size_t kBeamParts = kAround + 1;
  static constexpr std::size_t kBeamsPerPacket = 16 / kAround;
  /// A beam that an edge may split: upright (between columns) or level (between rings).
  struct SplitBeam {
    int column = 0, ring = 0;
    bool upright = true;
  };
  using SplitBeams = std::array<SplitBeam, kBeamsPerPacket>;
  struct ColumnPose {
    std::array<float, 9> R;         ///< T_world_sensor, row-major
    std::array<float, 3> t;         ///<
    std::array<float, 3> spin;      ///< angular velocity, world frame [rad/s]
    std::array<float, 3> velocity;  ///< of the sensor in the world [m/s]
  };
  /// Poses for the lanes of the tiles that hold one group of columns: rotation (9), origin (3).
  struct alignas(64) LanePoses {
    float m[12][16];
  };
  static void turn(const LanePoses& poses, const float* d, const float* o, RTCRay16& ray);
  LanePoses lanePoses(std::size_t tile) const;
  void poseColumns(const Trajectory& drive, double start_s, ThreadPool& threads);
  void aim(RayPacket& rays, std::size_t tile) const;
  void traceTile(const RayScene& scene, std::size_t tile, const LanePoses& poses);
  /// @param cosine of the ray's angle to the surface.
  Echo echoOf(const RayScene& scene, const RayPacket& rays, int lane, float cosine) const;
  /// @return rays traced.
  std::uint64_t splitBeams(const RayScene& scene, const std::vector<Echo>& centres, int first_column, int last_column);
  /// @return whether an edge may split this beam, which way.
  bool mayBeSplit(const std::vector<Echo>& centres, SplitBeam& beam) const;
  void splitSome(const RayScene& scene, const SplitBeams& beams, std::size_t n);
  void choose(std::array<Echo, kBeamParts>& parts, std::size_t beam);
  bool isLost(float signal, float u) const;
  /// What the sensor says of an echo, or that it says nothing.
  struct Beam {
    int column, ring;
    std::uint32_t draw;     ///< the how manieth echo of the beam
    float normal, uniform;  ///< random
  };
  bool report(Echo echo, const Beam& beam, std::uint32_t number, LidarScan& out, std::size_t at) const;
  void collect(int first_column, int last_column, std::uint32_t number, LidarScan& out) const;
  static LidarScan joined(const std::vector<LidarScan>& parts);

  SensorModel sensor_;
  LidarEffects effects_;
  Weather weather_;
  CounterRandom random_;
  BeamGrid grid_;
  Pose T_base_sensor_;
  std::vector<ColumnPose> columns_;
  std::uint64_t rays_ = 0;
  std::vector<Echo> echoes_, second_;  ///< second_: the other echo of a split beam
};

}  // namespace scslam::sim
