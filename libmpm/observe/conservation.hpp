#pragma once
/// The snow as a whole: sums over all particles, particles that entered and left, and the energy balance that ends an unstable run.

#include <optional>

#include "libmpm/core/health.hpp"
#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Sums over the whole domain, including the images beyond mirror planes (diagnostics.hpp).
class Conservation : public Observer {
 public:
  [[nodiscard]] std::string name() const override { return "conservation"; }
  [[nodiscard]] MeasuredFrom measured_from() const override { return MeasuredFrom::run; }  // frames hold neither C nor enough digits

  [[nodiscard]] std::vector<Column> columns() const override {
    std::vector<Column> columns = {{.quantity = "particles", .meaning = "number of particles, with the images beyond mirror planes"},
                                   {.quantity = "mass", .unit = "kg", .meaning = "mass of the snow"}};
    for (const Column& c : vector_columns({.quantity = "momentum", .unit = "kg m/s", .meaning = "momentum of the snow"}))
      columns.push_back(c);
    columns.push_back({.quantity = "kinetic_energy", .unit = "J", .meaning = "kinetic energy of the particle velocities"});
    columns.push_back({.quantity = "elastic_energy", .unit = "J", .meaning = "stored elastic energy"});
    columns.push_back({.quantity = "potential_energy", .unit = "J", .meaning = "potential energy, zero at the origin"});
    columns.push_back({.quantity = "max_speed", .unit = "m/s", .meaning = "speed of the fastest particle"});
    return columns;
  }

  void sample(const Instant& now, std::span<double> row) override {
    const Totals t = whole_of_mirrored(now.live->totals, now.live->scene.mirror);
    const double values[] = {static_cast<double>(t.particles),
                             t.mass,
                             t.momentum.x(),
                             t.momentum.y(),
                             t.momentum.z(),
                             t.kinetic_energy,
                             t.elastic_energy,
                             t.potential_energy,
                             now.live->state.max_speed};
    std::ranges::copy(values, row.begin());
  }
};

/// Counts the particles that entered and left: initial + entered = final + left.
class ParticleFlux : public Observer {
 public:
  /// @param outlet whether snow may leave across the domain's end at x_max; snow that leaves elsewhere is lost
  /// @param mirror planes beyond which nothing is computed: masses are those of the whole domain
  ParticleFlux(bool outlet, const MirrorPlanes& mirror) : outlet_(outlet), mirror_(mirror) {}

  [[nodiscard]] std::string name() const override { return "particle_flux"; }
  [[nodiscard]] MeasuredFrom measured_from() const override { return MeasuredFrom::run; }

  [[nodiscard]] std::vector<Result> summary(const Summary& end) const override {
    const FluxTotals &in = end.state->entered, &out = end.state->left;
    const std::uint64_t downstream = outlet_ ? out.through_x_max : 0;
    return {{"particles_initial", end.progress->initial_particles, "", "particles at the start, in the computed part of a mirrored flow"},
            {"particles_entered", in.count, "", "particles that entered since the start, likewise"},
            {"particles_final", std::uint64_t{end.state->grid.particle_count()}, "",
             "particles at the end, likewise: initial + entered - left"},
            {"particles_left", out.count, "", "particles that left the domain"},
            {"particles_left_downstream", downstream, "", "particles that left through the outlet downstream"},
            {"particles_lost", out.count - downstream, "", "particles that left anywhere else"},
            {"mass_entered_kg", mirror_.parts() * in.mass, "kg", "mass that entered, of the whole flow even if only half is computed"},
            {"mass_left_kg", mirror_.parts() * out.mass, "kg", "mass that left, of the whole flow"}};
  }

 private:
  bool outlet_;
  MirrorPlanes mirror_;
};

/// Has no columns; warns, or ends the run with UnstableError.
class HealthCheck : public Observer {
 public:
  [[nodiscard]] std::string name() const override { return "health"; }
  [[nodiscard]] MeasuredFrom measured_from() const override { return MeasuredFrom::run; }

  void begin(const State& state, const Scene& scene) override { watch_.emplace(state, scene); }
  void after_step(const StepReport& report, const State&) override { watch_->add(report); }
  std::vector<std::string> check(const Instant& now) override { return watch_->check(now.live->state, now.live->scene, now.live->totals); }

 private:
  std::optional<HealthWatch> watch_;
};

}  // namespace mpm
