#include "libmpm/campaign/run_name.hpp"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <cctype>

#include "libmpm/config/toml_text.hpp"
#include "libmpm/io/csv.hpp"

namespace mpm {

namespace {

/// A TOML value as part of a name: 3.0 is 3.
std::string value_in_name(const std::string& value) {
  const toml::table parsed = toml::parse("value = " + value);
  const toml::node& node = *parsed.get("value");
  if (const auto x = node.value<double>(); x && node.is_number()) return file_name_part(format_number(*x));
  if (const auto text = node.value_exact<std::string>()) return file_name_part(*text);
  return file_name_part(value);
}

}  // namespace

const std::map<std::string, std::string>& common_labels() {
  static const std::map<std::string, std::string> labels{
      {"material.model", ""},
      {"material.critical_state_slope", "m"},
      {"material.cohesion_beta", "beta"},
      {"material.hardening_xi", "xi"},
      {"conveyor.froude_number", "fr"},
      {"conveyor.velocity_m_s", "v"},
      {"conveyor.flow_height_m", "h"},
      {"conveyor.feed", ""},
      {"obstacle.width_m", "w"},
      {"obstacle.friction", "mu"},
      {"obstacle.friction_ratio", "mur"},
      {"obstacle.shape", ""},
      {"numerics.cell_size_m", "dx"},
      {"numerics.slope_deg", "slope"},
      {"numerics.transfer", ""},
      {"numerics.particles_per_cell", "ppc"},
      {"output.duration_s", "t"},
  };
  return labels;
}

std::string file_name_part(const std::string& text) {
  std::string part;
  for (const char c : text) {
    const bool safe = (std::isalnum(static_cast<unsigned char>(c)) != 0) || c == '.' || c == '_' || c == '+' || c == '-';
    if (safe) {
      part += c;
    } else if (!part.empty() && part.back() != '-') {
      part += '-';
    }
  }
  while (part.ends_with('-')) part.pop_back();
  return part;
}

std::string name_problem(const std::string& name) {
  constexpr std::size_t longest = 200;
  const bool usable = !name.empty() && name.size() <= longest && name == file_name_part(name) && name.front() != '.' && name.front() != '-';
  if (usable) return {};
  return fmt::format("\"{}\" names no folder; use 1 to {} letters, digits, '.', '_', '+' and '-', and do not begin with '.' or '-'",
                     config::one_line(name), longest);
}

std::string run_name(const std::vector<Setting>& varied, const std::map<std::string, std::string>& labels) {
  std::string name;
  for (const Setting& s : varied) {
    const auto label = labels.find(s.key);
    const std::string key = label != labels.end() ? label->second : file_name_part(s.key.substr(s.key.rfind('.') + 1));
    name += fmt::format("{}{}{}", name.empty() ? "" : "_", key, value_in_name(s.value));
  }
  return name;
}

}  // namespace mpm
