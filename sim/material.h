// What surfaces are made of, for light (LiDAR, near infrared) and for 76 GHz radar.
#pragma once
#include <cstdint>
#include <string>
#include <vector>

namespace scslam::sim {

/// Classes of SemanticKITTI; moving things have the class plus nothing: see movingLabel().
enum class Label : std::uint16_t {
  kUnlabelled = 0,
  kOutlier = 1,
  kCar = 10,
  kBicycle = 11,
  kBus = 13,
  kPerson = 30,
  kBicyclist = 31,
  kRoad = 40,
  kParking = 44,
  kSidewalk = 48,
  kOtherGround = 49,
  kBuilding = 50,
  kFence = 51,
  kOtherStructure = 52,
  kVegetation = 70,
  kTrunk = 71,
  kTerrain = 72,
  kPole = 80,
  kTrafficSign = 81,
  kOtherObject = 99,
};
/// The label of the same thing in motion (252 … 257), as SemanticKITTI numbers it.
std::uint16_t movingLabel(Label label);

struct Material {
  std::string name;
  Label label = Label::kUnlabelled;
  float reflectance = 0.3F;    ///< diffuse (Lambertian), 850 … 905 nm, 0 … 1
  float retro = 0;             ///< strength of the retro-reflecting lobe: 1 = a traffic sign, 0 = none
  float roughness_rad = 0;     ///< slope of its facets, one sigma; 0: an ideal diffuser, dark when seen at a slant
  float specular = 0;          ///< share of light that leaves like from a mirror (glass, water) and is lost: 0 … 1
  float permittivity = 5;      ///< relative, at 76 GHz
  bool metal = false;          ///< reflects radar whole
  float radar_diffuse = 0.3F;  ///< share of the reflected radar power that is scattered, not mirrored: 0 … 1

  /// Light that a rough diffuser returns to where it came from, against a smooth one hit at a right angle: M. Oren and
  /// S. Nayar, "Generalization of Lambert's reflectance model", SIGGRAPH 1994, for source and eye in one place.
  /// @param cosine of the angle of incidence.
  float backscatter(float cosine) const { return lambert * cosine + grazing * (1 - cosine * cosine); }
  float lambert = 1, grazing = 0;  ///< by roughness_rad: materials() sets them
};

/// The materials a world may use, in a fixed order. Index 0 is "default".
const std::vector<Material>& materials();
/// Index by name. @throw usageError that names the nearest.
std::uint16_t materialIndex(const std::string& name);
/// Index for the material name of a mesh file: equal, else contained in it ("Brick_01" is brick); -1: none.
int materialLike(const std::string& name_in_file);

}  // namespace scslam::sim
