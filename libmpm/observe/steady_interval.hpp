#pragma once
/// The steady interval of an impact and the means over it.

#include "libmpm/impact/impact_flow.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Finds the interval in which the run-up is steady (impact/steady.hpp), and computes mean, standard error and number of independent
/// samples of every column with `mean`. All means are over this interval, so that they describe one state of the flow.
class SteadyInterval : public Observer {
 public:
  /// @param flow  sets how long the first splash takes
  explicit SteadyInterval(const ImpactFlow& flow) : flow_(flow) {}

  [[nodiscard]] std::string name() const override { return "steady_interval"; }
  [[nodiscard]] std::optional<Steady> steady_interval(const TimeSeries& series) const override;
  [[nodiscard]] std::vector<Result> summary(const Summary& end) const override;

 private:
  ImpactFlow flow_;
};

}  // namespace mpm
