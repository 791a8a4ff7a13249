#pragma once
/// The heights by the paper's semi-empirical equations for the same case.

#include "libmpm/impact/impact_flow.hpp"
#include "libmpm/impact/semi_empirical.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Eqs. 7-10, which were fitted to obstacles as wide as the flow is high. Unknown for laws without M'.
class Prediction : public Observer {
 public:
  /// @param flow_height H, m
  Prediction(const ImpactFlow& flow, double flow_height) : flow_(flow), flow_height_(flow_height) {}

  [[nodiscard]] std::string name() const override { return "prediction"; }

  [[nodiscard]] std::vector<Result> summary(const Summary&) const override {
    double runup = MeanEstimate::none, pressure_height = MeanEstimate::none;
    if (flow_.effective_friction) {
      runup = predicted_runup(*flow_.effective_friction, flow_.velocity, flow_height_, flow_.gravity);
      pressure_height = predicted_pressure_height(*flow_.effective_friction, flow_.velocity, flow_height_, flow_.gravity);
    }
    return {{"predicted_runup_m", runup, "m", "steady run-up by the paper's semi-empirical equation for the same case"},
            {"predicted_pressure_height_m", pressure_height, "m", "pressure height by the paper's semi-empirical equation"}};
  }

 private:
  ImpactFlow flow_;
  double flow_height_;
};

}  // namespace mpm
