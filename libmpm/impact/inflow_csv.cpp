#include "libmpm/impact/inflow_csv.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "libmpm/base/parameter.hpp"
#include "libmpm/io/csv.hpp"

namespace mpm {

namespace {

constexpr std::uintmax_t most_bytes = 8U << 20U;    // as of a case file
constexpr double deepest = 100.0, fastest = 200.0;  // m, m/s: beyond, the unit is wrong
constexpr double loosest = 1.0, densest = 2.0;      // of density_ratio

/// The error of one row; empty if there is none.
std::string row_problem(double time, double before, double depth, double velocity, double ratio) {
  if (!std::isfinite(time) || time < 0.0) return fmt::format("time_s = {}; give times from 0 on", time);
  if (!(time > before)) return fmt::format("time_s = {} is not above that of the row before, {}; sort the rows", time, before);
  if (!(depth > 0.0) || depth > deepest)
    return fmt::format("depth_m = {} is not above 0 and at most {} m; leave out rows without flow, and check the unit", depth, deepest);
  if (!(velocity > 0.0) || velocity > fastest)
    return fmt::format("velocity_m_s = {} is not above 0 and at most {} m/s; leave out rows at rest, and check the unit", velocity,
                       fastest);
  if (!(ratio >= loosest && ratio <= densest)) {
    return fmt::format(
        "density_kg_m3 is {:.4g} times material.density_kg_m3; {:g} to {:g} times are possible, give the material the density "
        "of the loosest row",
        ratio, loosest, densest);
  }
  return {};
}

void read_rows(ConveyorSpec& belt, const Table& table, double density, const std::string& problem_start, ParameterReport& report) {
  const std::string key = "conveyor.inflow_csv";
  for (const char* column : {"time_s", "depth_m", "velocity_m_s"}) {
    if (!table.has(column))
      return report.problem(key, fmt::format("{} has no column {}; the first line names time_s, depth_m, velocity_m_s and perhaps "
                                             "density_kg_m3",
                                             problem_start, column));
  }
  if (table.rows() == 0) return report.problem(key, problem_start + " has no rows; give at least one");
  const std::vector<double> time = table.numbers("time_s"), depth = table.numbers("depth_m"), velocity = table.numbers("velocity_m_s");
  const std::vector<double> densities =
      table.has("density_kg_m3") ? table.numbers("density_kg_m3") : std::vector<double>(table.rows(), density);
  std::size_t strongest = 0;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    const double ratio = densities[i] / density;
    const std::string problem = row_problem(time[i], i > 0 ? time[i - 1] : -1.0, depth[i], velocity[i], ratio);
    if (!problem.empty()) return report.problem(key, fmt::format("{}, row {}: {}", problem_start, i + 1, problem));
    belt.inflow.push_back({time[i], velocity[i], depth[i], ratio});
    if (depth[i] * velocity[i] * velocity[i] > depth[strongest] * velocity[strongest] * velocity[strongest]) strongest = i;
  }
  if (!report.given("conveyor.velocity_m_s") && !report.given("conveyor.froude_number")) belt.velocity = velocity[strongest];
  if (!report.given("conveyor.flow_height_m")) belt.flow_height = depth[strongest];
}

}  // namespace

void read_inflow_csv(ConveyorSpec& belt, const std::filesystem::path& folder, double density, ParameterReport& report) {
  if (!belt.inflow_csv) return;
  const std::string name = *belt.inflow_csv, key = "conveyor.inflow_csv", start = fmt::format("= \"{}\"", name);
  belt.inflow_csv.reset();
  if (!belt.inflow.empty()) return report.problem(key, start + " is given beside [[conveyor.inflow]]; leave out one of the two");
  if (!report.sound("material.density_kg_m3")) return;
  std::error_code error;  // a device without end is not a table
  if (const auto size = std::filesystem::file_size(folder / name, error); !error && size > most_bytes)
    return report.problem(key, fmt::format("{} has {} bytes; at most {} are read, leave out rows", start, size, most_bytes));
  if (!std::filesystem::is_regular_file(folder / name, error))
    return report.problem(
        key, fmt::format("{}: there is no such file; it is looked for beside the case, as '{}'", start, (folder / name).string()));
  try {
    read_rows(belt, Table::read(folder / name), density, start, report);
  } catch (const IoError& unreadable) {
    report.problem(key, fmt::format("{}: {}", start, unreadable.what()));
  }
}

}  // namespace mpm
