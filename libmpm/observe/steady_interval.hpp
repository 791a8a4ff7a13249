#pragma once
/// The steady interval of an impact and the means over it.

#include "libmpm/impact/impact_flow.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Finds where the run-up is steady (impact/steady.hpp) and gives the mean, the standard error and the number of independent samples of
/// every column that asks for a mean. All means are over this one interval, so that they belong to one state of the flow.
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
