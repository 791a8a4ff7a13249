#pragma once
/// What a run's means are compared with: the heights by the paper's semi-empirical equations for the same case, and the numerical
/// uncertainty from grid studies at the run's resolution.

#include <cmath>
#include <string>

#include "libmpm/impact/grid_uncertainty.hpp"
#include "libmpm/impact/semi_empirical.hpp"
#include "libmpm/impact/steady.hpp"
#include "libmpm/observe/contact_force.hpp"
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

/// Entries of results.json only: the relative uncertainties of grid_uncertainty.hpp times the means.
class NumericalUncertainty : public Observer {
 public:
  /// @param relative  of each quantity; NaN: unknown. @param axis  m, as of TransientForce
  NumericalUncertainty(const GridUncertainty& relative, double axis) : relative_(relative), axis_(axis) {}

  [[nodiscard]] std::string name() const override { return "numerical_uncertainty"; }
  [[nodiscard]] MeasuredFrom measured_from() const override { return MeasuredFrom::run; }

  [[nodiscard]] std::vector<Result> summary(const Summary& end) const override {
    const auto of = [](double relative, double mean) { return relative * std::abs(mean); };
    const auto meaning = [](const char* what) {
      return std::string("numerical uncertainty of the mean ") + what +
             ": grid and time step, estimated from published grid studies at this resolution, not from this run; statistical error, snow "
             "parameters and model are not included";
    };
    const double moment = end.mean(overturning_moment(end.series["moment_y_n_m"], end.series["force_z_n"], axis_)).mean;
    return {{"runup_p99_numerical_uncertainty_m", of(relative_.runup, end.mean("runup_p99_m").mean), "m",
             meaning("run-up of 99 % of the mass"), Nature::uncertainty},
            {"runup_numerical_uncertainty_m", of(relative_.highest_particle, end.mean("runup_m").mean), "m",
             meaning("run-up of the highest particle"), Nature::uncertainty},
            {"pressure_height_numerical_uncertainty_m", of(relative_.pressure_height, end.mean("pressure_height_m").mean), "m",
             meaning("pressure height"), Nature::uncertainty},
            {"force_x_numerical_uncertainty_n", of(relative_.force, end.mean("force_x_n").mean), "N", meaning("stream-wise force"),
             Nature::uncertainty},
            {"overturning_moment_numerical_uncertainty_n_m", of(relative_.moment, moment), "N m", meaning("overturning moment"),
             Nature::uncertainty}};
  }

 private:
  GridUncertainty relative_;
  double axis_;
};

}  // namespace mpm
