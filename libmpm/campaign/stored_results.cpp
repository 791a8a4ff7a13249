#include "libmpm/campaign/stored_results.hpp"

#include <algorithm>
#include <cstdlib>
#include <limits>
#include <string_view>

#include "libmpm/base/text.hpp"
#include "libmpm/config/schema.hpp"
#include "libmpm/driver/case_schema.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/impact/semi_empirical.hpp"
#include "libmpm/impact/steady.hpp"
#include "libmpm/io/csv.hpp"

namespace mpm {

const std::vector<InputColumn>& input_columns() {
  static constexpr double none = std::numeric_limits<double>::quiet_NaN();
  const auto belt = [](auto get) { return [=](const Case& c) { return c.conveyor ? get(*c.conveyor, c) : none; }; };
  const auto mast = [](auto get) { return [=](const Case& c) { return c.obstacle ? get(*c.obstacle, c) : none; }; };
  const auto snow = [](auto get) {
    return [=](const Case& c) {
      const CamClay::Parameters* m = c.material.get_if<CamClay>();
      return m != nullptr ? get(*m) : none;
    };
  };
  static const std::vector<InputColumn> inputs{
      {"froude_number", "conveyor.froude_number", belt([](const ConveyorSpec& b, const Case& c) {
         return c.numerics.gravity > 0.0 ? froude_number(b.velocity, b.flow_height, c.numerics.gravity) : none;
       })},
      {"velocity_m_s", "conveyor.velocity_m_s", belt([](const ConveyorSpec& b, const Case&) { return b.velocity; })},
      {"flow_height_m", "conveyor.flow_height_m", belt([](const ConveyorSpec& b, const Case&) { return b.flow_height; })},
      {"conveyor_width_m", "conveyor.width_m", belt([](const ConveyorSpec& b, const Case&) { return b.width; })},
      {"gravity_m_s2", "numerics.gravity_m_s2", belt([](const ConveyorSpec&, const Case& c) { return c.numerics.gravity; })},
      {"critical_state_slope", "material.critical_state_slope", snow([](const CamClay::Parameters& m) { return m.critical_state_slope; })},
      {"cohesion_beta", "material.cohesion_beta", snow([](const CamClay::Parameters& m) { return m.cohesion_beta; })},
      {"hardening_xi", "material.hardening_xi", snow([](const CamClay::Parameters& m) { return m.hardening_xi; })},
      {"effective_friction", "", [](const Case& c) { return c.material.critical_state_ratio().value_or(none); }},
      {"plastic_compressibility", "", snow([](const CamClay::Parameters& m) {
         constexpr double quoted_at = 25e3;  // Pa; the paper's chi
         return plastic_compressibility(m.hardening_xi, quoted_at, m.preconsolidation_pressure,
                                        bulk_modulus(m.young_modulus, m.poisson_ratio));
       })},
      {"obstacle_width_m", "obstacle.width_m", mast([](const ObstacleSpec& o, const Case&) { return o.width(); })},
      {"relative_width", "",
       mast([](const ObstacleSpec& o, const Case& c) { return c.conveyor ? o.width() / c.conveyor->flow_height : none; })},
      {"obstacle_friction", "obstacle.friction", mast([](const ObstacleSpec& o, const Case&) { return o.friction; })},
      {"obstacle_friction_ratio", "obstacle.friction_ratio",
       mast([](const ObstacleSpec& o, const Case& c) { return o.friction / c.material.internal_friction().value_or(none); })},
      {"cell_size_m", "numerics.cell_size_m", [](const Case& c) { return c.numerics.cell_size; }},
  };
  return inputs;
}

namespace {

bool is_case_key(std::string_view column) {
  const std::size_t dot = column.find('.');
  return dot != std::string_view::npos && case_schema().find_key(column.substr(0, dot), column.substr(dot + 1)) != nullptr;
}

/// Whether a column tells of the campaign or of the case, and not of the results.
bool describes_the_run(const std::string& column) {
  constexpr std::string_view own[] = {"name", "run", "status", "cause"};
  return std::ranges::find(own, column) != std::end(own) || is_case_key(column) ||
         std::ranges::any_of(input_columns(), [&](const InputColumn& input) { return input.column == column; });
}

/// A cell of results.csv as results.json has it.
Value value_of(const std::string& column, const std::string& cell) {
  if (column == "case_hash" || column == "version" || column == "commit") return cell;  // a hash may look like a number
  if (cell == "nan") return MeanEstimate::none;
  if (cell.size() < 19 && cell.find_first_not_of("0123456789") == std::string::npos)
    return std::uint64_t{std::strtoull(cell.c_str(), nullptr, 10)};
  const auto number = parse_number(cell);
  return number ? Value(*number) : Value(cell);
}

}  // namespace

StoredResults::StoredResults(const std::vector<std::filesystem::path>& tables) {
  for (const std::filesystem::path& path : tables) {
    const Table table = Table::read(path);
    const std::vector<std::string> hashes = table.text("case_hash"), status = table.text("status");
    std::vector<Results> results(table.rows());
    for (const std::string& column : table.columns()) {
      if (describes_the_run(column)) continue;
      const std::vector<std::string> cells = table.text(column);
      for (std::size_t i = 0; i < cells.size(); ++i) {
        if (!cells[i].empty()) results[i].add({column, value_of(column, cells[i]), {}, {}});
      }
    }
    for (std::size_t i = 0; i < table.rows(); ++i) {
      if (status[i] == "done") rows_.emplace(hashes[i], std::move(results[i]));
    }
  }
}

std::optional<Results> StoredResults::of(const Case& c, const std::string& case_hash) const {
  const auto [first, last] = rows_.equal_range(case_hash);
  const auto whole = std::find_if(first, last, [&](const auto& row) { return is_whole_run(row.second, c); });
  return whole == last ? std::nullopt : std::optional(whole->second);
}

}  // namespace mpm
