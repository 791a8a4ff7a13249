#include "libmpm/observe/steady_interval.hpp"

#include <array>

namespace mpm {

namespace {

/// Mean, standard error and effective samples of a quantity. @param of the mean of each component: one or three
std::vector<Result> means(const Column& column, std::span<const MeanEstimate> of) {
  const auto value = [&](double MeanEstimate::*member) -> Value {
    if (of.size() == 1) return of[0].*member;
    return std::array{of[0].*member, of[1].*member, of[2].*member};
  };
  const std::string meaning = column.meaning + "; mean over the steady interval" + (of.size() == 1 ? "" : ": x, y, z");
  return {{column.statistic("mean"), value(&MeanEstimate::mean), column.unit, meaning},
          {column.statistic("standard_error"), value(&MeanEstimate::standard_error), column.unit,
           "standard error of that mean, which accounts for autocorrelation", Nature::uncertainty},
          {column.statistic("effective_samples", false), value(&MeanEstimate::effective_samples), "",
           "number of independent samples that would give that standard error", Nature::uncertainty}};
}

}  // namespace

std::optional<Steady> SteadyInterval::steady_interval(const TimeSeries& series) const {
  if (series.size() == 0) return std::nullopt;
  return find_steady(series.time(), series[column_],
                     impact_steady_criteria(flow_.arrival, flow_.velocity, flow_.gravity, series.time().back()));
}

std::vector<Result> SteadyInterval::summary(const Summary& end) const {
  const Steady& span = end.span;
  std::vector<Result> results = {
      {"steady", span.steady, "", "whether the run-up becomes steady; if not, there are no means"},
      {"steady_from_s", span.steady ? span.from : MeanEstimate::none, "s", "start of the steady interval"},
      {"steady_to_s", span.steady ? span.to : MeanEstimate::none, "s", "end of the steady interval"},
      {"steady_samples", std::uint64_t{span.last - span.first}, "", "rows of series.csv in it"},
      {"steady_column", column_, "", "column of series.csv that is steady in it (measurement.steady_by)", Nature::execution}};
  std::vector<MeanEstimate> components;
  for (const Column& column : end.series.columns()) {
    if (!column.mean) continue;
    components.push_back(end.mean(column.name()));
    if (column.axis == 'x' || column.axis == 'y') continue;
    for (Result& r : means(column, components)) results.push_back(std::move(r));
    components.clear();
  }
  return results;
}

}  // namespace mpm
