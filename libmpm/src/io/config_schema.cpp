#include "mpm/io/schema.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "config_keys.hpp"
#include "mpm/io/config.hpp"

namespace mpm {

const std::vector<TableInfo>& schema_tables() {
  static const std::vector<TableInfo> tables{
      {"", false, true, true, "Keys above the first table"},
      {"material", false, true, true, "The snow: one constitutive law and its parameters"},
      {"conveyor", false, true, false,
       "The paper's set-up: snow on a frictionless belt between moving side walls meets the obstacle. It stands instead of [[body]] and "
       "[[wall]]"},
      {"conveyor.inflow", true, true, false,
       "Inflow that varies in time, with feed = \"window\": linear between these rows, constant before the first and after the last"},
      {"obstacle", false, true, false, "Rigid obstacle with separable Coulomb contact; left out: none"},
      {"body", true, true, false, "A piece of material in a scene by hand (without [conveyor]), any number"},
      {"wall", true, true, false, "A half-space in a scene by hand, any number; acts on grid nodes on or behind its plane"},
      {"domain", false, true, false,
       "Where particles may be. Required in a scene by hand; with [conveyor] it may only cut the belt's own domain"},
      {"numerics", false, true, false, "Grid, particles and time step"},
      {"measurement", false, true, false,
       "Windows of the pressure profile on the obstacle. Left out, they follow the cell size as in the paper; a grid study fixes them"},
      {"output", false, true, false, "How long, and what is written"},
      {"path", false, false, true, "Strain path of one material point, for `mpm point`"},
      {"path.segments", true, false, true,
       "A list of inline tables: {d_eps_v, d_eps_q}, {velocity_gradient, time_s} or {radial_stress_pa, d_eps_axial}"},
  };
  return tables;
}

const std::vector<ModelInfo>& schema_models() {
  static const std::vector<ModelInfo> models{
      {"cohesive_cam_clay",
       "Cohesive Modified Cam-Clay: yield q^2 (1 + 2 beta) + M^2 (p + beta p_c)(p - p_c), p_c = K sinh(xi X)",
       {"young_modulus_pa", "poisson_ratio", "critical_state_slope", "cohesion_beta", "hardening_xi", "preconsolidation_pressure_pa"}},
      {"hencky_elastic", "Saint-Venant-Kirchhoff elasticity in Hencky strain", {"young_modulus_pa", "poisson_ratio"}},
      {"drucker_prager",
       "Drucker-Prager cone q = A p + C, dilatancy of its own, tears and recompacts; mu(I) rate dependence if its four keys are given",
       {"young_modulus_pa", "poisson_ratio", "cone_matching", "friction_angle_deg", "cohesion_pa", "dilatancy_angle_deg",
        "limit_friction_angle_deg", "reference_inertial_number", "grain_diameter_m", "grain_density_kg_m3"}},
      {"weakly_compressible_fluid",
       "Tait fluid p = K/n ((rho/rho_0)^n - 1) with Newtonian viscosity; tears where it would be pulled",
       {"bulk_modulus_pa", "tait_exponent", "viscosity_pa_s", "carries_tension"}},
  };
  return models;
}

const std::vector<KeyInfo>& schema_keys() {
  static const std::vector<KeyInfo> infos(config::keys().begin(), config::keys().end());
  return infos;
}

namespace {

std::string type_text(const KeyInfo& key) {
  switch (key.type) {
    case KeyType::text:
    case KeyType::choice: return "string";
    case KeyType::number: return "number";
    case KeyType::integer: return "integer";
    case KeyType::boolean: return "true or false";
    case KeyType::vector: return "[x, y, z]";
    case KeyType::matrix: return "3 x 3 numbers by rows";
    case KeyType::axes: return "list of strings";
  }
  return {};
}

std::string range_text(const Range& range) {
  return fmt::format("{}{:g}, {:g}{}", range.low_open ? '(' : '[', range.low, range.high, range.high_open ? ')' : ']');
}

}  // namespace

std::string schema_text() {
  std::string out = fmt::format(
      "Reference of case files, format version {}. TOML 1.0, SI units as named in the keys.\n"
      "A key that is not listed, or that does not apply, is refused. Ranges: [ ] with, ( ) without the end.\n",
      case_format_version);
  for (const TableInfo& table : schema_tables()) {
    const std::string title = table.name.empty() ? "(top)" : table.repeated ? "[[" + table.name + "]]" : "[" + table.name + "]";
    out += fmt::format("\n{}  {}.\n", title, table.description);
    for (const KeyInfo& key : schema_keys()) {
      if (key.table != table.name) continue;
      std::string kind = type_text(key);
      if (!key.unit.empty()) kind += ", " + key.unit;
      if (key.range) kind += ", " + range_text(*key.range);
      out += fmt::format("  {:<30}{}\n", key.name, kind);
      const auto detail = [&](std::string_view what, const std::string& text) {
        if (!text.empty()) out += fmt::format("      {:<9} {}\n", what, text);
      };
      out += fmt::format("      {}.\n", key.description);
      detail("one of", fmt::format("{}", fmt::join(key.choices, ", ")));
      detail("required", key.required_when);
      detail("default", key.default_text);
      detail("only with", key.used_when);
    }
  }
  out += "\nLaws (material.model), and the keys of [material] they use besides model and density_kg_m3:\n";
  for (const ModelInfo& model : schema_models()) {
    out += fmt::format("  {}\n      {}.\n      keys      {}\n", model.name, model.description, fmt::join(model.keys, ", "));
  }
  return out;
}

std::string schema_json() {
  using nlohmann::ordered_json;
  ordered_json root;
  root["format_version"] = case_format_version;
  for (const TableInfo& table : schema_tables()) {
    ordered_json keys = ordered_json::array();
    for (const KeyInfo& key : schema_keys()) {
      if (key.table != table.name) continue;
      ordered_json entry{{"name", key.name}, {"type", type_text(key)}, {"unit", key.unit}, {"description", key.description}};
      if (key.range) {
        entry["range"] = ordered_json{
            {"low", key.range->low}, {"high", key.range->high}, {"low_open", key.range->low_open}, {"high_open", key.range->high_open}};
      }
      if (!key.choices.empty()) entry["one_of"] = key.choices;
      if (!key.default_text.empty()) entry["default"] = key.default_text;
      if (!key.required_when.empty()) entry["required"] = key.required_when;
      if (!key.used_when.empty()) entry["only_with"] = key.used_when;
      keys.push_back(entry);
    }
    root["tables"].push_back({{"name", table.name},
                              {"repeated", table.repeated},
                              {"in_case", table.in_case},
                              {"in_path", table.in_path},
                              {"description", table.description},
                              {"keys", keys}});
  }
  for (const ModelInfo& model : schema_models()) {
    root["models"].push_back({{"name", model.name}, {"description", model.description}, {"keys", model.keys}});
  }
  return root.dump(2) + "\n";
}

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
