// The weights of registration.gates.quality, learned from sessions whose truth is known: `scslam learn`.
#pragma once
#include <atomic>
#include <filesystem>
#include <string>
#include <vector>

#include "scslam/core/registry.h"
#include "scslam/registration/alignment_quality.h"

namespace scslam {

struct LearnOptions {
  std::vector<std::filesystem::path> sessions, truths;  ///< equally many
  std::vector<std::string> sets;                        ///< over the configuration of each session
  bool quiet = false;
  const std::atomic<bool>* stop = nullptr;
};

struct LearnSummary {
  QualityParams quality;                          ///< with the weights found
  std::size_t examples = 0, right = 0;            ///< that were learned from
  std::size_t tested = 0;                         ///< others, of other places
  double auc = 0;                                 ///< over those tested
  double right_believed = 0, wrong_believed = 0;  ///< shares of them, at min_probability
};

/// Keyframes are registered against the surroundings of places they revisit, from starts that are wrong by up to 8 m
/// and 60 deg, and against places that they do not; what ends within 1 m and 5 deg of the truth is right. A quarter of
/// the ground, in squares of 20 m, is kept for the test. The result depends on nothing else, threads included.
/// @throw inputError for sessions that revisit no place.
LearnSummary learnQuality(const LearnOptions& options, const PluginContext& context);

/// As a configuration for `-c`, with where it comes from as a comment.
std::string learnYaml(const LearnSummary& summary, const LearnOptions& options);

}  // namespace scslam
