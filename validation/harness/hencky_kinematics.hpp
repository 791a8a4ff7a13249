#pragma once
/// Common part of the rate forms of isotropic laws with Hencky's elasticity: unknowns b_e - I (xx yy zz xy xz yz: the difference keeps
/// small strains exact) and one internal variable.

#include <string>
#include <vector>

#include "validation/harness/ode_reference.hpp"

namespace mpm::validation {

/// An elastic step longer than this might jump over the whole elastic domain, in at one side and out at the other.
inline constexpr double longest_elastic_step = 1.0 / 256;

/// Velocity gradient of a segment, which lasts a second. @param who  for the message
/// @throws ConfigError for a drained segment
Mat3 segment_gradient(const ReferenceSegment& s, const std::string& who);

/// Kirchhoff stress of a state.
struct HenckyStress {
  Mat3 h, deviator;  ///< b_e - I; of tau, Pa
  double p, q;       ///< pressure positive, Pa
};
/// @param y  b_e - I
HenckyStress hencky_stress(const double* y, double bulk_modulus, double shear_modulus);

/// The unknowns with pressure p, q along a direction (any length; none where q = 0) and an internal variable.
std::vector<double> hencky_unknowns(double p, double q, const Mat3& direction, double internal, double bulk_modulus, double shear_modulus);

/// Rates of b_e - I: L b + b L^T - g (n b + b n). @param dydt  its six numbers
void hencky_rates(const Mat3& h, const Mat3& gradient, double plastic_rate, const Mat3& normal, double* dydt);

/// The deformation after `time` at a constant velocity gradient. @param start  the deformation at time 0
Mat3 deformed(const Mat3& start, const Mat3& gradient, double time);

/// eps_q of a deformation: sqrt(2/3) of the norm of the deviator of its logarithmic strain.
double deviatoric_strain(const Mat3& deformation);

}  // namespace mpm::validation
