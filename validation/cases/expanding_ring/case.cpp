#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/scene.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/manufactured_motion.hpp"

namespace mpm::validation::expanding_ring {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double inner = 0.75, outer = 1.25;  ///< m; the ring, at t = 0
constexpr double period = 1.0;                ///< s
constexpr double margin = 0.25;               ///< m; material at rest on both sides of a ring with held edges
/// Amplitudes, m. Largest stretches: 1.06 (held) and 1.014 (free) with the small one, 1.49 and 1.58 with the large ones.
constexpr double small = 0.01, held_large = 0.08, free_large = 0.4;

/// What is at the edges of the ring.
enum class Edges {
  held,  ///< material at rest
  free,  ///< nothing
};

/// r = R + A g(t) phi(R) with g = (1 - cos(2 pi t/T))/2. Held edges: phi = (1 - x^2)^2 with x = (R - (a + b)/2)/((b - a)/2); phi and phi'
/// are zero at the edges. Free edges: phi' = c (R - a)(R - b), phi(b) = 1, so that the edges are free of stress. Derived in the README.
class Ring : public ManufacturedMotion {
 public:
  Ring(const HenckyElastic::Parameters& m, Edges edges, double amplitude)
      : density_(m.density), shear_(0.5 * m.young_modulus), amplitude_(amplitude), edges_(edges) {
    if (m.poisson_ratio != 0.0) throw ConfigError("expanding_ring: the exact stresses are those of poisson_ratio = 0");
  }

  /// r and its derivatives by R and t.
  struct Radius {
    double r, rate, acceleration;           ///< m, m/s, m/s^2
    double stretch, curvature, rate_slope;  ///< r', r'' in 1/m, r' by time in 1/s
  };
  [[nodiscard]] Radius at(double radius, double t) const {
    const Profile phi = profile(radius);
    const double w = 2.0 * pi / period;
    const double g = 0.5 * amplitude_ * (1.0 - std::cos(w * t)), g1 = 0.5 * amplitude_ * w * std::sin(w * t),
                 g2 = 0.5 * amplitude_ * w * w * std::cos(w * t);
    return {radius + g * phi.value, g1 * phi.value, g2 * phi.value, 1.0 + g * phi.slope, g * phi.curvature, g1 * phi.slope};
  }
  [[nodiscard]] Vec3 position(const Vec3& reference, double t) const override {
    const Polar e = polar(reference);
    return at(e.radius, t).r * e.r + reference.z() * Vec3::UnitZ();
  }
  [[nodiscard]] Vec3 velocity(const Vec3& reference, double t) const override {
    const Polar e = polar(reference);
    return at(e.radius, t).rate * e.r;
  }
  [[nodiscard]] Mat3 gradient(const Vec3& reference, double t) const override {
    const Polar e = polar(reference);
    const Radius x = at(e.radius, t);
    return x.rate_slope / x.stretch * e.r * e.r.transpose() + x.rate / x.r * e.theta * e.theta.transpose();
  }
  [[nodiscard]] Mat3 stress(const Vec3& reference, double t) const override {
    const Polar e = polar(reference);
    const Radius x = at(e.radius, t);
    return 2.0 * shear_ * (std::log(x.stretch) * e.r * e.r.transpose() + std::log(x.r / e.radius) * e.theta * e.theta.transpose());
  }
  [[nodiscard]] Vec3 body_force(const Vec3& reference, double t) const override {
    const Polar e = polar(reference);
    const Radius x = at(e.radius, t);
    const double radial = std::log(x.stretch) / x.stretch, hoop = std::log(x.r / e.radius) * e.radius / x.r;  // P over 2 G
    const double slope = (1.0 - std::log(x.stretch)) * x.curvature / (x.stretch * x.stretch);
    return (x.acceleration - 2.0 * shear_ / density_ * (slope + (radial - hoop) / e.radius)) * e.r;
  }

 private:
  /// Unit vectors along r and theta, the same at all times, and R.
  struct Polar {
    Vec3 r, theta;
    double radius;
  };
  static Polar polar(const Vec3& reference) {
    const double radius = std::hypot(reference.x(), reference.y()), c = reference.x() / radius, s = reference.y() / radius;
    return {Vec3(c, s, 0.0), Vec3(-s, c, 0.0), radius};
  }
  /// phi and its derivatives by R, 1/m and 1/m^2.
  struct Profile {
    double value, slope, curvature;
  };
  [[nodiscard]] Profile profile(double radius) const {
    constexpr double a = inner, b = outer, half = 0.5 * (b - a), c = 6.0 / (b * b * (3.0 * a - b));
    if (edges_ == Edges::free)
      return {c * radius * (radius * radius / 3.0 - 0.5 * (a + b) * radius + a * b), c * (radius - a) * (radius - b),
              c * (2.0 * radius - a - b)};
    if (radius <= a || radius >= b) return {0.0, 0.0, 0.0};
    const double x = (radius - 0.5 * (a + b)) / half, rest = 1.0 - x * x;
    return {rest * rest, -4.0 * x * rest / half, (12.0 * x * x - 4.0) / (half * half)};
  }
  double density_, shear_, amplitude_;
  Edges edges_;
};

struct Settings {
  int cells = 8;  ///< across the ring
  Edges edges = Edges::held;
  double amplitude = 0.01;  ///< A, m
  Transfer transfer = Transfer::aflip;
  int per_axis = 2;  ///< particles in a cell
};

struct Errors {
  double cell = 0.0;                         ///< m
  MotionErrors motion;                       ///< its displacements over A
  std::vector<double> radius, hoop, radial;  ///< of some particles at T/2: R, m; stresses over E
};

/// Share of the area of a square of the lattice that lies in the ring. @param x, y  corner next to the axis, m
double share_in_ring(double x, double y, double side) {
  constexpr int samples = 32;
  int inside = 0;
  for (int j = 0; j < samples; ++j) {
    for (int i = 0; i < samples; ++i) {
      const double radius = std::hypot(x + (i + 0.5) / samples * side, y + (j + 0.5) / samples * side);
      inside += radius > inner && radius < outer ? 1 : 0;
    }
  }
  return static_cast<double>(inside) / (samples * samples);
}

Errors expand(const CaseContext& context, const Settings& s) {
  Case c = context.read_case();
  const double dx = (outer - inner) / s.cells, spacing = dx / s.per_axis;
  c.numerics.cell_size = dx;
  c.numerics.transfer = s.transfer;
  c.numerics.flip_ratio = 1.0;
  c.numerics.particles_per_cell = s.per_axis * s.per_axis * s.per_axis;
  c.walls[1].point.z() = spacing;
  const auto& law = c.material.as<HenckyElastic>();
  const Ring exact(law, s.edges, s.amplitude);
  const CaseScene scene = make_scene(c);
  State state(dx, c.numerics.precision);
  std::vector<Vec3> reference;
  const double rest = s.edges == Edges::held ? margin : 0.0;
  std::size_t judged = 0;
  const auto count = static_cast<int>(std::ceil((outer + rest) / spacing));
  for (int j = 0; j < count; ++j) {
    for (int i = 0; i < count; ++i) {
      const Vec3 x((i + 0.5) * spacing, (j + 0.5) * spacing, 0.5 * spacing);
      const double radius = std::hypot(x.x(), x.y());
      if (radius < inner - rest - dx || radius > outer + rest + dx) continue;
      const double filled = radius > inner - rest && radius < outer + rest ? 1.0 : 0.0;
      const double share = s.edges == Edges::held ? filled : share_in_ring(i * spacing, j * spacing, spacing);
      if (share < 0.05) continue;  // less mass than this would only be noise at the edge
      Particle p{};
      for (int k = 0; k < 3; ++k) p.position[k] = x[k];
      p.volume = share * spacing * spacing * spacing;
      p.id = state.next_id++;
      reference.push_back(x);
      judged += radius > inner && radius < outer ? 1 : 0;
      state.grid.insert(p);
    }
  }
  state.grid.refresh();

  const double fastest = s.amplitude * 1.2 * pi / period;
  const double wanted = c.numerics.cfl * dx / (wave_speed_of(scene.material) + fastest);
  Errors e;
  e.cell = dx;
  const std::uint64_t drawn = std::max<std::uint64_t>(1, reference.size() / 1000);
  const auto draw = [&](const Particle& p, const Vec3& x) {
    if (p.id % drawn != 0) return;
    const double radius = std::hypot(x.x(), x.y()), cosine = x.x() / radius, sine = x.y() / radius;
    e.radius.push_back(radius);
    const double cross = 2.0 * p.stress[3] * sine * cosine;
    e.hoop.push_back((p.stress[0] * sine * sine + p.stress[1] * cosine * cosine - cross) / law.young_modulus);
    e.radial.push_back((p.stress[0] * cosine * cosine + p.stress[1] * sine * sine + cross) / law.young_modulus);
  };
  e.motion = follow(state, scene, exact, reference,
                    {.period = period, .steps = 2 * static_cast<int>(std::ceil(0.5 * period / wanted)), .judged = judged, .half = draw});
  e.motion.displacement /= s.amplitude;
  for (double& error : e.motion.history) error /= s.amplitude;
  return e;
}

struct Variant {
  std::string name;
  Settings settings;
};

/// "AFLIP, held edges, A = 0.01 m"
Variant variant(Transfer transfer, Edges edges, double amplitude, int per_axis = 2) {
  return {fmt::format("{}, {} edges, A = {} m{}", transfer == Transfer::aflip ? "AFLIP" : "FLIP", edges == Edges::held ? "held" : "free",
                      amplitude, per_axis == 2 ? "" : fmt::format(", {} particles in the plane of a cell", per_axis * per_axis)),
          {.edges = edges, .amplitude = amplitude, .transfer = transfer, .per_axis = per_axis}};
}

/// Exact stresses at T/2, and those of a run.
Plot stress_plot(const Ring& exact, const Errors& run, const HenckyElastic::Parameters& law) {
  const auto exact_stress = [&](const char* name, int component) {
    return reference_curve(name, inner, outer, 100, [&](double radius) {
      return exact.stress(Vec3(radius, 0.0, 0.0), 0.5 * period)(component, component) / law.young_modulus;
    });
  };
  return {"stress",
          "Stresses at T/2 on the coarsest grid, free edges, A = 0.4 m, AFLIP",
          "R [m]",
          "Kirchhoff stress / E [-]",
          {exact_stress("hoop, exact", 1),
           exact_stress("radial, exact", 0),
           {"hoop", run.radius, run.hoop, Series::Style::points},
           {"radial", run.radius, run.radial, Series::Style::points}}};
}

void run(const CaseContext& context, CaseResult& result) {
  const Case c = context.read_case();
  const auto& law = c.material.as<HenckyElastic>();
  for (const auto& [edges, amplitude] : {std::pair{Edges::held, held_large}, std::pair{Edges::free, free_large}}) {
    result.check_absolute(
        Label::verification,
        fmt::format("{} edges, body force: largest residual of the momentum equation over ρ0 |b|max",
                    edges == Edges::held ? "held" : "free"),
        momentum_residual(Ring(law, edges, amplitude), law, points_of_ring(inner, outer, period)), 0.0, "", 1e-4,
        "nested central differences over 1e-4 m, whose fourth derivatives are up to 1e4 times the values; round-off 1e-16/1e-8");
  }
  const auto grids = context.choose<std::vector<int>>({8, 12, 16}, {8, 12, 16, 24}, {8, 12, 16, 24, 32});
  std::vector<Variant> variants = {variant(Transfer::aflip, Edges::free, free_large), variant(Transfer::aflip, Edges::free, small),
                                   variant(Transfer::flip, Edges::free, small), variant(Transfer::aflip, Edges::held, small),
                                   variant(Transfer::flip, Edges::held, small)};
  if (context.level() != Level::quick) {
    variants.push_back(variant(Transfer::aflip, Edges::free, free_large, 3));
    variants.push_back(variant(Transfer::aflip, Edges::held, held_large));
    variants.push_back(variant(Transfer::flip, Edges::held, held_large));
  }
  const auto all = on_grids<Errors>(variants.size(), grids, [&](std::size_t v, int cells) {
    Settings s = variants[v].settings;
    s.cells = cells;
    return expand(context, s);
  });

  double work = 0.0;
  Plot errors{"errors", "Displacement, largest error over one period", "dx [m]", "L2 error over A [-]", {}, "", true, true};
  for (std::size_t v = 0; v < variants.size(); ++v) {
    std::vector<double> cell, error, stress;
    for (const Errors& e : all[v]) {
      cell.push_back(e.cell), error.push_back(e.motion.displacement), stress.push_back(e.motion.stress);
      work += e.motion.particle_steps;
    }
    const Settings& s = variants[v].settings;
    const std::string& name = variants[v].name;
    const double order = fitted_order(cell, error);
    Check& check = result.check_order(
        Label::verification, name + ": order of the displacement", order, 1.8, s.edges == Edges::held ? 3.5 : 2.6,
        s.edges == Edges::held ? "1.8 is the target for a second-order scheme; up to 3.5 because the coarsest grid has 8 cells "
                                 "across the whole wave"
                               : "1.8 is the target for a second-order scheme; up to 2.6 on coarse grids");
    check.observed_order = order;
    if (s.edges == Edges::free && s.amplitude > small) {
      if (s.per_axis == 2)
        check.known_miss(1.4, "the error of the stress does not fall with dx: stretched lattice, partly filled cells at the edges");
      result.check_at_most(Label::regression, fmt::format("{}: error of the displacement over A, {} cells", name, grids.back()),
                           error.back(), 1.5e-3, "", 0.0, "1.1e-3 was measured at 16 cells with FLIP, and less otherwise");
    }
    result.notes.push_back(fmt::format("{}: displacement error over A {:.2e} to {:.2e}, orders {:.2f}; stress at T/2 {:.2e} to {:.2e}.",
                                       name, error.front(), error.back(), fmt::join(pairwise_orders(cell, error), ", "), stress.front(),
                                       stress.back()));
    errors.series.push_back({name, cell, error, Series::Style::points});
  }
  errors.series.push_back(slope_line("order 2", errors.series.front().x, errors.series.front().y.back(), 2.0));
  result.plots.push_back(std::move(errors));
  result.plots.push_back(stress_plot(Ring(law, Edges::free, free_large), all[0].front(), law));
  result.notes.push_back(fmt::format("{:.1f} million particle-steps.", 1e-6 * work));
}

const Registration registered{{.title = "Expanding ring: large stretch with free edges", .run = run}};

}  // namespace
}  // namespace mpm::validation::expanding_ring
