#include "libmpm/io/json.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <cstdint>

#include "libmpm/base/error.hpp"
#include "libmpm/io/atomic_file.hpp"

namespace mpm {

std::string read_json_text(const std::filesystem::path& path) {
  constexpr std::uintmax_t most_bytes = std::uintmax_t{256} << 20;
  constexpr int deepest = 64;
  std::string text = read_file(path, most_bytes);
  int depth = 0;
  bool quoted = false;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    if (quoted && c == '\\') {
      ++at;
    } else if (c == '"') {
      quoted = !quoted;
    } else if (!quoted && (c == '[' || c == '{')) {
      if (++depth > deepest)
        throw IoError(fmt::format("cannot read '{}': it is nested deeper than {}; this is no file of this program, delete it",
                                  path.string(), deepest));
    } else if (!quoted && (c == ']' || c == '}')) {
      --depth;
    }
  }
  return text;
}

namespace {

/// Place of the value of the entry; npos without one.
std::size_t place_of_checksum(std::string_view json) {
  const std::string before = fmt::format("\"{}\": \"", checksum_entry);
  const std::size_t at = json.find(before);
  return at == std::string_view::npos ? at : at + before.size();
}

constexpr std::size_t digits = 8;

}  // namespace

std::string checksum(std::string_view text) {
  const uLong crc = crc32_z(crc32_z(0, nullptr, 0), reinterpret_cast<const Bytef*>(text.data()), text.size());
  return fmt::format("{:08x}", static_cast<std::uint32_t>(crc));
}

std::string with_checksum(std::string json) {
  if (const std::size_t at = place_of_checksum(json); at != std::string::npos) json.replace(at, digits, checksum(json));
  return json;
}

bool is_intact(const std::string& json) {
  const std::size_t at = place_of_checksum(json);
  if (at == std::string::npos) return json.find(checksum_entry) == std::string::npos;  // also as the end of another entry's name
  if (json.size() < at + digits) return false;
  std::string blank = json;
  return with_checksum(blank.replace(at, digits, no_checksum)) == json;
}

}  // namespace mpm
