// Where the time goes. Never part of a result: only metrics.json reports it.
#pragma once
#include <array>
#include <chrono>
#include <cstddef>
#include <vector>

namespace scslam {

enum class Stage : std::size_t { kRead, kPreprocess, kOdometry, kPlace, kRegistration, kGraph, kSession, kCount };
inline constexpr std::array<const char*, static_cast<std::size_t>(Stage::kCount)> kStageNames = {
    "read", "preprocess", "odometry", "place", "registration", "graph", "session"};

struct StageTimes {
  std::array<double, static_cast<std::size_t>(Stage::kCount)> total_ms{};
  std::vector<float> scan_ms;  ///< per scan, reading excluded
};

/// Adds the time until its end to one stage.
class StageTimer {
 public:
  StageTimer(StageTimes& times, Stage stage) : times_(times), stage_(static_cast<std::size_t>(stage)) {}
  ~StageTimer() { times_.total_ms[stage_] += elapsedMs(); }
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;
  double elapsedMs() const { return std::chrono::duration<double, std::milli>(Clock::now() - start_).count(); }

 private:
  using Clock = std::chrono::steady_clock;
  StageTimes& times_;
  std::size_t stage_;
  Clock::time_point start_ = Clock::now();
};

}  // namespace scslam
