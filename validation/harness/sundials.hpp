#pragma once
/// CVODE with root finding behind C++ callables: Adams methods of order up to 12 with fixed-point iteration (the rate equations
/// of a material point are not stiff away from the roots that stop the integration), restart after an event.

#include <functional>
#include <memory>
#include <span>
#include <vector>

namespace mpm::validation {

class OdeIntegrator {
 public:
  /// dy/dt = rhs(t, y); exceptions thrown inside leave advance() unchanged
  using Rhs = std::function<void(double t, const double* y, double* dydt)>;
  /// root functions g(t, y)
  using Roots = std::function<void(double t, const double* y, double* g)>;

  /// @param unknowns            length of y
  /// @param absolute_tolerance  in the unit of y
  OdeIntegrator(std::size_t unknowns, Rhs rhs, double relative_tolerance, double absolute_tolerance);
  ~OdeIntegrator();
  OdeIntegrator(const OdeIntegrator&) = delete;
  OdeIntegrator& operator=(const OdeIntegrator&) = delete;

  /// (Re-)initialises at y(t); the integration never steps beyond stop_time. A root function is looked at after each step only: where it
  /// may change its sign twice within one, bound the step.
  /// @param directions  one per root function: +1 rising, -1 falling; a root in the other direction is ignored
  /// @param longest_step  0: no bound
  void start(double t, std::span<const double> y, double stop_time, Roots roots, std::vector<int> directions, double longest_step = 0.0);
  struct Stop {
    double time;
    int root;  ///< index of the root function that stopped the integration, -1 where the target was reached
  };
  /// @throws UnstableError with CVODE's own message where it cannot go on
  Stop advance(double target);
  [[nodiscard]] std::span<const double> state() const;
  [[nodiscard]] long steps() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// IDA for F(t, y, y') = 0 of index 1 with consistent y(t0), y'(t0).
using Residual = std::function<void(double t, const double* y, const double* dydt, double* residual)>;
/// dF/dy + c dF/dy', row by row; Newton's iteration then converges to round-off, which difference quotients do not allow
using Jacobian = std::function<void(double t, double c, const double* y, const double* dydt, double* rows)>;
/// @returns y at each of the times (rising, after t0)
/// @throws UnstableError
std::vector<std::vector<double>> integrate_dae(const Residual& residual, const Jacobian& jacobian, double t0, std::vector<double> y,
                                               std::vector<double> dydt, std::span<const double> times, double relative_tolerance,
                                               double absolute_tolerance);

}  // namespace mpm::validation
