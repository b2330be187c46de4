#include "scslam/mapping/raster_map.h"

#include <algorithm>

#include "scslam/core/error.h"
#include "scslam/core/file.h"

namespace scslam {

void RasterFrame::include(int i, int j) {
  if (empty()) {
    i_min = i_max = i, j_min = j_max = j;
    return;
  }
  i_min = std::min(i_min, i), i_max = std::max(i_max, i);
  j_min = std::min(j_min, j), j_max = std::max(j_max, j);
}

GreyImage RasterFrame::picture(std::uint8_t value) const {
  constexpr std::size_t kMostPixels = std::size_t{1} << 30;
  if (rows() > kMostPixels / std::max<std::size_t>(1, columns()))
    throw usageError("a map of {} x {} cells of {} m is too large for one picture; give a larger --voxel", columns(),
                     rows(), cell_m);
  GreyImage image;
  image.rows = rows(), image.columns = columns();
  image.pixels.assign(image.rows * image.columns, value);
  return image;
}

std::vector<std::filesystem::path> writeRasterMap(const std::filesystem::path& folder, const std::string& name,
                                                  const GreyImage& picture, const RasterFrame& frame,
                                                  const RosMapMeaning& meaning) {
  const auto png = folder / (name + ".png"), world = folder / (name + ".pgw"), yaml = folder / (name + ".yaml");
  const double left = frame.i_min * frame.cell_m, bottom = frame.j_min * frame.cell_m,
               top = (frame.j_max + 1) * frame.cell_m;
  writeFileAtomically(png, encodeGreyPng(picture, true));
  writeFileAtomically(world, fmt::format("{:.17g}\n0\n0\n{:.17g}\n{:.17g}\n{:.17g}\n", frame.cell_m, -frame.cell_m,
                                         frame.offset_m.x() + left + 0.5 * frame.cell_m,
                                         frame.offset_m.y() + top - 0.5 * frame.cell_m));
  writeFileAtomically(yaml, fmt::format("image: {}.png\nmode: {}\nresolution: {:.17g}\norigin: [{:.17g}, {:.17g}, 0]\n"
                                        "negate: {}\noccupied_thresh: {}\nfree_thresh: {}\n",
                                        name, meaning.mode, frame.cell_m, left, bottom, meaning.negate ? 1 : 0,
                                        meaning.occupied_above, meaning.free_below));
  return {png, world, yaml};
}

}  // namespace scslam
