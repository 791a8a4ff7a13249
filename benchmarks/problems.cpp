#include "problems.hpp"

#include <cmath>
#include <numbers>
#include <random>

namespace mpm::benchmarks {

namespace {

void set_stress(Particle& p, double pressure, double q) {
  // q = sqrt(3/2 s:s) along one deviator with all six components
  constexpr double direction[6] = {1.0, -2.0, 1.0, 1.0, -1.0, 0.5};
  constexpr double norm2 = 6.0 + 2.0 * (1.0 + 1.0 + 0.25);
  const double scale = q / std::sqrt(1.5 * norm2);
  for (int i = 0; i < 6; ++i) p.stress[i] = scale * direction[i] - (i < 3 ? pressure : 0.0);
}

/// |s| of the deviator.
double stress_norm(const Particle& p, double pressure) {
  double sum = 0.0;
  for (int i = 0; i < 6; ++i) sum += i < 3 ? (p.stress[i] + pressure) * (p.stress[i] + pressure) : 2.0 * p.stress[i] * p.stress[i];
  return std::sqrt(sum);
}

}  // namespace

void use_tracked_numerics(Case& c) {
  c.numerics.transfer = Transfer::apic;
  c.numerics.contact = ContactRule::nodal;
}

namespace {

/// A cube of particles at rest.
Problem cube(std::size_t particles, int per_cell, const CamClay::Parameters& snow, Precision precision) {
  Case c;
  c.material = snow;
  c.numerics.cell_size = 0.05;
  c.numerics.precision = precision;
  c.numerics.particles_per_cell = per_cell;
  const double edge = 0.05 * std::max(1.0, std::round(std::cbrt(static_cast<double>(particles) / per_cell)));
  use_tracked_numerics(c);
  c.bodies.push_back({.max = Vec3::Constant(edge), .lattice = Lattice::aligned});
  CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  return {std::move(scene), std::move(state)};
}

void refill(Problem& problem, const std::vector<Particle>& particles) {
  State fresh(problem.state.grid.cell_size(), problem.state.grid.precision());
  for (const Particle& p : particles) fresh.grid.insert(p);
  fresh.grid.refresh();
  fresh.next_id = problem.state.next_id;
  fresh.max_speed = problem.state.max_speed;
  problem.state = std::move(fresh);
}

}  // namespace

double density(const Scene& scene) { return density_of(scene.material); }

CamClay::Parameters reference_snow() {
  return {{.density = 300.0, .young_modulus = 1e6, .poisson_ratio = 0.1},
          /*critical_state_slope=*/0.8,
          /*cohesion_beta=*/0.3,
          /*hardening_xi=*/0.5,
          /*preconsolidation_pressure=*/1e4};
}

Problem make_block(std::size_t particles, int per_cell, bool jitter, Precision precision) {
  Problem problem = cube(particles, per_cell, reference_snow(), precision);
  const double spacing = problem.state.grid.cell_size() / std::cbrt(static_cast<double>(per_cell));
  std::mt19937_64 random(1);
  std::uniform_real_distribution<double> shift(-0.5 * spacing, 0.5 * spacing);
  problem.state.grid.change_particles([&](Particle& p) {
    for (double& x : p.position) {
      if (jitter) x += shift(random);
    }
    const double *x = p.position, k = 3.0;
    for (int i = 0; i < 3; ++i) {
      p.velocity[i] = std::sin(k * x[(i + 1) % 3] + i);
      p.affine[3 * ((i + 1) % 3) + i] = k * std::cos(k * x[(i + 1) % 3] + i);
    }
    set_stress(p, 5e3 * (1.0 + std::sin(x[0] + x[1] + x[2])), 3e3 * std::cos(x[2]));
  });
  refill(problem, copy_particles(problem.state.grid));
  problem.state.max_speed = std::numbers::sqrt3;
  return problem;
}

Problem make_law_points(std::size_t particles, LawRegime regime, Precision precision) {
  CamClay::Parameters snow = reference_snow();
  if (regime == LawRegime::zero_slope) snow.critical_state_slope = 0.0;
  Problem problem = cube(particles, 8, snow, precision);
  const double p_c = snow.preconsolidation_pressure, beta = snow.cohesion_beta, slope = snow.critical_state_slope;
  std::mt19937_64 random(2);
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  problem.state.grid.change_particles([&](Particle& p) {
    const double rate = regime == LawRegime::elastic ? 0.5 : 5.0;  // 1/s; the step's strain is rate * law_step
    for (double& c : p.affine) c = rate * unit(random);
    switch (regime) {
      case LawRegime::elastic: set_stress(p, 0.4 * p_c, 0.1 * p_c); break;
      case LawRegime::yielding: {
        const double pressure = (0.35 + 0.4 * std::abs(unit(random))) * p_c;
        set_stress(p, pressure, slope * std::sqrt((pressure + beta * p_c) * (p_c - pressure) / (1.0 + 2.0 * beta)));
        // straining along the stress's own deviator outweighs the random part, so that the trial state lies outside
        constexpr double aligned = 20.0;  // 1/s
        const double n = aligned / stress_norm(p, pressure);
        const double* t = p.stress;
        const double column[9] = {t[0] + pressure, t[3], t[4], t[3], t[1] + pressure, t[5], t[4], t[5], t[2] + pressure};
        for (int i = 0; i < 9; ++i) p.affine[i] += n * column[i];
        break;
      }
      case LawRegime::apexes: {
        const bool compression = unit(random) > 0.0;
        set_stress(p, compression ? p_c : -beta * p_c, 0.0);
        std::fill(std::begin(p.affine), std::end(p.affine), 0.0);
        for (int i = 0; i < 3; ++i) p.affine[3 * i + i] = (compression ? -1.0 : 1.0) * (1.0 + 0.5 * std::abs(unit(random)));
        break;
      }
      case LawRegime::zero_slope: set_stress(p, unit(random) > 0.0 ? p_c : 0.2 * p_c, 0.0); break;
    }
  });
  return problem;
}

Problem make_avalanche(std::size_t particles, Precision precision) {
  const Vec3 plug_min(-8.0, -5.0, 0.0), plug_max(4.0, 5.0, 1.75), jet_min(-0.5, -0.875, 1.75), jet_max(0.0, 0.875, 26.75);
  constexpr double mast_half_width = 0.875, mast_depth = 1.75;
  const double volume = (plug_max - plug_min).prod() - mast_depth * 2.0 * mast_half_width * 1.75 + (jet_max - jet_min).prod();
  Case c;
  c.numerics.precision = precision;
  c.material.as<CamClay>().critical_state_slope = 0.8;
  c.material.as<CamClay>().hardening_xi = 5.0;
  use_tracked_numerics(c);
  c.numerics.cell_size = std::cbrt(8.0 * volume / static_cast<double>(particles));
  constexpr double speed = 20.7, lift = 15.0;  // m/s: the plug at Fr 5, the jet on its way up
  const auto add = [&](const Vec3& min, const Vec3& max, const Vec3& velocity) {
    c.bodies.push_back({.min = min, .max = max, .velocity = velocity, .lattice = Lattice::aligned});
  };
  const Vec3 forward(speed, 0.0, 0.0);
  add(plug_min, {0.0, plug_max.y(), plug_max.z()}, forward);
  add({0.0, plug_min.y(), 0.0}, {plug_max.x(), -mast_half_width, plug_max.z()}, forward);
  add({0.0, mast_half_width, 0.0}, plug_max, forward);
  add({mast_depth, -mast_half_width, 0.0}, {plug_max.x(), mast_half_width, plug_max.z()}, forward);
  add(jet_min, jet_max, {0.0, 0.0, lift});
  c.walls.push_back({.contact = Contact::separable});
  c.obstacle = ObstacleSpec{};
  CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  return {std::move(scene), std::move(state)};
}

std::vector<Particle> copy_particles(const Grid& grid) {
  std::vector<Particle> particles;
  particles.reserve(grid.particle_count());
  grid.for_each_particle([&](const Particle& p) { particles.push_back(p); });
  return particles;
}

void put_back(const std::vector<Particle>& particles, Grid& grid) {
  auto next = particles.begin();
  grid.change_particles([&](Particle& p) { p = *next++; });
}

}  // namespace mpm::benchmarks
