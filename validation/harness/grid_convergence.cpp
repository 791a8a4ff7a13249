#include "validation/harness/grid_convergence.hpp"

#include <fmt/format.h>

#include <cmath>

#include "mpm/error.hpp"

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
Plot error_plot(const std::string& id, const FigureStudy& s, const StudiedFigure& figure) {
  std::vector<double> slope;
  for (const double h : s.parameter) slope.push_back(s.error.front() * std::pow(h / s.parameter.front(), figure.formal_order));
  return {id,
          "Error of " + figure.quantity,
          label_of(s.kind),
          figure.unit.empty() ? "error" : fmt::format("error [{}]", figure.unit),
          {{"simulation", s.parameter, s.error, Series::Style::points},
           {fmt::format("order {:g}", figure.formal_order), s.parameter, slope, Series::Style::bound}},
          "",
          true,
          true};
}

}  // namespace

std::string with_uncertainty(const FigureStudy& study, const std::string& unit) {
  if (study.figure.empty() || !std::isfinite(study.figure.back().value)) return "no figure";
  const Figure& last = study.figure.back();
  std::string text = fmt::format("{:.4g}{}{}", last.value, unit.empty() ? "" : " ", unit);
  if (std::isfinite(study.uncertainty))
    text += fmt::format(", numerical uncertainty {:.2g} %", 100.0 * study.uncertainty / std::abs(last.value));
  if (std::isfinite(last.standard_error))
    text += fmt::format(", statistical (two standard errors) {:.2g} %", 200.0 * last.standard_error / std::abs(last.value));
  return text;
}

std::vector<FigureStudy> record_grid_study(CaseResult& result, const std::string& id, SweepKind kind, std::vector<double> values,
                                           const std::vector<StudiedFigure>& figures,
                                           const std::function<std::vector<Figure>(double)>& compute) {
  const Sweep sweep = in_order({kind, std::move(values), {}});
  std::vector<std::vector<Figure>> computed(figures.size());
  for (const double value : sweep.values) {
    const std::vector<Figure> here = compute(value);
    if (here.size() != figures.size())
      throw ConfigError(fmt::format("grid study {}: {} figures computed, {} asked for", id, here.size(), figures.size()));
    for (std::size_t i = 0; i < figures.size(); ++i) computed[i].push_back(here[i]);
  }
  std::vector<FigureStudy> studies;
  for (std::size_t i = 0; i < figures.size(); ++i) {
    const StudiedFigure& f = figures[i];
    studies.push_back(study_figure(f.quantity, kind, sweep.values, computed[i], f.exact, f.formal_order));
    const FigureStudy& s = studies.back();
    if (s.study) {
      GridStudy shown = *s.study;
      shown.asymptotic = s.asymptotic;
      shown.remark = s.verdict;
      result.studies.push_back({f.quantity, f.unit, shown, label_of(kind)});
    }
    if (f.exact && s.error.size() > 1) result.plots.push_back(error_plot(fmt::format("{}-{}", id, i + 1), s, f));
    result.notes.push_back(
        fmt::format("{}, {} {:.4g}: {}; {}.", f.quantity, label_of(kind), sweep.values.back(), with_uncertainty(s, f.unit), s.verdict));
  }
  return studies;
}

}  // namespace mpm::validation
