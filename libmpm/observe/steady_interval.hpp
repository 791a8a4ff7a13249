#pragma once
/// The steady interval of an impact, the means over it, and the end of a run whose means are known (impact/steady.hpp).

#include <array>
#include <string>
#include <utility>

#include "libmpm/impact/steady.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Finds the interval in which a column, by default the run-up without single particles, is steady (impact/steady.hpp), and computes mean,
/// standard error and number of independent samples of every column with `mean`. All means are over this interval, so that they describe
/// one state of the flow.
class SteadyInterval : public Observer {
 public:
  /// @param flow  sets how long the first splash takes. @param column  that has to be steady, as [measurement] steady_by has it
  SteadyInterval(const ImpactFlow& flow, std::string column) : flow_(flow), column_(std::move(column)) {}

  [[nodiscard]] std::string name() const override { return "steady_interval"; }
  [[nodiscard]] std::optional<Steady> steady_interval(const TimeSeries& series) const override {
    if (series.size() == 0) return std::nullopt;
    return find_steady(series.time(), series[column_], impact_steady_criteria(flow_, series.time().back()));
  }

  [[nodiscard]] std::vector<Result> summary(const Summary& end) const override {
    const Steady& span = end.span;
    std::vector<Result> results = {
        {"steady", span.steady, "", "whether the run-up becomes steady; if not, there are no means"},
        {"steady_from_s", span.steady ? span.from : MeanEstimate::none, "s", "start of the steady interval"},
        {"steady_to_s", span.steady ? span.to : MeanEstimate::none, "s", "end of the steady interval"},
        {"steady_samples", std::uint64_t{span.last - span.first}, "", "rows of series.csv in it"},
        {"inflow_constant_from_s", flow_.constant.from, "s",
         "when the last row of an inflow that varies has reached the obstacle: means are of that inflow alone; 0: the inflow is steady"},
        {"force_drift", drift(end.steady_part(end.series["force_x_n"])) / end.mean("force_x_n").mean, "",
         "how far the force is from steady: mean of force_x_n over the second half of the steady interval less that over the first, over "
         "the mean"},
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

 private:
  /// Mean, standard error and effective samples of a quantity. @param of the mean of each component: one or three
  static std::vector<Result> means(const Column& column, std::span<const MeanEstimate> of) {
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

  ImpactFlow flow_;
  std::string column_;
};

/// Applies the rule to the run-up, the pressure height and the stream-wise force, which other observers measure. Of MeasuredFrom::run: the
/// frames of a run are too far apart to say again when it ended.
class StopWhenSteady : public Observer {
 public:
  /// @param rule  with standard_error 0 no run ends by it. @param runup  column of the run-up, as of SteadyInterval
  StopWhenSteady(const StopRule& rule, std::string runup) : rule_(rule), runup_(std::move(runup)) {}

  [[nodiscard]] std::string name() const override { return "stop_when_steady"; }
  [[nodiscard]] MeasuredFrom measured_from() const override { return MeasuredFrom::run; }

  [[nodiscard]] bool may_end(const TimeSeries& series) const override {
    const std::array others{series["pressure_height_m"], series["force_x_n"]};
    return mpm::may_end(series.time(), series[runup_], others, rule_);
  }

  [[nodiscard]] std::vector<Result> summary(const Summary& end) const override {
    return {{"stop_when_steady", rule_.standard_error, "",
             "largest relative standard error of the means at which the run may end (output.stop_when_steady); 0: it may not",
             Nature::execution},
            {"stopped_when_steady", may_end(end.series), "", "whether the run ended by that rule, at duration_s", Nature::execution}};
  }

 private:
  StopRule rule_;
  std::string runup_;
};

}  // namespace mpm
