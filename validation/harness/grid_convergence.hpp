#pragma once
/// Grid, step and scatter studies for cases: hand over the sizes and a function that computes the figures at one size; what comes back is
/// judged, and is in the report.
///
///   const auto studies = record_grid_study(result, "dam", SweepKind::cell_size, {0.2, 0.1, 0.05},
///                                          {{.quantity = "front at t = 1 s", .unit = "m", .exact = 4.43}},
///                                          [&](double dx) { return std::vector<Figure>{{front(dx)}}; });

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "mpm/grid_sweep.hpp"
#include "validation/harness/case.hpp"

namespace mpm::validation {

/// A figure that a study follows.
struct StudiedFigure {
  std::string quantity, unit;
  double formal_order = 1.0;
  std::optional<double> exact = {};
};

/// Computes the figures at every value of the parameter, in the order of in_order() (coarse first), and records for each of them
/// - a NamedStudy, where there are three sizes with a figure: the report draws it;
/// - with an exact value, the log-log plot `id`-`number` of the errors over the size with a line of the formal order;
/// - a note: the last figure with its numerical and statistical uncertainty, and the verdict. Studies that are not asymptotic and
///   parameters without a figure are told there.
/// @param compute the figures at one value, in the order of `figures`; NaN where there is none
std::vector<FigureStudy> record_grid_study(CaseResult& result, const std::string& id, SweepKind kind, std::vector<double> values,
                                           const std::vector<StudiedFigure>& figures,
                                           const std::function<std::vector<Figure>(double)>& compute);

/// A figure as a reader needs it: "3.86 m, numerical uncertainty 0.25 m, statistical (two standard errors) 0.05 m".
std::string with_uncertainty(const FigureStudy& study, const std::string& unit);

}  // namespace mpm::validation
