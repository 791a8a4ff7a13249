#pragma once
/// How long a rank computes in a step, and how long it waits for others.

#include <chrono>
#include <optional>

#include "libmpm/base/process.hpp"

namespace mpm {

/// Processor time of the calling thread in a step, without waiting. A rank that waits keeps its core busy.
class StepClock {
 public:
  /// At the beginning of a step.
  void start() {
    start_ = thread_seconds();
    waited_ = 0.0;
  }
  /// At its end. @returns the computing time since start(), s; nothing if that was not called
  std::optional<double> stop() {
    if (!start_) return std::nullopt;
    const double computed = thread_seconds() - *start_ - waited_;
    start_.reset();
    return computed;
  }

  /// From its creation to its end the rank waits.
  class Waiting {
   public:
    /// @param sum  the elapsed time is added to it, s
    Waiting(StepClock& clock, double& sum) : clock_(clock), sum_(sum) {}
    ~Waiting() {
      sum_ += std::chrono::duration<double>(Elapsed::now() - elapsed_).count();
      clock_.waited_ += thread_seconds() - thread_;
    }
    Waiting(const Waiting&) = delete;
    Waiting& operator=(const Waiting&) = delete;

   private:
    using Elapsed = std::chrono::steady_clock;
    StepClock& clock_;
    double& sum_;
    Elapsed::time_point elapsed_ = Elapsed::now();
    double thread_ = thread_seconds();
  };

 private:
  std::optional<double> start_;
  double waited_ = 0.0;
};

}  // namespace mpm
