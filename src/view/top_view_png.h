// The map from above.
#pragma once
#include <functional>
#include <string>

#include "scslam/session/session.h"

namespace scslam {

struct TopViewOptions {
  int max_pixels = 1600;            ///< longest side
  const Session* marked = nullptr;  ///< of the same keyframes: its points are drawn over the others in red
};

/// All points of all keyframes from above: colour = height over the sensor, brightness = logarithm of their number; the
/// optimised trajectory over it, a scale bar. Streams the keyframes; memory is the picture's. Keyframes whose scan is
/// missing are left out. @param progress called with the keyframes done.
/// @return the bytes of a PNG file. @throw inputError for a damaged scan.
std::string topViewPng(const Session& session, const TopViewOptions& options = {},
                       const std::function<void(std::size_t)>& progress = {});

}  // namespace scslam
