#include "libmpm/base/text.hpp"

namespace mpm {

namespace {

/// Optimal string alignment distance: insertion, deletion, substitution, swap of neighbours.
std::size_t edits(std::string_view a, std::string_view b) {
  std::vector<std::vector<std::size_t>> d(a.size() + 1, std::vector<std::size_t>(b.size() + 1));
  for (std::size_t i = 0; i <= a.size(); ++i) {
    for (std::size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        d[i][j] = i + j;
        continue;
      }
      d[i][j] = std::min({d[i - 1][j] + 1, d[i][j - 1] + 1, d[i - 1][j - 1] + (a[i - 1] == b[j - 1] ? 0 : 1)});
      if (i > 1 && j > 1 && a[i - 1] == b[j - 2] && a[i - 2] == b[j - 1]) d[i][j] = std::min(d[i][j], d[i - 2][j - 2] + 1);
    }
  }
  return d[a.size()][b.size()];
}

}  // namespace

std::string nearest_word(std::string_view word, const std::vector<std::string>& candidates) {
  constexpr std::size_t longest_word = 64;  // of a sane key; keeps the distance table small
  if (word.empty() || word.size() > longest_word) return {};
  std::string best;
  std::size_t best_edits = 0;
  for (const std::string& candidate : candidates) {
    const std::size_t n = edits(word, candidate);
    const std::size_t limit = std::max<std::size_t>(2, std::max(word.size(), candidate.size()) / 3);
    const bool near = n <= limit && n < std::max(word.size(), candidate.size());
    const bool begins = std::min(word.size(), candidate.size()) > 2 && (candidate.starts_with(word) || word.starts_with(candidate));
    if ((near || begins) && (best.empty() || n < best_edits)) {
      best = candidate;
      best_edits = n;
    }
  }
  return best;
}

}  // namespace mpm
