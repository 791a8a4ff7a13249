#pragma once
/// Layers of fluid at rest or in long waves: the hydrostatic column of a compressible law, the bore between two such columns, particles
/// that start in equilibrium, and the depth of a simulated flow.

#include <functional>
#include <optional>
#include <vector>

#include "libmpm/driver/scene.hpp"
#include "validation/harness/setup.hpp"

namespace mpm::validation {

/// J = rho_0/rho as a function of the Cauchy pressure (Pa) along the loading curve of a fluid; 1 at no pressure.
using CompressionCurve = std::function<double(double)>;

/// Elastic Hencky fluid, p = K x e^x with x = -ln J.
CompressionCurve hencky_curve(double bulk_modulus);
/// Snow with M = 0 on first loading. The Kirchhoff pressure is p_K = J p, and x = p_K/K + (asinh(p_K/K) - asinh(p_c0/K))/xi from p_c0 on,
/// because there p_K = p_c = K sinh(xi X).
CompressionCurve snow_curve(double bulk_modulus, double xi, double preconsolidation_pressure);
/// Tait fluid, p = K/n (J^-n - 1).
CompressionCurve tait_curve(double bulk_modulus, int exponent);

/// Column at rest under gravity with no shear stress and nothing above it. The Cauchy pressure under the mass m per area is p = g m
/// exactly, and dz = J dm/rho_0, so that a column of mass mu has the height and the thrust per width
///   h(mu) = 1/rho_0 int_0^mu J(g m) dm,   F(mu) = int p dz = 1/rho_0 int_0^mu g m J(g m) dm.
/// Incompressible: mu = rho_0 h and F = rho_0 g h^2/2.
class HydrostaticColumn {
 public:
  HydrostaticColumn(double density, double gravity, CompressionCurve curve);
  [[nodiscard]] double height(double mass_per_area) const;  ///< m
  [[nodiscard]] double thrust(double mass_per_area) const;  ///< N/m
  [[nodiscard]] double mass(double height) const;           ///< kg/m^2, the inverse of height()
  [[nodiscard]] double density() const { return density_; }
  [[nodiscard]] double gravity() const { return gravity_; }

 private:
  [[nodiscard]] double integral(double mass_per_area, bool with_pressure) const;
  double density_, gravity_;
  CompressionCurve curve_;
};

/// Bore that a layer (mu_1, speed v towards the wall) drives back from a wall at rest.
struct Bore {
  double mass;    ///< mu_2 behind the bore, kg/m^2
  double height;  ///< h_2, m
  double speed;   ///< S, away from the wall, m/s
  double thrust;  ///< on the wall, N/m
};

/// Mass mu_1 (v + S) = mu_2 S and momentum mu_1 v (v + S) = F(mu_2) - F(mu_1) over a bore, with rest behind it and hydrostatic
/// pressure on both sides. Incompressible: Fr^2 = (r - 1)^2 (r + 1)/(2 r), r = h_2/h_1.
Bore reflected_bore(const HydrostaticColumn& column, double mass_per_area, double speed);

/// make_state() of a case with one box, its lattice staggered: the particles of the k-th lattice plane along `across` are moved along
/// `along` by frac(k phi) of the spacing (phi the golden ratio) and wrapped around inside the box. Every strip of the box keeps its mass.
///
/// Why: where a flow stretches a body along an axis by more than two or three, the columns of a plain lattice part by more than a cell;
/// the nodes between them are left without material and the body tears ('numerical fracture') although it is compressed from the other
/// side. In a staggered lattice the planes that close up there fill each other's gaps.
State staggered_state(const Case& c, const Scene& scene, int along, int across);

/// The particles of a case with one box on the floor z = 0, staggered, and compressed to rest under gravity by the law itself: a particle
/// at reference height Z of a layer of reference height H carries the pressure rho_0 g (H - Z) and sits at z = int_0^Z J dZ'. Stress and
/// internal variable come from the law's own isotropic compression.
State hydrostatic_state(const Case& c, const Scene& scene, int along, int across);

/// Mass per area along x, kg/m^2, by linear weighting on nodes x_min + i spacing.
struct DepthProfile {
  double x_min, spacing, width;  ///< width of the slice, m
  std::vector<double> mass;
  [[nodiscard]] double x(std::size_t i) const { return x_min + static_cast<double>(i) * spacing; }
};
/// @param width of the slice across the flow (y), m
DepthProfile depth_profile(const State& state, double density, double x_min, double x_max, double spacing, double width);
/// The same of the particles of an instant.
DepthProfile depth_profile(const std::vector<ParticleRecord>& particles, double x_min, double x_max, double spacing, double width);

/// Seen from x_max, the first place where the profile rises through `level`, by linear interpolation; empty if it nowhere does.
std::optional<double> last_crossing(const DepthProfile& profile, double level);

/// Mean and standard error of a series that is correlated in time, from `batches` consecutive batches.
struct BatchMean {
  double mean, standard_error;
};
BatchMean batch_mean(const std::vector<double>& values, std::size_t batches);

}  // namespace mpm::validation
