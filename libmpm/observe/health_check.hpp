#pragma once
/// Watches the energy balance and the time step of a run (core/health.hpp) and stops one that is unstable.

#include <optional>

#include "libmpm/core/health.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Has no columns; warns, or ends the run with UnstableError.
class HealthCheck : public Observer {
 public:
  [[nodiscard]] std::string name() const override { return "health"; }
  [[nodiscard]] Source source() const override { return Source::run; }

  void begin(const State& state, const Scene& scene) override { watch_.emplace(state, scene); }
  void after_step(const StepReport& report, const State&) override { watch_->add(report); }
  std::vector<std::string> check(const Instant& now) override { return watch_->check(now.live->state, now.live->scene, now.live->totals); }

 private:
  std::optional<HealthWatch> watch_;
};

}  // namespace mpm
