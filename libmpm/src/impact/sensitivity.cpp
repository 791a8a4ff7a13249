#include "mpm/impact/sensitivity.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <optional>
#include <utility>

#include "mpm/io/schema.hpp"
#include "mpm/io/table.hpp"

namespace mpm {

namespace {

constexpr const char* friction = "obstacle_friction";
constexpr const char* friction_ratio = "obstacle_friction_ratio";

/// Columns that hold a choice: not the point (flow, snow, width), not how long and how often is looked.
std::vector<std::string> choices_of(const Table& table) {
  std::vector<std::string> choices;
  for (const std::string& column : table.columns()) {
    const std::string owner = column.substr(0, column.find('.'));
    const bool key = column.size() > owner.size() && owner != "output" &&
                     std::ranges::any_of(schema_tables(), [&](const TableInfo& t) { return t.name == owner; });
    if (key || column == friction || column == friction_ratio || column == "cell_size_m") choices.push_back(column);
  }
  return choices;
}

/// Numbers as they were meant: without the rounding of having been computed.
std::string shown(const std::string& cell) {
  const char* end = cell.c_str() + cell.size();
  char* rest = nullptr;
  const double value = std::strtod(cell.c_str(), &rest);
  return rest == end && !cell.empty() ? fmt::format("{:.6g}", value) : cell;
}

/// The rows as text and numbers, and what the base is.
class Rows {
 public:
  explicit Rows(const Table& table) : choices_(choices_of(table)) {
    for (const std::string& choice : choices_) {
      for (const std::string& cell : table.text(choice)) cells_[choice].push_back(shown(cell));
    }
    std::vector<std::vector<std::string>> point_cells;
    for (const char* column : {"froude_number", "critical_state_slope", "cohesion_beta", "hardening_xi", "obstacle_width_m"}) {
      point_cells.push_back(table.text(column));
    }
    for (std::size_t i = 0; i < table.rows(); ++i) {
      std::vector<std::string> point;
      point.reserve(point_cells.size());
      for (const auto& column : point_cells) point.push_back(shown(column[i]));
      points_.push_back(fmt::format("{}", fmt::join(point, " ")));
    }
    for (const std::string& choice : choices_) {
      std::map<std::string, std::size_t> count;
      for (const std::string& cell : cells_[choice]) ++count[cell];
      count.erase("nan");  // a share of no friction at all
      const auto most = std::ranges::max_element(count, {}, [](const auto& c) { return c.second; });
      base_[choice] = most != count.end() ? most->first : "nan";
    }
  }

  [[nodiscard]] std::size_t size() const { return points_.size(); }
  [[nodiscard]] const std::string& point(std::size_t i) const { return points_[i]; }
  [[nodiscard]] const std::string& cell(const std::string& choice, std::size_t i) const { return cells_.at(choice)[i]; }

  /// What row i does otherwise than the base.
  [[nodiscard]] std::vector<std::string> differences(std::size_t i) const {
    std::vector<std::string> different;
    for (const std::string& choice : choices_) {
      if (choice == friction || choice == friction_ratio) continue;
      if (cell(choice, i) != base_.at(choice)) different.push_back(choice);
    }
    if (const auto what = friction_difference(i)) different.insert(different.begin(), *what);
    return different;
  }

 private:
  [[nodiscard]] std::optional<std::string> friction_difference(std::size_t i) const {
    const bool tied = base_.contains(friction_ratio), given = base_.contains(friction);
    if (!tied) return given && cell(friction, i) != base_.at(friction) ? std::optional<std::string>(friction) : std::nullopt;
    const std::string& ratio = cell(friction_ratio, i);
    if (ratio == base_.at(friction_ratio) || (ratio == "nan" && cell(friction, i) == "0")) return std::nullopt;
    return sharers(friction, i) >= sharers(friction_ratio, i) ? friction : friction_ratio;
  }
  [[nodiscard]] std::size_t sharers(const std::string& choice, std::size_t i) const {
    return static_cast<std::size_t>(std::ranges::count(cells_.at(choice), cell(choice, i)));
  }

  std::vector<std::string> choices_, points_;
  std::map<std::string, std::vector<std::string>> cells_;
  std::map<std::string, std::string> base_;
};

RatioSpread spread_of(const std::vector<const Sensitivity*>& runs, MeanRatio Sensitivity::*quantity) {
  std::vector<double> known;
  for (const Sensitivity* s : runs) {
    if (std::isfinite((s->*quantity).value)) known.push_back((s->*quantity).value);
  }
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  if (known.empty()) return {none, none, none};
  double logarithms = 0.0;
  for (const double ratio : known) logarithms += std::log(ratio);
  const auto [low, high] = std::ranges::minmax(known);
  return {std::exp(logarithms / static_cast<double>(known.size())), low, high};
}

std::vector<SensitivitySummary> summarise(const std::vector<Sensitivity>& runs) {
  std::vector<std::pair<std::string, std::string>> order;
  for (const Sensitivity& s : runs) {
    if (std::ranges::find(order, std::pair{s.choice, s.value}) == order.end()) order.emplace_back(s.choice, s.value);
  }
  std::vector<SensitivitySummary> summaries;
  for (const auto& [choice, value] : order) {
    std::vector<const Sensitivity*> group;
    double squares = 0.0, base_squares = 0.0;
    for (const Sensitivity& s : runs) {
      if (s.choice != choice || s.value != value) continue;
      group.push_back(&s);
      squares += std::pow(std::log(s.runup_to_published), 2);
      base_squares += std::pow(std::log(s.runup_to_published / s.runup.value), 2);
    }
    const auto count = static_cast<double>(group.size());
    summaries.push_back({choice, value, group.size(), spread_of(group, &Sensitivity::runup),
                         spread_of(group, &Sensitivity::pressure_height), spread_of(group, &Sensitivity::force), std::sqrt(squares / count),
                         std::sqrt(base_squares / count)});
  }
  return summaries;
}

}  // namespace

SensitivityStudy sensitivities(const std::filesystem::path& results) {
  const Table table = Table::read(results);
  const Rows rows(table);
  struct Output {
    std::vector<double> value, error;
  };
  const auto output = [&](const std::string& value, const std::string& error) {
    return Output{table.numbers(value), table.numbers(error)};
  };
  const Output runup = output("runup_mean_m", "runup_standard_error_m");
  const Output pressure_height = output("pressure_height_mean_m", "pressure_height_standard_error_m");
  const Output force = output("force_mean_n.x", "force_standard_error_n.x");
  const auto published_runup = table.numbers("predicted_runup_m"), published_height = table.numbers("predicted_pressure_height_m");
  const auto froude = table.numbers("froude_number"), slope = table.numbers("critical_state_slope"), beta = table.numbers("cohesion_beta");
  const auto xi = table.numbers("hardening_xi"), inner_friction = table.numbers("effective_friction");
  const auto names = table.text("name"), status = table.text("status");

  SensitivityStudy study;
  std::map<std::string, std::size_t> base_rows;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    if (rows.differences(i).empty() && std::isfinite(runup.value[i])) base_rows.emplace(rows.point(i), i);
  }
  std::size_t not_done = 0;
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const auto base = base_rows.find(rows.point(i));
    if (status[i] != "done") {
      ++not_done;
    } else if (!std::isfinite(runup.value[i])) {
      study.notes.push_back(names[i] + ": no steady mean of the run-up");
    } else if (base == base_rows.end()) {
      study.notes.push_back(names[i] + ": no run of the base with a steady mean at this point");
    } else {
      const std::size_t b = base->second;
      const auto different = rows.differences(i);
      std::vector<std::string> values;
      values.reserve(different.size());
      for (const std::string& choice : different) values.push_back(rows.cell(choice, i));
      const auto over_base = [&](const Output& o) { return ratio_of_means(o.value[i], o.error[i], o.value[b], o.error[b]); };
      study.runs.push_back({fmt::format("{}", fmt::join(different, ", ")), fmt::format("{}", fmt::join(values, ", ")), froude[i], slope[i],
                            beta[i], xi[i], inner_friction[i], over_base(runup), over_base(pressure_height), over_base(force),
                            runup.value[i] / published_runup[i], pressure_height.value[i] / published_height[i]});
    }
  }
  if (not_done > 0) study.notes.push_back(fmt::format("{} runs that are not done", not_done));
  study.summaries = summarise(study.runs);
  return study;
}

}  // namespace mpm
