#include "sim/material.h"

#include <algorithm>

#include "scslam/core/error.h"
#include "scslam/core/suggest.h"

namespace scslam::sim {
namespace {

std::vector<Material> rough(std::vector<Material> materials) {
  for (Material& m : materials) {
    const float variance = m.roughness_rad * m.roughness_rad;
    m.lambert = 1 - 0.5F * variance / (variance + 0.33F);
    m.grazing = 0.45F * variance / (variance + 0.09F);
  }
  return materials;
}

}  // namespace

std::uint16_t movingLabel(Label label) {
  switch (label) {
    case Label::kCar:
      return 252;
    case Label::kBicyclist:
      return 253;
    case Label::kPerson:
      return 254;
    case Label::kBus:
      return 257;
    default:
      return 259;  // moving other vehicle
  }
}

const std::vector<Material>& materials() {
  // Reflectance near 0.9 um: usual text-book values. Roughness: ground as it is known from images of roads and from the
  // returns that real sensors get of it at a slant (sim/targets). Permittivity at 76 GHz: ITU-R P.2040 and radar
  // literature.
  static const std::vector<Material> all = rough({
      {"default", Label::kOtherObject, 0.30F, 0, 0, 0, 5, false, 0.3F},
      {"asphalt", Label::kRoad, 0.17F, 0, 0.5F, 0, 4, false, 0.1F},
      {"road_marking", Label::kRoad, 0.45F, 0.05F, 0.35F, 0, 4, false, 0.1F},
      {"paving", Label::kSidewalk, 0.26F, 0, 0.4F, 0, 5, false, 0.15F},
      {"kerb", Label::kSidewalk, 0.32F, 0, 0.35F, 0, 5, false, 0.3F},
      {"soil", Label::kTerrain, 0.22F, 0, 0.6F, 0, 6, false, 0.4F},
      {"grass", Label::kTerrain, 0.45F, 0, 0.7F, 0, 8, false, 0.6F},
      {"water", Label::kOtherGround, 0.02F, 0, 0, 0.98F, 30, false, 0.02F},
      {"concrete", Label::kBuilding, 0.32F, 0, 0.35F, 0, 5.3F, false, 0.3F},
      {"brick", Label::kBuilding, 0.34F, 0, 0.4F, 0, 3.9F, false, 0.4F},
      {"plaster", Label::kBuilding, 0.50F, 0, 0.3F, 0, 3, false, 0.3F},
      {"wood", Label::kBuilding, 0.40F, 0, 0.3F, 0, 2, false, 0.4F},
      {"roof", Label::kBuilding, 0.25F, 0, 0.4F, 0, 4, false, 0.4F},
      {"glass", Label::kBuilding, 0.02F, 0, 0, 0.85F, 6.3F, false, 0.05F},
      {"tunnel_lining", Label::kOtherStructure, 0.28F, 0, 0.35F, 0, 5.3F, false, 0.3F},
      {"metal", Label::kOtherStructure, 0.40F, 0.01F, 0.1F, 0.2F, 1, true, 0.2F},
      {"fence", Label::kFence, 0.35F, 0, 0.2F, 0, 1, true, 0.6F},
      {"guard_rail", Label::kFence, 0.40F, 0.01F, 0.1F, 0.1F, 1, true, 0.2F},
      {"pole", Label::kPole, 0.38F, 0, 0.1F, 0.1F, 1, true, 0.3F},
      {"sign", Label::kTrafficSign, 0.60F, 1, 0, 0, 1, true, 0.1F},
      {"car_paint", Label::kCar, 0.28F, 0.005F, 0.1F, 0.3F, 1, true, 0.15F},
      {"car_glass", Label::kCar, 0.02F, 0, 0, 0.9F, 6.3F, false, 0.05F},
      {"number_plate", Label::kCar, 0.50F, 0.6F, 0, 0, 1, true, 0.1F},
      {"tyre", Label::kCar, 0.05F, 0, 0.3F, 0, 3, false, 0.5F},
      {"bus_paint", Label::kBus, 0.40F, 0.01F, 0.1F, 0.2F, 1, true, 0.15F},
      {"bicycle", Label::kBicycle, 0.25F, 0.02F, 0.2F, 0, 1, true, 0.6F},
      {"clothes", Label::kPerson, 0.40F, 0, 0.5F, 0, 3, false, 0.7F},
      {"leaves", Label::kVegetation, 0.48F, 0, 0.6F, 0, 3, false, 1},
      {"bark", Label::kTrunk, 0.30F, 0, 0.6F, 0, 2, false, 0.7F},
      {"retro_reflector", Label::kOtherObject, 0.60F, 5, 0, 0, 1, true, 0.05F},
      {"black", Label::kOtherObject, 0.02F, 0, 0, 0, 3, false, 0.3F},
      {"white", Label::kOtherObject, 0.90F, 0, 0, 0, 3, false, 0.3F},
  });
  return all;
}

std::uint16_t materialIndex(const std::string& name) {
  const auto& all = materials();
  const auto found = std::find_if(all.begin(), all.end(), [&](const Material& m) { return m.name == name; });
  if (found != all.end()) return static_cast<std::uint16_t>(found - all.begin());
  std::vector<std::string> names;
  for (const Material& m : all) names.push_back(m.name);
  throw usageError("no material is called '{}'{}", name, didYouMean(name, names));
}

int materialLike(const std::string& name_in_file) {
  std::string lower(name_in_file);
  std::transform(lower.begin(), lower.end(), lower.begin(), [](unsigned char c) { return std::tolower(c); });
  const auto& all = materials();
  int best = -1;
  std::size_t longest = 0;
  for (std::size_t i = 0; i < all.size(); ++i) {
    const std::string& name = all[i].name;
    if (lower == name) return static_cast<int>(i);
    if (name.size() > longest && lower.find(name) != std::string::npos)
      best = static_cast<int>(i), longest = name.size();
  }
  return best;
}

}  // namespace scslam::sim
