// What a simulation writes beside its rawlog.
#pragma once
#include <cmath>
#include <filesystem>

#include "scslam/core/stamp.h"
#include "sim/simulation.h"

namespace scslam::sim {

/// Names of what lies beside OUT.rawlog.
struct Outputs {
  std::filesystem::path rawlog, stem;
  explicit Outputs(const std::filesystem::path& output) : rawlog(output), stem(output) {
    if (rawlog.extension() != ".rawlog") rawlog += ".rawlog";
    stem = rawlog;
    stem.replace_extension();
  }
  std::filesystem::path operator()(const char* suffix) const { return stem.string() + suffix; }
};

/// Simulated drives begin on 2026-01-01 00:00 UTC. @param t [s] into the drive.
inline Stamp stampAt(double t) { return stampFromNanoseconds(1767225600'000000000 + std::llround(t * 1e9)); }

/// OUT.yaml, OUT.gt.tum, and what the scenario's `truth` asks for: firings, revisits, look-alikes, pictures.
void writeTruth(Simulation& simulation, const Outputs& out, ThreadPool& threads, SimulationSummary& summary);

}  // namespace scslam::sim
