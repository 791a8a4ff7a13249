#pragma once
/// Watches over a run from outside the step: the energy balance, a time step that shrinks, particles that start inside a boundary.
/// step() itself detects errors of single particles (not finite, turned inside out, too far in one step).

#include <string>
#include <vector>

#include "libmpm/core/diagnostics.hpp"

namespace mpm {

/// Energy balance: compares the change of the particles' energy E = kinetic (with the affine part that APIC keeps) + elastic with the
/// work done on them:
///
///   gain = E - E_start - [ sum_steps dt g.P + work of the boundaries' surfaces + E of what entered - E of what left ].
///
/// P is the momentum after the boundaries have acted, with which the particles move, so that dt g.P is the work of gravity; a surface that
/// moves with u does the work -J.u (Impulse::work), one at rest none. The rest can only be lost: contact, friction, plastic and viscous
/// work, and both transfers (APIC: Jiang et al. 2015; the PIC/FLIP blend, as long as the fraction of FLIP is at most 1). So gain
/// can only fall, except for the oscillation of symplectic Euler, whose energy for a mode of frequency omega stays within the fraction
/// omega dt/2 of a constant (Hairer, Lubich & Wanner, Geometric Numerical Integration, ch. IX). Its rise above its minimum is the excess, a
/// sign of instability, compared with the largest E so far. In stable runs of this project's cases the ratio stayed below 0.02; the energy
/// of an instability grows exponentially.
class EnergyWatch {
 public:
  /// 0.1: several times the values of stable runs. 0.9: at cfl <= 1 not even a run whose whole energy swings in the grid's highest mode
  /// (omega dt = sqrt(3/2) cfl for quadratic B-splines) shows more than 1 - (1 - 0.61)/(1 + 0.61) = 0.76.
  /// @{
  static constexpr double suspicious = 0.1, beyond_doubt = 0.9;
  /// @}

  /// Starts the balance at this state, for example after a resume.
  EnergyWatch(const State& state, const Scene& scene);
  /// To be called after every step.
  void add(const StepReport& report);
  /// @param now  sums of the computed part, without the images of mirror planes
  /// @returns excess over the largest E so far, 0 where there is no energy
  double excess_ratio(const Totals& now);
  [[nodiscard]] double excess() const { return excess_; }  ///< J, at the last call of excess_ratio
  [[nodiscard]] double gain() const { return gain_; }      ///< J, at the last call of excess_ratio

 private:
  Vec3 gravity_, momentum_;
  double start_, largest_, given_ = 0.0, gain_ = 0.0, lowest_ = 0.0, excess_ = 0.0;
};

/// The fastest particle; if several are equally fast, the one with the lowest number; all zeros without particles. With several ranks: on
/// the first.
Particle fastest_particle(const State& state);

/// The checks of a run at every sample. Each warning is given once.
class HealthWatch {
 public:
  /// Starts at this state.
  HealthWatch(const State& state, const Scene& scene);
  /// To be called after every step.
  void add(const StepReport& report) { energy_.add(report); }
  /// Warnings for the log. @throws UnstableError if the excess reaches nine tenths of the energy
  std::vector<std::string> check(const State& state, const Scene& scene, const Totals& now);

 private:
  EnergyWatch energy_;
  double first_step_;  ///< stable step at the start, s
  bool warned_energy_ = false, warned_step_ = false;
};

/// Particles that are inside a boundary.
struct BuriedParticles {
  std::size_t count = 0;  ///< number of particles
  std::string first;      ///< the one with the lowest number: "particle 7 at (1, 2, 3) m"
};

/// Particles whose eight nearest nodes the boundary covers; the material law has hardly any effect on them.
/// Collective: all ranks call it, and the first gets the result for all particles.
BuriedParticles buried_particles(const State& state, const Scene& scene, const Boundary& boundary);

}  // namespace mpm
