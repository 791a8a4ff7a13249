#include "mpm/impact/study_table.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "mpm/error.hpp"
#include "mpm/impact/semi_empirical.hpp"
#include "mpm/io/atomic_file.hpp"
#include "mpm/io/table.hpp"

namespace mpm {
namespace {

std::optional<double> number_of(const std::string& cell) {
  double value = 0.0;
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  return error == std::errc() && end == cell.data() + cell.size() ? std::optional(value) : std::nullopt;
}

/// Name of the column that is meant; empty if there is none. @throws IoError where several end in it
std::string find_column(const Table& table, const std::filesystem::path& file, const std::string& name) {
  if (table.has(name)) return name;
  std::vector<std::string> found;
  for (const std::string& column : table.columns()) {
    if (column.ends_with("." + name)) found.push_back(column);
  }
  if (found.size() > 1) {
    throw IoError(fmt::format("{}: '{}' may be {}; name one of them '{}'", file.string(), name, fmt::join(found, " or "), name));
  }
  return found.empty() ? "" : found.front();
}

/// Columns of one file by the names that this page of code uses.
class Columns {
 public:
  Columns(const Table& table, const std::filesystem::path& file) : table_(table), file_(file) {}

  /// NaN in every row where there is no such column.
  [[nodiscard]] std::vector<double> optional(std::initializer_list<const char*> names) const {
    for (const char* name : names) {
      if (const std::string column = find_column(table_, file_, name); !column.empty()) return table_.numbers(column);
    }
    return std::vector<double>(table_.rows(), StudyRun::none);
  }
  [[nodiscard]] std::vector<double> needed(const char* name, const char* instead = nullptr) const {
    if (find_column(table_, file_, name).empty()) {
      throw IoError(fmt::format("{}: no column '{}'{}; there are: {}", file_.string(), name,
                                instead != nullptr ? fmt::format(" (or {})", instead) : "", fmt::join(table_.columns(), ", ")));
    }
    return optional({name});
  }
  [[nodiscard]] std::vector<std::string> text(std::initializer_list<const char*> names) const {
    for (const char* name : names) {
      if (const std::string column = find_column(table_, file_, name); !column.empty()) return table_.text(column);
    }
    return std::vector<std::string>(table_.rows());
  }
  [[nodiscard]] bool has(const char* name) const { return !find_column(table_, file_, name).empty(); }

 private:
  const Table& table_;
  const std::filesystem::path& file_;
};

/// Runs of one file, in its order.
std::vector<StudyRun> runs_of(const Table& table, const std::filesystem::path& file) {
  const Columns columns(table, file);
  const bool by_slope = !columns.has("effective_friction");
  const auto slope = by_slope ? columns.needed("critical_state_slope", "effective_friction") : columns.optional({"critical_state_slope"});
  const auto beta = by_slope ? columns.needed("cohesion_beta", "effective_friction") : columns.optional({"cohesion_beta"});
  const auto friction = columns.optional({"effective_friction"});
  const bool by_velocity = !columns.has("froude_number");
  const auto speed = by_velocity ? columns.needed("velocity_m_s", "froude_number") : columns.needed("froude_number");
  const auto xi = columns.needed("hardening_xi"), height = columns.needed("flow_height_m");
  const auto width = columns.optional({"obstacle.width_m", "obstacle_width_m"}), gravity = columns.optional({"gravity_m_s2"});
  const auto runup = columns.needed("runup_mean_m"), pressure_height = columns.needed("pressure_height_mean_m");
  const auto runup_error = columns.optional({"runup_standard_error_m"}), runup_peak = columns.optional({"runup_peak_m"});
  const auto pressure_error = columns.optional({"pressure_height_standard_error_m"}),
             pressure_peak = columns.optional({"pressure_height_peak_m"}), compaction = columns.optional({"compaction_mean"});
  const auto folder = columns.text({"run", "name"});

  std::vector<StudyRun> runs;
  for (std::size_t i = 0; i < table.rows(); ++i) {
    StudyRun r;
    if (!folder[i].empty()) r.folder = file.parent_path() / folder[i];
    r.gravity = std::isfinite(gravity[i]) ? gravity[i] : standard_gravity;
    r.flow_height = height[i];
    r.obstacle_width = std::isfinite(width[i]) ? width[i] : height[i];
    r.froude = by_velocity ? froude_number(speed[i], height[i], r.gravity) : speed[i];
    r.velocity = by_velocity ? speed[i] : flow_velocity(speed[i], height[i], r.gravity);
    r.critical_state_slope = slope[i];
    r.cohesion_beta = beta[i];
    r.effective_friction = by_slope ? effective_friction(slope[i], beta[i]) : friction[i];
    r.hardening_xi = xi[i];
    r.runup = runup[i] / height[i];
    r.runup_error = runup_error[i] / height[i];
    r.runup_peak = runup_peak[i] / height[i];
    r.pressure_height = pressure_height[i] / height[i];
    r.pressure_height_error = pressure_error[i] / height[i];
    r.pressure_height_peak = pressure_peak[i] / height[i];
    r.compaction = compaction[i];
    runs.push_back(std::move(r));
  }
  return runs;
}

/// Why a row has no steady run-up, in the table's own words where it has some.
std::string why_no_mean(const std::string& status, const std::string& steady) {
  static const std::set<std::string> fine{"", "ok", "done", "finished"};
  if (!fine.contains(status)) return "status: " + status;
  if (steady == "false" || steady == "0") return "no steady span";
  return "no steady mean of the run-up";
}

std::vector<std::string> comments_of(const std::filesystem::path& file) {
  std::vector<std::string> lines;
  const std::string content = read_file(file);
  std::string_view rest = content;
  while (!rest.empty()) {
    const std::size_t newline = std::min(rest.find('\n'), rest.size());
    if (rest.front() == '#') {
      const std::string_view line = rest.substr(1, newline - 1);
      lines.emplace_back(line.substr(std::min(line.find_first_not_of(' '), line.size())));
    }
    rest = rest.substr(std::min(newline + 1, rest.size()));
  }
  return lines;
}

/// What runs.csv of a campaign says about how its runs were computed; nothing where there is none.
std::vector<std::string> executions_of(const std::filesystem::path& file) {
  if (!std::filesystem::exists(file)) return {};
  const Table table = Table::read(file);
  std::vector<std::string> lines;
  std::map<std::string, std::size_t> machines;
  if (table.has("instruction_set") && table.has("compiler") && table.has("threads")) {
    const auto instructions = table.text("instruction_set"), compiler = table.text("compiler"), threads = table.text("threads");
    for (std::size_t i = 0; i < table.rows(); ++i) {
      if (!threads[i].empty()) ++machines[fmt::format("{} thread(s) a run, {}, {}", threads[i], instructions[i], compiler[i])];
    }
  }
  lines.reserve(machines.size() + 1);
  for (const auto& [machine, runs] : machines) lines.push_back(fmt::format("{} runs with {}", runs, machine));
  if (table.has("wall_time_s")) {
    double seconds = 0.0;
    for (const double t : table.numbers("wall_time_s")) seconds += std::isfinite(t) ? t : 0.0;
    constexpr double hour = 3600.0;
    lines.push_back(fmt::format("{:.1f} h of wall time, summed over the runs", seconds / hour));
  }
  return lines;
}

/// Inputs that Eqs. 7-10 do not know: a table that varies them mixes what one equation cannot tell apart.
constexpr std::array other_inputs{"cell_size_m",       "particles_per_cell",
                                  "transfer",          "flip_ratio",
                                  "obstacle.friction", "obstacle_friction",
                                  "slope_deg",         "sidewall_contact",
                                  "sidewall_friction", "feed",
                                  "upstream_length_m", "density_kg_m3",
                                  "young_modulus_pa",  "preconsolidation_pressure_pa",
                                  "obstacle.shape"};

}  // namespace

bool same_input(double a, double b) { return std::abs(a - b) <= 1e-6 * std::max(1.0, std::abs(b)); }

bool StudyRun::reference_width() const { return same_input(relative_width(), 1.0); }

RowFilter::RowFilter(std::string text) : text_(std::move(text)) {
  const std::size_t at = text_.find_first_of("=!<>");
  const std::size_t after = at == std::string::npos ? at : text_.find_first_not_of("=!<>", at);
  if (at != std::string::npos) operator_ = text_.substr(at, after == std::string::npos ? after : after - at);
  static const std::set<std::string> known{"=", "!=", "<", "<=", ">", ">="};
  if (at == std::string::npos || at == 0 || after == std::string::npos || !known.contains(operator_)) {
    throw ConfigError(fmt::format("--filter '{}': a condition is `column OP value[,value]`, OP one of = != < <= > >=", text_));
  }
  const auto trimmed = [](std::string word) {
    word.erase(0, word.find_first_not_of(' '));
    word.erase(word.find_last_not_of(' ') + 1);
    return word;
  };
  column_ = trimmed(text_.substr(0, at));
  for (std::size_t from = after; from <= text_.size();) {
    const std::size_t comma = std::min(text_.find(',', from), text_.size());
    values_.push_back(trimmed(text_.substr(from, comma - from)));
    from = comma + 1;
  }
  if (operator_ != "=" && operator_ != "!=" && (values_.size() > 1 || !number_of(values_.front()))) {
    throw ConfigError(fmt::format("--filter '{}': {} needs one number", text_, operator_));
  }
}

bool RowFilter::keeps(const std::string& cell) const {
  const auto number = number_of(cell);
  if (operator_ == "=" || operator_ == "!=") {
    const bool found = std::ranges::any_of(values_, [&](const std::string& value) {
      const auto wanted = number_of(value);
      return number && wanted ? same_input(*number, *wanted) : cell == value;
    });
    return found == (operator_ == "=");
  }
  if (cell.empty()) return false;
  if (!number) throw ConfigError(fmt::format("--filter '{}': '{}' in the table is no number; use = or !=", text_, cell));
  const double limit = *number_of(values_.front());
  if (operator_ == "<") return *number < limit;
  if (operator_ == "<=") return *number <= limit || same_input(*number, limit);
  if (operator_ == ">") return *number > limit;
  return *number >= limit || same_input(*number, limit);
}

StudyTable read_study_table(std::span<const std::filesystem::path> files, std::span<const RowFilter> filters) {
  StudyTable study;
  std::vector<std::string> order;  // of the reasons, as they came up
  std::map<std::string, std::size_t> counts;
  std::map<std::string, std::set<std::string>> varied;
  std::set<std::string> friction_ratios;
  const auto leave_out = [&](const std::string& reason) {
    if (counts[reason]++ == 0) order.push_back(reason);
  };
  for (const std::filesystem::path& file : files) {
    const Table table = Table::read(file);
    for (std::string& line : comments_of(file)) study.provenance.push_back(std::move(line));
    study.files.push_back(file.string());
    study.rows += table.rows();
    for (std::string& line : executions_of(file.parent_path() / "runs.csv")) study.provenance.push_back(std::move(line));
    std::vector<std::vector<std::string>> filtered;
    for (const RowFilter& filter : filters) {
      const std::string column = find_column(table, file, filter.column());
      if (column.empty()) {
        throw ConfigError(fmt::format("--filter '{}': {} has no column '{}'; there are: {}", filter.text(), file.string(), filter.column(),
                                      fmt::join(table.columns(), ", ")));
      }
      filtered.push_back(table.text(column));
    }
    const Columns columns(table, file);
    const auto status = columns.text({"status"}), steady = columns.text({"steady"});
    const auto version = columns.text({"version"}), commit = columns.text({"commit"});
    std::map<std::pair<std::string, std::string>, std::size_t> programs;
    for (std::size_t i = 0; i < table.rows(); ++i) {
      if (!version[i].empty()) ++programs[{version[i], commit[i]}];
    }
    for (const auto& [program, count] : programs) {
      study.provenance.push_back(fmt::format("{} runs by version {}, commit {}", count, program.first, program.second));
    }
    std::map<std::string, std::vector<std::string>> others;
    for (const char* name : other_inputs) {
      if (columns.has(name)) others[name] = columns.text({name});
    }
    const auto friction_ratio = columns.optional({"obstacle_friction_ratio"});
    const auto runs = runs_of(table, file);
    for (std::size_t i = 0; i < runs.size(); ++i) {
      std::size_t kept_by = 0;
      while (kept_by < filters.size() && filters[kept_by].keeps(filtered[kept_by][i])) ++kept_by;
      if (kept_by < filters.size()) {
        leave_out("filter " + filters[kept_by].text());
      } else if (const StudyRun& r = runs[i];
                 !std::isfinite(r.froude + r.effective_friction + r.hardening_xi + r.flow_height + r.obstacle_width)) {
        leave_out("an input is missing");
      } else if (!std::isfinite(runs[i].runup)) {
        leave_out(why_no_mean(status[i], steady[i]));
      } else {
        study.runs.push_back(runs[i]);
        for (const auto& [name, cells] : others) varied[name].insert(cells[i]);
        if (std::isfinite(friction_ratio[i])) friction_ratios.insert(fmt::format("{:.6g}", friction_ratio[i]));
      }
    }
  }
  for (const std::string& reason : order) study.left_out.emplace_back(reason, counts[reason]);
  if (friction_ratios.size() == 1) varied.erase("obstacle_friction");  // one choice: the mast's friction follows the snow's own
  for (const auto& [name, values] : varied) {
    if (values.size() > 1) {
      study.cautions.push_back(fmt::format("{} varies ({}), which the equations do not know; choose one with --filter '{}=...'", name,
                                           fmt::join(values, ", "), name));
    }
  }
  return study;
}

}  // namespace mpm
