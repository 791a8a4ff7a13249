#include "libmpm/io/json_text.hpp"

#include <fmt/format.h>

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

}  // namespace mpm
