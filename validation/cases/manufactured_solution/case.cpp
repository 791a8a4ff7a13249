#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/scene.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/norms.hpp"
#include "validation/harness/particle_access.hpp"
#include "validation/harness/periodic.hpp"

namespace mpm::validation::manufactured_solution {
namespace {

constexpr double pi = std::numbers::pi;

/// sin(2 pi X_i) and cos(2 pi X_i) of a particle: they stay the same.
struct Place {
  Vec3 sine, cosine;
  explicit Place(const Vec3& x) : sine((2.0 * pi * x).array().sin()), cosine((2.0 * pi * x).array().cos()) {}
};

/// cos(c pi t + phi_i) and its rate: the same for all particles.
struct Instant {
  Vec3 swing, rate;
};

/// u_i(X, t) = A_i sin(2 pi X_i) cos(c pi t + phi_i), each component a function of its own coordinate, so that F is diagonal.
struct Solution {
  double lame, shear, density, c;  ///< lambda and G, Pa; rho_0; c = sqrt(E/rho_0), m/s
  Vec3 amplitude;                  ///< A_i, m
  Vec3 phase = Vec3(0.25 * pi, 11.0 / 12.0 * pi, 19.0 / 12.0 * pi);

  Solution(const MaterialParameters& material, const Vec3& a) : Solution(material.as<HenckyElastic>(), a) {}
  Solution(const HenckyElastic::Parameters& m, const Vec3& a)
      : lame(m.young_modulus * m.poisson_ratio / ((1.0 + m.poisson_ratio) * (1.0 - 2.0 * m.poisson_ratio))),
        shear(m.young_modulus / (2.0 * (1.0 + m.poisson_ratio))),
        density(m.density),
        c(std::sqrt(m.young_modulus / m.density)),
        amplitude(a) {}

  [[nodiscard]] double period() const { return 2.0 / c; }
  [[nodiscard]] Instant at(double t) const {
    const Vec3 angle = Vec3::Constant(c * pi * t) + phase;
    return {angle.array().cos(), -c * pi * angle.array().sin()};
  }
  [[nodiscard]] Vec3 displacement(const Place& x, const Instant& t) const { return amplitude.cwiseProduct(x.sine).cwiseProduct(t.swing); }
  [[nodiscard]] Vec3 velocity(const Place& x, const Instant& t) const { return amplitude.cwiseProduct(x.sine).cwiseProduct(t.rate); }
  /// F_ii = 1 + du_i/dX_i
  [[nodiscard]] Vec3 stretch(const Place& x, const Instant& t) const {
    return Vec3::Ones() + 2.0 * pi * amplitude.cwiseProduct(x.cosine).cwiseProduct(t.swing);
  }
  /// d(F_ii)/dt
  [[nodiscard]] Vec3 stretch_rate(const Place& x, const Instant& t) const {
    return 2.0 * pi * amplitude.cwiseProduct(x.cosine).cwiseProduct(t.rate);
  }
  /// tau_i = lambda sum_j ln F_jj + 2 G ln F_ii, Kirchhoff, Pa
  [[nodiscard]] Vec3 stress(const Place& x, const Instant& t) const {
    const Vec3 strain = stretch(x, t).array().log();
    return Vec3::Constant(lame * strain.sum()) + 2.0 * shear * strain;
  }
  /// b_i = -c^2 pi^2 u_i + 4 pi^2 u_i (E_oed - tau_i) / (rho_0 F_ii^2), m/s^2; derived in the README
  [[nodiscard]] Vec3 body_force(const Place& x, const Instant& t) const {
    const Vec3 u = displacement(x, t), f = stretch(x, t), tau = stress(x, t);
    const double oedometric = lame + 2.0 * shear;
    return -c * c * pi * pi * u + 4.0 * pi * pi / density * (u.array() * (oedometric - tau.array()) / f.array().square()).matrix();
  }
};

/// Largest residual of rho_0 u'' = dP_ii/dX_i + rho_0 b, P_ii = tau_i/F_ii, over the largest rho_0 |b|; derivatives by central differences
/// of the solution itself, so that the body force is checked by other means than its derivation.
double momentum_residual(const Solution& s) {
  constexpr double h = 1e-4;
  double worst = 0.0, scale = 0.0;
  for (int n = 0; n < 400; ++n) {
    const Vec3 x(0.1373 * n - std::floor(0.1373 * n), 0.2719 * n - std::floor(0.2719 * n), 0.4831 * n - std::floor(0.4831 * n));
    const double t = s.period() * (0.3711 * n - std::floor(0.3711 * n)), dt = h * s.period();
    const Vec3 acceleration =
        (s.displacement(Place(x), s.at(t + dt)) - 2.0 * s.displacement(Place(x), s.at(t)) + s.displacement(Place(x), s.at(t - dt))) /
        (dt * dt);
    const Vec3 b = s.body_force(Place(x), s.at(t));
    scale = larger(scale, s.density * b.norm());
    for (int i = 0; i < 3; ++i) {
      const auto piola = [&](double shift) {
        const Place at(x + shift * Vec3::Unit(i));
        return s.stress(at, s.at(t))[i] / s.stretch(at, s.at(t))[i];
      };
      worst = larger(worst, std::abs(s.density * (acceleration[i] - b[i]) - (piola(h) - piola(-h)) / (2.0 * h)));
    }
  }
  return worst / scale;
}

struct Settings {
  int cells = 16;  ///< per metre
  int per_axis = 2;
  double cfl = 0.4;
  bool periodic = true;         ///< surrounded by its own periodic continuation; false: between slip walls
  bool quasi_1d = false;        ///< displacement along x only, one particle across
  bool half_step_start = true;  ///< velocities start from v(-dt/2); false: from v(0)
  double offset = 0.0;          ///< of the cube against the grid, in cells
  ContactRule contact = ContactRule::nodal;
  Transfer transfer = Transfer::apic;
};

struct Errors {
  double displacement = 0.0;            ///< largest L2 error over a period, over the amplitude
  double stress = 0.0;                  ///< largest L2 error of tau_xx over a period, over its largest value
  std::vector<double> time, history;    ///< in periods; L2 error of the displacement over the amplitude
  std::vector<Vec3> late_displacement;  ///< of each particle at 3/8 of the period, m
  double profile_time = 0.0;            ///< s
  std::vector<double> x, ux, txx;       ///< one component only: X, u, tau_xx at half a period
  std::size_t particle_steps = 0;
};

Errors simulate(const CaseContext& context, const Settings& s) {
  Case c = context.read_case();
  const double dx = 1.0 / s.cells, side = s.quasi_1d ? dx / s.per_axis : 1.0;
  const Vec3 shift = s.offset * dx * Vec3(1.0, s.quasi_1d ? 0.0 : 1.0, s.quasi_1d ? 0.0 : 1.0);
  c.numerics.cell_size = dx;
  c.numerics.contact = s.contact;
  c.numerics.transfer = s.transfer;
  c.numerics.particles_per_cell = s.per_axis * s.per_axis * s.per_axis;
  c.bodies.at(0).max = Vec3(1.0, side, side);
  for (WallSpec& wall : c.walls) {
    for (int i = 1; i < 3; ++i)
      if (wall.point[i] > 0.0) wall.point[i] = side;
    wall.point += shift;
  }
  if (s.periodic) std::erase_if(c.walls, [&](const WallSpec& wall) { return !s.quasi_1d || wall.normal.x() != 0.0; });
  c.domain.min = Vec3::Constant(-2.0);
  c.domain.max = Vec3::Constant(3.0);
  const double amplitude = 0.05;
  const Solution exact(c.material, amplitude * (s.quasi_1d ? Vec3(1.0, 0.0, 0.0) : Vec3(1.0, 1.0, 1.0)));

  const CaseScene scene = make_scene(c);
  const State lattice = make_state(c, scene);
  const std::vector<Vec3> reference = reference_positions(lattice);
  std::vector<Place> places;
  for (const Vec3& x : reference) places.emplace_back(x);
  // leapfrog is of second order only with a constant step
  const double wave_speed = wave_speed_of(scene.material);
  const double wanted = s.cfl * dx / (wave_speed + exact.c * pi * exact.amplitude.norm());
  const auto steps = static_cast<int>(std::ceil(exact.period() / wanted));
  const double dt = exact.period() / steps;

  State state(dx, c.numerics.precision);
  state.next_id = lattice.next_id;
  lattice.grid.for_each_particle([&](Particle p) {
    const Vec3& x = reference[p.id];
    const Instant start = exact.at(0.0), early = exact.at(s.half_step_start ? -0.5 * dt : 0.0);
    const Place& place = places[p.id];
    const Vec3 u = exact.displacement(place, start), v = exact.velocity(place, early), f = exact.stretch(place, start),
               rate = exact.stretch_rate(place, early), tau = exact.stress(place, start);
    for (int i = 0; i < 3; ++i) {
      p.position[i] = x[i] + u[i] + shift[i];
      p.velocity[i] = v[i];
      p.affine[4 * i] = rate[i] / f[i];
      p.stress[i] = tau[i];
    }
    state.grid.insert(p);
  });
  state.grid.refresh();
  const PeriodicBox surroundings(shift, s.quasi_1d ? Vec3(1.0, 0.0, 0.0) : Vec3::Ones(), 2.5 * dx, lattice.next_id);

  Errors result;
  double largest_stress = 0.0;
  const int middle = steps / 2, late = 3 * steps / 8, stride = std::max(1, steps / 40);  // errors are taken forty times
  for (int n = 0; n < steps; ++n) {
    const double t = n * dt;
    const Instant now = exact.at(t), next = exact.at(t + dt);
    // f_i = sum w m b is the consistent load: a change of the particles' velocity before the transfer does the same
    state.grid.change_particles([&](Particle& p) {
      if (p.id >= lattice.next_id) return;
      const Vec3 b = exact.body_force(places[p.id], now);
      for (int i = 0; i < 3; ++i) p.velocity[i] += dt * b[i];
    });
    if (s.periodic) surroundings.renew(state);
    step(state, scene, dt);
    result.particle_steps += state.grid.particle_count();
    if ((n + 1) % stride != 0 && n + 1 != middle && n + 1 != late && n + 1 != steps) continue;
    double squares = 0.0, stress_squares = 0.0;
    result.late_displacement.resize(reference.size());
    state.grid.for_each_particle([&](const Particle& p) {
      if (p.id >= lattice.next_id) return;
      const Vec3& x = reference[p.id];
      const Vec3 u = Vec3(p.position[0], p.position[1], p.position[2]) - x - shift;
      const double txx = exact.stress(places[p.id], next).x();
      squares += (u - exact.displacement(places[p.id], next)).squaredNorm();
      stress_squares += (p.stress[0] - txx) * (p.stress[0] - txx);
      largest_stress = larger(largest_stress, std::abs(txx));
      if (n + 1 == late) result.late_displacement[p.id] = u;
      if (n + 1 == middle && s.quasi_1d) {
        result.x.push_back(x.x()), result.ux.push_back(u.x()), result.txx.push_back(p.stress[0]);
      }
    });
    if (n + 1 == middle) result.profile_time = t + dt;
    const auto count = static_cast<double>(reference.size());
    result.time.push_back((t + dt) / exact.period());
    result.history.push_back(std::sqrt(squares / count) / amplitude);
    result.displacement = larger(result.displacement, result.history.back());
    result.stress = larger(result.stress, std::sqrt(stress_squares / count));
  }
  result.stress /= largest_stress;
  return result;
}

/// Errors over the grids for one kind of set-up.
struct Sweep {
  std::vector<double> cell, displacement, stress;
  Errors finest;
};

Sweep sweep(const CaseContext& context, Settings s, const std::vector<int>& grids, std::size_t& work) {
  Sweep r;
  for (const int cells : grids) {
    s.cells = cells;
    r.finest = simulate(context, s);
    r.cell.push_back(1.0 / cells);
    r.displacement.push_back(r.finest.displacement);
    r.stress.push_back(r.finest.stress);
    work += r.finest.particle_steps;
  }
  return r;
}

std::string listed(const std::vector<double>& values) { return fmt::format("{:.2f}", fmt::join(values, ", ")); }

constexpr double target = 1.8;

/// Largest size of the leading error of quadratic splines, the smoothing k^2 dx^2 / 8 of a value, relative to the amplitude.
double smoothing(double dx, int components) { return std::sqrt(components) * std::pow(2.0 * pi * dx, 2) / 8.0; }

/// The cube: the order of the scheme, and what slip walls make of it.
void cube(const CaseContext& context, CaseResult& result, std::size_t& work) {
  const Sweep open = sweep(context, {}, context.choose<std::vector<int>>({8, 12, 16}, {8, 12, 16, 24, 32}, {8, 12, 16, 24, 32, 48}), work);
  context.log("cube in its periodic surroundings, 8 particles per cell");
  const double order = fitted_order(open.cell, open.displacement);
  result
      .check_order(Label::verification, "cube in periodic surroundings, 8 particles per cell: order of the displacement", order, target,
                   2.5, "1.8 is the target for a second-order scheme; up to 2.5 because the coarsest grid has 4 cells to half a wave")
      .observed_order = order;
  result
      .check_absolute(Label::verification, "cube in periodic surroundings: displacement error (L2 over A) at the finest grid",
                      open.displacement.back(), 0.0, "", smoothing(open.cell.back(), 3),
                      "size of the smoothing k² dx²/8 by quadratic splines, in three components")
      .observed_order = order;
  Plot plot{"cube", "Errors in the cube, largest over one period", "dx [m]", "L2 error of u over A [-]", {}, "", true, true};
  plot.series.push_back({"periodic surroundings, 8 per cell", open.cell, open.displacement, Series::Style::points});
  if (context.level() != Level::quick) {
    const Sweep many = sweep(context, {.per_axis = 3}, context.choose<std::vector<int>>({}, {8, 12, 16, 24}, {8, 12, 16, 24, 32}), work);
    const double p = fitted_order(many.cell, many.displacement);
    result
        .check_order(Label::verification, "cube in periodic surroundings, 27 particles per cell: order of the displacement", p, target, 2.5,
                     "as with 8 particles per cell")
        .observed_order = p;
    plot.series.push_back({"periodic surroundings, 27 per cell", many.cell, many.displacement, Series::Style::points});
    context.log("cube in its periodic surroundings, 27 particles per cell");
  }
  const Sweep walls = sweep(context, {.periodic = false},
                            context.choose<std::vector<int>>({8, 12, 16}, {8, 12, 16, 24, 32}, {8, 12, 16, 24, 32, 48}), work);
  const double wall_order = fitted_order(walls.cell, walls.displacement);
  result
      .check_order(Label::verification, "cube between slip walls: order of the displacement", wall_order, 0.85, 1.25,
                   "walls are of first order: they act 0.17 dx behind their plane (case elastic_wave); 1.8 is not met with them")
      .observed_order = wall_order;
  plot.series.push_back({"slip walls, 8 per cell", walls.cell, walls.displacement, Series::Style::points});
  plot.series.push_back(slope_line("order 2", open.cell, open.displacement.back(), 2.0));
  plot.series.push_back(slope_line("order 1", walls.cell, walls.displacement.back(), 1.0));
  result.plots.push_back(std::move(plot));
  result.plots.push_back({"history",
                          "Error over one period, finest cube",
                          "time [periods]",
                          "L2 error of u over A [-]",
                          {{"periodic surroundings", open.finest.time, open.finest.history, Series::Style::simulation},
                           {"slip walls", walls.finest.time, walls.finest.history, Series::Style::simulation}},
                          "",
                          false,
                          true});
  result.notes.push_back(
      fmt::format("With slip walls and contact on nodes the order of the displacement is {:.2f}, not {}. Without them it is {:.2f}: the "
                  "walls, not the scheme, are of first order.",
                  wall_order, target, order));
  result.notes.push_back("Cube, orders from grid to grid: periodic " + listed(pairwise_orders(open.cell, open.displacement)) +
                         "; slip walls " + listed(pairwise_orders(walls.cell, walls.displacement)) + ".");
  context.log("cube between slip walls");
}

/// The cube between slip walls that act at their surface, on planes of nodes and between them.
void walls_at_their_surface(const CaseContext& context, CaseResult& result, std::size_t& work) {
  const auto grids = context.choose<std::vector<int>>({8, 12, 16}, {8, 12, 16, 24, 32}, {8, 12, 16, 24, 32, 48});
  Plot plot{"surface-walls", "Cube between slip walls, contact at the surface", "dx [m]", "L2 error of u over A [-]", {}, "", true, true};
  struct Kind {
    std::string name;
    double offset;
    Transfer transfer;
  };
  for (const auto& [name, offset, transfer] :
       {Kind{"APIC, walls on nodes", 0.0, Transfer::apic}, Kind{"APIC, walls between nodes", 0.5, Transfer::apic},
        Kind{"AFLIP, walls on nodes", 0.0, Transfer::aflip}}) {
    const Sweep s =
        sweep(context, {.periodic = false, .offset = offset, .contact = ContactRule::surface, .transfer = transfer}, grids, work);
    const double order = fitted_order(s.cell, s.displacement);
    result
        .check_order(Label::verification, "cube between slip walls that act at their surface, " + name + ": order of the displacement",
                     order, 1.9, 2.6, "second order is the aim; up to 2.6 because the coarsest grid has 4 cells to half a wave")
        .observed_order = order;
    result.notes.push_back(fmt::format("Cube between slip walls that act at their surface, {}: errors {:.2e} to {:.2e}, orders {}.", name,
                                       s.displacement.front(), s.displacement.back(), listed(pairwise_orders(s.cell, s.displacement))));
    plot.series.push_back({name, s.cell, s.displacement, Series::Style::points});
    if (plot.series.size() == 1) plot.series.push_back(slope_line("order 2", s.cell, s.displacement.back(), 2.0));
  }
  result.plots.push_back(std::move(plot));
  context.log("cube between slip walls that act at their surface");
}

/// One component, one particle across: the same scheme on fine grids.
void column(const CaseContext& context, CaseResult& result, std::size_t& work) {
  const auto grids =
      context.choose<std::vector<int>>({8, 12, 16, 24, 32, 48}, {8, 12, 16, 24, 32, 48, 64, 96}, {8, 12, 16, 24, 32, 48, 64, 96, 128});
  Plot displacement{"quadrature", "Where quadrature takes over: displacement, one component",
                    "dx [m]",     "L2 error of u over A [-]",
                    {},           "Particles per cell and axis at the start; the material is stretched by up to 31 %.",
                    true,         true};
  Plot stress{"quadrature-stress",
              "Where quadrature takes over: stress, one component",
              "dx [m]",
              "L2 error of τ_xx over its largest value [-]",
              {},
              "The floor falls with the number of particles, not with dx.",
              true,
              true};
  for (const int n : {2, 3, 4, 6}) {
    const Sweep s = sweep(context, {.per_axis = n, .quasi_1d = true}, grids, work);
    // grids on which the error of the scheme is larger than that of the quadrature (see the README)
    const std::size_t used = n == 2 ? 4 : n == 3 ? 5 : grids.size();
    const std::vector<double> h(s.cell.begin(), s.cell.begin() + static_cast<long>(used)),
        e(s.displacement.begin(), s.displacement.begin() + static_cast<long>(used));
    const double order = fitted_order(h, e);
    result
        .check_order(
            Label::verification,
            fmt::format("one component, {} particles per cell and axis: order of the displacement, dx = 1/8 to 1/{}", n, grids[used - 1]),
            order, target, 2.5, "second order until quadrature takes over")
        .observed_order = order;
    result.notes.push_back(
        fmt::format("One component, {} particles per cell and axis, orders from grid to grid (8 to {} cells): displacement {}; stress {}. "
                    "Errors at the "
                    "finest: {:.2e}, {:.2e}.",
                    n, grids.back(), listed(pairwise_orders(s.cell, s.displacement)), listed(pairwise_orders(s.cell, s.stress)),
                    s.displacement.back(), s.stress.back()));
    displacement.series.push_back({fmt::format("{} per axis", n), s.cell, s.displacement, Series::Style::points});
    stress.series.push_back({fmt::format("{} per axis", n), s.cell, s.stress, Series::Style::points});
    if (n == 6) {
      displacement.series.push_back(slope_line("order 2", s.cell, s.displacement.back(), 2.0));
      stress.series.push_back(slope_line("order 2", s.cell, s.stress.front() * std::pow(s.cell.back() / s.cell.front(), 2), 2.0));
    }
  }
  const Sweep walls = sweep(context, {.periodic = false, .quasi_1d = true}, grids, work);
  displacement.series.push_back({"2 per axis, slip walls", walls.cell, walls.displacement, Series::Style::points});
  stress.series.push_back({"2 per axis, slip walls", walls.cell, walls.stress, Series::Style::points});
  result.notes.push_back("One component between slip walls, 2 particles per cell and axis, orders from grid to grid: displacement " +
                         listed(pairwise_orders(walls.cell, walls.displacement)) + "; stress " +
                         listed(pairwise_orders(walls.cell, walls.stress)) +
                         " (L2: an error that does not fall, in a layer of one cell, has order 1/2).");
  result.plots.push_back(std::move(displacement));
  result.plots.push_back(std::move(stress));
  context.log("one component: particles per cell");
}

/// Fields at half a period against the exact ones.
void profile(const CaseContext& context, CaseResult& result) {
  const Errors r = simulate(context, {.cells = 16, .per_axis = 4, .quasi_1d = true}),
               w = simulate(context, {.cells = 16, .per_axis = 4, .periodic = false, .quasi_1d = true});
  const Solution exact(context.read_case().material, Vec3(0.05, 0.0, 0.0));
  const double t = r.profile_time;
  const auto place = [](double x) { return Place(Vec3(x, 0.0, 0.0)); };
  const Series line =
      reference_curve("exact", 0.0, 1.0, 200, [&](double x) { return 1e3 * exact.displacement(place(x), exact.at(t)).x(); });
  const Series stress_line =
      reference_curve("exact", 0.0, 1.0, 200, [&](double x) { return 1e-3 * exact.stress(place(x), exact.at(t)).x(); });
  const auto points = [](const std::string& name, const Errors& e, bool stress) {
    std::vector<std::pair<double, double>> sorted;
    for (std::size_t i = 0; i < e.x.size(); ++i) sorted.emplace_back(e.x[i], stress ? 1e-3 * e.txx[i] : 1e3 * e.ux[i]);
    std::sort(sorted.begin(), sorted.end());
    Series s{name, {}, {}, Series::Style::points};
    for (const auto& [x, y] : sorted) s.x.push_back(x), s.y.push_back(y);
    return s;
  };
  result.plots.push_back({"profile-u",
                          fmt::format("Displacement at t = {:.2f} periods, dx = 1/16 m", t / exact.period()),
                          "X [m]",
                          "u [mm]",
                          {line, points("periodic surroundings", r, false), points("slip walls", w, false)}});
  result.plots.push_back({"profile-stress",
                          fmt::format("Stress at t = {:.2f} periods, dx = 1/16 m", t / exact.period()),
                          "X [m]",
                          "τ_xx [kPa]",
                          {stress_line, points("periodic surroundings", r, true), points("slip walls", w, true)}});
}

/// Time step and start, and the place of the cube in the grid, one component.
void time_and_place(const CaseContext& context, CaseResult& result, std::size_t& work) {
  const Settings base{.cells = 32, .per_axis = 4, .quasi_1d = true};
  Series half{"start from v(-dt/2)", {}, {}, Series::Style::points}, plain{"start from v(0)", {}, {}, Series::Style::points};
  std::vector<double> cfl, difference;
  for (const double value : {0.8, 0.4, 0.2, 0.1, 0.05}) {
    Settings s = base;
    s.cfl = value;
    const Errors a = simulate(context, s);
    s.half_step_start = false;
    const Errors b = simulate(context, s);
    work += a.particle_steps + b.particle_steps;
    double squares = 0.0;
    for (std::size_t i = 0; i < a.late_displacement.size(); ++i) squares += (a.late_displacement[i] - b.late_displacement[i]).squaredNorm();
    cfl.push_back(value);
    difference.push_back(std::sqrt(squares / static_cast<double>(a.late_displacement.size())));
    half.x.push_back(value), half.y.push_back(a.displacement);
    plain.x.push_back(value), plain.y.push_back(b.displacement);
  }
  const double order = fitted_order(cfl, difference);
  result
      .check_order(Label::verification, "start from v(0) instead of v(-dt/2): order in dt of the difference", order, 0.9, 1.1,
                   "half a step of acceleration: first order")
      .observed_order = order;
  result.plots.push_back({"time-step",
                          "Error against the time step, dx = 1/32 m, 4 particles per cell and axis",
                          "CFL number [-]",
                          "L2 error of u over A [-]",
                          {half, plain, slope_line("order 1", cfl, plain.y[1] * cfl.back() / cfl[1], 1.0)},
                          "With velocities at half steps space limits at every time step; below CFL 0.4 the error grows, because every "
                          "APIC step filters once.",
                          true,
                          true});
  Series two{"2 per axis", {}, {}, Series::Style::points}, four{"4 per axis", {}, {}, Series::Style::points};
  for (int i = 0; i <= 8; ++i) {
    Settings s{.cells = 24, .quasi_1d = true, .offset = i / 8.0};
    const Errors a = simulate(context, s);
    s.per_axis = 4;
    const Errors b = simulate(context, s);
    work += a.particle_steps + b.particle_steps;
    two.x.push_back(s.offset), two.y.push_back(a.displacement);
    four.x.push_back(s.offset), four.y.push_back(b.displacement);
  }
  const auto [low, high] = std::minmax_element(two.y.begin(), two.y.end());
  result.notes.push_back(fmt::format(
      "Shifted against the grid by 0 to 1 cell (dx = 1/24 m, 2 particles per cell and axis): error {:.2e} to {:.2e}.", *low, *high));
  result.plots.push_back({"offset",
                          "Error against the place in the grid, dx = 1/24 m",
                          "shift against the grid [dx]",
                          "L2 error of u over A [-]",
                          {two, four},
                          "Periodic surroundings."});
  context.log("one component: time step, place in the grid");
}

void run(const CaseContext& context, CaseResult& result) {
  const Case c = context.read_case();
  result.check_absolute(Label::verification, "body force: largest residual of the momentum equation over ρ0 |b|max",
                        momentum_residual(Solution(c.material, Vec3::Constant(0.05))), 0.0, "", 1e-6,
                        "central differences over 1e-4 of a wave: (2π 1e-4)²/6 = 7e-8, times derivatives of 1/F² at F = 0.69");
  std::size_t work = 0;
  cube(context, result, work);
  walls_at_their_surface(context, result, work);
  column(context, result, work);
  time_and_place(context, result, work);
  profile(context, result);
  result.notes.push_back(fmt::format("{:.0f} million particle-steps.", 1e-6 * static_cast<double>(work)));
}

const Registration registered{{.title = "Manufactured solution: order of the displacement", .run = run}};

}  // namespace
}  // namespace mpm::validation::manufactured_solution
