#pragma once
/// Common part of the rate forms of isotropic laws with Hencky's elasticity: unknowns b_e - I (xx yy zz xy xz yz: the difference keeps
/// small strains exact) and one internal variable.

#include <Eigen/Eigenvalues>
#include <cmath>
#include <string>
#include <unsupported/Eigen/MatrixFunctions>
#include <vector>

#include "libmpm/base/error.hpp"
#include "validation/harness/ode_reference.hpp"

namespace mpm::validation {

/// An elastic step longer than this might jump over the whole elastic domain, in at one side and out at the other.
inline constexpr double longest_elastic_step = 1.0 / 256;

/// Velocity gradient of a segment, which lasts a second. @param who  for the message
/// @throws ConfigError for a drained segment
inline Mat3 segment_gradient(const ReferenceSegment& s, const std::string& who) {
  switch (s.control) {
    case ReferenceSegment::Control::strain: {
      Mat3 gradient = Vec3(0.5, 0.5, -1.0).asDiagonal();
      gradient *= s.d_eps_q;
      gradient += s.d_eps_v / 3.0 * Mat3::Identity();
      return gradient;
    }
    case ReferenceSegment::Control::velocity_gradient: return s.gradient;
    case ReferenceSegment::Control::drained_triaxial: break;
  }
  throw ConfigError(who + ": drained segments need coaxial_reference");
}

/// Kirchhoff stress of a state.
struct HenckyStress {
  Mat3 h, deviator;  ///< b_e - I; of tau, Pa
  double p, q;       ///< pressure positive, Pa
};
/// @param y  b_e - I
inline HenckyStress hencky_stress(const double* y, double bulk_modulus, double shear_modulus) {
  HenckyStress r;
  r.h << y[0], y[3], y[4], y[3], y[1], y[5], y[4], y[5], y[2];
  const Eigen::SelfAdjointEigenSolver<Mat3> eigen(r.h);
  const Vec3 strain = 0.5 * eigen.eigenvalues().array().log1p().matrix();
  const double volumetric = strain.sum();
  const Vec3 s = 2.0 * shear_modulus * (strain.array() - volumetric / 3.0).matrix();
  r.deviator = eigen.eigenvectors() * s.asDiagonal() * eigen.eigenvectors().transpose();
  r.p = -bulk_modulus * volumetric;
  r.q = std::sqrt(1.5) * s.norm();
  return r;
}

/// The unknowns with pressure p, q along a direction (any length; none where q = 0) and an internal variable.
inline std::vector<double> hencky_unknowns(double p, double q, const Mat3& direction, double internal, double bulk_modulus,
                                           double shear_modulus) {
  const double norm = std::sqrt(1.5) * direction.norm();
  const Mat3 dev = norm > 0.0 ? Mat3(direction * (q / (norm * 2.0 * shear_modulus))) : Mat3(Mat3::Zero());
  const Mat3 h = ((dev - p / (3.0 * bulk_modulus) * Mat3::Identity()) * 2.0).exp() - Mat3::Identity();
  return {h(0, 0), h(1, 1), h(2, 2), h(0, 1), h(0, 2), h(1, 2), internal};
}

/// Rates of b_e - I: L b + b L^T - g (n b + b n). @param dydt  its six numbers
inline void hencky_rates(const Mat3& h, const Mat3& gradient, double plastic_rate, const Mat3& normal, double* dydt) {
  const Mat3 b = Mat3::Identity() + h;
  const Mat3 lb = gradient * b - plastic_rate * normal * b;
  const Mat3 d = lb + lb.transpose();
  dydt[0] = d(0, 0), dydt[1] = d(1, 1), dydt[2] = d(2, 2), dydt[3] = d(0, 1), dydt[4] = d(0, 2), dydt[5] = d(1, 2);
}

/// eps_q of a deformation: sqrt(2/3) of the norm of the deviator of its logarithmic strain.
inline double deviatoric_strain(const Mat3& deformation) {
  const Vec3 strain = 0.5 * Eigen::SelfAdjointEigenSolver<Mat3>(deformation * deformation.transpose()).eigenvalues().array().log().matrix();
  return std::sqrt(2.0 / 3.0) * (strain.array() - strain.sum() / 3.0).matrix().norm();
}

}  // namespace mpm::validation
