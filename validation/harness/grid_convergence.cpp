#include "validation/harness/grid_convergence.hpp"

#include <fmt/format.h>

#include <cmath>

#include "libmpm/base/error.hpp"

namespace mpm::validation {
namespace {

std::string label_of(SweepKind kind) {
  switch (kind) {
    case SweepKind::cell_size: return "cell size [m]";
    case SweepKind::particles_per_cell: return "particles per cell";
    case SweepKind::cfl: return "CFL number";
    case SweepKind::offset: return "offset [cells]";
  }
  return {};
}

/// Errors over the size, and the slope they should have.
Plot error_plot(const std::string& id, const MetricConvergence& s, const FollowedQuantity& followed) {
  std::vector<double> slope;
  for (const double h : s.parameter) slope.push_back(s.error.front() * std::pow(h / s.parameter.front(), followed.formal_order));
  return {id,
          "Error of " + followed.quantity,
          label_of(s.kind),
          followed.unit.empty() ? "error" : fmt::format("error [{}]", followed.unit),
          {{"simulation", s.parameter, s.error, Series::Style::points},
           {fmt::format("order {:g}", followed.formal_order), s.parameter, slope, Series::Style::bound}},
          "",
          true,
          true};
}

}  // namespace

std::string with_uncertainty(const MetricConvergence& judged, const std::string& unit) {
  if (judged.metric.empty() || !std::isfinite(judged.metric.back().value)) return "no value";
  const Metric& last = judged.metric.back();
  std::string text = fmt::format("{:.4g}{}{}", last.value, unit.empty() ? "" : " ", unit);
  if (std::isfinite(judged.uncertainty))
    text += fmt::format(", numerical uncertainty {:.2g} %", 100.0 * judged.uncertainty / std::abs(last.value));
  if (std::isfinite(last.standard_error))
    text += fmt::format(", statistical (two standard errors) {:.2g} %", 200.0 * last.standard_error / std::abs(last.value));
  return text;
}

std::vector<MetricConvergence> record_convergence(CaseResult& result, const std::string& id, SweepKind kind, std::vector<double> values,
                                                  const std::vector<FollowedQuantity>& quantities,
                                                  const std::function<std::vector<Metric>(double)>& compute) {
  const Sweep sweep = in_order({kind, std::move(values), {}});
  std::vector<std::vector<Metric>> computed(quantities.size());
  for (const double value : sweep.values) {
    const std::vector<Metric> here = compute(value);
    if (here.size() != quantities.size())
      throw ConfigError(fmt::format("convergence of {}: {} quantities computed, {} requested", id, here.size(), quantities.size()));
    for (std::size_t i = 0; i < quantities.size(); ++i) computed[i].push_back(here[i]);
  }
  std::vector<MetricConvergence> judged;
  for (std::size_t i = 0; i < quantities.size(); ++i) {
    const FollowedQuantity& f = quantities[i];
    judged.push_back(judge_metric(f.quantity, kind, sweep.values, computed[i], f.exact, f.formal_order));
    const MetricConvergence& s = judged.back();
    if (s.convergence) {
      Convergence shown = *s.convergence;
      shown.asymptotic = s.asymptotic;
      shown.remark = s.verdict;
      result.convergences.push_back({f.quantity, f.unit, shown, label_of(kind)});
    }
    if (f.exact && s.error.size() > 1) result.plots.push_back(error_plot(fmt::format("{}-{}", id, i + 1), s, f));
    result.notes.push_back(
        fmt::format("{}, {} {:.4g}: {}; {}.", f.quantity, label_of(kind), sweep.values.back(), with_uncertainty(s, f.unit), s.verdict));
  }
  return judged;
}

}  // namespace mpm::validation
