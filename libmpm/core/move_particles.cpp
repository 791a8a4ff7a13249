#include "libmpm/core/move_particles.hpp"

#include <omp.h>

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <optional>

#include "libmpm/base/process.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/core/diagnostics.hpp"
#include "libmpm/core/particle_contact.hpp"
#include "libmpm/core/stress_update.hpp"

namespace mpm {

namespace {

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

/// Sum over the blocks of all ranks.
FluxTotals sum_of(std::span<const FluxTotals> parts, RankGroup& ranks) {
  constexpr std::size_t counts = 2;  // its first members
  BlockSums sums(sizeof(FluxTotals) / sizeof(double));
  for (const FluxTotals& part : parts) {
    if (part.count > 0) sums.add_members<counts>(0, part);
  }
  sums.add_ranks(ranks);
  return sums.members<FluxTotals, counts>(0);
}

constexpr double StepTimes::*phases_of_the_loop[] = {&StepTimes::grid_to_particle, &StepTimes::stress, &StepTimes::sort};

/// Adds the wall time of the loop to its phases, in the ratio of the times that the threads spent in them.
void add_loop(StepTimes& times, double loop, const StepTimes& threads) {
  const double all = threads.total();
  if (all == 0.0) return;
  for (const auto phase : phases_of_the_loop) times.*phase += loop * threads.*phase / all;
}

/// det(I + dt C): ratio of the particle's volumes after and before the last step; at most 0 if the step turned it inside out.
double volume_stretch(const Particle& p, double dt) { return (Mat3::Identity() + dt * Eigen::Map<const Mat3>(p.affine)).determinant(); }

/// The particle of a block to name in the error message. If values are not finite: one that was turned inside out, because it may have
/// spread to the others; else the first with a bad value. If a particle moved too far: the fastest.
Particle culprit_of(const ParticleBin& bin, double dt, const BlockMotion& motion) {
  const auto severity = [&](const Particle& p) {
    if (motion.finite) return Eigen::Map<const Vec3>(p.velocity).squaredNorm();
    return all_finite(p) ? 0.0 : volume_stretch(p, dt) <= 0.0 ? 2.0 : 1.0;
  };
  Particle worst = bin[0];
  for (int s = 1; s < bin.count(); ++s) {
    const Particle p = bin[s];
    const double own = severity(p), largest = severity(worst);
    if (own > largest || (own == largest && p.id < worst.id)) worst = p;
  }
  return worst;
}

/// What went wrong in a step of length dt with one of the particles of a block: which particle, where, with which values, and the remedy.
/// @param motion  not finite, or not within reach
std::string instability_text(const State& state, const Scene& scene, double dt, std::int32_t block, const BlockMotion& motion) {
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
  const double pressure = -(p.stress[0] + p.stress[1] + p.stress[2]) / 3.0;
  return "unstable at t = " + number_text(state.time) + " s, step " + std::to_string(state.step) + " (dt = " + number_text(dt, 3) +
         " s): " + what + " of particle " + std::to_string(p.id) + (known ? " at " : " near ") +
         vector_text((known ? position : centre) - scene.offset) + " m; velocity " + vector_text(p.velocity) + " m/s" +
         (std::isfinite(pressure) ? ", pressure " + number_text(pressure, 4) + " Pa" : "") +
         ". Try a smaller CFL number or a finer grid, or look for a body that starts inside a boundary or another body";
}

}  // namespace

FluxTotals move_particles(State& state, const Scene& scene, const TransferOptions& options, ImpulseRecord& impulses, StepTimes* times) {
  Grid& grid = state.grid;
  Ranks& ranks = grid.ranks();
  const bool measured = ranks.measures();
  const auto blocks = grid.occupied_blocks();
  std::vector<BlockMotion> motion(blocks.size());
  std::vector<FluxTotals> left(blocks.size());
  std::vector<std::vector<ParticleImpulse>> taken(blocks.size());
  bool out_of_memory = false;
  StepTimes loop, of_threads;
  const auto move = [&](bool outer) {
#pragma omp parallel
    {
      StepTimes of_thread;
      const PhaseTimer timed(times != nullptr ? &of_thread : nullptr);
#pragma omp for schedule(dynamic, blocks_at_a_time) nowait
      for (std::size_t i = 0; i < blocks.size(); ++i) {
        Block& block = grid.block(blocks[i]);
        if (block.outer != outer) continue;
        const std::int32_t after = moved_next(blocks, i);
        const std::int32_t next = after != no_block && grid.block(after).outer == outer ? after : no_block;  // no block that has moved
        try {
          const double start = measured ? thread_seconds() : 0.0;
          const int particles = block.particles.count();
          timed(&StepTimes::grid_to_particle, [&] {
            motion[i] = grid_to_particle(grid, blocks[i], options, next);  // v_p, C_p, x_p
            taken[i] = return_to_surface(grid, blocks[i], scene.boundaries, state.time + options.dt, options.density);
          });
          timed(&StepTimes::stress, [&] { motion[i].finite = update_stress(grid, blocks[i], scene.material, options.dt); });  // tau_p
          if (!motion[i].finite || !motion[i].within_reach) continue;
          timed(&StepTimes::sort, [&] {
            left[i] = remove_outside(grid, blocks[i], scene);
            motion[i].within_reach = collect_migrants(grid, blocks[i]);
          });
          if (measured) ranks.note_time(block, blocks[i], particles, thread_seconds() - start);
        } catch (const std::bad_alloc&) {  // no exception may leave a parallel region
#pragma omp atomic write
          out_of_memory = true;
        }
        if (omp_get_thread_num() == 0) ranks.progress();
      }
#pragma omp critical
      for (const auto phase : phases_of_the_loop) of_threads.*phase += of_thread.*phase;
    }
  };
  PhaseTimer(times != nullptr ? &loop : nullptr)(&StepTimes::grid_to_particle, [&] {
    move(false);
    ranks.receive_nodes(NodeFields(grid));
    if (ranks.size() > 1) move(true);
  });
  if (out_of_memory) throw std::bad_alloc();
  if (times != nullptr) add_loop(*times, loop.grid_to_particle, of_threads);

  double max_speed_squared = 0.0;
  std::optional<BlockError> error;
  for (std::size_t i = 0; i < blocks.size() && !error; ++i) {
    if (!motion[i].finite || !motion[i].within_reach)
      error = BlockError{grid.block(blocks[i]).coordinate, instability_text(state, scene, options.dt, blocks[i], motion[i])};
    max_speed_squared = std::max(max_speed_squared, motion[i].max_speed_squared);
  }
  state.max_speed = std::sqrt(ranks.largest_or_throw(max_speed_squared, error));
  for (const auto& of_block : taken) {
    for (const ParticleImpulse& t : of_block) {
      if (std::holds_alternative<SurfaceSolid>(scene.boundaries[t.boundary]))
        impulses.add_to_contact(t.boundary, t.layer, t.impulse);
      else
        impulses.add_impulse(t.boundary, t.impulse);
    }
  }
  return sum_of(left, ranks);
}

}  // namespace mpm
