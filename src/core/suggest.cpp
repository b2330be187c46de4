#include "scslam/core/suggest.h"

#include <algorithm>
#include <numeric>

namespace scslam {
namespace {

std::size_t editDistance(const std::string& a, const std::string& b) {
  std::vector<std::size_t> row(b.size() + 1);
  std::iota(row.begin(), row.end(), std::size_t{0});
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t substituted = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, substituted});
    }
  }
  return row[b.size()];
}

}  // namespace

std::string didYouMean(const std::string& word, const std::vector<std::string>& known) {
  if (known.empty()) return "";
  std::string all;
  for (const auto& name : known) all += (all.empty() ? "" : ", ") + name;
  const auto nearest = std::min_element(known.begin(), known.end(), [&word](const auto& a, const auto& b) {
    return editDistance(word, a) < editDistance(word, b);
  });
  const std::size_t distance = editDistance(word, *nearest);
  const bool close = distance <= std::max<std::size_t>(2, word.size() / 3);
  return close ? "; did you mean '" + *nearest + "'? (known: " + all + ")" : " (known: " + all + ")";
}

}  // namespace scslam
