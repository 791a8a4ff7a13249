#include "libmpm/core/step.hpp"

#include <omp.h>

#include <Eigen/LU>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>

#include "libmpm/base/error.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/base/thread_time.hpp"
#include "libmpm/core/block_sums.hpp"
#include "libmpm/core/diagnostics.hpp"
#include "libmpm/core/joined_blocks.hpp"
#include "libmpm/core/lumped_mass.hpp"
#include "libmpm/core/particle_contact.hpp"
#include "libmpm/core/stress_update.hpp"

namespace mpm {

namespace {

constexpr double collapse_ratio = 1e-4;  ///< a step below this fraction of the step at rest is a collapse: the run would never end

bool finite(const Particle& p) {
  double sum = 0.0;
  for (const double v : p.position) sum += 0.0 * v;
  for (const double v : p.velocity) sum += 0.0 * v;
  for (const double v : p.affine) sum += 0.0 * v;
  for (const double v : p.stress) sum += 0.0 * v;
  return sum + 0.0 * p.internal == 0.0;
}

/// det(I + dt C): ratio of the particle's volumes after and before the last step; at most 0 if the step turned it inside out.
double volume_stretch(const Particle& p, double dt) { return (Mat3::Identity() + dt * Eigen::Map<const Mat3>(p.affine)).determinant(); }

/// The particle of a block to name in the error message. If values are not finite: one that was turned inside out, because it may have
/// spread to the others; else the first with a bad value. If a particle moved too far: the fastest.
Particle culprit_of(const ParticleBin& bin, double dt, const BlockMotion& motion) {
  const auto severity = [&](const Particle& p) {
    if (motion.finite) return Eigen::Map<const Vec3>(p.velocity).squaredNorm();
    return finite(p) ? 0.0 : volume_stretch(p, dt) <= 0.0 ? 2.0 : 1.0;
  };
  Particle worst = bin[0];
  for (int s = 1; s < bin.count(); ++s) {
    const Particle p = bin[s];
    const double own = severity(p), largest = severity(worst);
    if (own > largest || (own == largest && p.id < worst.id)) worst = p;
  }
  return worst;
}

std::string instability(const State& state, const Vec3& offset, double dt, std::int32_t block, const BlockMotion& motion) {
  const Particle p = culprit_of(state.grid.block(block).particles, dt, motion);
  const double stretch = volume_stretch(p, dt);
  const std::string what = motion.finite    ? "displacement of more than a block of four cells in one step"
                           : stretch <= 0.0 ? "inversion (the step turned it inside out, det(I + dt C) = " + number_text(stretch, 3) + ")"
                                            : "a value that is not finite (NaN or infinite)";
  // if the position itself is not finite, give the centre of the block
  const Index3& c = state.grid.block(block).coordinate;
  const Vec3 centre = block_box(c, state.grid.cell_size()).center();
  const Vec3 position = position_of(p);
  const bool known = position.allFinite();
  return "unstable at t = " + number_text(state.time) + " s, step " + std::to_string(state.step) + " (dt = " + number_text(dt, 3) +
         " s): " + what + " of particle " + std::to_string(p.id) + (known ? " at " : " near ") +
         vector_text((known ? position : centre) - offset) + " m; velocity " + vector_text(p.velocity) + " m/s, pressure " +
         number_text(-(p.stress[0] + p.stress[1] + p.stress[2]) / 3.0, 4) +
         " Pa. Try a smaller CFL number or a finer grid, or look for a body that starts inside a boundary or another body";
}

/// Removes the particles of a block that are outside the domain. Call it while those that leave the block are still in it.
FluxTotals remove_outside(Grid& grid, std::int32_t index, const Scene& scene) {
  const Eigen::AlignedBox3d domain(scene.domain_min, scene.domain_max);
  const double dx = grid.cell_size();
  const Index3& block = grid.block(index).coordinate;
  FluxTotals left;
  if (domain.contains(block_box(block, dx, block_edge))) return left;  // as far as a particle moves in a step
  ParticleBin& bin = grid.block(index).particles;
  const bool only_leavers = domain.contains(block_box(block, dx));
  const auto before = [&](int s) { return only_leavers ? bin.last_leaver(s) : s - 1; };
  with_record_type(grid.precision(), [&](auto record) {
    for (int s = before(bin.count()); s >= 0; s = before(s)) {
      const Vec3 x = position_of(bin.record<decltype(record)>(s), bin.frame);
      if (domain.contains(x)) continue;
      const Particle p = bin[s];
      const double mass = density_of(scene.material) * p.volume;
      left += FluxTotals{1, x.x() > domain.max().x() ? 1U : 0U, mass, mass * velocity_of(p), kinetic_and_elastic_energy(p, scene, dx)};
      grid.remove(index, s);
    }
  });
  return left;
}

/// Fraction of the velocity that the grid cannot represent which particles keep in a step of length dt (transfer.hpp).
double kept_fraction(const State& state, const Scene& scene, double dt) {
  switch (scene.numerics.transfer) {
    case Transfer::flip: return scene.numerics.flip_ratio;
    case Transfer::aflip: {
      const double speed = wave_speed_of(scene.material) + state.max_speed;
      return 1.0 - std::min(1.0, dt * speed / (scene.numerics.relaxation_cells * state.grid.cell_size()));
    }
    case Transfer::apic: break;
  }
  return 0.0;
}

/// Uses one thread for a step with so little work that waking the others costs more than it saves. The results have the same bits.
class ThreadsForWork {
 public:
  explicit ThreadsForWork(std::size_t particles) : threads_(omp_get_max_threads()) {
    constexpr std::size_t fewest = 4000;  // about 0.3 ms of one core; the loops of a step need some 0.05 ms to start and to end
    if (particles < fewest) omp_set_num_threads(1);
  }
  ~ThreadsForWork() { omp_set_num_threads(threads_); }
  ThreadsForWork(const ThreadsForWork&) = delete;
  ThreadsForWork& operator=(const ThreadsForWork&) = delete;

 private:
  int threads_;
};

using Clock = std::chrono::steady_clock;
double seconds(Clock::time_point from, Clock::time_point to) { return std::chrono::duration<double>(to - from).count(); }

/// Adds the time since the last call to one of the phases; does nothing if the caller passed no StepTimes.
class PhaseTimer {
 public:
  explicit PhaseTimer(const StepTimes* times) : wanted_(times != nullptr) { restart(); }
  void restart() {
    if (wanted_) last_ = Clock::now();
  }
  void add_to(double& phase) {
    if (!wanted_) return;
    const auto now = Clock::now();
    phase += seconds(last_, now);
    last_ = now;
  }

 private:
  bool wanted_;
  Clock::time_point last_;
};

/// Sum over the blocks of all ranks.
FluxTotals sum_of(std::span<const FluxTotals> parts, Ranks* ranks) {
  constexpr std::size_t counts = 2;  // its first members
  BlockSums sums(sizeof(FluxTotals) / sizeof(double));
  for (const FluxTotals& part : parts) {
    if (part.count > 0) sums.add_part<counts>(0, part);
  }
  sums.add_ranks(ranks);
  return sums.part<FluxTotals, counts>(0);
}

/// Updates velocity, position and stress of all particles, and holds them outside of solids. Puts those that left their block into its
/// outbox, and removes those that left the domain. Particles of outer blocks come last, when the nodes of other ranks have arrived.
/// @param part  the impulses on solids are added to it
FluxTotals move_particles(State& state, const Scene& scene, const TransferOptions& options, GridUpdatePart& part, StepTimes* times) {
  Grid& grid = state.grid;
  Ranks* const ranks = grid.ranks();
  const bool measured = ranks != nullptr && ranks->measures();
  const auto blocks = grid.occupied_blocks();
  std::vector<BlockMotion> motion(blocks.size());
  std::vector<FluxTotals> left(blocks.size());
  const ParticleContact contact(scene.boundaries);
  std::vector<std::vector<ParticleContact::Taken>> taken(blocks.size());
  bool out_of_memory = false;
  double gather_time = 0.0, stress_time = 0.0, sort_time = 0.0, loop_time = 0.0;
  PhaseTimer loop_timer(times);
  const auto move = [&](bool outer) {
#pragma omp parallel for schedule(dynamic, blocks_at_a_time) reduction(+ : gather_time, stress_time, sort_time)
    for (std::size_t i = 0; i < blocks.size(); ++i) {
      Block& block = grid.block(blocks[i]);
      if (block.outer != outer) continue;
      try {
        PhaseTimer timer(times);
        const double start = measured ? thread_seconds() : 0.0;
        const int particles = block.particles.count();
        motion[i] = grid_to_particle(grid, blocks[i], options, moved_next(blocks, i));
        taken[i] = contact.hold(grid, blocks[i], options.density);
        timer.add_to(gather_time);
        motion[i].finite = update_stress(grid, blocks[i], scene.material, options.dt);
        timer.add_to(stress_time);
        if (!motion[i].finite || !motion[i].within_reach) continue;
        left[i] = remove_outside(grid, blocks[i], scene);
        collect_migrants(grid, blocks[i], motion[i]);
        timer.add_to(sort_time);
        if (measured) ranks->note_time(block, blocks[i], particles, thread_seconds() - start);
      } catch (const std::bad_alloc&) {  // no exception may leave a parallel region
#pragma omp atomic write
        out_of_memory = true;
      }
      if (ranks != nullptr && omp_get_thread_num() == 0) ranks->progress();
    }
  };
  move(false);
  if (ranks != nullptr) {
    ranks->receive_nodes(grid);
    move(true);
  }
  if (out_of_memory) throw std::bad_alloc();
  loop_timer.add_to(loop_time);
  if (const double threads_time = gather_time + stress_time + sort_time; threads_time > 0.0) {
    times->grid_to_particle += loop_time * gather_time / threads_time;
    times->stress += loop_time * stress_time / threads_time;
    times->sort += loop_time * sort_time / threads_time;
  }
  double max_speed_squared = 0.0;
  std::optional<BlockError> error;
  for (std::size_t i = 0; i < blocks.size() && !error; ++i) {
    if (!motion[i].finite || !motion[i].within_reach)
      error = BlockError{grid.block(blocks[i]).coordinate, instability(state, scene.offset, options.dt, blocks[i], motion[i])};
    max_speed_squared = std::max(max_speed_squared, motion[i].max_speed_squared);
  }
  if (ranks != nullptr) {
    max_speed_squared = ranks->agree(max_speed_squared, error);
  } else if (error) {
    throw UnstableError(error->text);
  }
  state.max_speed = std::sqrt(max_speed_squared);
  for (const auto& of_block : taken) {
    for (const ParticleContact::Taken& t : of_block) part.add_to_contact(t.boundary, t.layer, t.impulse);
  }
  return sum_of(left, ranks);
}

}  // namespace

double stable_time_step(const AnyMaterial& material, double cfl, double cell_size, double max_speed) {
  const double dt = cfl * cell_size / (wave_speed_of(material) + max_speed), viscosity = viscosity_of(material);
  return viscosity > 0.0 ? std::min(dt, cfl * density_of(material) * cell_size * cell_size / (2.0 * viscosity)) : dt;
}

double stable_time_step(const State& state, const Scene& scene) {
  const double dx = state.grid.cell_size();
  const double dt = stable_time_step(scene.material, scene.numerics.cfl, dx, state.max_speed);
  const double at_rest = stable_time_step(scene.material, scene.numerics.cfl, dx, 0.0);
  if (!(dt >= collapse_ratio * at_rest)) {
    throw UnstableError("the time step collapsed at t = " + number_text(state.time) + " s, step " + std::to_string(state.step) + ": " +
                        number_text(dt, 3) + " s, at rest it is " + number_text(at_rest, 3) + " s, because the fastest particle moves at " +
                        number_text(state.max_speed, 4) + " m/s. Try a smaller CFL number or a finer grid");
  }
  return dt;
}

StepReport step(State& state, const Scene& scene, double dt, StepTimes* times) {
  if (Ranks* const ranks = state.grid.ranks()) {
    ranks->instruct(Task::step, state, dt);
    ranks->prepare(state.grid, JoinedBlocks(scene, state.grid.cell_size(), state.time));
  }
  StepReport report;
  report.dt = dt;
  const TransferOptions options{.dt = dt,
                                .density = density_of(scene.material),
                                .affine = scene.numerics.transfer != Transfer::flip,
                                .kept = kept_fraction(state, scene, dt),
                                .shock_viscosity = keeps_compaction(scene.material) ? scene.numerics.shock_viscosity : 0.0};
  Grid& grid = state.grid;
  const ThreadsForWork threads(grid.particle_count());
  StepTimes unused;
  StepTimes& spent = times != nullptr ? *times : unused;
  PhaseTimer timer(times);

  if (scene.source) report.entered = scene.source->release(state);
  timer.add_to(spent.source);

  grid.keep_old_nodes(options.kept > 0.0 || need_lumped_mass_correction(scene.boundaries));
  particle_to_grid(grid, options);  // m_i, p_i, dt f_i
  timer.add_to(spent.particle_to_grid);

  fold_mirror_planes(grid, scene.mirror);
  const GridForces forces{scene.boundaries, scene.layered, scene.gravity, scene.mirror, options.density, 1.0 - options.kept};
  GridUpdatePart part = update_grid(grid, forces, dt, state.time);  // v_i, contact
  if (grid.ranks() != nullptr) grid.ranks()->send_nodes(grid);
  timer.add_to(spent.grid_update);

  report.left = move_particles(state, scene, options, part, times);  // v_p, C_p, x_p, then the law: tau_p
  timer.restart();
  GridUpdate update = std::move(part).sum(grid.ranks());
  timer.add_to(spent.grid_update);
  grid.migrate();  // into their new blocks; sorts by cell
  timer.add_to(spent.sort);

  report.gravity_impulse = dt * update.mass * scene.gravity;
  report.impulses = std::move(update.impulses);
  report.layers = std::move(update.layers);
  state.time += dt;
  ++state.step;
  state.entered += report.entered;
  state.left += report.left;
  if (grid.ranks() != nullptr) grid.ranks()->done();
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
