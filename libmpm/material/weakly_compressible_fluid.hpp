#pragma once
/// Weakly compressible Newtonian fluid with the Tait (Murnaghan) equation of state.
///
/// Textbook form. Cauchy stress sigma = -p I + 2 eta dev D, with
///   p = K/n ((rho/rho_0)^n - 1),   c = sqrt(K/rho_0) at rest,   rho/rho_0 = 1/J   (Murnaghan 1944; Cole 1948; n = 7 for water, 1: linear)
///   psi = K/n ((J^(1-n) - 1)/(n - 1) + J - 1), n = 1: K (J - 1 - ln J)   per reference volume; -d psi/dJ = p.
/// With carries_tension = false, the default, the fluid carries no tension: where J > 1, p = 0 and psi = 0. A free surface separates,
/// and torn material must return to its volume before it carries pressure again. Its viscous stress is that of the fluid in it, 2 eta dev D
/// per reference volume, without the void: the limit of the time step for viscosity holds for rho_0.
///
/// Spray. A particle alone in free flight keeps its velocity gradient, so J grows exponentially, without a force that could stop it: at
/// tr D = 100/s beyond the largest float within a second. J of torn fluid therefore stays at most 1 + `emptiest`.
///
/// Form coded. The internal variable is j = J - 1, advanced by j + (1 + j)(det(I + dl) - 1) with det(I + dl) - 1 from the invariants of dl:
/// no transcendental function, and full relative precision for small j. With r = rho/rho_0 - 1 = -j/(1 + j), (1 + r)^n - 1 comes from n - 1
/// multiply-adds, y <- y + r (1 + y), again with relative precision. D is taken from (f f^T - I)/(2 dt), f = I + dl, which is exactly 0 in
/// a rotation and differs from D by a term of the order of dt.

#include <limits>
#include <string_view>

#include "libmpm/material/concept.hpp"

namespace mpm {

/// The law; formulas above.
class WeaklyCompressibleFluid {
 public:
  /// Density, equation of state, viscosity, tearing.
  struct Parameters {
    static constexpr std::string_view name = "weakly_compressible_fluid";  ///< value of [material] model
    /// One line for the reference of keys.
    static constexpr std::string_view description =
        "Tait fluid p = K/n ((rho/rho_0)^n - 1) with Newtonian viscosity; tears where it would be pulled";
    /// The law in formulas, for exported cases.
    static constexpr std::string_view equations =
        "Cauchy stress sigma = -p I + 2 eta dev D, D the symmetric part of the velocity gradient, p = K/n (J^-n - 1). Without "
        "carries_tension p = 0 where J > 1. internal: J - 1.";

    double density = 300.0;        ///< rho_0, kg/m^3
    double bulk_modulus = 1.0e6;   ///< K = rho_0 c^2, Pa
    int tait_exponent = 7;         ///< n
    double viscosity = 0.0;        ///< eta, Pa s
    bool carries_tension = false;  ///< whether p may be negative
    bool operator==(const Parameters&) const = default;

    /// The keys (base/parameter.hpp).
    template <class Table>
    static void declare(Table& table) {
      declare_density(table, &Parameters::density);
      table.add("bulk_modulus_pa", &Parameters::bulk_modulus)
          .unit("Pa")
          .range(1.0, 1e12)
          .required()
          .text("Bulk modulus K = density c^2; with a speed of sound c of ten times the fastest flow the density changes by about 1 %");
      table.add("tait_exponent", &Parameters::tait_exponent)
          .range(1.0, 20.0)
          .text("Exponent n of the equation of state p = K/n ((rho/rho_0)^n - 1); 1 is linear");
      table.add("viscosity_pa_s", &Parameters::viscosity)
          .unit("Pa s")
          .range(0.0, 1e9)
          .text("Dynamic viscosity; explicit: a large one shortens the step (docs/theory/method.md)");
      table.add("carries_tension", &Parameters::carries_tension)
          .text("Whether pressure may be negative; if not, the fluid tears and recompacts before it carries pressure again");
    }
  };

  /// Beside what every law has.
  static constexpr OptionalMembers has{.viscosity = true};

  /// @throws ConfigError if a parameter is out of range
  explicit WeaklyCompressibleFluid(const Parameters& parameters);

  /// @param dt  s, above 0; matters with viscosity only. The result is NaN in a lane whose deformation is inverted or not finite.
  template <LaneNumber T>
  void update_stress(MaterialState<T>& state, const Matrix3<T>& dl, double dt) const;

  /// J = 1 + j
  template <LaneNumber T>
  [[nodiscard]] T volume_ratio(const MaterialState<T>& state) const {
    return 1.0 + state.internal;
  }
  [[nodiscard]] double density() const { return density_; }      ///< rho_0, kg/m^3
  [[nodiscard]] double initial_internal() const { return 0.0; }  ///< j = 0
  [[nodiscard]] double viscosity() const { return viscosity_; }  ///< eta, Pa s
  /// sqrt(K/rho_0), m/s. In compression sound is faster, by (rho/rho_0)^((n - 1)/2).
  [[nodiscard]] double wave_speed() const { return std::sqrt(bulk_ / density_); }
  [[nodiscard]] double bulk_speed() const { return carries_tension_ ? wave_speed() : 0.0; }  ///< 0: a drop that expands flies apart
  /// psi, J/m^3 of reference volume.
  [[nodiscard]] double stored_energy(const MaterialState<double>& state) const;

  static constexpr double emptiest = 1e6;  ///< largest J - 1 of torn fluid: some drops in all of a domain
  /// p, Pa (Cauchy), at j = J - 1.
  template <LaneNumber T>
  [[nodiscard]] T pressure(const T& j) const {
    const T r = -j / (1.0 + j);
    T y = r;
    for (int i = 1; i < exponent_; ++i) y += r * (1.0 + y);
    const T p = (bulk_ / exponent_) * y;
    return carries_tension_ ? p : max(p, T{});
  }

 private:
  double density_, bulk_, viscosity_;
  int exponent_;
  bool carries_tension_;
};

template <LaneNumber T>
void WeaklyCompressibleFluid::update_stress(MaterialState<T>& state, const Matrix3<T>& dl, double dt) const {
  const auto& l = dl.m;
  const auto minor = [&](int i, int j) { return l[i][i] * l[j][j] - l[i][j] * l[j][i]; };
  const T determinant =
      l[0][0] * minor(1, 2) - l[0][1] * (l[1][0] * l[2][2] - l[1][2] * l[2][0]) + l[0][2] * (l[1][0] * l[2][1] - l[1][1] * l[2][0]);
  const T growth = (l[0][0] + l[1][1] + l[2][2]) + (minor(0, 1) + minor(0, 2) + minor(1, 2)) + determinant;  // det(I + dl) - 1
  const T ratio = 1.0 + state.internal;
  const Mask<T> valid = (growth > -1.0) & (growth < std::numeric_limits<double>::infinity());
  state.internal += ratio * growth + select(valid, T{}, broadcast<T>(std::numeric_limits<double>::quiet_NaN()));
  if (!carries_tension_) state.internal = min(broadcast<T>(emptiest), state.internal);  // the second where it is NaN

  const T now = 1.0 + state.internal;
  const T mean = -now * pressure(state.internal);
  state.stress = {mean, mean, mean, T{}, T{}, T{}};
  if (viscosity_ == 0.0) return;
  const auto stretch = [&](int i, int j) { return l[i][j] + l[j][i] + l[i][0] * l[j][0] + l[i][1] * l[j][1] + l[i][2] * l[j][2]; };
  const Sym3<T> green{stretch(0, 0), stretch(1, 1), stretch(2, 2), stretch(0, 1), stretch(0, 2), stretch(1, 2)};
  const T filled = carries_tension_ ? now : min(broadcast<T>(1.0), now);
  state.stress = state.stress + ((viscosity_ / dt) * filled) * deviator(green);
}

static_assert(Material<WeaklyCompressibleFluid>);

}  // namespace mpm
