#include "validation/harness/hencky_kinematics.hpp"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "libmpm/base/error.hpp"
#include "libmpm/base/tensor.hpp"

namespace mpm::validation {

Mat3 segment_gradient(const ReferenceSegment& s, const std::string& who) {
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

HenckyStress hencky_stress(const double* y, double bulk_modulus, double shear_modulus) {
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

std::vector<double> hencky_unknowns(double p, double q, const Mat3& direction, double internal, double bulk_modulus, double shear_modulus) {
  const double norm = std::sqrt(1.5) * direction.norm();
  const Mat3 dev = norm > 0.0 ? Mat3(direction * (q / (norm * 2.0 * shear_modulus))) : Mat3(Mat3::Zero());
  const Mat3 h = exp_minus_identity(Mat3((dev - p / (3.0 * bulk_modulus) * Mat3::Identity()) * 2.0));
  return {h(0, 0), h(1, 1), h(2, 2), h(0, 1), h(0, 2), h(1, 2), internal};
}

void hencky_rates(const Mat3& h, const Mat3& gradient, double plastic_rate, const Mat3& normal, double* dydt) {
  const Mat3 b = Mat3::Identity() + h;
  const Mat3 lb = gradient * b - plastic_rate * normal * b;
  const Mat3 d = lb + lb.transpose();
  dydt[0] = d(0, 0), dydt[1] = d(1, 1), dydt[2] = d(2, 2), dydt[3] = d(0, 1), dydt[4] = d(0, 2), dydt[5] = d(1, 2);
}

Mat3 deformed(const Mat3& start, const Mat3& gradient, double time) { return start + exp_minus_identity(Mat3(gradient * time)) * start; }

double deviatoric_strain(const Mat3& deformation) {
  const Vec3 strain = 0.5 * Eigen::SelfAdjointEigenSolver<Mat3>(deformation * deformation.transpose()).eigenvalues().array().log().matrix();
  return std::sqrt(2.0 / 3.0) * (strain.array() - strain.sum() / 3.0).matrix().norm();
}

}  // namespace mpm::validation
