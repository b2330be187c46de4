// Things that stand about in worlds: cars, trees, lamp posts, people. Each is a thing of its own (instance number).
//
// Poses are T_world_prop: origin on the ground in the middle of the thing, x forward (the way it drives or looks),
// z up. Each call takes the same few numbers from `random` whatever it builds, so that changing one thing (bare trees
// in winter, a van instead of a car) leaves the rest of a world as it was.
#pragma once
#include "sim/mesh_builder.h"

namespace scslam::sim {

enum class CarBody { kAny, kCar, kVan };

/// Body, windows, four wheels, number plates and rear reflectors. Cars 3.7 … 4.8 x 1.7 … 1.85 x 1.42 … 1.65 m, vans
/// 5 … 5.9 x 1.95 … 2.05 x 2 … 2.4 m; of kAny every eighth is a van. About 300 triangles.
void addCar(MeshBuilder& builder, const Pose& T_world_car, RandomSequence& random, CarBody body = CarBody::kAny);
/// City bus, 12 x 2.55 x 3.1 m.
void addBus(MeshBuilder& builder, const Pose& T_world_bus, RandomSequence& random);
/// Bicycle of 1.75 m, alone …
void addBicycle(MeshBuilder& builder, const Pose& T_world_bicycle, RandomSequence& random);
/// … and ridden.
void addCyclist(MeshBuilder& builder, const Pose& T_world_bicycle, RandomSequence& random);
/// Somebody walking, 1.55 … 1.9 m tall.
void addPerson(MeshBuilder& builder, const Pose& T_world_person, RandomSequence& random);

/// Broad-leaved tree: trunk, branches and a crown of clumps of leaves, a third of the height wide to each side.
/// @param height [m]. @param leaf_share 1 summer (about 2500 triangles), 0 bare.
void addTree(MeshBuilder& builder, const Eigen::Vector3d& base, double height, RandomSequence& random,
             double leaf_share = 1);
/// Rounded bush of leaves, about as wide as high. @param height [m].
void addBush(MeshBuilder& builder, const Eigen::Vector3d& base, double height, RandomSequence& random,
             double leaf_share = 1);

/// Lamp post of 5 … 9 m with an arm that reaches 1.6 m forward (x) and a lamp.
void addPole(MeshBuilder& builder, const Pose& T_world_pole, RandomSequence& random);
/// Traffic sign on a post of 2.2 … 2.6 m; its retro-reflecting face looks along x.
void addSign(MeshBuilder& builder, const Pose& T_world_sign, RandomSequence& random);
/// Signals for those who come from along x: post, box of three lamps with a backing board.
void addTrafficLight(MeshBuilder& builder, const Pose& T_world_light, RandomSequence& random);
/// Street bench, 1.8 m wide; who sits there looks along x.
void addBench(MeshBuilder& builder, const Pose& T_world_bench, RandomSequence& random);
/// Litter or wheeled bin, 0.8 … 1.2 m high.
void addBin(MeshBuilder& builder, const Pose& T_world_bin, RandomSequence& random);

enum class FenceKind {
  kBars,      ///< posts every 2.5 m, two rails and upright bars every 14 cm: rays pass between
  kRails,     ///< posts every 2.5 m and three rails, as around a meadow
  kGuardRail  ///< posts every 4 m and one band of steel 0.31 m high on the left seen from a to b
};
/// Fence from a to b (on the ground), `height` [m] high.
void addFence(MeshBuilder& builder, const Eigen::Vector3d& a, const Eigen::Vector3d& b, double height,
              FenceKind kind = FenceKind::kBars);

}  // namespace scslam::sim
