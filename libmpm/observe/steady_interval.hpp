#pragma once
/// The steady interval of an impact and the means over it.

#include <string>
#include <utility>

#include "libmpm/impact/impact_flow.hpp"
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
  [[nodiscard]] std::optional<Steady> steady_interval(const TimeSeries& series) const override;
  [[nodiscard]] std::vector<Result> summary(const Summary& end) const override;

 private:
  ImpactFlow flow_;
  std::string column_;
};

}  // namespace mpm
