#include "libmpm/config/value_text.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

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
