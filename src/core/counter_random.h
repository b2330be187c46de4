// Random numbers that depend on their coordinates alone (seed, stream, scan, column, ring, draw), never on who asked
// first: Philox4x32-10 (Salmon et al., "Parallel random numbers: as easy as 1, 2, 3", SC 2011).
#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>

namespace scslam {

/// Multipliers and key steps of Philox4x32.
inline constexpr std::uint32_t kPhiloxMultiplier[2] = {0xD2511F53, 0xCD9E8D57},
                               kPhiloxStep[2] = {0x9E3779B9, 0xBB67AE85};

/// One Philox4x32-10 block: four independent 32-bit words for a counter and a key.
inline std::array<std::uint32_t, 4> philox(std::array<std::uint32_t, 4> counter, std::array<std::uint32_t, 2> key) {
  for (int round = 0; round < 10; ++round) {
    const std::uint64_t a = std::uint64_t{kPhiloxMultiplier[0]} * counter[0];
    const std::uint64_t b = std::uint64_t{kPhiloxMultiplier[1]} * counter[2];
    counter = {static_cast<std::uint32_t>(b >> 32) ^ counter[1] ^ key[0], static_cast<std::uint32_t>(b),
               static_cast<std::uint32_t>(a >> 32) ^ counter[3] ^ key[1], static_cast<std::uint32_t>(a)};
    key[0] += kPhiloxStep[0], key[1] += kPhiloxStep[1];
  }
  return counter;
}

/// A word as a number in (0, 1), never 0 nor 1.
inline float uniformOf(std::uint32_t word) {
  return std::min((static_cast<float>(word >> 8) + 0.5F) * 0x1p-24F, 0x1.fffffep-1F);
}

/// Natural logarithm of a positive normal number, to 2e-7: the polynomial of Cephes (Moshier 1989), without a call or a
/// branch, so that many are taken at once, and with the same bits on any machine.
inline float logOf(float x) {
  const auto bits = std::bit_cast<std::int32_t>(x);
  const std::int32_t exponent = (bits - 0x3F3504F3) >> 23;  // of sqrt(1/2) … sqrt(2)
  const float f = std::bit_cast<float>(bits - (exponent << 23)) - 1.0F, e = static_cast<float>(exponent), z = f * f;
  float p = 7.0376836292e-2F;
  p = p * f - 1.1514610310e-1F, p = p * f + 1.1676998740e-1F, p = p * f - 1.2420140846e-1F;
  p = p * f + 1.4249322787e-1F, p = p * f - 1.6668057665e-1F, p = p * f + 2.0000714765e-1F;
  p = p * f - 2.4999993993e-1F, p = p * f + 3.3333331174e-1F;
  return f + (p * f * z - 2.12194440e-4F * e - 0.5F * z) + 0.693359375F * e;
}

/// Standard normal from a word by the inverse error function (Giles 2010, single precision): one word, one number.
/// In parts, so that many can be taken at once: symmetricOf() the word, tailOf() that, then x times the polynomial for
/// the middle (w < 5) or the tail.
struct InverseError {
  static float symmetricOf(std::uint32_t word) {  ///< (-1, 1)
    return std::min((static_cast<float>(word >> 8) + 0.5F) * 0x1p-23F - 1.0F, 1 - 0x1p-24F);
  }
  static float tailOf(float x) { return -logOf((1.0F - x) * (1.0F + x)); }
  static float middle(float w) {
    const float a = w - 2.5F;
    float p = 2.81022636e-08F;
    p = 3.43273939e-07F + p * a, p = -3.5233877e-06F + p * a, p = -4.39150654e-06F + p * a;
    p = 0.00021858087F + p * a, p = -0.00125372503F + p * a, p = -0.00417768164F + p * a, p = 0.246640727F + p * a;
    return 1.41421356F * (1.50140941F + p * a);
  }
  static float tail(float w) {
    const float b = std::sqrt(w) - 3.0F;
    float p = -0.000200214257F;
    p = 0.000100950558F + p * b, p = 0.00134934322F + p * b, p = -0.00367342844F + p * b;
    p = 0.00573950773F + p * b, p = -0.0076224613F + p * b, p = 0.00943887047F + p * b, p = 1.00167406F + p * b;
    return 1.41421356F * (2.83297682F + p * b);
  }
};

inline float normalOf(std::uint32_t word) {
  const float x = InverseError::symmetricOf(word), w = InverseError::tailOf(x);
  return (w < 5.0F ? InverseError::middle(w) : InverseError::tail(w)) * x;
}

/// What a random number is for: numbers of different streams are independent.
enum class RandomStream : std::uint32_t { kWorld, kLidar, kRadar, kImu, kWheel, kGnss, kDrive, kActors, kFaults };

/// A source of blocks for one seed and one stream (and one sensor of that kind: `unit`).
class CounterRandom {
 public:
  CounterRandom(std::uint64_t seed, RandomStream stream, std::uint32_t unit = 0)
      : key_{static_cast<std::uint32_t>(seed),
             static_cast<std::uint32_t>(seed >> 32) ^ (static_cast<std::uint32_t>(stream) * 0x9E3779B1U + unit)} {}
  /// Four words for the coordinates (scan, column, ring, draw); unused coordinates are 0.
  std::array<std::uint32_t, 4> block(std::uint32_t scan, std::uint32_t column = 0, std::uint32_t ring = 0,
                                     std::uint32_t draw = 0) const {
    return philox({scan, column, ring, draw}, key_);
  }
  /// normalOf() word 0 and uniformOf() word 1 of block(scan, column, ring) for the rings 0 … n-1, many at a time.
  void drawColumn(std::uint32_t scan, std::uint32_t column, std::size_t n, float* normal, float* uniform) const;

 private:
  std::array<std::uint32_t, 2> key_;
};

/// Numbers in a row for code that runs in one fixed order anyway (generating a world).
class RandomSequence {
 public:
  explicit RandomSequence(const CounterRandom& random, std::uint32_t what = 0) : random_(random), what_(what) {}
  double uniform() { return static_cast<double>(uniformOf(word())); }
  double uniform(double lo, double hi) { return lo + (hi - lo) * uniform(); }
  double normal() { return static_cast<double>(normalOf(word())); }
  /// 0 … n-1.
  int below(int n) { return static_cast<int>((std::uint64_t{word()} * static_cast<std::uint64_t>(n)) >> 32); }

 private:
  std::uint32_t word() {
    if (left_ == 0) block_ = random_.block(index_++, what_), left_ = 4;
    return block_[--left_];
  }
  CounterRandom random_;
  std::uint32_t what_, index_ = 0, left_ = 0;
  std::array<std::uint32_t, 4> block_{};
};

}  // namespace scslam
