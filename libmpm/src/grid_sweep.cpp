#include "mpm/grid_sweep.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "mpm/error.hpp"
#include "mpm/io/atomic_file.hpp"
#include "mpm/io/config.hpp"
#include "mpm/io/schema.hpp"
#include "mpm/io/table.hpp"
#include "mpm/run_folder.hpp"

namespace mpm {

namespace {

using Json = nlohmann::ordered_json;

constexpr int converge_format_version = 1;

bool is_size(SweepKind kind) { return kind == SweepKind::cell_size || kind == SweepKind::cfl; }

/// The components that a name can mean: name, or name[i] of an array.
std::vector<std::string> names_in(const Json& results) {
  std::vector<std::string> names;
  for (const auto& [key, value] : results.items()) {
    if (!value.is_array()) names.push_back(key);
    for (std::size_t i = 0; value.is_array() && i < value.size(); ++i) names.push_back(fmt::format("{}[{}]", key, i));
  }
  return names;
}

/// force_mean_n.x is force_mean_n[0].
std::string with_index(std::string name) {
  if (name.size() > 2 && name[name.size() - 2] == '.') {
    const auto axis = std::string_view("xyz").find(name.back());
    if (axis != std::string_view::npos) name = fmt::format("{}[{}]", name.substr(0, name.size() - 2), axis);
  }
  return name;
}

/// Null without the key.
Json at(const Json& results, const std::string& name) {
  const auto bracket = name.find('[');
  const auto found = results.find(name.substr(0, bracket));
  if (found == results.end()) return {};
  if (bracket == std::string::npos) return *found;
  const std::string index = name.substr(bracket + 1, name.size() - bracket - 2);
  if (!found->is_array() || index.size() != 1 || index[0] < '0' || index[0] > '9') return {};
  const auto i = static_cast<std::size_t>(index[0] - '0');
  return i < found->size() ? (*found)[i] : Json{};
}

Json number(double x) { return std::isfinite(x) ? Json(x) : Json(); }

}  // namespace

std::string to_string(SweepKind kind) {
  switch (kind) {
    case SweepKind::cell_size: return "cell_size_m";
    case SweepKind::particles_per_cell: return "particles_per_cell";
    case SweepKind::cfl: return "cfl";
    case SweepKind::offset: return "grid_offset_cells";
  }
  return {};
}

Sweep in_order(Sweep sweep) {
  if (sweep.values.empty()) throw ConfigError(fmt::format("sweep of {}: no values", to_string(sweep.kind)));
  if (is_size(sweep.kind)) std::ranges::sort(sweep.values, std::greater{});
  if (sweep.kind == SweepKind::particles_per_cell) std::ranges::sort(sweep.values);
  for (std::size_t i = 0; i < sweep.values.size(); ++i) {
    if (std::count(sweep.values.begin(), sweep.values.end(), sweep.values[i]) > 1)
      throw ConfigError(fmt::format("sweep of {}: {} stands twice; give each value once", to_string(sweep.kind), sweep.values[i]));
  }
  for (const char axis : sweep.axes) {
    if (std::string_view("xyz").find(axis) == std::string_view::npos || std::ranges::count(sweep.axes, axis) > 1)
      throw ConfigError(fmt::format("sweep of {}: axes '{}'; give some of x, y and z, each once", to_string(sweep.kind), sweep.axes));
  }
  return sweep;
}

Case swept_case(const Case& c, const Sweep& sweep, double value) {
  std::string text = format_number(value);
  if (sweep.kind == SweepKind::offset) {
    std::string axes = sweep.axes;
    if (axes.empty()) {
      if (!c.domain.mirror_x) axes += 'x';
      if (!c.domain.mirror_y && !(c.conveyor && c.conveyor->mirror_y)) axes += 'y';
      axes += 'z';
    }
    const auto along = [&](char axis) { return axes.find(axis) == std::string::npos ? std::string("0") : text; };
    text = fmt::format("[{}, {}, {}]", along('x'), along('y'), along('z'));
  }
  return parse_case(write_case(c), "case", {fmt::format("numerics.{}={}", to_string(sweep.kind), text)});
}

std::string sweep_directory(SweepKind kind, double value) {
  const char* prefix = kind == SweepKind::cell_size            ? "dx"
                       : kind == SweepKind::particles_per_cell ? "ppc"
                       : kind == SweepKind::cfl                ? "cfl"
                                                               : "offset";
  return fmt::format("{}_{}", prefix, format_number(value));
}

SweepResult run_sweep(const Case& c, const Sweep& sweep, const SweepOptions& options) {
  const Sweep ordered = in_order(sweep);
  std::vector<Case> cases;
  for (const double value : ordered.values) cases.push_back(swept_case(c, ordered, value));
  SweepResult result;
  for (std::size_t i = 0; i < cases.size(); ++i) {
    SweepPoint point{ordered.values[i], options.out / sweep_directory(ordered.kind, ordered.values[i]), false, {}};
    if (options.on_start) options.on_start(point);
    if (const auto finished = options.resume ? finished_results(point.directory, cases[i]) : std::nullopt) {
      point.reused = true;
      point.results_json = *finished;
    } else {
      RunOptions run;
      run.out = point.directory;
      run.threads = options.threads;
      // A finished run of another duration, or of another case, is not gone on from: its figures would be over another time.
      run.resume = options.resume && !std::filesystem::exists(point.directory / "results.json");
      run.on_progress = options.on_progress;
      run.poll = options.poll;
      const RunResult done = run_case(cases[i], run);
      if (!done.finished) return result;
      point.results_json = done.results_json;
    }
    result.points.push_back(point);
    if (options.on_point) options.on_point(result.points.back());
  }
  result.finished = true;
  return result;
}

Figure figure_of(const std::string& results_json, const std::string& name) {
  const Json results = Json::parse(results_json, nullptr, false);
  if (!results.is_object()) throw IoError("results.json is not a JSON object; run the case again");
  const std::string key = with_index(name);
  const auto names = names_in(results);
  if (std::ranges::find(names, key) == names.end()) {
    const bool vector = std::ranges::find(names, key + "[0]") != names.end();
    const std::string nearest = nearest_word(key, names);
    throw ConfigError(fmt::format("metric {}: results.json has no such figure; {}", name,
                                  vector            ? fmt::format("it is a vector: give {0}[0], {0}[1] or {0}[2]", key)
                                  : nearest.empty() ? "see the README for the figures that a run leaves"
                                                    : fmt::format("did you mean {}?", nearest)));
  }
  const Json value = at(results, key);
  if (value.is_string() || value.is_boolean()) throw ConfigError(fmt::format("metric {}: {} is no number", name, value.dump()));
  Figure figure;
  if (value.is_number()) figure.value = value.get<double>();
  // X_mean_UNIT has its standard error in X_standard_error_UNIT.
  if (const auto place = key.find("_mean"); place != std::string::npos) {
    std::string error_key = key;
    const Json error = at(results, error_key.replace(place, std::string_view("_mean").size(), "_standard_error"));
    if (error.is_number()) figure.standard_error = error.get<double>();
  }
  return figure;
}

FigureStudy study_figure(const std::string& name, SweepKind kind, std::vector<double> parameter, std::vector<Figure> figure,
                         std::optional<double> exact, double formal_order) {
  if (parameter.size() != figure.size())
    throw ConfigError(fmt::format("study of {}: {} parameters and {} figures", name, parameter.size(), figure.size()));
  FigureStudy s;
  s.name = name;
  s.kind = kind;
  s.exact = exact;
  s.parameter = std::move(parameter);
  s.figure = std::move(figure);
  std::vector<double> h, f, error, missing;
  std::vector<Figure> there;
  for (std::size_t i = 0; i < s.figure.size(); ++i) {
    if (exact) s.error.push_back(std::abs(s.figure[i].value - *exact));
    if (!std::isfinite(s.figure[i].value)) {
      missing.push_back(s.parameter[i]);
      continue;
    }
    h.push_back(s.parameter[i]);
    f.push_back(s.figure[i].value);
    there.push_back(s.figure[i]);
  }
  if (!f.empty()) {
    s.lowest = *std::ranges::min_element(f);
    s.highest = *std::ranges::max_element(f);
  }
  const std::string gaps =
      missing.empty() ? "" : fmt::format("; no figure at {}: the run has no steady span or does not measure it", fmt::join(missing, ", "));
  if (!is_size(kind)) {
    if (f.size() > 1) s.uncertainty = 0.5 * (s.highest - s.lowest);
    const double middle = 0.5 * (s.highest + s.lowest);
    s.verdict = f.empty() ? "no figure"
                          : fmt::format("scatter over {} values: {:.3g} to {:.3g}, half the range is {:.2g} %", f.size(), s.lowest,
                                        s.highest, middle != 0.0 ? 100.0 * s.uncertainty / std::abs(middle) : 0.0);
    s.verdict += gaps;
    return s;
  }
  if (exact && missing.empty() && s.error.size() > 1) s.error_order = pairwise_orders(s.parameter, s.error);
  if (f.size() < 3) {
    s.verdict = fmt::format("values only: {} size{} with a figure, an order needs three and better four{}", f.size(),
                            f.size() == 1 ? "" : "s", gaps);
    return s;
  }
  s.study = grid_study(h, f, formal_order);
  s.uncertainty = f.size() >= 4 ? s.study->least_squares_uncertainty : s.study->gci * std::abs(f.back());
  s.asymptotic = s.study->asymptotic;
  s.verdict = s.study->remark;
  const Figure &finest = there.back(), &next = there[there.size() - 2];
  const double noise = 2.0 * std::hypot(finest.standard_error, next.standard_error), difference = std::abs(finest.value - next.value);
  if (s.study->behaviour != Behaviour::constant && difference <= noise) {
    s.asymptotic = false;
    s.verdict = fmt::format(
        "not asymptotic: the two finest differ by {:.3g}, within twice the statistical error of their difference ({:.3g}), so no order can "
        "be "
        "told",
        difference, noise);
  }
  s.verdict += gaps;
  return s;
}

std::string sweep_json(const Case& c, const Sweep& sweep, const std::vector<SweepPoint>& points, const std::vector<FigureStudy>& studies) {
  Json json;
  json["format_version"] = converge_format_version;
  json["title"] = c.title;
  json["sweep"] = to_string(sweep.kind);
  json["points"] = Json::array();
  for (const SweepPoint& p : points) {
    const Json results = Json::parse(p.results_json, nullptr, false);
    Json entry{{"value", p.value}, {"directory", p.directory.filename().string()}, {"reused", p.reused}};
    for (const char* key : {"case_hash", "commit", "steady", "steps", "particle_steps", "wall_time_s"}) entry[key] = at(results, key);
    json["points"].push_back(entry);
  }
  json["figures"] = Json::array();
  for (const FigureStudy& s : studies) {
    Json figure{{"name", s.name}, {"parameter", s.parameter}};
    figure["value"] = Json::array();
    figure["standard_error"] = Json::array();
    for (const Figure& f : s.figure) {
      figure["value"].push_back(number(f.value));
      figure["standard_error"].push_back(number(f.standard_error));
    }
    if (s.exact) {
      figure["exact"] = *s.exact;
      figure["error"] = Json::array();
      for (const double e : s.error) figure["error"].push_back(number(e));
      figure["error_order"] = Json::array();
      for (const double p : s.error_order) figure["error_order"].push_back(number(p));
    }
    if (s.study) {
      const GridStudy& g = *s.study;
      figure["triples"] = Json::array();
      for (std::size_t i = 0; i < g.triples.size(); ++i) {
        figure["triples"].push_back({{"sizes", {g.size[i], g.size[i + 1], g.size[i + 2]}},
                                     {"behaviour", to_string(g.triples[i].behaviour)},
                                     {"order", number(g.triples[i].order)},
                                     {"extrapolated", number(g.triples[i].extrapolated)}});
      }
      figure["behaviour"] = to_string(g.behaviour);
      figure["order"] = number(g.order);
      figure["extrapolated"] = number(g.extrapolated);
      figure["safety_factor"] = g.safety_factor;
      figure["gci"] = number(g.gci);
      figure["least_squares_order"] = number(g.least_squares_order);
      figure["least_squares_limit"] = number(g.least_squares_limit);
      figure["least_squares_uncertainty"] = number(g.least_squares_uncertainty);
      figure["asymptotic"] = s.asymptotic;
    }
    figure["lowest"] = number(s.lowest);
    figure["highest"] = number(s.highest);
    figure["uncertainty"] = number(s.uncertainty);
    figure["verdict"] = s.verdict;
    json["figures"].push_back(figure);
  }
  return json.dump(2) + "\n";
}

void write_sweep_table(const std::filesystem::path& path, const Sweep& sweep, const std::vector<FigureStudy>& studies) {
  std::vector<std::string> names{to_string(sweep.kind)};
  std::vector<std::vector<double>> columns{studies.empty() ? std::vector<double>{} : studies.front().parameter};
  for (const FigureStudy& s : studies) {
    std::vector<double> value, standard_error;
    for (const Figure& f : s.figure) {
      value.push_back(f.value);
      standard_error.push_back(f.standard_error);
    }
    names.insert(names.end(), {s.name, s.name + ":standard_error"});
    columns.insert(columns.end(), {value, standard_error});
    if (s.exact) {
      names.push_back(s.name + ":error");
      columns.push_back(s.error);
    }
  }
  write_table(path, names, columns);
}

}  // namespace mpm
