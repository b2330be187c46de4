// A yard with a parked car and a moving one, seen by a spinning sensor: sessions to clean and their true labels.
#pragma once
#include <fstream>

#include "apps/session_of.h"
#include "odometry/spinning.h"
#include "session/memory_folder.h"

namespace scslam::test {

struct CleanScene {
  std::filesystem::path session, labels;
  std::vector<Box> moving;  ///< by keyframe
};

inline Box parkedCar() { return {{2, -7, 0.3}, {6, -5.2, 1.5}}; }

/// 48 x 24 x 12 m with two buildings, a pole and a parked car.
inline BoxWorld yard() {
  return {{{{-24, -12, 0}, {24, 12, 12}},
           {{-15, 8, 0}, {-5, 12, 5}},
           {{8, 8, 0}, {14, 12, 6}},
           {{-2, 6, 0}, {-1.7, 6.3, 4}},
           parkedCar()}};
}

/// @param T_world_base where the scans are taken. @param moving where the moving car is then; it stands 0.3 m over the
/// ground. Labels are written as the SemanticKITTI ones: 252 moves, 10 stands, 0 where the noise leaves it open.
inline CleanScene cleanScene(const std::string& name, const std::vector<Pose>& T_world_base,
                             const std::vector<Box>& moving) {
  static const std::filesystem::path root = memoryFolder() / "clean";
  const CleanScene scene{root / name, root / (name + "-labels"), moving};
  std::filesystem::create_directories(scene.labels);
  std::vector<Cloud> clouds;
  for (std::size_t k = 0; k < T_world_base.size(); ++k) {
    BoxWorld world = yard();
    world.boxes.push_back(moving[k]);
    clouds.push_back(spunAt(k, T_world_base[k], world, {48, 720, -0.42, 0.1, 0.01}).cloud);
    std::ofstream file(scene.labels / fmt::format("{:06}.label", k), std::ios::binary);
    const Pose T = T_world_base[k] * T_base_sensor();
    for (std::size_t i = 0; i < clouds[k].size(); ++i) {
      const Eigen::Vector3d p = T * clouds[k].point(i).cast<double>();
      const double outside = (moving[k].low - p).cwiseMax(p - moving[k].high).maxCoeff();
      const std::uint32_t label = outside < 0.03 ? 252 : outside < 0.1 ? 0 : 10;
      file.write(reinterpret_cast<const char*>(&label), 4);
    }
  }
  SessionParts parts{T_world_base, T_world_base};
  parts.cloud_sensor = [&clouds](std::size_t k) { return clouds[k]; };
  parts.T_base_sensor = T_base_sensor();
  sessionOf(scene.session, parts);
  return scene;
}

inline Box carAt(double x, double y) { return {{x - 2, y - 0.9, 0.3}, {x + 2, y + 0.9, 1.5}}; }

/// The sensor drives along the yard; a car comes towards it.
inline const CleanScene& passingCar() {
  static const CleanScene scene = [] {
    std::vector<Pose> poses;
    std::vector<Box> cars;
    for (int k = 0; k < 24; ++k) {
      poses.push_back(poseFromYaw(0.02 * k, {-12 + 0.8 * k, -1, 0}));
      cars.push_back(carAt(18 - 1.6 * k, 3));
    }
    return cleanScene("passing", poses, cars);
  }();
  return scene;
}

}  // namespace scslam::test
