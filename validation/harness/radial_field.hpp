#pragma once
/// Plane strain with motion along the radius only, r(R, t), as a test of a law in a field: rings of material between R = a and R = b, whose
/// neighbours are moved exactly.
///
/// The exact motion is known everywhere. Particles with a < R < b move as the method wants; those inside a (the driver) and, unless
/// the surface at b is free, those outside b (the rim) carry the exact velocity, velocity gradient and stress in every step. The
/// acceleration of the exact motion is given to all particles as a body force: the static solution of a law that does not depend on the
/// rate is then the exact solution of the dynamic problem, at any speed of loading.

#include <functional>
#include <vector>

#include "libmpm/driver/case.hpp"
#include "validation/harness/case.hpp"

namespace mpm::validation {

/// A point of the exact solution.
struct RadialPoint {
  double r = 0.0, velocity = 0.0, acceleration = 0.0;  ///< m, m/s, m/s^2
  double radial_rate = 0.0, hoop_rate = 0.0;           ///< of the logarithmic strains, 1/s
  double radial = 0.0, hoop = 0.0, axial = 0.0;        ///< Kirchhoff stress, Pa, tension positive
  double internal = 0.0;                               ///< internal variable of the law
};

/// The exact solution at one time, by radius R, m.
using RadialState = std::function<RadialPoint(double radius)>;
/// The exact solution by time, s; before 0 all is at rest.
using RadialMotion = std::function<RadialState(double time)>;

/// What is computed.
struct RadialSetting {
  double inner = 0.0, outer = 0.0;      ///< a, b, m
  int cells = 8;                        ///< in a
  bool free_surface = false;            ///< at b; else a rim that is moved
  double judged_from = 0.0;             ///< radii between which stresses are judged, m: lower
  double judged_to = 0.0;               ///< upper; 0: b
  int per_axis = 2;                     ///< particles per cell and axis
  double initial_volume_ratio = 1.0;    ///< J of the start: the particles' stress at t = 0 is that of motion(0)
  double duration = 0.0;                ///< s
  Transfer transfer = Transfer::aflip;  ///< between particles and grid
  double flip_ratio = 1.0;              ///< Transfer::flip
};

/// Errors at the end, over the particles that are free to move; of stress and internal variable over those within the judged radii.
struct RadialErrors {
  double cell = 0.0;                                      ///< over a
  double displacement = 0.0;                              ///< root mean square, m
  double radial = 0.0, hoop = 0.0, axial = 0.0;           ///< root mean square, Pa
  double internal = 0.0;                                  ///< root mean square
  double wall_stress = 0.0, wall_exact = 0.0;             ///< mean radial stress of the particles within a/8 of a: ours, exact, Pa
  std::vector<double> place, radial_values, hoop_values;  ///< R/a of the free particles, and their stresses, Pa
  std::vector<double> internal_values;                    ///< and internal variables
  double particle_steps = 0.0;
};

/// Makes the run. @param base  the case file: law, numerics, a body (of which the lattice and the extent along z are not used), two slip
/// walls normal to z
RadialErrors run_radial(const Case& base, const RadialSetting& setting, const RadialMotion& exact);

}  // namespace mpm::validation
