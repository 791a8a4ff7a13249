#pragma once
/// Reference for material-point paths of a frictional cone (Drucker-Prager, mu(I)): the rate equations integrated by SUNDIALS CVODE to
/// rtol 1e-13. Nothing of the library's own law is used here.
///
/// Elasticity p = -K tr eps, s = 2 G dev eps (Kirchhoff stress, Hencky strain eps = 1/2 log b_e, p > 0 in compression), q = sqrt(3/2 s:s);
/// f = q - A p - C; flow N = 3/2 s/q + A_psi/3 I with the rate g' = sqrt(2/3 dev d^P : dev d^P). Unknowns are b_e and the plastic volume
/// strain X:
///   b_e' = l b_e + b_e l^T - 2 g' N b_e,   X' = A_psi g'.
/// q' = (3 G/q) s:d - 3 G g' and p' = -K tr d + K A_psi g', so that f' = 0 gives
///   g' = max(0, (3 G/q) s:d + A K tr d) / (3 G + K A A_psi).
/// With mu(I), q = A(I) p + C, A(I) = A + (A_2 - A)/(I_0/I + 1) and I = sqrt(3) g' d_g sqrt(rho_s/p) give for f > 0
///   I = I_0 f / ((A_2 - A) p - f),   g' = I sqrt(p/rho_s) / (sqrt(3) d_g).
/// At the apex p = -C/A, q = 0, all further strain is plastic: X = eps_v - C/(A K). A point without cohesion that is compressed there first
/// closes X, free of stress; from X = 0 the stress grows along a ray, p' = K (-tr d + A_psi g'), q' = 3 G (eps_q' - g').
///
/// Events, each found as a root of CVODE or in closed form, after which the integration starts anew: onset of yield, unloading, apex,
/// recompaction.

#include "libmpm/material/drucker_prager.hpp"
#include "validation/harness/ode_reference.hpp"

namespace mpm::validation {

/// Parameters in the symbols above.
struct Cone {
  double bulk_modulus, shear_modulus;  ///< K, G, Pa
  double slope, intercept;             ///< A; C, Pa
  double dilatancy = 0.0;              ///< A_psi
  double slope_increase = 0.0;         ///< A_2 - A; 0: no rate dependence
  double reference_number = 0.0;       ///< I_0
  double grain_diameter = 0.0;         ///< d_g, m
  double grain_density = 0.0;          ///< rho_s, kg/m^3

  /// From the angles of Mohr-Coulomb, by the formulas of Drucker and Prager's textbook cones for the two tests that fix them:
  /// triaxial_compression A = 6 sin phi/(3 - sin phi), C = 6 c cos phi/(3 - sin phi), A_psi likewise; simple_shear sqrt(3) tan phi,
  /// sqrt(3) c, sqrt(3) tan psi. @throws ConfigError for another matching
  static Cone of(const DruckerPrager::Parameters& p);
};

/// Integrates any path without stress control; a segment lasts one second.
/// @throws ConfigError for drained segments and for the closing of cohesive or rate-dependent material; UnstableError where CVODE gives up
ReferencePath cone_reference(const Cone&, const std::vector<ReferenceSegment>&, const ReferenceOptions& = {});

}  // namespace mpm::validation
