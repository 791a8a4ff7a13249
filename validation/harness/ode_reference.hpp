#pragma once
/// Reference for material-point paths: the rate equations of the cohesive Modified Cam-Clay law, integrated by SUNDIALS CVODE
/// to rtol 1e-13, in two forms. Nothing of the library's own law is used here.
///
/// Elasticity p = -K eps_v^e, s = 2 G dev eps^e (Kirchhoff stress, Hencky strain, p > 0 in compression); yield function
/// y = q^2 (1 + 2 beta) + M^2 (p + beta p_c)(p - p_c); p_c = K sinh(xi max(X, 0)); L_v b_e = -2 g' N b_e, N = dy/dtau.
/// With tr N = -y_p and sqrt(2/3)|dev N| = y_q the plastic strain rates are eps_v^P' = -g' y_p (so X' = g' y_p) and
/// eps_q^P' = g' y_q, hence on a coaxial path
///   p' = -K eps_v' - K g' y_p,   q' = 3 G eps_q' - 3 G g' y_q,   X' = g' y_p,
///   y_p = M^2 (2 p - (1 - beta) p_c),   y_q = 2 (1 + 2 beta) q,   dy/dp_c = -M^2 ((1 - beta) p + 2 beta p_c),
/// and y' = 0 gives g' = max(0, A)/D with
///   A = -K y_p eps_v' + 3 G y_q eps_q',
///   D = K y_p^2 + 3 G y_q^2 + M^2 ((1 - beta) p + 2 beta p_c) y_p xi sqrt(K^2 + p_c^2).
/// General form: b_e' = l b_e + b_e l^T - 2 g' N b_e (six components) and X; there A = -K y_p tr d + 6 G (1 + 2 beta) s : d,
/// because s : d/dt(1/2 log b_e) = s : (d - g' N) for s coaxial with b_e.
///
/// Events, each found as a root of CVODE, after which the integration starts anew: onset of yield (y), unloading (A), exhaustion
/// (p_c -> 0), snap-back (D -> 0), recompaction of stress-free snow (X = 0).

#include <array>
#include <cstddef>
#include <limits>
#include <string>
#include <vector>

#include "libmpm/base/types.hpp"

namespace mpm::validation {

/// Parameters of the law, in the symbols of the equations above.
struct CamClay {
  double bulk_modulus;               ///< K, Pa
  double shear_modulus;              ///< G, Pa
  double critical_state_slope;       ///< M > 0 (M = 0 has no rate form; see isotropic_limit)
  double cohesion_beta;              ///< beta >= 0
  double hardening_xi;               ///< xi > 0
  double preconsolidation_pressure;  ///< p_c0, Pa

  /// From Young's modulus (Pa) and Poisson's ratio.
  static CamClay from_young(double young, double poisson, double m, double beta, double xi, double pc0);
  /// X_0 = asinh(p_c0/K)/xi
  [[nodiscard]] double initial_internal() const;
  /// p_c(X) = K sinh(xi max(X, 0)), Pa
  [[nodiscard]] double preconsolidation(double internal) const;
  /// y(p, q, X), Pa^2
  [[nodiscard]] double yield(double p, double q, double internal) const;
};

/// One piece of a path; rates are constant over a time of one.
struct ReferenceSegment {
  enum class Control { strain, drained_triaxial, velocity_gradient } control = Control::strain;
  double d_eps_v = 0.0;          ///< strain: increment of volumetric Hencky strain, expansion positive
  double d_eps_q = 0.0;          ///< strain: increment of eps_q, axial shortening positive (may be negative: extension)
  double radial_stress = 0.0;    ///< drained_triaxial: sigma_r held, Pa, compression positive
  double d_eps_axial = 0.0;      ///< drained_triaxial: increment of axial Hencky strain, shortening negative
  Mat3 gradient = Mat3::Zero();  ///< velocity_gradient: l times its duration

  static ReferenceSegment strain_increment(double d_eps_v, double d_eps_q);
  static ReferenceSegment drained(double radial_stress, double d_eps_axial);
  static ReferenceSegment general(const Mat3& gradient);
};

/// State at the end of a sample interval.
struct ReferencePoint {
  double time;              ///< segments passed, 0 at the start
  double eps_v;             ///< volumetric Hencky strain
  double eps_q;             ///< coaxial paths: accumulated signed eps_q; general paths: of 1/2 log F F^T
  double p, q;              ///< Kirchhoff, Pa; q >= 0
  double q_signed;          ///< coaxial paths: axial minus radial stress, compression positive; general: q
  double internal;          ///< X
  double preconsolidation;  ///< p_c, Pa
  bool plastic;
  Mat3 stress;  ///< tau, Pa, tension positive; coaxial paths: axis along z
};

enum class PathEvent { onset, unloading, exhaustion, snap_back, recompaction };
std::string to_string(PathEvent);

struct EventRecord {
  PathEvent event;
  double time;
  double internal_before, internal_after;  ///< X; they differ at a snap-back only
};

struct ReferencePath {
  std::vector<ReferencePoint> points;  ///< samples_per_segment per segment, the start first
  std::vector<EventRecord> events;
  double drift = 0.0;  ///< max |y| / max(p_c, 1e-3 p_c0)^2 over plastic points
  /// min D/(K y_p^2 + 3 G y_q^2) where the plastic state is entered or sampled: the plastic strain rate is amplified by its inverse, and
  /// at zero the point snaps back
  double margin = std::numeric_limits<double>::infinity();
  long steps = 0;  ///< of CVODE
};

struct ReferenceOptions {
  double relative_tolerance = 1e-13;
  std::size_t samples_per_segment = 160;
};

/// Integrates a coaxial path with unknowns (p, q, X).
/// @throws ConfigError for M = 0, a general segment, or non-positive moduli; UnstableError where CVODE gives up
ReferencePath coaxial_reference(const CamClay&, const std::vector<ReferenceSegment>&, const ReferenceOptions& = {});

/// Integrates any path with unknowns (b_e - I, X); drained segments are not possible here.
ReferencePath general_reference(const CamClay&, const std::vector<ReferenceSegment>&, const ReferenceOptions& = {});

/// Independent formulation: SUNDIALS IDA on the index-1 system with unknowns (q, X), p = K (X_0 - eps_v - X):
///   y_p (3 G eps_q' - q') - 3 G y_q X' = 0,   y(p, q, X) = 0.
/// Only the plastic part of a strain-controlled path, from a point on the yield surface with y_p != 0.
/// @param start    on the surface
/// @param d_eps_v, d_eps_q  increments over the segment
/// @param samples  equally spaced points after the start
/// @throws UnstableError where IDA gives up at every absolute tolerance up to 1e-12
std::vector<ReferencePoint> dae_reference(const CamClay&, const ReferencePoint& start, double d_eps_v, double d_eps_q, std::size_t samples,
                                          double relative_tolerance = 1e-13);

/// The result of backward Euler: the first X below `internal` at which the state that the flow rule reaches from the trial state lies on
/// the yield surface again, p = p_trial - K (X - X_n), q = q_trial/(1 + 6 G (1 + 2 beta) (X - X_n)/y_p), found by a scan in equal
/// ratios and a bracketed root; stress-free at X = X_n + p_trial/K if there is none. Independent of the library's search.
struct Landing {
  double p, q, internal;
};
/// @param p_trial, q_trial  Pa, on or outside the surface of `internal` (X_n > 0), on its dilative side
/// @param skipped           the scan starts this fraction of X_n below X_n: above zero where the trial state itself is a root
Landing nearest_landing(const CamClay&, double p_trial, double q_trial, double internal, double skipped = 1e-12);

/// Exact states where the path has a closed form.
namespace exact {
/// Isotropic compression beyond p_c0: sinh(xi X) + X = e + X_0, p = p_c; e = -eps_v.
/// @returns X
double isotropic_compression(const CamClay&, double compression);
/// Largest root X < start of X - beta sinh(xi max(X, 0)) = e + X_0: the result for a point at the tension apex (q = 0).
double tension_apex(const CamClay&, double compression, double start);
/// Any isotropic history, taken in pieces of monotone volume change: X after the compression e where it was X_n before; then
/// p = K (e + X_0 - X). Elastic (X_n) within the apexes, else one of the two roots above. Holds on every path where M = 0.
double isotropic(const CamClay&, double compression, double internal);
/// Endless isochoric shear: (1 - beta)/2 sinh(xi X) + X = e + X_0, p = (1 - beta) p_c/2, q = M' p.
/// @returns X
double isochoric_critical_state(const CamClay&, double compression);
/// Critical-state ratio q/p = M' = M (1 + beta)/((1 - beta) sqrt(1 + 2 beta)), from y = 0 and y_p = 0.
double critical_ratio(const CamClay&);
/// p at the end of drained triaxial compression, 3 p_i/(3 - M') (M' < 3), or extension, 3 p_i/(3 + M'), from the isotropic stress p_i.
double drained_critical_pressure(const CamClay&, double isotropic_pressure, bool extension);
/// q at yield where p = 0: M p_c sqrt(beta/(1 + 2 beta)), Pa.
double yield_without_pressure(const CamClay&, double internal);
/// Elastic simple shear by gamma (1 along 1 per unit of 2) of Hencky's law: S = asinh(gamma/2)/sqrt(1 + gamma^2/4), tau_12 = 2 G S,
/// tau_11 = -tau_22 = G gamma S, all others zero.
Mat3 hencky_simple_shear(double shear_modulus, double gamma);
}  // namespace exact

}  // namespace mpm::validation
