#include "libmpm/config/findings.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <tuple>

#include "libmpm/base/error.hpp"
#include "libmpm/config/guard.hpp"

namespace mpm::config {

namespace {

/// "body[0]" of "body[0].min_m", "body" of "body[0]"; empty at the end.
std::string outer(const std::string& path) {
  const std::size_t cut = path.ends_with(']') ? path.rfind('[') : path.rfind('.');
  return cut == std::string::npos ? "" : path.substr(0, cut);
}

}  // namespace

Findings::Findings(std::string file) : file_(std::move(file)) { enter_table("", in_file(1, 1)); }

Place Findings::in_file(std::uint32_t line, std::uint32_t column) const {
  line = std::max<std::uint32_t>(1, line), column = std::max<std::uint32_t>(1, column);
  return {0, line, column, fmt::format("{}:{}:{}", file_, line, column)};
}

void Findings::enter_table(const std::string& path, const Place& place) {
  places_[path] = place;
  tables_.insert(path);
}

bool Findings::sound(const std::string& path) const {
  for (std::string part = path; !part.empty(); part = outer(part)) {
    if (unsound_.contains(part)) return false;
  }
  return true;
}

const Place& Findings::place_of(const std::string& path) const {
  for (const std::string& part : {path, outer(path)}) {
    if (const auto at = places_.find(part); at != places_.end()) return at->second;
  }
  return places_.at("");
}

void Findings::problem(const std::string& path, const std::string& text) {
  if (path.empty()) return add(place_of(path), text);
  if (tables_.contains(path)) return add(place_of(path), fmt::format("[{}] {}", path, text));
  const std::string table = outer(path);
  const std::string key = table.empty() ? path : path.substr(table.size() + 1);
  add(place_of(path), fmt::format("{}{} {}", table.empty() ? "" : fmt::format("[{}] ", table), key, text));
  mark_unsound(path);
}

void Findings::add(const Place& place, const std::string& text) {
  if (!given_up()) findings_.push_back({place, text});
}

bool Findings::given_up() const { return findings_.size() >= most_problems; }

void Findings::throw_if_any() {
  if (findings_.empty()) return;
  std::ranges::stable_sort(findings_, {}, [](const Finding& f) { return std::tuple(f.place.source_number, f.place.line, f.place.column); });
  std::string message;
  for (const Finding& f : std::span(findings_).first(std::min(findings_.size(), problems_shown)))
    message += fmt::format("{}{}: {}", message.empty() ? "" : "\n", f.place.text, f.text);
  if (findings_.size() > problems_shown) {
    message += fmt::format("\n{}: {}{} more errors; fix these first, or check that this is the right file", file_,
                           given_up() ? "at least " : "", findings_.size() - problems_shown);
  }
  throw ConfigError(message);
}

}  // namespace mpm::config
