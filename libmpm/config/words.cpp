#include "libmpm/config/words.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

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

namespace mpm::config {

std::string quoted(const std::string& text) {
  std::string out = "\"";
  for (const char c : text) {
    if (c == '"' || c == '\\') {
      out += {'\\', c};
    } else if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) {
      out += fmt::format("\\u{:04X}", static_cast<unsigned>(c));
    } else {
      out += c;
    }
  }
  return out + "\"";
}

namespace {

struct TomlWriter {
  std::string operator()(bool x) const { return x ? "true" : "false"; }
  std::string operator()(std::int64_t x) const { return fmt::format("{}", x); }
  std::string operator()(double x) const {
    std::string out = fmt::format("{}", x);
    if (out.find_first_of(".en") == std::string::npos) out += ".0";  // otherwise TOML reads an integer
    return out;
  }
  std::string operator()(const std::string& x) const { return quoted(x); }
  std::string operator()(const Vec3& x) const { return fmt::format("[{}, {}, {}]", (*this)(x[0]), (*this)(x[1]), (*this)(x[2])); }
  std::string operator()(const Mat3& x) const {
    return fmt::format("[{}, {}, {}]", (*this)(Vec3(x.row(0))), (*this)(Vec3(x.row(1))), (*this)(Vec3(x.row(2))));
  }
  std::string operator()(const std::vector<std::string>& x) const {
    std::vector<std::string> items;
    items.reserve(x.size());
    for (const std::string& item : x) items.push_back(quoted(item));
    return fmt::format("[{}]", fmt::join(items, ", "));
  }
};

}  // namespace

std::string to_toml(const ParameterValue& value) { return std::visit(TomlWriter{}, value); }

}  // namespace mpm::config
