#include "plain_reference.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>

#include "libmpm/base/bspline.hpp"

namespace mpm::benchmarks {

namespace {

// A node sums some hundred terms in another order than the plain path: 1e-13 of the largest sum is a thousand roundings.
constexpr double sum_tolerance = 1e-13;
// v_p and dx C_p / 4 are weighted sums of node velocities, which are quotients of such sums; a light node's quotient has a larger error by
// the ratio of masses, which its small weight compensates.
constexpr double velocity_tolerance = 1e-12;
// The required accuracy of the law: 1e-12 max(|tau|, 2e-3 G).
constexpr double law_tolerance = 1e-12, strain_floor = 2e-3;
// A whole step: the velocity gradient's error dt 4/dx 1e-12 |v| is a strain error of about 1e-13 at 20 m/s, and K or G times that adds to
// the law's own.
constexpr double step_tolerance = 1e-10;

[[noreturn]] void fail(const std::string& text) { throw std::runtime_error("wrong result: " + text); }

void expect_near(const char* what, std::uint64_t id, double value, double expected, double tolerance) {
  if (!(std::abs(value - expected) <= tolerance))
    fail(fmt::format("{} of particle {} is {:.17g}, expected {:.17g}, allowed difference {:.3g}", what, id, value, expected, tolerance));
}

/// G, Pa; rho_0 c^2 for a fluid, which has no shear modulus: the scale below which a stress counts as small.
double shear_modulus(const AnyMaterial& material) {
  return std::visit(
      [](const auto& law) {
        if constexpr (requires { law.moduli(); }) {
          return law.moduli().shear();
        } else {
          return law.density() * law.wave_speed() * law.wave_speed();
        }
      },
      material);
}

double stress_size(const Particle& p) {
  double sum = 0.0;
  for (int i = 0; i < 6; ++i) sum += (i < 3 ? 1.0 : 2.0) * p.stress[i] * p.stress[i];
  return std::sqrt(sum);
}

void compare_stress(const Particle& p, const Particle& expected, double relative, double shear) {
  const double tolerance = relative * std::max(stress_size(expected), strain_floor * shear);
  for (int i = 0; i < 6; ++i) expect_near("stress", p.id, p.stress[i], expected.stress[i], tolerance);
  expect_near("internal variable", p.id, p.internal, expected.internal, tolerance / shear);
}

void compare_motion(const Particle& p, const Particle& expected, double speed, double dx) {
  for (int i = 0; i < 3; ++i) {
    expect_near("velocity", p.id, p.velocity[i], expected.velocity[i], velocity_tolerance * speed);
    expect_near("position", p.id, p.position[i], expected.position[i],
                4.0 * std::numeric_limits<double>::epsilon() * (std::abs(expected.position[i]) + dx));
  }
  for (int i = 0; i < 9; ++i) expect_near("affine velocity", p.id, p.affine[i], expected.affine[i], 4.0 / dx * velocity_tolerance * speed);
}

}  // namespace

PlainGrid::PlainGrid(const std::vector<Particle>& particles, double cell_size) : cell_size_(cell_size) {
  constexpr auto most = std::numeric_limits<std::int32_t>::max();
  Index3 high{-most, -most, -most};
  low_ = {most, most, most};
  for (const Particle& p : particles) {
    for (std::size_t i = 0; i < 3; ++i) {
      const std::int32_t base = base_node(p.position[i] / cell_size);
      low_[i] = std::min(low_[i], base);
      high[i] = std::max(high[i], base + 2);
    }
  }
  for (std::size_t i = 0; i < 3; ++i) size_[i] = high[i] - low_[i] + 1;
  nodes_.assign(static_cast<std::size_t>(size_[0]) * static_cast<std::size_t>(size_[1]) * static_cast<std::size_t>(size_[2]), Node{});
}

bool PlainGrid::contains(const Index3& index) const {
  for (std::size_t i = 0; i < 3; ++i) {
    if (index[i] < low_[i] || index[i] >= low_[i] + size_[i]) return false;
  }
  return true;
}

std::size_t PlainGrid::place(const Index3& index) const {
  const auto at = [&](std::size_t i) { return static_cast<std::size_t>(index[i] - low_[i]); };
  return at(0) + static_cast<std::size_t>(size_[0]) * (at(1) + static_cast<std::size_t>(size_[1]) * at(2));
}

Node PlainGrid::largest() const {
  Node most{};
  for (const Node& n : nodes_) {
    for (int i = 0; i < 4; ++i) most[i] = std::max(most[i], std::abs(n[i]));
  }
  return most;
}

/// f(node index, w_ip, x_i - x_p) for the 27 nodes.
template <class F>
void PlainGrid::for_each_weight(const double* position, F&& f) const {
  double w[3][3];
  Index3 base{};
  for (std::size_t i = 0; i < 3; ++i) {
    const double x = position[i] / cell_size_;
    base[i] = base_node(x);
    const auto b = bspline_weights(x - base[i]);
    w[i][0] = b.n0, w[i][1] = b.n1, w[i][2] = b.n2;
  }
  for (int k = 0; k < 3; ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 3; ++i) {
        const Index3 index{base[0] + i, base[1] + j, base[2] + k};
        const Vec3 distance(cell_size_ * index[0] - position[0], cell_size_ * index[1] - position[1], cell_size_ * index[2] - position[2]);
        f(index, w[0][i] * w[1][j] * w[2][k], distance);
      }
    }
  }
}

void PlainGrid::scatter(const std::vector<Particle>& particles, const TransferOptions& options) {
  for (const Particle& p : particles) {
    const double mass = options.density * p.volume, force = options.dt * p.volume * 4.0 / (cell_size_ * cell_size_);
    const double* s = p.stress;
    Mat3 stress;
    stress << s[0], s[3], s[4], s[3], s[1], s[5], s[4], s[5], s[2];
    const Eigen::Map<const Mat3> c(p.affine);
    const double compression = std::max(-c.trace(), 0.0);
    stress -= options.density * cell_size_ * cell_size_ * compression *
              std::min(options.shock_viscosity * compression, shock_stability / options.dt) * Mat3::Identity();
    const Mat3 affine = mass * c - force * stress;
    const Vec3 momentum = mass * Eigen::Map<const Vec3>(p.velocity);
    for_each_weight(p.position, [&](const Index3& index, double w, const Vec3& distance) {
      const Vec3 part = w * (momentum + affine * distance);
      node(index) += Node{part.x(), part.y(), part.z(), w * mass};
    });
  }
}

void PlainGrid::update(const Scene& scene, double dt, double time) {
  Index3 index{};
  for (index[2] = low_[2]; index[2] < low_[2] + size_[2]; ++index[2]) {
    for (index[1] = low_[1]; index[1] < low_[1] + size_[1]; ++index[1]) {
      for (index[0] = low_[0]; index[0] < low_[0] + size_[0]; ++index[0]) {
        Node& n = node(index);
        if (n[3] <= 0.0) continue;
        Vec3 v = Vec3(n[0], n[1], n[2]) / n[3] + dt * scene.gravity;
        const Vec3 position = cell_size_ * Vec3(index[0], index[1], index[2]);
        for (const Boundary& boundary : scene.boundaries) {
          std::visit(
              [&](const auto& b) {
                if constexpr (HasConstrain<std::decay_t<decltype(b)>>) {
                  v = b.covers(position, time) ? b.constrain(position, v, time) : v;
                } else {
                  fail("the plain reference knows boundaries only that act on each node by itself");
                }
              },
              boundary);
        }
        n = Node{v.x(), v.y(), v.z(), n[3]};
      }
    }
  }
}

void PlainGrid::gather(Particle& p, double dt) const {
  Vec3 velocity = Vec3::Zero();
  Mat3 affine = Mat3::Zero();
  for_each_weight(p.position, [&](const Index3& index, double w, const Vec3& distance) {
    const Node& n = node(index);
    const Vec3 v(n[0], n[1], n[2]);
    velocity += w * v;
    affine += (w * 4.0 / (cell_size_ * cell_size_)) * v * distance.transpose();
  });
  Eigen::Map<Vec3>(p.velocity) = velocity;
  Eigen::Map<Mat3>(p.affine) = affine;
  Eigen::Map<Vec3>(p.position) += dt * velocity;
}

void apply_law_plainly(Particle& p, const AnyMaterial& material, double dt) {
  Matrix3<double> dl{};
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) dl.m[i][j] = dt * p.affine[3 * j + i];
  }
  MaterialState<double> state{{p.stress[0], p.stress[1], p.stress[2], p.stress[3], p.stress[4], p.stress[5]}, p.internal};
  std::visit([&](const auto& law) { law.update_stress(state, dl, dt); }, material);
  const Sym3<double>& s = state.stress;
  const double stress[6] = {s.xx, s.yy, s.zz, s.xy, s.xz, s.yz};
  std::copy(std::begin(stress), std::end(stress), p.stress);
  p.internal = state.internal;
}

void check_scatter(const Grid& grid, const TransferOptions& options) {
  const std::vector<Particle> particles = copy_particles(grid);
  PlainGrid plain(particles, grid.cell_size());
  plain.scatter(particles, options);
  const Node scale = plain.largest();
  const double momentum_scale = std::max({scale[0], scale[1], scale[2]});
  for (const auto b : grid.own_blocks()) {
    for (int n = 0; n < block_nodes; ++n) {
      const Index3& c = grid.block(b).coordinate;
      const Index3 index = node_index(c, n);
      const Node expected = plain.contains(index) ? plain.node(index) : Node{}, found = grid.momenta(b).node[n];
      for (int i = 0; i < 4; ++i) {
        const double tolerance = sum_tolerance * (i < 3 ? momentum_scale : scale[3]);
        if (!(std::abs(found[i] - expected[i]) <= tolerance))
          fail(fmt::format("component {} of node ({}, {}, {}) is {:.17g}, expected {:.17g}, allowed difference {:.3g}", i, index[0],
                           index[1], index[2], found[i], expected[i], tolerance));
      }
    }
  }
}

void check_nodes_and_gather(const Problem& problem, const std::vector<Particle>& before, const TransferOptions& scattered) {
  const Grid& grid = problem.state.grid;
  PlainGrid plain(before, grid.cell_size());
  plain.scatter(before, scattered);
  plain.update(problem.scene, scattered.dt, problem.state.time);
  const std::vector<Particle> after = copy_particles(grid);
  if (after.size() != before.size()) fail("the number of particles changed");
  const Node scale = plain.largest();
  for (std::size_t i = 0; i < after.size(); ++i) {
    Particle expected = before[i];
    plain.gather(expected, 0.0);
    compare_motion(after[i], expected, std::max({scale[0], scale[1], scale[2]}), grid.cell_size());
  }
}

void check_law(const Problem& problem, const std::vector<Particle>& before, double dt) {
  const std::vector<Particle> after = copy_particles(problem.state.grid);
  if (after.size() != before.size()) fail("the number of particles changed");
  const double shear = shear_modulus(problem.scene.material);
  for (std::size_t i = 0; i < after.size(); ++i) {
    Particle expected = before[i];
    apply_law_plainly(expected, problem.scene.material, dt);
    compare_stress(after[i], expected, law_tolerance, shear);
  }
}

void check_step(const Problem& problem, const std::vector<Particle>& before, double dt, double time_before) {
  const Grid& grid = problem.state.grid;
  PlainGrid plain(before, grid.cell_size());
  plain.scatter(before, transfer_options(problem.scene, dt));
  plain.update(problem.scene, dt, time_before);
  const Node scale = plain.largest();
  const double speed = std::max({scale[0], scale[1], scale[2]}), shear = shear_modulus(problem.scene.material);
  std::vector<std::optional<Particle>> after(problem.state.next_id);
  grid.for_each_particle([&](const Particle& p) { after[p.id] = p; });
  for (Particle expected : before) {
    const std::optional<Particle>& p = after[expected.id];
    if (!p) fail(fmt::format("particle {} is gone", expected.id));
    plain.gather(expected, dt);
    compare_motion(*p, expected, speed, grid.cell_size());
    apply_law_plainly(expected, problem.scene.material, dt);
    compare_stress(*p, expected, step_tolerance, shear);
  }
  check_order(grid, before.size());
}

void check_order(const Grid& grid, std::uint64_t particles) {
  std::uint64_t count = 0, id_sum = 0;
  for (const auto b : grid.occupied_blocks()) {
    const Block& block = grid.block(b);
    const ParticleBin& bin = block.particles;
    for (int cell = 0; cell < block_nodes; ++cell) {
      for (int n = bin.cell_start[cell]; n < bin.cell_start[cell + 1]; ++n) {
        const Particle p = bin[bin.order[static_cast<std::size_t>(n)]];
        ++count;
        id_sum += p.id;
        for (int axis = 0; axis < 3; ++axis) {
          const double offset = p.position[axis] / grid.cell_size() - node_index(block.coordinate, cell)[static_cast<std::size_t>(axis)];
          constexpr double tie = 1e-9;  // at an exact tie both neighbours are correct
          if (!(offset >= 0.5 - tie && offset <= 1.5 + tie))
            fail(fmt::format("particle {} is filed under a cell {:.3g} cells away", p.id, offset - 1.0));
        }
      }
    }
  }
  if (count != particles) fail(fmt::format("{} particles are filed, expected {}", count, particles));
  if (id_sum != particles * (particles - 1) / 2) fail("some particle is filed twice and another is lost");
}

}  // namespace mpm::benchmarks
