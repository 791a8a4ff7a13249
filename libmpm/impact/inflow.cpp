#include "libmpm/impact/inflow.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "libmpm/base/parameter.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/io/csv.hpp"

namespace mpm {

Inflow::Inflow(const ConveyorSpec& conveyor) : slip_ratio_(conveyor.slip_ratio), exponent_(conveyor.shear_exponent) {
  for (const InflowPoint& p : conveyor.inflow) {
    points_.push_back({p.time, p.velocity.value_or(conveyor.velocity), p.flow_height.value_or(conveyor.flow_height), p.density_ratio, 0.0});
  }
  if (points_.empty()) points_.push_back({0.0, conveyor.velocity, conveyor.flow_height, 1.0, 0.0});
  for (std::size_t i = 1; i < points_.size(); ++i) {
    const Point& before = points_[i - 1];
    points_[i].travelled = before.travelled + 0.5 * (before.velocity + points_[i].velocity) * (points_[i].time - before.time);
  }
}

Inflow::Between Inflow::between(double time) const {
  const auto after = std::find_if(points_.begin(), points_.end(), [&](const Point& p) { return p.time > time; });
  if (after == points_.begin()) return {&points_.front(), &points_.front(), 0.0};
  if (after == points_.end()) return {&points_.back(), &points_.back(), 0.0};
  const Point &a = *(after - 1), &b = *after;
  return {&a, &b, (time - a.time) / (b.time - a.time)};
}

double Inflow::interpolated(double time, double Point::*what) const {
  const Between p = between(time);
  return p.a->*what + p.fraction * (p.b->*what - p.a->*what);
}

double Inflow::travelled_since_first(double time) const {
  const Between p = between(time);
  return p.a->travelled + 0.5 * (p.a->velocity + velocity(time)) * (time - p.a->time);
}

double Inflow::travelled(double time) const {
  if (steady()) return points_.front().velocity * time;
  return travelled_since_first(time) - travelled_since_first(0.0);
}

double Inflow::fastest() const { return std::ranges::max_element(points_, {}, &Point::velocity)->velocity; }

double Inflow::highest() const { return std::ranges::max_element(points_, {}, &Point::flow_height)->flow_height; }

double Inflow::shear(double relative_height) const {
  if (!sheared()) return 1.0;
  return slip_ratio_ + (1.0 - slip_ratio_) * (1.0 + exponent_) * std::pow(std::clamp(relative_height, 0.0, 1.0), exponent_);
}

double Inflow::mean_shear(double from, double to) const {
  if (!sheared()) return 1.0;
  return slip_ratio_ + (1.0 - slip_ratio_) * (std::pow(to, 1.0 + exponent_) - std::pow(from, 1.0 + exponent_)) / (to - from);
}

namespace {

constexpr std::uintmax_t most_bytes = 8U << 20U;  // as of a case file
constexpr const char* density_column = "density_kg_m3";
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
      return report.problem(key,
                            fmt::format("{} has no column {}, only '{}'; the first line names time_s, depth_m, velocity_m_s and perhaps "
                                        "density_kg_m3, with commas between",
                                        problem_start, column, fmt::join(table.columns(), ",")));
  }
  if (!table.has(density_column)) {  // a misspelt one would count as constant density
    for (const std::string& column : table.columns()) {
      if (column.find("density") != std::string::npos || nearest_word(column, {density_column}) == density_column)
        return report.problem(key, fmt::format("{} has a column {}; did you mean {}?", problem_start, column, density_column));
    }
  }
  if (table.rows() == 0) return report.problem(key, problem_start + " has no rows; give at least one");
  const std::vector<double> time = table.numbers("time_s"), depth = table.numbers("depth_m"), velocity = table.numbers("velocity_m_s");
  const std::vector<double> densities =
      table.has(density_column) ? table.numbers(density_column) : std::vector<double>(table.rows(), density);
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
  if (!report.valid("material.density_kg_m3")) return;
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
