#include "libmpm/config/guard.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <system_error>

#include "libmpm/base/error.hpp"

namespace mpm::config {

namespace {

/// Past a TOML string that begins at text[at]; past the end of the line if it is not closed there (the parser reports that).
std::size_t end_of_string(std::string_view text, std::size_t at) {
  const char quote = text[at];
  const std::string_view triple = quote == '"' ? R"(""")" : "'''";
  const bool multi_line = text.substr(at, triple.size()) == triple;
  for (at += multi_line ? triple.size() : 1; at < text.size(); ++at) {
    if (multi_line ? text.substr(at, triple.size()) == triple : text[at] == quote) return at + (multi_line ? triple.size() : 1);
    if (quote == '"' && text[at] == '\\') {
      ++at;
    } else if (!multi_line && text[at] == '\n') {
      return at;
    }
  }
  return text.size();
}

/// Whether a name follows the bracket at text[at] that begins the header of a table. The parser assumes that; if it was built with
/// assertions, the program would end.
bool names_a_table(std::string_view text, std::size_t at) {
  at += text.substr(at, 2) == "[[" ? 2 : 1;
  while (at < text.size() && (text[at] == ' ' || text[at] == '\t')) ++at;
  constexpr std::string_view first =
      "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789_-\"']";  // ]: the parser reports that error
  return at >= text.size() || first.find(text[at]) != std::string_view::npos;
}

}  // namespace

void check_text(std::string_view text, std::string_view file_name) {
  if (text.size() > most_bytes) {
    throw ConfigError(fmt::format("{}:1:1: the file is larger than {} MB; a case has a few kB, is this one?", file_name, most_bytes >> 20));
  }
  std::size_t line = 1, line_start = 0;
  int parts = 1, open_brackets = 0;
  bool line_is_blank = true;  // so far
  const std::size_t byte_order_mark = text.starts_with("\xef\xbb\xbf") ? 3 : 0;
  for (std::size_t at = 0; at < text.size();) {
    const char c = text[at];
    if (c == '#') {
      at = std::min(text.find('\n', at), text.size());
      continue;
    }
    if (c == '"' || c == '\'') {
      const std::size_t end = end_of_string(text, at);
      line_is_blank = false;
      for (; at < end; ++at) {
        if (text[at] != '\n') continue;
        ++line;
        line_start = at + 1;
      }
      continue;
    }
    constexpr unsigned char last_ascii = 0x7f;
    if (static_cast<unsigned char>(c) > last_ascii && at >= byte_order_mark) {
      throw ConfigError(fmt::format("{}:{}:{}: not valid TOML: a character that is not ASCII is outside quotes and comments", file_name,
                                    line, at - line_start + 1));
    }
    if (c == '.' && ++parts > most_key_parts) {
      throw ConfigError(fmt::format("{}:{}:{}: a key of more than {} parts; keys here have at most three, table.table.key", file_name, line,
                                    at - line_start + 1, most_key_parts));
    }
    if (c == '[' && line_is_blank && open_brackets == 0 && !names_a_table(text, at)) {
      throw ConfigError(fmt::format("{}:{}:{}: not valid TOML: a table has a name of letters, digits, _ and -, or in quotes", file_name,
                                    line, at - line_start + 1));
    }
    if (c == '[' || c == '{') ++open_brackets;
    if ((c == ']' || c == '}') && open_brackets > 0) --open_brackets;
    line_is_blank = c == '\n' || (line_is_blank && (c == ' ' || c == '\t' || c == '\r'));
    if (c == '\n') {
      ++line;
      line_start = at + 1;
    }
    if (std::string_view("\n,=[]{}").find(c) != std::string_view::npos) parts = 1;
    ++at;
  }
}

std::string bounded_file_text(const std::filesystem::path& file) {
  std::error_code failed;
  const bool missing = std::filesystem::status(file, failed).type() == std::filesystem::file_type::not_found;
  if (missing && !file.empty()) throw IoError(fmt::format("'{}' does not exist; check the path", file.string()));
  std::ifstream in;
  if (!std::filesystem::is_directory(file, failed)) in.open(file, std::ios::binary);
  std::string text;
  while (in.is_open() && in && text.size() <= most_bytes) {
    constexpr std::size_t piece = std::size_t{64} << 10;
    const std::size_t before = text.size();
    text.resize(std::min(before + piece, most_bytes + 1));
    in.read(text.data() + before, static_cast<std::streamsize>(text.size() - before));
    text.resize(before + static_cast<std::size_t>(in.gcount()));
  }
  if (!in.is_open() || in.bad()) throw IoError(fmt::format("{}: cannot be read; give the path of a TOML file", file.string()));
  return text;
}

bool has_table(std::string_view text, std::string_view table) {
  const std::string header = "\n[" + std::string(table) + "]";
  return text.starts_with(header.substr(1)) || text.find(header) != text.npos;
}

}  // namespace mpm::config
