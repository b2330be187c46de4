// Maps that are pictures: where their pixels lie, and the files that say so.
#pragma once
#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <filesystem>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "scslam/core/grey_png.h"

namespace scslam {

/// Square cells of the map's x-y plane; cell (i, j) reaches from (i, j) * cell_m to (i + 1, j + 1) * cell_m. Stored by
/// tiles, so that memory follows what was seen and not the rectangle around it.
template <class Cell>
class TiledGrid {
 public:
  static constexpr int kSide = 128;
  using Tile = std::array<Cell, static_cast<std::size_t>(kSide) * kSide>;

  Cell& at(int i, int j) { return tile(i, j)[inTile(i, j)]; }
  /// The tile that holds cell (i, j), made where it is new. References stay valid.
  Tile& tile(int i, int j) { return tiles_[{floorDiv(j), floorDiv(i)}]; }
  static std::size_t inTile(int i, int j) {
    return static_cast<std::size_t>(j - floorDiv(j) * kSide) * kSide +
           static_cast<std::size_t>(i - floorDiv(i) * kSide);
  }
  /// Calls visit(i, j, cell) for all cells of all tiles, in a fixed order.
  template <class Visit>
  void forEach(const Visit& visit) const {
    for (const auto& [key, tile] : tiles_)
      for (int y = 0; y < kSide; ++y)
        for (int x = 0; x < kSide; ++x)
          visit(key.second * kSide + x, key.first * kSide + y,
                tile[static_cast<std::size_t>(y) * kSide + static_cast<std::size_t>(x)]);
  }

 private:
  static int floorDiv(int a) { return a >= 0 ? a / kSide : -((-a + kSide - 1) / kSide); }
  std::map<std::pair<int, int>, Tile> tiles_;  ///< by (row, column)
};

/// The smallest rectangle of cells around what was seen.
struct RasterFrame {
  double cell_m = 1;
  int i_min = 0, i_max = -1, j_min = 0, j_max = -1;    ///< inclusive; empty while i_max < i_min
  Eigen::Vector3d offset_m = Eigen::Vector3d::Zero();  ///< MapInfo's: goes into the world file

  void include(int i, int j);
  bool empty() const { return i_max < i_min; }
  std::size_t columns() const { return empty() ? 0 : static_cast<std::size_t>(i_max - i_min + 1); }
  std::size_t rows() const { return empty() ? 0 : static_cast<std::size_t>(j_max - j_min + 1); }
  /// A picture of `value`, north (+y) up. @throw usageError when it would have more than 2^30 pixels.
  GreyImage picture(std::uint8_t value) const;
  /// Pixel of a cell in picture().
  std::size_t pixel(int i, int j) const {
    return static_cast<std::size_t>(j_max - j) * columns() + static_cast<std::size_t>(i - i_min);
  }
};

/// How a ROS map server is to read the picture.
struct RosMapMeaning {
  std::string mode = "trinary";  ///< trinary or scale
  bool negate = false;           ///< false: black is occupied
  double occupied_above = 0.65, free_below = 0.196;
};

/// Writes NAME.png, NAME.pgw (world file: pixel size and the centre of the upper left pixel) and NAME.yaml (ROS map).
/// @return the files, the picture first. @throw inputError when they cannot be written.
std::vector<std::filesystem::path> writeRasterMap(const std::filesystem::path& folder, const std::string& name,
                                                  const GreyImage& picture, const RasterFrame& frame,
                                                  const RosMapMeaning& meaning);

}  // namespace scslam
