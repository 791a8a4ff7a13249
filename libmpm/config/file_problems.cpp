#include "libmpm/config/file_problems.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <span>
#include <tuple>

#include "libmpm/base/error.hpp"

namespace mpm::config {

namespace {

/// "body[0]" of "body[0].min_m", "body" of "body[0]"; empty at the end.
std::string outer(const std::string& path) {
  const std::size_t cut = path.ends_with(']') ? path.rfind('[') : path.rfind('.');
  return cut == std::string::npos ? "" : path.substr(0, cut);
}

}  // namespace

FileProblems::FileProblems(std::string file) : file_(std::move(file)) { enter_table("", in_file(1, 1)); }

FilePosition FileProblems::in_file(std::uint32_t line, std::uint32_t column) const {
  line = std::max<std::uint32_t>(1, line), column = std::max<std::uint32_t>(1, column);
  return {0, line, column, fmt::format("{}:{}:{}", file_, line, column)};
}

void FileProblems::enter_table(const std::string& path, const FilePosition& place) {
  places_[path] = place;
  tables_.insert(path);
}

bool FileProblems::valid(const std::string& path) const {
  for (std::string part = path; !part.empty(); part = outer(part)) {
    if (invalid_.contains(part)) return false;
  }
  return true;
}

const FilePosition& FileProblems::position_of(const std::string& path) const {
  for (const std::string& part : {path, outer(path)}) {
    if (const auto at = places_.find(part); at != places_.end()) return at->second;
  }
  return places_.at("");
}

void FileProblems::problem(const std::string& path, const std::string& text) {
  if (path.empty()) return add(position_of(path), text);
  if (tables_.contains(path)) return add(position_of(path), fmt::format("[{}] {}", path, text));
  const std::string table = outer(path);
  const std::string key = table.empty() ? path : path.substr(table.size() + 1);
  add(position_of(path), fmt::format("{}{} {}", table.empty() ? "" : fmt::format("[{}] ", table), key, text));
  mark_invalid(path);
}

void FileProblems::add(const FilePosition& place, const std::string& text) {
  if (!given_up()) problems_.push_back({place, text});
}

bool FileProblems::given_up() const { return problems_.size() >= most_problems; }

void FileProblems::throw_if_any() {
  if (problems_.empty()) return;
  std::ranges::stable_sort(problems_, {}, [](const Problem& f) { return std::tuple(f.place.source_number, f.place.line, f.place.column); });
  std::string message;
  for (const Problem& f : std::span(problems_).first(std::min(problems_.size(), problems_shown)))
    message += fmt::format("{}{}: {}", message.empty() ? "" : "\n", f.place.text, f.text);
  if (problems_.size() > problems_shown) {
    message += fmt::format("\n{}: {}{} more errors; fix these first, or check that this is the right file", file_,
                           given_up() ? "at least " : "", problems_.size() - problems_shown);
  }
  throw ConfigError(message);
}

}  // namespace mpm::config
