#include "libmpm/driver/metric_convergence.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "libmpm/base/error.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"

namespace mpm {

namespace {

using Json = nlohmann::ordered_json;

constexpr int converge_format_version = 2;

/// Half the range of the values, for a parameter without a limit to extrapolate to.
void judge_scatter(MetricConvergence& m, std::size_t values) {
  if (values > 1) m.uncertainty = 0.5 * (m.highest - m.lowest);
  const double middle = 0.5 * (m.highest + m.lowest);
  m.verdict = values == 0 ? "no value"
                          : fmt::format("scatter over {} values: {:.3g} to {:.3g}, half the range is {:.2g} %", values, m.lowest, m.highest,
                                        middle != 0.0 ? 100.0 * m.uncertainty / std::abs(middle) : 0.0);
}

/// Order and limit from three or more sizes, unless the two finest agree within their statistical errors.
/// @param size the sizes that have a value, coarse first; `metric` belongs to them
void judge_sizes(MetricConvergence& m, const std::vector<double>& size, const std::vector<Metric>& metric, double formal_order) {
  std::vector<double> value;
  for (const Metric& x : metric) value.push_back(x.value);
  m.convergence = judge_convergence(size, value, formal_order);
  m.uncertainty = m.convergence->uncertainty;
  m.asymptotic = m.convergence->asymptotic;
  m.verdict = m.convergence->remark;
  const Metric &finest = metric.back(), &next = metric[metric.size() - 2];
  const double noise = 2.0 * std::hypot(finest.standard_error, next.standard_error), difference = std::abs(finest.value - next.value);
  if (m.convergence->behaviour == Behaviour::constant || !(difference <= noise)) return;
  m.asymptotic = false;
  m.verdict = fmt::format(
      "not asymptotic: the two finest differ by {:.3g}, within twice the statistical error of their difference ({:.3g}), so the order "
      "cannot be determined",
      difference, noise);
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
  json.update({{"lowest", m.lowest}, {"highest", m.highest}, {"uncertainty", m.uncertainty}, {"verdict", m.verdict}});
  return json;
}

}  // namespace

MetricConvergence judge_metric(const std::string& name, SweepKind kind, std::vector<double> parameter, std::vector<Metric> metric,
                               std::optional<double> exact, double formal_order) {
  if (parameter.size() != metric.size())
    throw ConfigError(fmt::format("convergence of {}: {} parameters and {} values", name, parameter.size(), metric.size()));
  MetricConvergence m;
  m.name = name;
  m.kind = kind;
  m.exact = exact;
  m.parameter = std::move(parameter);
  m.metric = std::move(metric);
  std::vector<double> size, missing;
  std::vector<Metric> there;
  for (std::size_t i = 0; i < m.metric.size(); ++i) {
    if (exact) m.error.push_back(std::abs(m.metric[i].value - *exact));
    if (std::isfinite(m.metric[i].value)) {
      size.push_back(m.parameter[i]);
      there.push_back(m.metric[i]);
    } else {
      missing.push_back(m.parameter[i]);
    }
  }
  if (!there.empty()) {
    const auto [lowest, highest] = std::ranges::minmax_element(there, {}, &Metric::value);
    m.lowest = lowest->value;
    m.highest = highest->value;
  }
  if (goes_to_zero(kind) && exact && missing.empty() && m.error.size() > 1) m.error_order = pairwise_orders(m.parameter, m.error);
  if (!goes_to_zero(kind)) {
    judge_scatter(m, there.size());
  } else if (there.size() < 3) {
    m.verdict = fmt::format("values only: {} size{} with a value, an order needs three and better four", there.size(),
                            there.size() == 1 ? "" : "s");
  } else {
    judge_sizes(m, size, there, formal_order);
  }
  if (!missing.empty())
    m.verdict += fmt::format("; no value at {}: the run has no steady interval or does not measure it", fmt::join(missing, ", "));
  return m;
}

std::string converge_json(const Case& c, const Sweep& sweep, const std::vector<SweepPoint>& points,
                          const std::vector<MetricConvergence>& metrics) {
  Json json{{"format_version", converge_format_version}, {"title", c.title}, {"sweep", to_string(sweep.kind)}};
  json["points"] = Json::array();
  for (const SweepPoint& p : points) {
    const Json results = Json::parse(p.results_json, nullptr, false);
    Json entry{{"value", p.value}, {"directory", p.directory.filename().string()}, {"reused", p.reused}};
    for (const char* key : {"case_hash", "commit", "steady", "steps", "particle_steps", "wall_time_s"})
      entry[key] = results.contains(key) ? results[key] : Json();
    json["points"].push_back(entry);
  }
  json["metrics"] = Json::array();
  for (const MetricConvergence& m : metrics) json["metrics"].push_back(to_json(m));
  return json.dump(2) + "\n";  // NaN is not JSON: the serialiser writes null
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
