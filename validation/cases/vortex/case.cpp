#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <optional>

#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/scene.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/manufactured_motion.hpp"
#include "validation/harness/particle_access.hpp"

namespace mpm::validation::vortex {
namespace {

constexpr double pi = std::numbers::pi;
constexpr double inner = 0.75, outer = 1.25;  ///< m; the ring that moves
constexpr double period = 1.0;                ///< s

/// Points turn about the z axis by alpha(R, t) = A g(t) h(R): g = (1 - cos(2 pi t/T))/2, h = 1 - 32 (R - 1)^2 + 256 (R - 1)^4 in the ring,
/// 0 beside it. Derived in the README.
class Vortex : public ManufacturedMotion {
 public:
  Vortex(const HenckyElastic::Parameters& m, double angle)
      : density_(m.density), shear_(m.young_modulus / (2.0 * (1.0 + m.poisson_ratio))), angle_(angle) {}

  /// alpha and its derivatives at a radius and a time.
  struct Turn {
    double angle, rate, acceleration;  ///< rad, rad/s, rad/s^2
    double slope, curvature;           ///< by R, 1/m, 1/m^2
    double rate_slope;                 ///< of the rate by R
  };
  [[nodiscard]] Turn at(double radius, double t) const {
    if (radius <= inner || radius >= outer) return {};
    const double x = radius - 1.0, w = 2.0 * pi / period;
    const double h = 1.0 - 32.0 * x * x + 256.0 * x * x * x * x, h1 = -64.0 * x + 1024.0 * x * x * x, h2 = -64.0 + 3072.0 * x * x;
    const double g = 0.5 * (1.0 - std::cos(w * t)), g1 = 0.5 * w * std::sin(w * t), g2 = 0.5 * w * w * std::cos(w * t);
    return {angle_ * g * h, angle_ * g1 * h, angle_ * g2 * h, angle_ * g * h1, angle_ * g * h2, angle_ * g1 * h1};
  }
  [[nodiscard]] Vec3 position(const Vec3& reference, double t) const override {
    const double a = at(std::hypot(reference.x(), reference.y()), t).angle, c = std::cos(a), s = std::sin(a);
    return {c * reference.x() - s * reference.y(), s * reference.x() + c * reference.y(), reference.z()};
  }
  /// Unit vectors along r and theta where a point of the reference is at t.
  struct Polar {
    Vec3 r, theta;
    double radius;
  };
  [[nodiscard]] Polar polar(const Vec3& reference, double t) const {
    const double radius = std::hypot(reference.x(), reference.y());
    const Vec3 x = position(reference, t);
    if (radius == 0.0) return {Vec3::UnitX(), Vec3::UnitY(), 0.0};
    return {Vec3(x.x(), x.y(), 0.0) / radius, Vec3(-x.y(), x.x(), 0.0) / radius, radius};
  }
  [[nodiscard]] Vec3 velocity(const Vec3& reference, double t) const override {
    const Polar e = polar(reference, t);
    return e.radius * at(e.radius, t).rate * e.theta;
  }
  /// L = d v/d x: v_theta = r w(r), with w the rate.
  [[nodiscard]] Mat3 gradient(const Vec3& reference, double t) const override {
    const Polar e = polar(reference, t);
    const Turn a = at(e.radius, t);
    return (a.rate + e.radius * a.rate_slope) * e.theta * e.r.transpose() - a.rate * e.r * e.theta.transpose();
  }
  /// Kirchhoff stress, Pa.
  [[nodiscard]] Mat3 stress(const Vec3& reference, double t) const override {
    const Polar e = polar(reference, t);
    const Shear s = shear(e.radius * at(e.radius, t).slope);
    return s.along * (e.theta * e.theta.transpose() - e.r * e.r.transpose()) +
           s.across * (e.theta * e.r.transpose() + e.r * e.theta.transpose());
  }
  /// b, m/s^2.
  [[nodiscard]] Vec3 body_force(const Vec3& reference, double t) const override {
    const Polar e = polar(reference, t);
    const Turn a = at(e.radius, t);
    if (e.radius <= inner || e.radius >= outer) return Vec3::Zero();
    const Shear s = shear(e.radius * a.slope);
    const double change = a.slope + e.radius * a.curvature;  // d gamma/d r
    const double radial = -e.radius * a.rate * a.rate + (s.along_slope * change + 2.0 * s.along / e.radius) / density_;
    const double tangential = e.radius * a.acceleration - (s.across_slope * change + 2.0 * s.across / e.radius) / density_;
    return radial * e.r + tangential * e.theta;
  }

 private:
  /// Hencky's simple shear: tau_rtheta = 2 G S, tau_thetatheta = -tau_rr = G gamma S, S = asinh(gamma/2)/sqrt(1 + gamma^2/4).
  struct Shear {
    double along, across, along_slope, across_slope;  ///< G gamma S, 2 G S, and by gamma
  };
  [[nodiscard]] Shear shear(double gamma) const {
    const double root = 1.0 + 0.25 * gamma * gamma, s = std::asinh(0.5 * gamma) / std::sqrt(root), slope = (0.5 - 0.25 * gamma * s) / root;
    return {shear_ * gamma * s, 2.0 * shear_ * s, shear_ * (s + gamma * slope), 2.0 * shear_ * slope};
  }
  double density_, shear_, angle_;
};

struct Settings {
  int cells = 16;       ///< across the ring
  double angle = 0.05;  ///< A, rad
  Transfer transfer = Transfer::aflip;
  int per_axis = 2;
};

struct Errors {
  double cell = 0.0;                 ///< m
  MotionErrors motion;               ///< its displacements over A times 1 m
  std::vector<double> radius, turn;  ///< of the ring's particles at T/2, m; angle turned over A
};

Errors turn(const CaseContext& context, const Settings& s) {
  Case c = context.read_case();
  const double dx = (outer - inner) / s.cells, side = dx / s.per_axis;
  c.numerics.cell_size = dx;
  c.numerics.transfer = s.transfer;
  c.numerics.flip_ratio = 1.0;
  c.numerics.particles_per_cell = s.per_axis * s.per_axis * s.per_axis;
  const double radius = std::ceil((outer + 2.0 * dx) / dx) * dx;
  c.bodies[0].min = Vec3(-radius, -radius, 0.0);
  c.bodies[0].max = Vec3(radius, radius, side);
  c.walls[1].point.z() = side;
  const Vortex exact(c.material.as<HenckyElastic>(), s.angle);
  const CaseScene scene = make_scene(c);
  const State disc = make_state(c, scene);
  const std::vector<Vec3> reference = reference_positions(disc);
  State state(dx, c.numerics.precision);
  state.next_id = disc.next_id;
  disc.grid.for_each_particle([&](const Particle& p) {  // what lies further inside than two cells from the ring stays at rest anyway
    if (std::hypot(p.position[0], p.position[1]) > inner - 2.0 * dx) state.grid.insert(p);
  });
  state.grid.refresh();

  const double fastest = outer * s.angle * pi / period, wanted = c.numerics.cfl * dx / (wave_speed_of(scene.material) + fastest);
  const auto steps = 2 * static_cast<int>(std::ceil(0.5 * period / wanted));
  const auto moving = static_cast<std::size_t>(std::ranges::count_if(reference, [](const Vec3& x) {
    const double r = std::hypot(x.x(), x.y());
    return r > inner && r < outer;
  }));
  Errors e;
  e.cell = dx;
  const auto drawn = static_cast<std::uint64_t>(std::max(1.0, static_cast<double>(reference.size()) / 2000.0));
  const auto draw = [&](const Particle& p, const Vec3& x) {
    const double r = std::hypot(x.x(), x.y());
    if (r < inner - 2.0 * dx || p.id % drawn != 0) return;
    e.radius.push_back(r);
    const double across = x.x() * p.position[1] - x.y() * p.position[0], along = x.x() * p.position[0] + x.y() * p.position[1];
    e.turn.push_back(std::atan2(across, along) / s.angle);
  };
  e.motion = follow(state, scene, exact, reference, {.period = period, .steps = steps, .judged = moving, .half = draw});
  e.motion.displacement /= s.angle;
  for (double& error : e.motion.history) error /= s.angle;
  return e;
}

struct Variant {
  std::string name;
  Settings settings;
  std::optional<double> lowest_order = {};  ///< bound where the order is known to be missed
  const char* cause = "";
  bool judged = true;  ///< false: not measured with the defaults, a note only
};

/// Angle by which the ring has turned at T/2, over the exact one: the exact profile that fits the particles best.
double share_of_turn(const Vortex& exact, const Settings& s, const Errors& e) {
  double product = 0.0, square = 0.0;
  for (std::size_t i = 0; i < e.radius.size(); ++i) {
    const double profile = exact.at(e.radius[i], 0.5 * period).angle / s.angle;
    product += profile * e.turn[i];
    square += profile * profile;
  }
  return product / square;
}

void run(const CaseContext& context, CaseResult& result) {
  const Case c = context.read_case();
  result.check_absolute(
      Label::verification, "body force: largest residual of the momentum equation over ρ0 |b|max",
      momentum_residual(Vortex(c.material.as<HenckyElastic>(), 0.3), c.material.as<HenckyElastic>(), points_of_ring(inner, outer, period)),
      0.0, "", 1e-4,
      "nested central differences over 1e-4 m, whose fourth derivatives are up to 1e4 times the values; round-off 1e-16/1e-8");
  const auto grids = context.choose<std::vector<int>>({8, 12, 16}, {8, 12, 16, 24}, {8, 12, 16, 24, 32, 48});
  std::vector<Variant> variants = {
      {"AFLIP, 0.05 rad", {}},
      {"APIC, 0.05 rad", {.transfer = Transfer::apic}, 1.7, "the grids are not asymptotic: the order scatters from grid to grid"},
      {"FLIP, 0.05 rad", {.transfer = Transfer::flip}}};
  if (context.level() != Level::quick) {
    variants.push_back({.name = "AFLIP, 0.3 rad", .settings = {.angle = 0.3}, .judged = false});
    variants.push_back({"APIC, 0.3 rad",
                        {.angle = 0.3, .transfer = Transfer::apic},
                        0.94,
                        "the shear distorts the lattice, and four particles in the plane of a cell do not sample it well"});
    variants.push_back({.name = "FLIP, 0.3 rad", .settings = {.angle = 0.3, .transfer = Transfer::flip}, .judged = false});
    for (const auto& [name, transfer] :
         {std::pair{"AFLIP", Transfer::aflip}, std::pair{"APIC", Transfer::apic}, std::pair{"FLIP", Transfer::flip}})
      variants.push_back({.name = std::string(name) + ", 0.3 rad, 9 particles in the plane of a cell",
                          .settings = {.angle = 0.3, .transfer = transfer, .per_axis = 3},
                          .judged = false});
  }
  const auto all = on_grids<Errors>(variants.size(), grids, [&](std::size_t v, int cells) {
    Settings s = variants[v].settings;
    s.cells = cells;
    return turn(context, s);
  });

  double work = 0.0;
  Plot errors{"errors", "Displacement, largest error over one period", "dx [m]", "L2 error over A · 1 m [-]", {}, "", true, true};
  Plot history{"history", "Error over one period on the finest grid", "time [T]", "L2 error over A · 1 m [-]", {}, "", false, true};
  for (std::size_t v = 0; v < variants.size(); ++v) {
    std::vector<double> cell, error, stress;
    for (const Errors& e : all[v]) {
      cell.push_back(e.cell), error.push_back(e.motion.displacement), stress.push_back(e.motion.stress);
      work += e.motion.particle_steps;
    }
    const double order = fitted_order(cell, error);
    const std::string& name = variants[v].name;
    if (variants[v].judged) {
      Check& check =
          result.check_order(Label::verification, name + ": order of the displacement", order, 1.8, 2.6,
                             "1.8 is the target for a second-order scheme; up to 2.6 because the ring has 8 cells across on the coarsest "
                             "grid");
      check.observed_order = order;
      if (variants[v].lowest_order) check.known_miss(*variants[v].lowest_order, variants[v].cause);
    }
    if (v == 0) {  // the defaults
      const Settings& s = variants[v].settings;
      const double angle = s.angle * 180.0 / pi;
      const Vortex exact(c.material.as<HenckyElastic>(), s.angle);
      result.compare(Label::verification, name + ": angle at T/2", Quantity::angle, angle * share_of_turn(exact, s, all[v].back()), angle,
                     "°");
    }
    result.notes.push_back(fmt::format(
        "{}: displacement error {:.2e} to {:.2e}, orders {:.2f}; stress at T/2 {:.2e} to {:.2e}, order {:.2f}.", name, error.front(),
        error.back(), fmt::join(pairwise_orders(cell, error), ", "), stress.front(), stress.back(), fitted_order(cell, stress)));
    errors.series.push_back({name, cell, error, Series::Style::points});
    history.series.push_back({name, all[v].back().motion.time, all[v].back().motion.history, Series::Style::simulation});
  }
  errors.series.push_back(slope_line("order 2", errors.series.front().x, errors.series.front().y.back(), 2.0));
  result.plots.push_back(std::move(errors));
  result.plots.push_back(std::move(history));
  const Vortex unit(c.material.as<HenckyElastic>(), 1.0);
  result.plots.push_back({"turn",
                          "Angle at T/2 on the coarsest grid, A = 0.05 rad",
                          "R [m]",
                          "angle turned / A [-]",
                          {reference_curve("exact", 0.7, 1.3, 120, [&](double r) { return unit.at(r, 0.5 * period).angle; }),
                           {"AFLIP", all[0].front().radius, all[0].front().turn, Series::Style::points}}});
  result.notes.push_back(fmt::format("{:.1f} million particle-steps.", 1e-6 * work));
}

const Registration registered{{.title = "Generalised vortex: shear and rotation", .run = run}};

}  // namespace
}  // namespace mpm::validation::vortex
