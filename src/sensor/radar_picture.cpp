#include "scslam/sensor/radar_picture.h"

#include <cmath>

#include "scslam/core/error.h"
#include "scslam/core/file.h"
#include "scslam/core/grey_png.h"

namespace scslam {
namespace {

constexpr std::size_t kMaxFileBytes = std::size_t{1} << 28;

}  // namespace

void stampRows(RadarScan& sweep, Stamp stamp, const SensorModel& table) {
  const auto n = static_cast<double>(sweep.azimuths);
  const double shift = table.radar.stamp == "end" ? n - 1 : table.radar.stamp == "middle" ? std::floor(n / 2) - 1 : 0;
  for (std::size_t i = 0; i < sweep.azimuths; ++i) {
    const std::chrono::duration<double> after(table.sweep_s * (static_cast<double>(i) - shift) / n);
    sweep.stamps[i] = stamp + std::chrono::duration_cast<Stamp::duration>(after);
  }
}

RadarScan readRadarPicture(const std::filesystem::path& file, Stamp stamp, const SensorModel& table) {
  const GreyImage image = decodeGreyPng(readFile(file, kMaxFileBytes), file.string());
  if (image.rows < 2 || image.columns < 2)
    throw inputError("{}: {} x {} pixels are no radar sweep", file.string(), image.columns, image.rows);
  const bool by_row = static_cast<std::size_t>(table.columns) == image.rows && image.rows != image.columns;
  RadarScan sweep;
  sweep.resize(by_row ? image.rows : image.columns, by_row ? image.columns : image.rows);
  if (by_row) {
    sweep.power = image.pixels;
  } else {
    for (std::size_t bin = 0; bin < sweep.bins; ++bin)
      for (std::size_t azimuth = 0; azimuth < sweep.azimuths; ++azimuth)
        sweep.power[azimuth * sweep.bins + bin] = image.pixels[bin * image.columns + azimuth];
  }
  const double turn = 2 * M_PI, step = (table.clockwise ? turn : -turn) / static_cast<double>(sweep.azimuths);
  for (std::size_t i = 0; i < sweep.azimuths; ++i) {
    const double turns = (table.radar.first_azimuth_deg * M_PI / 180 + step * static_cast<double>(i)) / turn;
    sweep.angles[i] = (turns - std::floor(turns)) * turn;
  }
  stampRows(sweep, stamp, table);
  applyTable(table.radar, sweep);
  sweep.label = "radar";
  sweep.T_base_sensor = table.T_base_sensor();
  return sweep;
}

}  // namespace scslam
