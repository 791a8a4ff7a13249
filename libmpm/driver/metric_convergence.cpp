#include "libmpm/driver/metric_convergence.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>
#include <variant>

#include "libmpm/base/error.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/driver/observers.hpp"

namespace mpm {

std::string to_string(SweepKind kind) {
  static constexpr std::array keys{"cell_size_m", "particles_per_cell", "cfl", "grid_offset_cells"};
  return keys.at(static_cast<std::size_t>(kind));
}

bool goes_to_zero(SweepKind kind) { return kind == SweepKind::cell_size || kind == SweepKind::cfl; }

Sweep in_order(Sweep sweep) {
  if (sweep.values.empty()) throw ConfigError(fmt::format("sweep of {}: no values", to_string(sweep.kind)));
  if (goes_to_zero(sweep.kind)) std::ranges::sort(sweep.values, std::greater{});
  if (sweep.kind == SweepKind::particles_per_cell) std::ranges::sort(sweep.values);
  for (std::size_t i = 0; i < sweep.values.size(); ++i) {
    if (std::count(sweep.values.begin(), sweep.values.end(), sweep.values[i]) > 1)
      throw ConfigError(fmt::format("sweep of {}: {} is given twice; give each value once", to_string(sweep.kind), sweep.values[i]));
  }
  for (const char axis : sweep.axes) {
    if (std::string_view("xyz").find(axis) == std::string_view::npos || std::ranges::count(sweep.axes, axis) > 1)
      throw ConfigError(fmt::format("sweep of {}: axes '{}'; give some of x, y and z, each once", to_string(sweep.kind), sweep.axes));
  }
  return sweep;
}

namespace {

std::vector<std::string> names_of(const std::vector<Result>& values) {
  std::vector<std::string> names;
  for (const Result& r : values) names.push_back(r.name);
  return names;
}

/// force_mean_n[0] is force_mean_n.x.
std::string with_axis(const std::string& name) {
  for (std::size_t i = 0; i < 3; ++i) {
    if (name.ends_with(fmt::format("[{}]", i))) return component_name(name.substr(0, name.size() - 3), i);
  }
  return name;
}

/// @return the name as it is among the known ones. @throws ConfigError if it is not
std::string require_name(const std::string& name, const std::vector<std::string>& known) {
  const std::string key = with_axis(name);
  for (const std::string& same : {name, key}) {
    if (std::ranges::find(known, same) != known.end()) return same;
  }
  const bool vector = std::ranges::find(known, key + ".x") != known.end();
  const std::string nearest = nearest_word(key, known);
  throw ConfigError(fmt::format("metric {}: results.json has no such number; {}", name,
                                vector            ? fmt::format("it is a vector: give {0}.x, {0}.y or {0}.z", key)
                                : nearest.empty() ? "docs/results.md lists the metrics of a run"
                                                  : fmt::format("did you mean {}?", nearest)));
}

}  // namespace

Metric metric_of(const Results& results, const std::string& name) {
  const std::vector<Result> values = results.components();
  const std::string key = require_name(name, names_of(values));
  const auto number = [&](const std::string& of) {
    const auto found = std::ranges::find(values, of, &Result::name);
    return found == values.end() ? Metric::none : as_number(found->value).value_or(Metric::none);
  };
  const Value& value = std::ranges::find(values, key, &Result::name)->value;
  if (std::holds_alternative<std::string>(value) || std::holds_alternative<bool>(value))
    throw ConfigError(fmt::format("metric {}: {} is not a number", name, as_json(value)));
  return {number(key), number(standard_error_name(key))};
}

std::vector<std::string> known_metrics(const Case& c) {
  std::vector<Result> values = expected_results(c).components();
  std::erase_if(values,
                [](const Result& r) { return std::holds_alternative<std::string>(r.value) || std::holds_alternative<bool>(r.value); });
  return names_of(values);
}

void require_known_metrics(const Case& c, const std::vector<std::string>& names) {
  const std::vector<std::string> known = known_metrics(c);
  for (const std::string& name : names) (void)require_name(name, known);
}

namespace {

/// Half the range of the values, for a parameter without a limit to extrapolate to.
void judge_scatter(MetricConvergence& m, std::size_t values) {
  if (values > 1) m.uncertainty = 0.5 * (m.highest - m.lowest);
  const double middle = 0.5 * (m.highest + m.lowest);
  m.verdict = values == 0 ? "no value"
                          : fmt::format("scatter over {} values: {:.3g} to {:.3g}, half the range is {:.2g} %", values, m.lowest, m.highest,
                                        middle != 0.0 ? 100.0 * m.uncertainty / std::abs(middle) : 0.0);
}

/// Order and limit from three or more sizes.
/// @param size the sizes that are judged, coarse first; `metric` belongs to them
void judge_sizes(MetricConvergence& m, const std::vector<double>& size, const std::vector<Metric>& metric, double formal_order) {
  std::vector<double> value;
  for (const Metric& x : metric) value.push_back(x.value);
  const double noise = 2.0 * std::hypot(metric.back().standard_error, metric[metric.size() - 2].standard_error);
  m.convergence = judge_convergence(size, value, formal_order, std::isfinite(noise) ? noise : 0.0);
  m.uncertainty = m.convergence->uncertainty;
  m.asymptotic = m.convergence->asymptotic;
  m.verdict = m.convergence->remark;
}

/// Removes sizes that are too close to the next finer one for their difference to show an order. @returns those, coarse first
std::vector<double> thin_out(std::vector<double>& size, std::vector<Metric>& metric) {
  std::vector<double> removed;
  for (std::size_t i = size.size(); i-- > 1;) {
    if (size[i - 1] >= least_size_ratio * size[i] * (1.0 - 1e-9)) continue;
    removed.insert(removed.begin(), size[i - 1]);
    size.erase(size.begin() + static_cast<std::ptrdiff_t>(i - 1));
    metric.erase(metric.begin() + static_cast<std::ptrdiff_t>(i - 1));
  }
  return removed;
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
  const std::vector<double> close = goes_to_zero(kind) ? thin_out(size, there) : std::vector<double>();
  if (!goes_to_zero(kind)) {
    judge_scatter(m, there.size());
  } else if (there.size() < 3) {
    m.verdict = fmt::format("values only: {} with a value, an order needs three and better four", counted(there.size(), "size"));
  } else {
    judge_sizes(m, size, there, formal_order);
  }
  if (!there.empty() && std::isfinite(m.uncertainty)) {
    const double standard_error = there.back().standard_error;
    m.total_uncertainty = std::isfinite(standard_error) ? std::hypot(m.uncertainty, 2.0 * standard_error) : m.uncertainty;
  }
  if (!close.empty())
    m.verdict += fmt::format("; not judged: {}, less than {} times the next finer size", fmt::join(close, ", "), least_size_ratio);
  if (!missing.empty())
    m.verdict += fmt::format("; no value at {}: the run has no steady interval or does not measure it", fmt::join(missing, ", "));
  return m;
}

std::string quote(const MetricConvergence& m) {
  const auto last = std::find_if(m.metric.rbegin(), m.metric.rend(), [](const Metric& x) { return std::isfinite(x.value); });
  if (last == m.metric.rend()) return fmt::format("{}: {}", m.name, m.verdict);
  const auto at = static_cast<std::size_t>(m.metric.rend() - last) - 1;
  const std::string where = at + 1 == m.metric.size() ? "" : fmt::format(" at {} (none at {})", m.parameter[at], m.parameter.back());
  if (!std::isfinite(m.total_uncertainty))
    return fmt::format("{}{} = {:.4g}, uncertainty not known: {}", m.name, where, last->value, m.verdict);
  return fmt::format(
      "{}{} = {:.4g} +- {:.2g} ({:.2g} %): {} +- {:.2g} ({}), statistics {}", m.name, where, last->value, m.total_uncertainty,
      100.0 * m.total_uncertainty / std::abs(last->value), to_string(m.kind), m.uncertainty,
      m.convergence ? m.convergence->basis : m.verdict,
      std::isfinite(last->standard_error) ? fmt::format("+- {:.2g} (two standard errors)", 2.0 * last->standard_error) : "not known");
}

}  // namespace mpm
