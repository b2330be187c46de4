// Precision-recall curves of place recognisers and what they find by heading and offset, on one page.
#pragma once
#include <string>

#include "scslam/apps/place_recognition.h"

namespace scslam {

/// An SVG, 900 px wide: left the curves with F1max (dot) and the largest recall at 100 % precision (bar); right
/// recall@1 (pale) and recall at 100 % precision (full) by heading difference and by lateral offset; below the figures.
std::string placesSvg(const PlaceReport& report);

}  // namespace scslam
