#include "sim/radar_receiver.h"

#include <algorithm>
#include <cmath>

#include "scslam/core/simd.h"

namespace scslam::sim {

namespace {

constexpr std::size_t kFractions = 64;  ///< of a bin, for the position of a response
constexpr double kResponseSigmas = 4;   ///< half the length of a response: amplitude e^-8
constexpr std::size_t kTable = 4096;
constexpr std::uint32_t kNoise = 1000;  ///< draw number that no path has

SCSLAM_KERNEL void addScaled(const float* response, std::size_t n, float re, float im, float* to_re, float* to_im) {
  for (std::size_t k = 0; k < n; ++k) to_re[k] += re * response[k], to_im[k] += im * response[k];
}
SCSLAM_KERNEL void addSquared(const float* response, std::size_t n, float power, float* to) {
  for (std::size_t k = 0; k < n; ++k) to[k] += power * response[k] * response[k];
}

}  // namespace

/// Sums of a row, with half a response of room at both ends.
struct RadarReceiver::Line {
  std::vector<float> re, im, power;
  explicit Line(std::size_t size) : re(size), im(size), power(size) {}
  float total(std::size_t i) const { return power[i] + re[i] * re[i] + im[i] * im[i]; }
};

RadarReceiver::RadarReceiver(const RadarModel& model, const RadarAntenna& antenna, const CounterRandom& random,
                             std::uint32_t scan_number)
    : model_(model),
      antenna_(antenna),
      random_(random),
      scan_(scan_number),
      resolution_(model.range_resolution_m),
      offset_(model.range_offset_m),
      row_width_(2 * M_PI / model.azimuths),
      sigma_(std::max(0.3, model.range_width_m / model.range_resolution_m / (2 * std::sqrt(std::log(2.0))))),
      saturation_(std::pow(10.0, model.saturation_db / 10)),
      streak_(std::pow(10.0, model.streak_db / 10)),
      phase_noise_(std::pow(10.0, model.phase_noise_db / 10)) {
  reach_ = static_cast<int>(std::ceil(antenna.azimuthReach() / row_width_));
  half_ = static_cast<std::size_t>(std::ceil(kResponseSigmas * sigma_));
  taps_ = 2 * half_ + 1;
  for (std::size_t f = 0; f < kFractions; ++f)
    for (std::size_t k = 0; k < taps_; ++k) {
      const double x = static_cast<double>(k) - static_cast<double>(half_) + 0.5 -
                       (static_cast<double>(f) + 0.5) / static_cast<double>(kFractions);
      response_.push_back(static_cast<float>(std::exp(-x * x / (2 * sigma_ * sigma_))));
    }
  noise_step_ = static_cast<std::size_t>(std::max(1.0, std::floor(sigma_ / 1.2)));
  for (std::size_t k = half_ % noise_step_; k < taps_; k += noise_step_) {
    const auto h = static_cast<double>(response_[kFractions / 2 * taps_ + k]);
    noise_squares_ += h * h;
  }
  for (std::size_t p = 0; p < kTable; ++p) table_.push_back(level(static_cast<double>(p)));
}

std::vector<float> RadarReceiver::power(std::span<const std::vector<RadarEcho>> rows, std::uint32_t number) const {
  const auto bins = static_cast<std::size_t>(model_.bins);
  Line line(bins + 2 * taps_);
  addEchoes(rows, line);
  if (model_.noise > 0) addNoise(number, line);
  std::vector<float> result(bins);
  for (std::size_t i = 0; i < bins; ++i) result[i] = line.total(i + taps_);
  return result;
}

/// @param position [bins]; the middle of bin 0 is 0.5.
void RadarReceiver::add(double position, float re, float im, Line& line) const {
  const double first = position - static_cast<double>(half_) + static_cast<double>(taps_);
  if (!(first >= 0) || first + static_cast<double>(taps_) >= static_cast<double>(line.re.size())) return;
  const auto begin = static_cast<std::size_t>(first);
  const auto fraction = static_cast<std::size_t>((first - static_cast<double>(begin)) * kFractions);
  const float* response = &response_[fraction * taps_];
  if (model_.speckle)
    addScaled(response, taps_, re, im, &line.re[begin], &line.im[begin]);
  else
    addSquared(response, taps_, re, &line.power[begin]);
}

void RadarReceiver::addEchoes(std::span<const std::vector<RadarEcho>> rows, Line& line) const {
  constexpr float kFaintest = 1e-5F;
  for (std::size_t r = 0; r < rows.size(); ++r) {
    const int later = reach_ - static_cast<int>(r);  // this row after the one the echo's ray belongs to
    const double turned = later * row_width_, seconds = later * model_.rowTime();
    for (const RadarEcho& echo : rows[r]) {
      const double out = antenna_.azimuthGain(static_cast<double>(echo.azimuth_out) - turned);
      const double in = echo.azimuth_in == echo.azimuth_out
                            ? out
                            : antenna_.azimuthGain(static_cast<double>(echo.azimuth_in) - turned);
      const float power = echo.power * static_cast<float>(out * in);
      if (power < kFaintest) continue;
      const double range = echo.range + seconds * echo.motion + model_.doppler_beta_s * echo.doppler;
      const float amplitude = std::sqrt(power);
      add(position(range), model_.speckle ? amplitude * echo.re : power, amplitude * echo.im, line);
    }
  }
}

/// White noise, closer together than the response is wide, through the response: thermal noise, and the transmitter's
/// phase noise on all that comes back in this row. Behind a return that saturates the receiver it rises.
void RadarReceiver::addNoise(std::uint32_t number, Line& line) const {
  std::size_t saturated_from = line.re.size();
  double peak = 0, sum = 0;
  for (std::size_t i = taps_; i + taps_ < line.re.size(); ++i) {
    const double p = static_cast<double>(line.total(i));
    sum += p;
    if (p > saturation_) saturated_from = std::min(saturated_from, i), peak = std::max(peak, p);
  }
  const double mean = model_.noise + phase_noise_ * sum, quiet = std::sqrt(mean / noise_squares_ / 2);
  const double raised = quiet * std::sqrt(1 + streak_ * peak / saturation_);
  const float* response = &response_[kFractions / 2 * taps_];
  std::array<std::uint32_t, 4> words{};
  std::uint32_t node = 0;
  for (std::size_t begin = 0; begin + taps_ <= line.re.size(); begin += noise_step_, ++node) {
    if (node % 2 == 0) words = random_.block(scan_, number, node / 2, kNoise);
    const std::size_t pair = node % 2 * 2;
    const auto scale = static_cast<float>(begin + half_ > saturated_from ? raised : quiet);
    addScaled(response, taps_, scale * normalOf(words[pair]), scale * normalOf(words[pair + 1]), &line.re[begin],
              &line.im[begin]);
  }
}

void RadarReceiver::compress(std::span<const float> power, std::span<std::uint8_t> levels) const {
  const auto limit = static_cast<float>(saturation_);
  for (std::size_t i = 0; i < power.size(); ++i) {
    const float p = std::min(power[i], limit) + 0.5F;
    levels[i] = p < static_cast<float>(kTable) ? table_[static_cast<std::size_t>(p)] : level(static_cast<double>(p));
  }
}

/// @param power in whole quanta.
std::uint8_t RadarReceiver::level(double power) const {
  if (power < 1) return 0;
  const double value = model_.compression == "sqrt" ? 255 * std::sqrt(power / saturation_)
                                                    : model_.counts_per_db * 10 * std::log10(power) + 0.1;
  return static_cast<std::uint8_t>(std::clamp(value, 0.0, 255.0));
}

}  // namespace scslam::sim
