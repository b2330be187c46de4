#include "sim/props.h"

#include <functional>

#include "sim/scenery.h"
#include "worlds.h"

namespace scslam::sim {
namespace {

RandomSequence sequence(std::uint64_t seed = 1) { return RandomSequence(CounterRandom(seed, RandomStream::kWorld)); }

struct Prop {
  std::string name;
  std::function<void(MeshBuilder&, RandomSequence&)> add;
  Label label;                  ///< of a third of its surface at least
  Eigen::Vector3d least, most;  ///< size [m]
};

std::vector<Prop> props() {
  const Pose I = Pose::Identity();
  const Vector3d o = Vector3d::Zero();
  return {
      {"car", [=](auto& b, auto& r) { addCar(b, I, r, CarBody::kCar); }, Label::kCar, {3.7, 1.7, 1.4}, {4.9, 2.4, 1.7}},
      {"van", [=](auto& b, auto& r) { addCar(b, I, r, CarBody::kVan); }, Label::kCar, {5, 1.95, 2}, {6, 2.5, 2.4}},
      {"bus", [=](auto& b, auto& r) { addBus(b, I, r); }, Label::kBus, {12, 2.5, 3}, {12.1, 2.6, 3.4}},
      {"bicycle", [=](auto& b, auto& r) { addBicycle(b, I, r); }, Label::kBicycle, {1.7, 0.5, 0.9}, {1.8, 0.7, 1.2}},
      {"cyclist", [=](auto& b, auto& r) { addCyclist(b, I, r); }, Label::kPerson, {1.7, 0.5, 1.5}, {1.8, 0.8, 2.1}},
      {"person", [=](auto& b, auto& r) { addPerson(b, I, r); }, Label::kPerson, {0.2, 0.5, 1.5}, {1, 0.8, 1.95}},
      {"tree", [=](auto& b, auto& r) { addTree(b, o, 9, r); }, Label::kVegetation, {4, 4, 8.5}, {8, 8, 10.5}},
      {"bush", [=](auto& b, auto& r) { addBush(b, o, 1.2, r); }, Label::kVegetation, {0.8, 0.8, 1}, {2, 2, 1.8}},
      {"pole", [=](auto& b, auto& r) { addPole(b, I, r); }, Label::kPole, {1.6, 0.1, 5}, {2.1, 0.3, 9.6}},
      {"sign", [=](auto& b, auto& r) { addSign(b, I, r); }, Label::kPole, {0.05, 0.4, 2.3}, {0.2, 0.8, 3.2}},
      {"light", [=](auto& b, auto& r) { addTrafficLight(b, I, r); }, Label::kPole, {0.3, 0.5, 3.3}, {0.6, 0.6, 4.4}},
      {"bench", [=](auto& b, auto& r) { addBench(b, I, r); }, Label::kOtherObject, {0.4, 1.8, 0.8}, {0.6, 1.8, 0.95}},
      {"bin", [=](auto& b, auto& r) { addBin(b, I, r); }, Label::kOtherObject, {0.4, 0.4, 0.8}, {0.8, 0.7, 1.3}},
      {"fence",
       [=](auto& b, auto&) {
         addFence(b, o, {10, 0, 1}, 1.2);
       },
       Label::kFence,
       {10, 0.05, 2.2},
       {10.2, 0.2, 2.5}},
  };
}

TEST(Props, AreSoundOfTheirSizeAndTheirClass) {
  for (const Prop& prop : props())
    for (std::uint64_t seed = 1; seed <= 12; ++seed) {
      SCOPED_TRACE(prop.name);
      MeshBuilder builder;
      RandomSequence random = sequence(seed);
      prop.add(builder, random);
      const Mesh& mesh = builder.mesh();
      expectSound(mesh);
      const Vector3d size = mesh.bounds().sizes().cast<double>();
      EXPECT_TRUE((size.array() >= prop.least.array() - 1e-6).all()) << size.transpose();
      EXPECT_TRUE((size.array() <= prop.most.array() + 1e-6).all()) << size.transpose();
      double of_class = 0, whole = 0;
      for (std::size_t i = 0; i < mesh.size(); ++i) {
        const auto p = [&](std::size_t k) { return mesh.vertices[mesh.triangles[i][k]]; };
        const double area = static_cast<double>((p(1) - p(0)).cross(p(2) - p(0)).norm());
        whole += area;
        if (materials()[mesh.material[i]].label == prop.label) of_class += area;
        EXPECT_EQ(mesh.instance[i], 1);
      }
      EXPECT_GT(of_class, whole / 3);
      EXPECT_EQ(builder.instance(), 0) << "what follows is no part of it";
    }
}

TEST(Props, TakeTheSameNumbersWhateverTheyBuild) {
  const auto next = [](const std::function<void(MeshBuilder&, RandomSequence&)>& add) {
    MeshBuilder builder;
    RandomSequence random = sequence();
    add(builder, random);
    return random.uniform();
  };
  const double expected = next([](auto& b, auto& r) { addBin(b, Pose::Identity(), r); });
  EXPECT_EQ(next([](auto& b, auto& r) { addTree(b, Vector3d::Zero(), 8, r, 0); }), expected);
  for (const Prop& prop : props())
    if (prop.name != "fence") {  // it takes none
      EXPECT_EQ(next(prop.add), expected) << prop.name;
    }
}

TEST(Props, BareTreeKeepsItsTrunkAndBranches) {
  MeshBuilder summer, winter;
  RandomSequence a = sequence(), b = sequence();
  addTree(summer, Vector3d::Zero(), 8, a, 1);
  addTree(winter, Vector3d::Zero(), 8, b, 0);
  std::vector<Eigen::Vector3f> bark_summer, bark_winter;
  const auto bark = [](const Mesh& mesh, std::vector<Eigen::Vector3f>& out) {
    for (std::size_t i = 0; i < mesh.size(); ++i)
      if (mesh.material[i] == materialIndex("bark")) out.push_back(mesh.vertices[mesh.triangles[i][0]]);
  };
  bark(summer.mesh(), bark_summer), bark(winter.mesh(), bark_winter);
  EXPECT_EQ(bark_summer, bark_winter);
  EXPECT_EQ(winter.mesh().size(), bark_winter.size());
  EXPECT_GT(summer.mesh().size(), 1500U);
  EXPECT_LT(summer.mesh().size(), 3000U);
}

TEST(Props, RaysPassBetweenTheBarsOfAFence) {
  MeshBuilder builder;
  addFence(builder, {0, 5, 0}, {20, 5, 0}, 1.2);
  World world;
  world.mesh = builder.take();
  const RayScene scene(world);
  int passed = 0;
  for (int i = 0; i < 1000; ++i) passed += !scene.first({1 + 0.018 * i, 0, 0.6}, {0, 1, 0}, 20);
  EXPECT_GT(passed, 800);
  EXPECT_LT(passed, 930);
}

TEST(Props, CarsShowTheirPlatesToFrontAndRear) {
  MeshBuilder builder;
  RandomSequence random = sequence();
  addCar(builder, poseFromYaw(M_PI / 2, {10, 3, 0}), random, CarBody::kCar);
  World world;
  world.mesh = builder.take();
  const RayScene scene(world);
  for (const auto& [y, z, way] : {std::tuple{-10.0, 0.6, 1.0}, std::tuple{16.0, 0.45, -1.0}}) {
    const auto hit = scene.first({10.1, y, z}, {0, way, 0}, 50);
    ASSERT_TRUE(hit);
    EXPECT_EQ(hit->surface.material->name, "number_plate");
  }
}

TEST(RoughGround, HasTheDeviationAskedAndRepeats) {
  const RoughGround ground(3, 0.02), tiled(3, 0.02, 40);
  double sum = 0, squares = 0, worst = 0;
  int n = 0;
  for (double x = -150; x < 150; x += 0.73)
    for (double y = -150; y < 150; y += 0.73, ++n) sum += ground(x, y), squares += std::pow(ground(x, y), 2);
  EXPECT_NEAR(sum / n, 0, 0.001);
  EXPECT_NEAR(std::sqrt(squares / n), 0.02, 0.001);
  for (double x = -7; x < 50; x += 0.61) worst = std::max(worst, std::abs(tiled(x, 2 * x) - tiled(x + 80, 2 * x - 40)));
  EXPECT_LT(worst, 1e-9);
}

}  // namespace
}  // namespace scslam::sim
