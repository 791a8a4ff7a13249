#pragma once
/// Ends a run whose means are known (impact/stop_rule.hpp).

#include <array>
#include <string>
#include <utility>

#include "libmpm/impact/stop_rule.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Applies the rule to the run-up, the pressure height and the stream-wise force, which other observers measure. Of Source::run: the frames
/// of a run are too far apart to say again when it ended.
class StopWhenSteady : public Observer {
 public:
  /// @param rule  with standard_error 0 no run ends by it. @param runup  column of the run-up, as of SteadyInterval
  StopWhenSteady(const StopRule& rule, std::string runup) : rule_(rule), runup_(std::move(runup)) {}

  [[nodiscard]] std::string name() const override { return "stop_when_steady"; }
  [[nodiscard]] Source source() const override { return Source::run; }

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
