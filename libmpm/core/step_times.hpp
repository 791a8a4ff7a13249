#pragma once
/// Times of the phases of a step, for benchmarks: the step runs each phase through a PhaseTimer.

#include <chrono>
#include <utility>

namespace mpm {

/// Wall time of the phases of a step, s. Blocks are moved phase by phase within one parallel loop: its wall time is divided among its
/// phases by the time that the threads spent in them.
struct StepTimes {
  double source = 0.0, particle_to_grid = 0.0, grid_update = 0.0, grid_to_particle = 0.0, stress = 0.0, sort = 0.0;  ///< s
  /// Sum of the phases, s.
  [[nodiscard]] double total() const { return source + particle_to_grid + grid_update + grid_to_particle + stress + sort; }
};

/// Calls functions and adds the time that they take to a phase. `timed(&StepTimes::sort, [&] { return f(); })` returns what f returns.
class PhaseTimer {
 public:
  /// @param times  null: only calls the functions
  explicit PhaseTimer(StepTimes* times) : times_(times) {}

  /// Calls f.
  template <class F>
  decltype(auto) operator()(double StepTimes::*phase, F&& f) const {
    const Span span(times_ != nullptr ? &(times_->*phase) : nullptr);
    return std::forward<F>(f)();
  }

 private:
  using Clock = std::chrono::steady_clock;
  /// From its construction to its end.
  class Span {
   public:
    explicit Span(double* time) : time_(time) {
      if (time_ != nullptr) start_ = Clock::now();
    }
    ~Span() {
      if (time_ != nullptr) *time_ += std::chrono::duration<double>(Clock::now() - start_).count();
    }
    Span(const Span&) = delete;
    Span& operator=(const Span&) = delete;

   private:
    double* time_;
    Clock::time_point start_;
  };
  StepTimes* times_;
};

}  // namespace mpm
