#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <numeric>

#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/scene.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/discrete_bar.hpp"
#include "validation/harness/norms.hpp"
#include "validation/harness/particle_access.hpp"
#include "validation/harness/setup.hpp"
#include "validation/harness/slender.hpp"

namespace mpm::validation::elastic_wave {
namespace {

constexpr double pi = std::numbers::pi;

/// How the ends of a bar of length L are held; its first mode and wave number k.
enum class Ends {
  walls,   ///< slip walls at x = 0 and L: u = sin(k x), k = pi/L
  mirror,  ///< mirror plane at x = 0 (exact), free at L: u = sin(k x), k = pi/(2 L)
  free,    ///< free bar of length 2 L, half of it computed: as `mirror`, and nothing touches its sides (nu = 0)
};

struct Settings {
  Ends ends = Ends::mirror;
  int cells = 16;     ///< per L
  int per_axis = 2;   ///< particles per cell and axis
  double cfl = 0.4;   ///< c dt / dx
  double offset = 0;  ///< of the bar against the grid, in cells
  Transfer transfer = Transfer::apic;
  double flip_ratio = 0.0;
  ContactRule contact = ContactRule::nodal;
};

struct Vibration {
  double cell = 0.0;            ///< m
  double frequency = 0.0;       ///< over the exact one
  double damping = 0.0;         ///< ratio zeta: the amplitude falls by exp(-2 pi zeta) a period
  std::vector<double> time, v;  ///< in exact periods; modal velocity over its start
  std::size_t particle_steps = 0;
};

constexpr int periods = 10;
constexpr double amplitude = 1e-6;  ///< of the velocity over the wave speed: strains of 1e-6, so that the exact solution is the linear one

/// The case file with cell size, ends and numerics of one run.
Case bar_case(const CaseContext& context, const Settings& s) {
  Case c = context.read_case();
  const double length = c.bodies.at(0).max.x(), dx = length / s.cells;
  const double side = s.ends == Ends::free ? 2.0 * dx : dx / s.per_axis;
  const Vec3 shift(s.offset * dx, 0.0, 0.0);
  c.numerics.cell_size = dx;
  c.numerics.particles_per_cell = s.per_axis * s.per_axis * s.per_axis;
  c.numerics.cfl = s.cfl;
  c.numerics.transfer = s.transfer;
  c.numerics.flip_ratio = s.flip_ratio;
  c.numerics.contact = s.contact;
  set_side(c, side, {1, 2});
  if (s.ends != Ends::walls) {
    c.domain.mirror_x = true;
    std::erase_if(c.walls, [](const WallSpec& wall) { return wall.normal.x() != 0.0; });
  }
  if (s.ends == Ends::free) {
    c.walls.clear();
    c.material.as<HenckyElastic>().poisson_ratio = 0.0;  // an axial strain has no lateral stress: the one-dimensional frequency is exact
  }
  c.bodies[0].min += shift;
  c.bodies[0].max += shift;
  for (WallSpec& wall : c.walls) wall.point += shift;
  return c;
}

/// Amplitude of a frequency in samples: least-squares fit of a cos + b sin.
double fitted_amplitude(const std::vector<double>& t, const std::vector<double>& y, std::size_t begin, std::size_t end, double omega) {
  double cc = 0, cs = 0, ss = 0, yc = 0, ys = 0;
  for (std::size_t i = begin; i < end; ++i) {
    const double c = std::cos(omega * t[i]), s = std::sin(omega * t[i]);
    cc += c * c, cs += c * s, ss += s * s, yc += y[i] * c, ys += y[i] * s;
  }
  const double det = cc * ss - cs * cs;
  return std::hypot((yc * ss - ys * cs) / det, (ys * cc - yc * cs) / det);
}

/// Ends, wave number and frequency of the first mode of a bar.
struct Mode {
  double start, k, omega, speed;
  [[nodiscard]] double shape(double x) const { return std::sin(k * (x - start)); }
};

Mode mode_of(const Case& c, Ends ends) {
  const double start = c.bodies[0].min.x(), length = c.bodies[0].max.x() - start, speed = wave_speed_of(make_material(c.material));
  const double k = (ends == Ends::walls ? 1.0 : 0.5) * pi / length;
  return {start, k, k * speed, speed};
}

/// A bar that swings in its first mode for ten periods.
Setup bar_setup(const CaseContext& context, const Settings& s) {
  Case c = bar_case(context, s);
  const Mode mode = mode_of(c, s.ends);
  const double dt = s.cfl * c.numerics.cell_size / mode.speed;
  const auto steps = static_cast<std::size_t>(std::ceil(periods * 2.0 * pi / mode.omega / dt));
  const char* ends = s.ends == Ends::walls    ? "between slip walls"
                     : s.ends == Ends::mirror ? "confined, between a mirror plane and a free end"
                                              : "free";
  return {.id = fmt::format("{}-dx{}",
                            s.ends == Ends::walls    ? "walls"
                            : s.ends == Ends::mirror ? "mirror"
                                                     : "free",
                            s.cells),
          .title = fmt::format("bar {}, dx = L/{}", ends, s.cells),
          .spec = std::move(c),
          .start =
              [mode](const Case& spec, const Scene& scene) {
                State state = make_state(spec, scene);
                state.grid.change_particles([&](Particle& p) {
                  p.velocity[0] = amplitude * mode.speed * mode.shape(p.position[0]);
                  p.affine[0] = amplitude * mode.speed * mode.k * std::cos(mode.k * (p.position[0] - mode.start));
                });
                return state;
              },
          .times = even_times(0.0, static_cast<double>(steps) * dt, steps),
          .fields = {.position = false, .identity = true},
          .time_step = dt,
          .procedure =
              "The velocity of the first mode swings freely. The velocity written at time t is taken as that of t - time_step_s/2, as a "
              "leap-frog has it; time_step_s is to be used as it is."};
}

/// Measures a bar that swings: frequency from the zeros of the modal velocity, damping from its amplitude in the first and the last
/// period.
Vibration vibrate(const CaseContext& context, const Settings& s) {
  const Setup setup = bar_setup(context, s);
  const Mode mode = mode_of(setup.spec, s.ends);
  const CaseScene scene = make_scene(setup.spec);
  std::vector<double> shape;
  for (const ParticleRecord& p : particle_records(make_state(setup.spec, scene), scene)) {
    if (p.id >= shape.size()) shape.resize(p.id + 1);
    shape[p.id] = mode.shape(p.position.x());
  }
  Vibration result;
  result.cell = setup.spec.numerics.cell_size;
  const double period = 2.0 * pi / mode.omega, dt = setup.time_step;
  const RunCost cost = play(context, setup, [&](const Instant& now) {
    double a = 0.0, norm = 0.0;
    for (const ParticleRecord& p : now.particles) {
      a += p.mass * p.velocity.x() * shape.at(p.id);
      norm += p.mass * shape[p.id] * shape[p.id];
    }
    result.time.push_back((now.time - 0.5 * dt) / period);  // velocities live at half steps
    result.v.push_back(a / (norm * amplitude * mode.speed));
    return true;
  });
  result.particle_steps = static_cast<std::size_t>(cost.particle_steps);
  std::vector<double> zeros;
  for (std::size_t i = 1; i < result.v.size(); ++i) {
    if ((result.v[i - 1] > 0.0) == (result.v[i] > 0.0)) continue;
    zeros.push_back(result.time[i - 1] + (result.time[i] - result.time[i - 1]) * result.v[i - 1] / (result.v[i - 1] - result.v[i]));
  }
  if (zeros.size() < 2) {  // another solver's bar that does not swing
    result.frequency = result.damping = std::numeric_limits<double>::quiet_NaN();
    return result;
  }
  result.frequency = 0.5 * static_cast<double>(zeros.size() - 1) / (zeros.back() - zeros.front());
  const auto in_period = static_cast<std::size_t>(std::lround(period / dt / result.frequency));
  const double circular = 2.0 * pi * result.frequency;
  const double first = fitted_amplitude(result.time, result.v, 0, in_period, circular);
  const double last = fitted_amplitude(result.time, result.v, result.v.size() - in_period, result.v.size(), circular);
  const double between = result.time.back() - result.time[in_period - 1];
  result.damping = std::log(first / last) / (circular * between);
  return result;
}

/// Frequency over the exact one and damping ratio of a plane wave on an endless regular lattice of particles, exactly: the analysis of von
/// Neumann of the linearised step (derived in the README).
struct Dispersion {
  double frequency, damping;
};
Dispersion dispersion(double k_dx, int per_axis, double cfl, Transfer transfer, double flip_ratio) {
  using Complex = std::complex<double>;
  double s2 = 0.0, g2 = 0.0;  // means over the particles of a cell of |S|^2 and |g dx|^2
  for (int p = 0; p < per_axis; ++p) {
    const double x = (p + 0.5) / per_axis, nearest = std::round(x);
    Complex s = 0.0, g = 0.0;
    for (int i = -1; i <= 1; ++i) {
      const double xi = nearest + i - x, a = std::abs(xi);
      const double w = a < 0.5 ? 0.75 - a * a : 0.5 * (1.5 - a) * (1.5 - a);
      s += w * std::exp(Complex(0.0, k_dx * xi));
      g += 4.0 * w * xi * std::exp(Complex(0.0, k_dx * xi));
    }
    s2 += std::norm(s) / per_axis;
    g2 += std::norm(g) / per_axis;
  }
  const double stiffness = cfl * cfl * g2;  // (c dt)^2 mean |g|^2
  const double a = transfer == Transfer::apic ? s2 + 0.25 * g2 : flip_ratio + s2 * (1.0 - flip_ratio);
  const double trace = 1.0 + a - stiffness, determinant = transfer == Transfer::apic ? a : a - (a - s2) * stiffness;
  const double radius = std::sqrt(determinant), angle = std::acos(0.5 * trace / radius);
  return {angle / (cfl * k_dx), -std::log(radius) / angle};
}

/// First frequency, over the exact one, of the semi-discrete bar between slip walls: lumped masses, stresses at the particles, and the
/// nodes on and behind both walls at rest. Solved as an eigenproblem, without time and without the
/// library, by inverse iteration from the exact mode.
double frequency_between_walls(int cells, int per_axis) {
  const DiscreteBar bar(cells, per_axis, cells - 1);
  std::vector<double> mode;
  for (int i = 1; i < cells; ++i) mode.push_back(std::sin(pi * i / cells));
  double squared = 0.0;
  for (int round = 0; round < 20; ++round) {  // the error of a Rayleigh quotient falls to a sixteenth or less
    std::vector<double> inertia = bar.mass;
    for (std::size_t i = 0; i < mode.size(); ++i) inertia[i] *= mode[i];
    const std::vector<double> next = bar.solve(inertia);
    squared = std::inner_product(mode.begin(), mode.end(), inertia.begin(), 0.0) /
              std::inner_product(next.begin(), next.end(), inertia.begin(), 0.0);
    for (std::size_t i = 0; i < mode.size(); ++i) mode[i] = squared * next[i];
  }
  return std::sqrt(squared) * cells / pi;
}

/// A transfer and how it is called in plots.
struct Method {
  std::string name;
  Transfer transfer;
  double flip_ratio;
};

/// Errors of one way to hold the ends and one transfer over the grids.
struct Sweep {
  std::vector<double> cell, frequency, damping;  ///< m; |f/f_exact - 1|; zeta
  Vibration finest;
  std::size_t particle_steps = 0;
};

Sweep sweep(const CaseContext& context, Settings s, const std::vector<int>& grids) {
  Sweep result;
  for (const int cells : grids) {
    s.cells = cells;
    result.finest = vibrate(context, s);
    result.cell.push_back(result.finest.cell);
    result.frequency.push_back(std::abs(result.finest.frequency - 1.0));
    result.damping.push_back(result.finest.damping);
    result.particle_steps += result.finest.particle_steps;
  }
  return result;
}

/// Cells per length of the bars that are judged.
std::vector<int> mirror_grids(const CaseContext& context) {
  return context.choose<std::vector<int>>({8, 12, 16, 24, 32}, {8, 12, 16, 24, 32, 48, 64}, {8, 12, 16, 24, 32, 48, 64, 96, 128});
}
std::vector<int> free_grids(const CaseContext& context) {
  return context.choose<std::vector<int>>({8, 12, 16, 24}, {8, 12, 16, 24, 32}, {8, 12, 16, 24, 32, 48});
}

std::vector<Setup> setups(const CaseContext& context) {
  std::vector<Setup> all;
  for (const int cells : mirror_grids(context)) all.push_back(bar_setup(context, {.ends = Ends::mirror, .cells = cells}));
  for (const int cells : free_grids(context)) all.push_back(bar_setup(context, {.ends = Ends::free, .cells = cells}));
  return all;
}

/// The scheme without walls: order, and the leading error that the analysis predicts. Another solver is judged by its order alone.
void ends_without_walls(const CaseContext& context, CaseResult& result, const std::vector<Method>& methods, std::size_t& work) {
  const auto grids = mirror_grids(context);
  Plot frequency{"frequency", "Error of the frequency, bar between a mirror plane and a free end",   "dx / L [-]", "|f / f_exact - 1| [-]",
                 {},          "Lines: von Neumann analysis of the step, no fit. Marks: simulation.", true,         true};
  Plot damping{"damping",    "Numerical damping, bar between a mirror plane and a free end",
               "dx / L [-]", "damping ratio ζ [-]",
               {},           "Lines: von Neumann analysis of the step, no fit. The material itself has no damping.",
               true,         true};
  for (const Method& m : methods) {
    const Sweep s = sweep(context, {.ends = Ends::mirror, .transfer = m.transfer, .flip_ratio = m.flip_ratio}, grids);
    work += s.particle_steps;
    Series line_f{m.name + ", analysis", s.cell, {}, Series::Style::reference};
    Series line_d = line_f;
    for (const double h : s.cell) {
      const Dispersion d = dispersion(0.5 * pi * h, 2, 0.4, m.transfer, m.flip_ratio);
      line_f.y.push_back(std::abs(d.frequency - 1.0));
      line_d.y.push_back(d.damping);
    }
    const std::string what = "mirror and free end, " + m.name + ": ";
    const double hertz = wave_speed_of(make_material(bar_case(context, {}).material)) / 4.0;  // exact, L = 1 m
    result.compare(Label::verification, what + "frequency", Quantity::frequency, hertz * s.finest.frequency, hertz, "Hz");
    result.check_order(Label::verification, what + "order of the frequency", fitted_order(s.cell, s.frequency), 1.9, 2.1,
                       "second order; fourth-order terms at the coarsest grid are (k dx)^2 = 4 % of the second-order ones");
    if (!own_run(context)) continue;
    result.check_relative(Label::verification, what + "error of the frequency at the finest grid against the analysis", s.frequency.back(),
                          line_f.y.back(), "", 0.02, "the analysis has no ends; the free end adds a contribution of order dx / L");
    const double order = m.transfer == Transfer::flip && m.flip_ratio < 1.0 ? 1.0 : 3.0;
    result.check_order(Label::verification, what + "order of the damping ratio", fitted_order(s.cell, s.damping), order - 0.2, order + 0.2,
                       "order of the analysis; the free end adds a contribution of order dx / L, 20 % of the damping on these grids");
    frequency.series.push_back(std::move(line_f));
    frequency.series.push_back({m.name, s.cell, s.frequency, Series::Style::points});
    damping.series.push_back(std::move(line_d));
    damping.series.push_back({m.name, s.cell, s.damping, Series::Style::points});
    result.notes.push_back(fmt::format(
        "{}, mirror plane and free end, L = {} dx: frequency {:+.3e}, damping ratio {:.2e}, that is {:.4f} % of "
        "the amplitude lost in a period.",
        m.name, grids.back(), s.finest.frequency - 1.0, s.damping.back(), 100.0 * (1.0 - std::exp(-2.0 * pi * s.damping.back()))));
    if (order < 3.0) damping.series.push_back(slope_line("order 1", s.cell, s.damping.back(), 1.0));
    if (m.transfer == Transfer::apic) {
      frequency.series.push_back(slope_line("order 2", s.cell, s.frequency.back(), 2.0));
      damping.series.push_back(slope_line("order 3", s.cell, s.damping.back(), 3.0));
      Series exact{"exact", {}, {}, Series::Style::reference};
      const Vibration v = vibrate(context, {.ends = Ends::mirror, .cells = 8});
      for (const double t : v.time) exact.x.push_back(t), exact.y.push_back(std::cos(2.0 * pi * t));
      result.plots.push_back({"history",
                              "First mode of the bar over ten periods, L = 8 dx",
                              "time [periods]",
                              "modal velocity over its start [-]",
                              {exact, {"APIC", v.time, v.v, Series::Style::simulation}},
                              "Mirror plane and free end, the coarsest grid: late by 4 % of a period after ten."});
    }
    context.log(fmt::format("mirror and free end, {}: {} grids", m.name, grids.size()));
  }
  if (!own_run(context)) return;
  result.plots.push_back(std::move(frequency));
  result.plots.push_back(std::move(damping));
}

/// Slip walls at both ends that act at their surface: second order, as the inside.
void ends_at_surfaces(const CaseContext& context, CaseResult& result, std::size_t& work) {
  const Sweep s = sweep(context, {.ends = Ends::walls, .contact = ContactRule::surface}, {8, 12, 16, 24});
  work += s.particle_steps;
  result
      .check_order(Label::verification, "slip walls that act at their surface: order of the frequency", fitted_order(s.cell, s.frequency),
                   1.8, 2.4, "second order in the interior and at walls; the coarsest grid has eight cells")
      .observed_order = fitted_order(s.cell, s.frequency);
}

/// Slip walls at both ends that act on nodes: first order, and exactly what the discrete system has.
void ends_at_walls(const CaseContext& context, CaseResult& result, std::size_t& work) {
  const auto grids =
      context.choose<std::vector<int>>({8, 12, 16, 24, 32}, {8, 12, 16, 24, 32, 48, 64}, {8, 12, 16, 24, 32, 48, 64, 96, 128});
  const Sweep s = sweep(context, {.ends = Ends::walls}, grids);
  work += s.particle_steps;
  Series discrete{"eigenproblem of the discrete bar", s.cell, {}, Series::Style::reference};
  for (const int cells : grids) discrete.y.push_back(1.0 - frequency_between_walls(cells, 2));
  // the time integration adds (omega dt)^2 / 24
  const double in_time = std::pow(0.4 * pi / grids.back(), 2) / 24.0;
  result.check_absolute(Label::verification, "slip walls: frequency of the finest grid minus that of the discrete bar",
                        s.finest.frequency - in_time, 1.0 - discrete.y.back(), "", 2e-4 * std::pow(32.0 / grids.back(), 2),
                        "damping at the walls shifts the frequency in second order: ζ is 3e-4 at 32 cells");
  std::vector<double> remainder;  // without the second-order error of the scheme itself
  for (std::size_t i = 0; i < grids.size(); ++i)
    remainder.push_back(s.frequency[i] + dispersion(pi * s.cell[i], 2, 0.4, Transfer::apic, 0.0).frequency - 1.0);
  result.check_order(Label::verification, "slip walls: order of the frequency, without the scheme's own second-order error",
                     fitted_order(s.cell, remainder), 0.9, 1.1, "first order: the walls act at nodes and cut the kernels of the next ones");
  const double shift = remainder.back() / (2.0 * (1.0 - remainder.back())) * grids.back();
  result.notes.push_back(fmt::format(
      "Slip walls: the bar swings as if each wall stood {:.4f} dx behind its plane (finest grid); order of the whole error {:.2f}, of the "
      "damping "
      "ratio {:.2f}; error {:.2e} and ζ = {:.1e} at L = {} dx.",
      shift, fitted_order(s.cell, s.frequency), fitted_order(s.cell, s.damping), s.frequency.back(), s.damping.back(), grids.back()));
  result.plots.push_back(
      {"walls",
       "Error of the frequency, bar between slip walls",
       "dx / L [-]",
       "|f / f_exact - 1| [-]",
       {discrete, {"APIC", s.cell, s.frequency, Series::Style::points}, slope_line("order 1", s.cell, s.frequency.back(), 1.0)},
       "The wall holds the nodes on and behind its plane.",
       true,
       true});

  // position of the wall, if it is not on a plane of nodes
  Series moved{"L = 16 dx", {}, {}, Series::Style::points};
  for (int i = 0; i <= 8; ++i) {
    const double offset = i / 8.0;
    const Vibration v = vibrate(context, {.ends = Ends::walls, .cells = 16, .offset = offset});
    moved.x.push_back(offset);
    moved.y.push_back(16.0 * (1.0 / v.frequency - 1.0));
    work += v.particle_steps;
  }
  result.plots.push_back(
      {"offset",
       "Walls off the planes of nodes",
       "shift of bar and walls against the grid [dx]",
       "apparent length minus L [dx]",
       {moved, {"no error", {0.0, 1.0}, {0.0, 0.0}, Series::Style::bound}},
       "Both walls move with the bar. A wall acts from the first node on or behind its plane, so the apparent length depends on "
       "where the planes lie between nodes."});
  const auto [low, high] = std::minmax_element(moved.y.begin(), moved.y.end());
  result.notes.push_back(
      fmt::format("Walls shifted against the grid (L = 16 dx): the apparent length exceeds L by {:.2f} to {:.2f} dx.", *low, *high));
  context.log("slip walls: grids and shifts");
}

/// Free bar in three dimensions: free sides, nu = 0.
void free_bar(const CaseContext& context, CaseResult& result, std::size_t& work) {
  const auto grids = free_grids(context);
  const Sweep s = sweep(context, {.ends = Ends::free}, grids);
  work += s.particle_steps;
  result.check_order(Label::verification, "free bar, nu = 0: order of the frequency", fitted_order(s.cell, s.frequency), 1.9, 2.1,
                     "second order, as without sides");
  if (!own_run(context)) return;
  result.check_at_most(Label::verification, "free bar, nu = 0: error of the frequency at the finest grid", s.frequency.back(),
                       std::abs(dispersion(0.5 * pi * s.cell.back(), 2, 0.4, Transfer::apic, 0.0).frequency - 1.0) * 1.02, "", 0.0,
                       "that of the analysis, and 2 % for the end");
  context.log("free bar");
}

/// Sweeps at one grid: time step and particles per cell.
void sweeps(const CaseContext& context, CaseResult& result, std::size_t& work) {
  constexpr int cells = 16;
  const double k_dx = 0.5 * pi / cells;
  Series by_cfl{"simulation", {}, {}, Series::Style::points}, cfl_line{"analysis", {}, {}, Series::Style::reference};
  Series loss{"simulation", {}, {}, Series::Style::points}, loss_line = cfl_line;
  for (const double cfl : {0.05, 0.1, 0.2, 0.4, 0.6, 0.8}) {
    const Vibration v = vibrate(context, {.cells = cells, .cfl = cfl});
    const Dispersion d = dispersion(k_dx, 2, cfl, Transfer::apic, 0.0);
    work += v.particle_steps;
    by_cfl.x.push_back(cfl), by_cfl.y.push_back(v.frequency - 1.0);
    cfl_line.x.push_back(cfl), cfl_line.y.push_back(d.frequency - 1.0);
    loss.x.push_back(cfl), loss.y.push_back(v.damping);
    loss_line.x.push_back(cfl), loss_line.y.push_back(d.damping);
  }
  result.plots.push_back({"cfl-frequency",
                          "Frequency against the time step, L = 16 dx, APIC",
                          "c_P dt / dx [-]",
                          "f / f_exact - 1 [-]",
                          {cfl_line, by_cfl},
                          "Space gives -0.1076 (k dx)², symplectic Euler adds (ω dt)²/24: space dominates at every stable step.",
                          true,
                          false});
  result.plots.push_back({"cfl-damping",
                          "Damping against the time step, L = 16 dx, APIC",
                          "c_P dt / dx [-]",
                          "damping ratio ζ [-]",
                          {loss_line, loss},
                          "Each step filters the velocity once: smaller steps lose more.",
                          true,
                          true});
  double worst = 0.0;
  Series by_count{"simulation", {}, {}, Series::Style::points}, count_line{"analysis", {}, {}, Series::Style::reference};
  for (int n = 1; n <= 6; ++n) {
    const Vibration v = vibrate(context, {.cells = cells, .per_axis = n});
    const Dispersion d = dispersion(k_dx, n, 0.4, Transfer::apic, 0.0);
    work += v.particle_steps;
    by_count.x.push_back(n), by_count.y.push_back(v.frequency - 1.0);
    count_line.x.push_back(n), count_line.y.push_back(d.frequency - 1.0);
    if (n > 1) worst = larger(worst, std::abs(v.frequency - d.frequency) / std::abs(d.frequency - 1.0));
  }
  result.check_at_most(Label::verification, "2 to 6 particles per cell and axis: frequency error against the analysis, largest deviation",
                       worst, 0.0, "", 0.05, "the free end adds a contribution of order dx / L = 1/16");
  result.plots.push_back({"particles",
                          "Frequency against the number of particles, L = 16 dx, APIC",
                          "particles per cell and axis",
                          "f / f_exact - 1 [-]",
                          {count_line, by_count},
                          "On a regular lattice quadrature is not what limits: the error hardly depends on the number."});
  context.log("sweeps of time step and particles per cell");
}

void run(const CaseContext& context, CaseResult& result) {
  std::vector<Method> methods = {{"APIC", Transfer::apic, 0.0}, {"FLIP 0.95", Transfer::flip, 0.95}, {"FLIP", Transfer::flip, 1.0}};
  if (!own_run(context)) methods = {{"as written back", Transfer::apic, 0.0}};
  std::size_t work = 0;
  ends_without_walls(context, result, methods, work);
  if (!own_run(context)) {
    free_bar(context, result, work);
    return;
  }
  ends_at_surfaces(context, result, work);
  ends_at_walls(context, result, work);
  free_bar(context, result, work);
  sweeps(context, result, work);
  result.notes.push_back(
      fmt::format("The elastic snow of the bars has c_P = 58.4 m/s; the strain amplitude is 1e-6. {:.1f} million particle-steps.",
                  1e-6 * static_cast<double>(work)));
}

const Registration registered{{.title = "Elastic waves: a P-wave between walls and a vibrating bar", .run = run, .setups = setups}};

}  // namespace
}  // namespace mpm::validation::elastic_wave
