#pragma once
/// Number and mass of particles: initial, entered, left, final.

#include "libmpm/observe/observer.hpp"

namespace mpm {

/// Counts the particles that entered and left: initial + entered = final + left.
class ParticleFlux : public Observer {
 public:
  /// @param outlet whether snow may leave across the domain's end at x_max; snow that leaves elsewhere is lost
  /// @param mirror planes beyond which nothing is computed: masses are those of the whole domain
  ParticleFlux(bool outlet, const MirrorPlanes& mirror) : outlet_(outlet), mirror_(mirror) {}

  [[nodiscard]] std::string name() const override { return "particle_flux"; }
  [[nodiscard]] Source source() const override { return Source::run; }

  [[nodiscard]] std::vector<Result> summary(const Summary& end) const override {
    const FluxTotals &in = end.state->entered, &out = end.state->left;
    const std::uint64_t downstream = outlet_ ? out.through_x_max : 0;
    return {{"particles_initial", end.progress->initial_particles, "", "particles at the start"},
            {"particles_entered", in.count, "", "particles that entered since the start"},
            {"particles_final", std::uint64_t{end.state->grid.particle_count()}, "", "particles at the end: initial + entered - left"},
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

}  // namespace mpm
