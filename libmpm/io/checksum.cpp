#include "libmpm/io/checksum.hpp"

#include <fmt/format.h>
#include <zlib.h>

#include <cstdint>

namespace mpm {

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
