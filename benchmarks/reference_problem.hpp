#pragma once
/// Moving problems for whole steps, and the reference problem among them: a problem that is stepped, monitored, and seeded again when
/// it leaves the state for which the results are valid.

#include <cstdint>
#include <functional>
#include <stdexcept>
#include <vector>

#include "problems.hpp"

namespace mpm::benchmarks {

/// Fractions of the particles that yielded or changed cell in one step.
struct Activity {
  double yielding = 0.0;       ///< the law's internal variable changed
  double changing_cell = 0.0;  ///< the base node changed
  double changing_block = 0.0;
};

class SteppedProblem {
 public:
  /// @param make        the problem at t = 0
  /// @param least       fractions that every counted step must reach
  /// @param most_steps  steps after which the problem is seeded again in any case
  SteppedProblem(std::function<Problem()> make, const Activity& least, int most_steps);

  Problem& problem() { return problem_; }
  /// The problem at t = 0, then untimed steps until one reaches the least fractions. @throws std::runtime_error if none of 200 does
  void seed();

  /// One step that reaches the least fractions. `one_step(problem, dt)` does exactly one step and times it itself: it is called again,
  /// after seeding, if the previous step missed a fraction; the last call counts. Counting the particles is not part of it.
  /// @throws std::runtime_error if the fractions are missed repeatedly
  template <class OneStep>
  Activity counted_step(OneStep&& one_step) {
    for (int attempt = 0; attempt < most_attempts; ++attempt) {
      if (steps_ >= most_steps_) seed();
      remember();
      one_step(problem_, stable_time_step(problem_.state, problem_.scene));
      ++steps_;
      const Activity s = activity();
      if (reaches(s)) return s;
      steps_ = most_steps_;
    }
    throw std::runtime_error("the problem does not keep the fractions of yielding and moving particles that it must have");
  }

  [[nodiscard]] int seedings() const { return seedings_; }

 private:
  static constexpr int most_attempts = 4;
  void remember();
  [[nodiscard]] Activity activity() const;
  [[nodiscard]] bool reaches(const Activity& s) const;

  std::function<Problem()> make_;
  Activity least_;
  int most_steps_, steps_ = 0, seedings_ = 0;
  Problem problem_;
  struct Before {
    double internal;
    std::uint64_t cell;
  };
  std::vector<Before> before_;  // by identity number
};

/// Part of the reference block that deforms plastically.
enum class Regime : std::uint8_t {
  elastic,          ///< p_c0 beyond reach; moves at 10 m/s along x, with a twentieth of the velocity gradient: strains stay small
  partly_yielding,  ///< the upper half moves with the speed of z = 2 m, without straining
  fully_yielding,   ///< the reference problem
};

/// The reference problem: block 2 x 1 x 4 m (x, y, z), 8 particles a cell, v = (5 (x - 1) + 2 z, 0, -5 z) m/s with its gradient,
/// E 1 MPa, nu 0.1, rho 300, M 0.8, beta 0.3, xi 0.5, p_c0 10 kPa; gravity and a frictionless floor at z = 0.
/// dx = 0.05 m: 512,000 particles.
Problem make_reference(double cell_size, Regime regime, Precision precision = Precision::double_precision);

/// The reference problem as it is timed: at least 99 % of the particles yield and 2 % change cell in every counted step (fully yielding
/// only).
SteppedProblem reference_problem(double cell_size = 0.05, Regime regime = Regime::fully_yielding,
                                 Precision precision = Precision::double_precision);

/// make_avalanche, seeded again every 100 steps: before the jet has fallen.
SteppedProblem avalanche_problem(std::size_t particles, Precision precision = Precision::double_precision);

}  // namespace mpm::benchmarks
