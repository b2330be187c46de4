// Figures that need to know which point lies beside which: drop-outs, edges, noise, the sensor's grid.
#pragma once
#include <array>
#include <string>

#include "sim/range_image.h"
#include "sim/realism_figures.h"

namespace scslam::sim {

/// Drop-outs in numbers: pixels whose two azimuth neighbours agree, and how many of these have no return.
struct DropoutCount {
  double pixels = 0, lost = 0;
};
using RangeCounts = std::array<DropoutCount, kDropoutBins_m.size() - 1>;
using SignalCounts = std::array<DropoutCount, kSignalBins.size() - 1>;

void measureReturns(const RangeImage& image, RealismFigures& figures);
/// @param pooled the counts of this image are added to it.
void measureDropouts(const RangeImage& image, RealismFigures& figures, RangeCounts& pooled);
void measureEdges(const RangeImage& image, RealismFigures& figures);
/// Fourth difference along the azimuth, which curvature and slope do not move: sigma = 1.4826 MAD / sqrt(70), from
/// runs of five returns within 0.25 m. A bin with 200 of these or fewer is not measured.
void measureNoise(const RangeImage& image, RealismFigures& figures);
/// Off-grid distances, range quantum, time a column.
void measureGrid(const RangeImage& image, const Cloud& cloud, RealismFigures& figures);

/// Why the intensities of this cloud are not counts of a detector's signal; empty when they may be.
std::string whyNoSignal(const RangeImage& image, const Cloud& cloud);
void countBySignal(const RangeImage& image, const Cloud& cloud, SignalCounts& counts);

}  // namespace scslam::sim
