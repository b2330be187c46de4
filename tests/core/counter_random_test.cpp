#include "scslam/core/counter_random.h"

#include <cmath>
#include <vector>

#include "support/support.h"

namespace scslam {
namespace {

TEST(CounterRandom, IsPhiloxAsPublished) {
  // Known answers of the authors' library (Random123, kat_vectors).
  using Block = std::array<std::uint32_t, 4>;
  EXPECT_EQ(philox({0, 0, 0, 0}, {0, 0}), (Block{0x6627e8d5, 0xe169c58d, 0xbc57ac4c, 0x9b00dbd8}));
  EXPECT_EQ(philox({0xffffffff, 0xffffffff, 0xffffffff, 0xffffffff}, {0xffffffff, 0xffffffff}),
            (Block{0x408f276d, 0x41c83b0e, 0xa20bc7c6, 0x6d5451fd}));
}

TEST(CounterRandom, NormalsHaveTheMomentsOfNormals) {
  const CounterRandom random(5, RandomStream::kLidar);
  double sum = 0, squares = 0, cubes = 0, fourths = 0;
  constexpr int kDraws = 400000;
  for (int i = 0; i < kDraws; ++i) {
    const double z = static_cast<double>(normalOf(random.block(static_cast<std::uint32_t>(i))[0]));
    sum += z, squares += z * z, cubes += z * z * z, fourths += z * z * z * z;
  }
  const double root = std::sqrt(kDraws);
  EXPECT_NEAR(sum / kDraws, 0, 4 / root);
  EXPECT_NEAR(squares / kDraws, 1, 4 * std::sqrt(2.0) / root);
  EXPECT_NEAR(cubes / kDraws, 0, 4 * std::sqrt(15.0) / root);
  EXPECT_NEAR(fourths / kDraws, 3, 4 * std::sqrt(96.0) / root);
}

TEST(CounterRandom, AColumnHoldsTheNumbersOfItsBlocks) {
  const CounterRandom random(7, RandomStream::kLidar, 2);
  for (const std::size_t n : {1U, 16U, 37U, 128U}) {
    std::vector<float> normal(n + 1, -9), uniform(n + 1, -9);
    random.drawColumn(3, 500, n, normal.data(), uniform.data());
    for (std::uint32_t ring = 0; ring < n; ++ring) {
      const auto words = random.block(3, 500, ring);
      EXPECT_EQ(normal[ring], normalOf(words[0])) << ring;
      EXPECT_EQ(uniform[ring], uniformOf(words[1])) << ring;
    }
    EXPECT_EQ(normal[n], -9);
    EXPECT_EQ(uniform[n], -9);
  }
}

TEST(CounterRandom, LogarithmIsThatOfTheLibrary) {
  for (float x = 1e-12F; x < 1e6F; x *= 1.0173F) {
    const double exact = std::log(static_cast<double>(x));
    EXPECT_NEAR(static_cast<double>(logOf(x)), exact, 2e-7 * std::max(1.0, std::abs(exact))) << x;
  }
  EXPECT_EQ(logOf(1.0F), 0.0F);
}

TEST(CounterRandom, EveryWordGivesAFiniteNumber) {
  for (const std::uint32_t word : {0U, 0xFFU, 0x7FFFFFFFU, 0x80000000U, 0xFFFFFF00U, 0xFFFFFFFFU}) {
    EXPECT_TRUE(std::isfinite(normalOf(word))) << word;
    EXPECT_GT(uniformOf(word), 0.F);
    EXPECT_LT(uniformOf(word), 1.F);
  }
}

TEST(CounterRandom, StreamsAndUnitsDiffer) {
  const auto a = CounterRandom(1, RandomStream::kLidar).block(1), b = CounterRandom(1, RandomStream::kRadar).block(1);
  const auto c = CounterRandom(1, RandomStream::kLidar, 1).block(1),
             d = CounterRandom(2, RandomStream::kLidar).block(1);
  EXPECT_NE(a, b);
  EXPECT_NE(a, c);
  EXPECT_NE(a, d);
  EXPECT_NE(b, c);
}

}  // namespace
}  // namespace scslam
