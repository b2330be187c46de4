#include "scslam/place/column_spectra.h"

#include <gtest/gtest.h>

#include <random>

#include "scslam/place/key_index.h"

namespace scslam {
namespace {

TEST(ColumnSpectra, CorrelatesLikeTheSumOverEveryShift) {
  std::mt19937 random(1);
  const auto uniform = [&random] { return static_cast<float>(random() % 1000) / 1000; };
  for (const std::size_t columns : {2u, 9u, 45u, 60u, 63u, 64u}) {
    constexpr std::size_t kRows = 7;
    std::vector<float> a(kRows * columns), b(kRows * columns);
    std::generate(a.begin(), a.end(), uniform), std::generate(b.begin(), b.end(), uniform);
    const ColumnSpectra spectra(kRows, columns);
    std::vector<float> A(spectra.size()), B(spectra.size());
    spectra.transform(a.data(), A), spectra.transform(b.data(), B);
    float similarity[ColumnSpectra::kMaxColumns];
    spectra.correlate(A.data(), B.data(), similarity);
    for (std::size_t s = 0; s < columns; ++s) {
      double expected = 0;
      for (std::size_t r = 0; r < kRows; ++r)
        for (std::size_t j = 0; j < columns; ++j) expected += a[r * columns + j] * b[r * columns + (j + s) % columns];
      EXPECT_NEAR(similarity[s], expected, 1e-5 * expected + 1e-5) << columns << " columns, shift " << s;
    }
  }
}

TEST(KeyIndex, FindsWhatSortingAllFindsAtEverySize) {
  std::mt19937 random(2);
  KeyIndex index(5);
  std::vector<std::vector<float>> keys;
  for (int i = 0; i < 2500; ++i) {
    keys.emplace_back();
    for (int d = 0; d < 5; ++d) keys.back().push_back(static_cast<float>(random() % 8));  // many ties
    index.add(keys.back().data());
  }
  std::vector<KeyIndex::Neighbour> found;
  for (const std::size_t n : {0u, 1u, 31u, 1023u, 1024u, 1025u, 2500u, 9999u})
    for (const std::size_t count : {0u, 1u, 50u, 4000u}) {
      const auto& key = keys[77];
      std::vector<KeyIndex::Neighbour> expected;
      for (std::size_t i = 0; i < std::min<std::size_t>(n, keys.size()); ++i) {
        float sum = 0;
        for (std::size_t d = 0; d < 5; ++d) sum += (keys[i][d] - key[d]) * (keys[i][d] - key[d]);
        expected.push_back({sum, i});
      }
      std::sort(expected.begin(), expected.end());
      expected.resize(std::min(count, expected.size()));
      index.nearest(key.data(), n, count, found);
      EXPECT_EQ(found, expected) << n << ", " << count;
    }
}

}  // namespace
}  // namespace scslam
