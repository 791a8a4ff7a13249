#include "libmpm/campaign/grid_study.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string_view>
#include <variant>

#include "libmpm/driver/case_file.hpp"
#include "libmpm/io/csv.hpp"
#include "libmpm/io/json.hpp"

namespace mpm {

namespace {

using Json = nlohmann::ordered_json;

constexpr int converge_format_version = 3;

/// The value of the key that is varied, as TOML. Offsets are along the axes of the sweep, by default all without a mirror plane.
std::string toml_value(const Case& c, const Sweep& sweep, double value) {
  std::string text = format_number(value);
  if (sweep.kind != SweepKind::offset) return text;
  std::string axes = sweep.axes;
  if (axes.empty()) {
    if (!c.domain.mirror_x) axes += 'x';
    if (!c.domain.mirror_y && !(c.conveyor && c.conveyor->mirror_y)) axes += 'y';
    axes += 'z';
  }
  const auto along = [&](char axis) { return axes.find(axis) == std::string::npos ? std::string("0") : text; };
  return fmt::format("[{}, {}, {}]", along('x'), along('y'), along('z'));
}

/// Begins the names of runs.
std::string_view label_of(SweepKind kind) {
  static constexpr std::array labels{"dx", "ppc", "cfl", "offset"};
  return labels.at(static_cast<std::size_t>(kind));
}

Json to_json(const Convergence& c) {
  Json json;
  json["triples"] = Json::array();
  for (std::size_t i = 0; i < c.triples.size(); ++i) {
    json["triples"].push_back({{"sizes", {c.size[i], c.size[i + 1], c.size[i + 2]}},
                               {"behaviour", to_string(c.triples[i].behaviour)},
                               {"order", c.triples[i].order},
                               {"extrapolated", c.triples[i].extrapolated}});
  }
  json["behaviour"] = to_string(c.behaviour);
  json["order"] = c.order;
  json["extrapolated"] = c.extrapolated;
  json["safety_factor"] = c.safety_factor;
  json["gci"] = c.gci;
  json["basis"] = c.basis;
  json["least_squares_order"] = c.least_squares_order;
  json["least_squares_limit"] = c.least_squares_limit;
  json["least_squares_uncertainty"] = c.least_squares_uncertainty;
  return json;
}

Json to_json(const MetricConvergence& m) {
  Json json{{"name", m.name}, {"parameter", m.parameter}, {"value", Json::array()}, {"standard_error", Json::array()}};
  for (const Metric& x : m.metric) {
    json["value"].push_back(x.value);
    json["standard_error"].push_back(x.standard_error);
  }
  if (m.exact) json.update({{"exact", *m.exact}, {"error", m.error}, {"error_order", m.error_order}});
  if (m.convergence) {
    json.update(to_json(*m.convergence));
    json["asymptotic"] = m.asymptotic;
  }
  json.update({{"lowest", m.lowest},
               {"highest", m.highest},
               {"uncertainty", m.uncertainty},
               {"total_uncertainty", m.total_uncertainty},
               {"verdict", m.verdict}});
  return json;
}

}  // namespace

Campaign make_grid_study(const Case& c, const Sweep& sweep, int threads, int ranks) {
  CampaignPlan plan;
  plan.title = c.title;
  plan.base_text = write_case(c);
  plan.base_name = "the case of the study";
  plan.threads = threads;
  plan.ranks = ranks;
  plan.longest_first = false;  // coarse first: cheap runs show what is wrong
  plan.keep_frames = plan.keep_final = true;
  for (const double value : sweep.values) {
    plan.runs.push_back({fmt::format("{}{}", label_of(sweep.kind), format_number(value)),
                         {{"numerics." + to_string(sweep.kind), toml_value(c, sweep, value)}}});
  }
  return make_campaign(std::move(plan));
}

std::vector<std::string> study_notes(const Case& c, const Sweep& sweep) {
  std::vector<std::string> notes;
  constexpr double recommended_ratio = 1.3, slack = 1e-9;
  for (std::size_t i = 1; goes_to_zero(sweep.kind) && i < sweep.values.size(); ++i) {
    const double ratio = sweep.values[i - 1] / sweep.values[i];
    if (ratio < recommended_ratio * (1.0 - slack))
      notes.push_back(fmt::format("{} is only {:.3g} times {}; an order of convergence needs a ratio of at least {}", sweep.values[i - 1],
                                  ratio, sweep.values[i], recommended_ratio));
  }
  if (sweep.kind != SweepKind::cell_size || !c.obstacle) return notes;
  std::vector<std::string> odd, few;
  for (const double dx : sweep.values) {
    constexpr double least_cells = 3.0;
    const double cells = c.obstacle->width() / dx;
    const std::string text = fmt::format("{} ({:.3g} cells)", dx, cells);
    if (std::abs(cells - std::round(cells)) > 1e-6) odd.push_back(text);
    if (cells < least_cells - slack) few.push_back(text);
  }
  if (!few.empty())
    notes.push_back(
        fmt::format("fewer than three cells across the obstacle at {}: the flow around it is not resolved, and the error may be "
                    "many times the difference of such grids",
                    fmt::join(few, ", ")));
  if (!odd.empty()) notes.push_back(fmt::format("the obstacle's width is not a whole number of cells at {}", fmt::join(odd, ", ")));
  const MeasurementSpec& m = c.measurement;
  if (c.conveyor && (!m.bin_height || !m.filter_length || !m.box_upstream || !m.box_inside)) {
    notes.emplace_back(
        "the windows of the pressure profile follow the cell size, and their bias with them: fix bin_height_m, filter_length_m, "
        "box_upstream_m and box_inside_m in [measurement] for a study of pressures");
  }
  return notes;
}

std::string converge_json(const Case& c, const Sweep& sweep, const Campaign& study, const std::vector<RunStatus>& status,
                          const std::vector<MetricConvergence>& metrics) {
  Json json{{"format_version", converge_format_version}, {"title", c.title}, {"sweep", to_string(sweep.kind)}};
  json["points"] = Json::array();
  for (std::size_t i = 0; i < study.runs.size(); ++i) {
    Json entry{{"value", sweep.values[i]}, {"directory", "runs/" + study.runs[i].name}};
    for (const char* key : {"case_hash", "commit", "steady", "steps", "particle_steps", "wall_time_s"}) {
      const Result* const result = status[i].results.find(key);
      entry[key] = result != nullptr ? std::visit([](const auto& x) { return Json(x); }, result->value) : Json();
    }
    json["points"].push_back(std::move(entry));
  }
  json["notes"] = study_notes(c, sweep);
  json["metrics"] = Json::array();
  for (const MetricConvergence& m : metrics) json["metrics"].push_back(to_json(m));
  return json_text(json, 2);  // NaN is not JSON: the serialiser writes null
}

void write_converge_table(const std::filesystem::path& path, const Sweep& sweep, const std::vector<MetricConvergence>& metrics) {
  std::vector<std::string> names{to_string(sweep.kind)};
  std::vector<std::vector<double>> columns{metrics.empty() ? std::vector<double>{} : metrics.front().parameter};
  for (const MetricConvergence& m : metrics) {
    std::vector<double> value, standard_error;
    for (const Metric& x : m.metric) {
      value.push_back(x.value);
      standard_error.push_back(x.standard_error);
    }
    names.insert(names.end(), {m.name, m.name + ":standard_error"});
    columns.insert(columns.end(), {value, standard_error});
    if (m.exact) {
      names.push_back(m.name + ":error");
      columns.push_back(m.error);
    }
  }
  write_table(path, names, columns);
}

}  // namespace mpm
