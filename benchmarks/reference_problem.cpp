#include "reference_problem.hpp"

#include <algorithm>
#include <cmath>

#include "problems.hpp"

namespace mpm::benchmarks {

namespace {

constexpr double least_yielding = 0.99, least_changing_cell = 0.02;  // of the reference problem

/// Calls f(particle, cell key) on all particles, in parallel; bits 0..5 of the key are the cell in its block.
template <class F>
void for_each_cell(const Grid& grid, F&& f) {
  const auto blocks = grid.occupied_blocks();
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Block& block = grid.block(blocks[i]);
    std::uint64_t key = 0;
    for (const auto c : block.coordinate) key = key << 19 | static_cast<std::uint64_t>(c + (1 << 18));
    for (int s = 0; s < block.particles.count(); ++s) f(block.particles[s], key << 6 | block.particles.cell[static_cast<std::size_t>(s)]);
  }
}

}  // namespace

SteppedProblem::SteppedProblem(std::function<Problem()> make, const Activity& least, int most_steps)
    : make_(std::move(make)), least_(least), most_steps_(most_steps), problem_(make_()) {
  seed();
}

void SteppedProblem::seed() {
  constexpr int most_tries = 200;
  problem_ = make_();
  steps_ = 0;
  ++seedings_;
  for (int n = 0; n < most_tries; ++n) {
    remember();
    step(problem_.state, problem_.scene, stable_time_step(problem_.state, problem_.scene));
    if (reaches(activity())) return;
  }
  throw std::runtime_error("the problem does not reach the required fractions of yielding and moving particles");
}

void SteppedProblem::remember() {
  before_.resize(problem_.state.next_id);
  for_each_cell(problem_.state.grid, [&](const Particle& p, std::uint64_t cell) { before_[p.id] = {p.internal, cell}; });
}

Activity SteppedProblem::activity() const {
  std::uint64_t resting = 0, changing_cell = 0, changing_block = 0;
  for_each_cell(problem_.state.grid, [&](const Particle& p, std::uint64_t cell) {
    const Before& b = before_[p.id];
    const auto count = [](std::uint64_t& sum, bool yes) {
      if (!yes) return;
#pragma omp atomic
      ++sum;
    };
    count(resting, p.internal == b.internal);  // counts those at rest, because fewer atomics are needed if nearly all yield
    count(changing_cell, cell != b.cell);
    count(changing_block, cell >> 6 != b.cell >> 6);
  });
  const auto total = static_cast<double>(problem_.state.grid.particle_count());
  return {1.0 - static_cast<double>(resting) / total, static_cast<double>(changing_cell) / total,
          static_cast<double>(changing_block) / total};
}

bool SteppedProblem::reaches(const Activity& s) const { return s.yielding >= least_.yielding && s.changing_cell >= least_.changing_cell; }

Problem make_reference(double cell_size, Regime regime, Precision precision) {
  constexpr double middle = 2.0;  // m; above it nothing strains in the partly yielding problem
  Case c;
  c.material = reference_snow();
  if (regime == Regime::elastic) c.material.as<CamClay>().preconsolidation_pressure = 1e9;
  c.numerics.cell_size = cell_size;
  c.numerics.precision = precision;
  use_tracked_numerics(c);
  c.bodies.push_back({.max = {2.0, 1.0, 4.0}, .lattice = Lattice::aligned});
  c.walls.push_back({.contact = Contact::separable});
  CaseScene scene = make_scene(c);
  State state = make_state(c, scene);
  double max_speed_squared = 0.0;
  state.grid.change_particles([&](Particle& p) {
    const bool rigid = regime == Regime::partly_yielding && p.position[2] > middle;
    const double x = p.position[0], z = rigid ? middle : p.position[2];
    Mat3 gradient = Mat3::Zero();
    Vec3 v(2.0 * z, 0.0, -5.0 * z);
    if (!rigid) {
      v.x() += 5.0 * (x - 1.0);
      gradient << 5.0, 0.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, -5.0;
    }
    if (regime == Regime::elastic) {
      constexpr double remaining = 0.05;
      v = remaining * v + Vec3(10.0, 0.0, 0.0);
      gradient *= remaining;
    }
    Eigen::Map<Vec3>(p.velocity) = v;
    Eigen::Map<Mat3>(p.affine) = gradient;
    max_speed_squared = std::max(max_speed_squared, v.squaredNorm());
  });
  state.max_speed = std::sqrt(max_speed_squared);
  return {std::move(scene), std::move(state)};
}

SteppedProblem reference_problem(double cell_size, Regime regime, Precision precision) {
  const bool all = regime == Regime::fully_yielding;
  const Activity least = all ? Activity{.yielding = least_yielding, .changing_cell = least_changing_cell} : Activity{};
  return {[=] { return make_reference(cell_size, regime, precision); }, least, 200};
}

SteppedProblem avalanche_problem(std::size_t particles, Precision precision) {
  return {[=] { return make_avalanche(particles, precision); }, Activity{}, 100};
}

}  // namespace mpm::benchmarks
