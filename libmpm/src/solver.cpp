#include "mpm/solver.hpp"

#include <fmt/format.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>

#include "mpm/diagnostics.hpp"
#include "mpm/error.hpp"
#include "mpm/stress.hpp"

namespace mpm {

namespace {

constexpr double collapse_ratio = 1e-4;  ///< a step below this share of the step at rest is a collapse: the run would never end

bool finite(const Particle& p) {
  double sum = 0.0;
  for (const double v : p.position) sum += 0.0 * v;
  for (const double v : p.velocity) sum += 0.0 * v;
  for (const double v : p.affine) sum += 0.0 * v;
  for (const double v : p.stress) sum += 0.0 * v;
  return sum + 0.0 * p.internal == 0.0;
}

/// det(I + dt C): by how much the last step stretched the particle's volume; not above 0 where it turned it inside out.
double volume_stretch(const Particle& p, double dt) { return (Mat3::Identity() + dt * Eigen::Map<const Mat3>(p.affine)).determinant(); }

/// Which particle of a block ended the run: of those with a fault the one turned inside out, for the others may have it from there; else
/// the fastest, if one went too far; else the first by number.
const Particle& culprit_of(const ParticleBin& bin, double dt, const BlockMotion& motion) {
  const auto suspicion = [&](const Particle& p) {
    if (motion.finite) return Eigen::Map<const Vec3>(p.velocity).squaredNorm();
    return finite(p) ? 0.0 : volume_stretch(p, dt) <= 0.0 ? 2.0 : 1.0;
  };
  const Particle* worst = &bin[0];
  for (int s = 1; s < bin.count(); ++s) {
    const double mine = suspicion(bin[s]), worse = suspicion(*worst);
    if (mine > worse || (mine == worse && bin[s].id < worst->id)) worst = &bin[s];
  }
  return *worst;
}

[[noreturn]] void throw_unstable(const State& state, const Vec3& offset, double dt, std::int32_t block, const BlockMotion& motion) {
  const Particle& p = culprit_of(state.grid.block(block).particles, dt, motion);
  const double stretch = volume_stretch(p, dt);
  const std::string what = motion.finite    ? "displacement of more than a block of four cells in one step"
                           : stretch <= 0.0 ? fmt::format("inversion (the step turned it inside out, det(I + dt C) = {:.3g})", stretch)
                                            : "a value that is not finite (NaN or infinite)";
  // a position that is lost itself is told by its block
  const Index3& c = state.grid.block(block).coordinate;
  const Vec3 centre = state.grid.cell_size() * (4.0 * Vec3(c[0], c[1], c[2]) + Vec3::Constant(2.5));
  const Vec3 position(p.position[0], p.position[1], p.position[2]);
  const Vec3 where = (position.allFinite() ? position : centre) - offset;
  throw UnstableError(fmt::format(
      "unstable at t = {:.6g} s, step {} (dt = {:.3g} s): {} of particle {} {} ({:.4g}, {:.4g}, {:.4g}) m; velocity ({:.4g}, {:.4g}, "
      "{:.4g}) m/s, pressure {:.4g} Pa. Try a smaller [numerics] cfl, a finer cell_size_m, or look for a body that starts inside a wall "
      "or another body",
      state.time, state.step, dt, what, p.id, position.allFinite() ? "at" : "near", where.x(), where.y(), where.z(), p.velocity[0],
      p.velocity[1], p.velocity[2], -(p.stress[0] + p.stress[1] + p.stress[2]) / 3.0));
}

/// Removes the particles of a block that are outside the domain.
Passage remove_outside(Grid& grid, std::int32_t index, const Scene& scene) {
  const Vec3 &min = scene.domain_min, &max = scene.domain_max;
  const double dx = grid.cell_size();
  const Index3& c = grid.block(index).coordinate;
  const Vec3 low = dx * (4.0 * Vec3(c[0], c[1], c[2]) + Vec3::Constant(0.5 - 4.0));  // positions a step can lead to from this block
  const Vec3 high = low + Vec3::Constant(12.0 * dx);
  Passage left;
  if ((low.array() >= min.array()).all() && (high.array() <= max.array()).all()) return left;
  ParticleBin& bin = grid.block(index).particles;
  for (int s = bin.count() - 1; s >= 0; --s) {
    const Particle& p = bin[s];
    const Vec3 x(p.position[0], p.position[1], p.position[2]);
    if ((x.array() >= min.array()).all() && (x.array() <= max.array()).all()) continue;
    const double mass = density_of(scene.material) * p.volume;
    left += Passage{1, x.x() > max.x() ? 1U : 0U, mass, mass * Vec3(p.velocity[0], p.velocity[1], p.velocity[2]),
                    kinetic_and_elastic_energy(p, scene, dx)};
    grid.remove(index, s);
  }
  return left;
}

/// Velocities before forces, which FLIP needs beside the new ones.
void store_old_velocities(State& state, const Scene& scene, TransferOptions options) {
  options.dt = 0.0;
  particle_to_grid(state.grid, options);
  fold_mirror_planes(state.grid, scene.mirror_x, scene.mirror_y);
  const auto all = state.grid.all_blocks();
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < all.size(); ++i) {
    for (int n = 0; n < block_nodes; ++n) {
      const Node node = state.grid.nodes(all[i]).node[n];
      state.grid.old_nodes(all[i]).node[n] = node[3] > 0.0 ? node * (1.0 / node[3]) : Node{};
    }
  }
}

/// Velocity, position and stress of all particles; those that left their block are in its outbox, those that left the domain are gone.
Passage move_particles(State& state, const Scene& scene, const TransferOptions& options) {
  Grid& grid = state.grid;
  const auto blocks = grid.occupied_blocks();
  std::vector<BlockMotion> motion(blocks.size());
  std::vector<Passage> left(blocks.size());
  bool out_of_memory = false;
#pragma omp parallel for schedule(dynamic, blocks_at_a_time)
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    try {
      motion[i] = grid_to_particle(grid, blocks[i], options, moved_next(blocks, i));
      motion[i].finite = update_stress(grid, blocks[i], scene.material, options.dt);
      if (!motion[i].finite || !motion[i].within_reach) continue;
      left[i] = remove_outside(grid, blocks[i], scene);
      collect_migrants(grid, blocks[i], motion[i]);
    } catch (const std::bad_alloc&) {  // no exception may leave a parallel region
#pragma omp atomic write
      out_of_memory = true;
    }
  }
  if (out_of_memory) throw std::bad_alloc();
  Passage sum;
  double max_speed_squared = 0.0;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    if (!motion[i].finite || !motion[i].within_reach) throw_unstable(state, scene.offset, options.dt, blocks[i], motion[i]);
    max_speed_squared = std::max(max_speed_squared, motion[i].max_speed_squared);
    sum += left[i];
  }
  state.max_speed = std::sqrt(max_speed_squared);
  return sum;
}

}  // namespace

double stable_time_step(const AnyMaterial& material, double cfl, double cell_size, double max_speed) {
  const double dt = cfl * cell_size / (wave_speed_of(material) + max_speed), viscosity = viscosity_of(material);
  return viscosity > 0.0 ? std::min(dt, cfl * density_of(material) * cell_size * cell_size / (2.0 * viscosity)) : dt;
}

double stable_time_step(const State& state, const Scene& scene) {
  const double dx = state.grid.cell_size();
  const double dt = stable_time_step(scene.material, scene.cfl, dx, state.max_speed);
  const double at_rest = stable_time_step(scene.material, scene.cfl, dx, 0.0);
  if (!(dt >= collapse_ratio * at_rest)) {
    throw UnstableError(
        fmt::format("the time step collapsed at t = {:.6g} s, step {}: {:.3g} s, at rest it is {:.3g} s, because the fastest particle "
                    "moves at {:.4g} m/s. "
                    "Try a smaller [numerics] cfl or a finer cell_size_m",
                    state.time, state.step, dt, at_rest, state.max_speed));
  }
  return dt;
}

StepReport step(State& state, const Scene& scene, double dt) {
  StepReport report;
  report.dt = dt;
  TransferOptions options{dt, density_of(scene.material), scene.transfer == Transfer::apic, scene.flip_ratio};
  Grid& grid = state.grid;

  if (scene.feed) report.entered = scene.feed->release(state);
  if (!options.apic) store_old_velocities(state, scene, options);
  particle_to_grid(grid, options);  // m_i, p_i + dt f_i
  fold_mirror_planes(grid, scene.mirror_x, scene.mirror_y);
  const double mass = update_grid(grid, scene.boundaries, scene.gravity, dt, state.time, scene.mirror_x, scene.mirror_y, report.impulses,
                                  scene.obstacle, &report.obstacle_layers);
  report.gravity_impulse = dt * mass * scene.gravity;
  report.left = move_particles(state, scene, options);  // v_p, C_p, x_p, then the law: tau_p
  grid.migrate();                                       // blocks and cells again in order

  state.time += dt;
  ++state.step;
  state.entered += report.entered;
  state.left += report.left;
  return report;
}

void advance(State& state, const Scene& scene, double time, const std::function<void(const StepReport&)>& after) {
  while (state.time < time) {
    const double dt = stable_time_step(state, scene);
    const double rest = time - state.time;
    const bool last = rest <= dt;
    const StepReport report = step(state, scene, last ? rest : rest < 2.0 * dt ? 0.5 * rest : dt);
    if (last) state.time = time;
    if (after) after(report);
  }
}

}  // namespace mpm
