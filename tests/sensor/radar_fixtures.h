// Made-up radar sweeps, and folders of them in every layout that is read.
#pragma once
#include <cmath>

#include "scslam/core/grey_png.h"
#include "scslam/sensor/oxford_radar.h"
#include "scslam/sensor/radar_scan.h"
#include "support/support.h"

namespace scslam::test {

/// The first azimuth at `stamp`, the rest evenly over a quarter of a second; encoder from 0 on; no echo yet.
inline RadarScan emptySweep(Stamp stamp, std::size_t azimuths = 400, std::size_t bins = 1000) {
  RadarScan sweep;
  sweep.resize(azimuths, bins);
  sweep.range_resolution_m = 0.0432;
  sweep.label = "radar";
  const auto period = std::chrono::nanoseconds(250'000'000 / azimuths);
  for (std::size_t i = 0; i < azimuths; ++i) {
    sweep.stamps[i] = stamp + std::chrono::duration_cast<Stamp::duration>(period * i);
    sweep.angles[i] = 2 * M_PI * static_cast<double>(i) / static_cast<double>(azimuths);
  }
  return sweep;
}

/// An echo as a logarithmic receiver shows it: a parabola of levels, half of `top` at `width` bins from `position`.
inline void addEcho(RadarScan& sweep, std::size_t azimuth, double position, double top, double width = 8) {
  for (std::size_t i = 0; i < sweep.bins; ++i) {
    const double x = (static_cast<double>(i) + 0.5 - position) / width;
    const double level = std::round(top * (1 - 0.5 * x * x));
    if (level > sweep.row(azimuth)[i]) sweep.row(azimuth)[i] = static_cast<std::uint8_t>(std::min(level, 255.0));
  }
}

/// Number i of a fixture: 8 azimuths of 40 bins, different in each.
inline RadarScan fixtureSweep(std::size_t i, Stamp stamp) {
  RadarScan sweep = emptySweep(stamp, 8, 40);
  for (std::size_t a = 0; a < sweep.azimuths; ++a)
    addEcho(sweep, a, 10 + static_cast<double>(i + a), 90 + static_cast<double>(i), 4);
  return sweep;
}

/// As MulRan's polar and RADIATE have it: a column an azimuth.
inline std::string encodeColumns(const RadarScan& sweep) {
  GreyImage image;
  image.rows = sweep.bins, image.columns = sweep.azimuths;
  for (std::size_t bin = 0; bin < sweep.bins; ++bin)
    for (std::size_t a = 0; a < sweep.azimuths; ++a) image.pixels.push_back(sweep.row(a)[bin]);
  return encodeGreyPng(image, true);
}

}  // namespace scslam::test
