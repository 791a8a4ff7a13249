#include "libmpm/core/step.hpp"

#include <omp.h>

#include <algorithm>

#include "libmpm/base/error.hpp"
#include "libmpm/base/text.hpp"
#include "libmpm/core/lumped_mass.hpp"
#include "libmpm/core/move_particles.hpp"

namespace mpm {

namespace {

/// Fraction that particles retain in a step of length dt of the velocity that the grid cannot represent (transfer.hpp).
double retained_fraction(const State& state, const Scene& scene, double dt) {
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

constexpr double collapse_ratio = 1e-4;  ///< a step below this fraction of the step at rest is a collapse: the run would never end

/// Sets OpenMP to one thread until the end of the scope, on all ranks alike, where waking the others costs more than it saves. Same bits.
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

}  // namespace

StepReport step(State& state, const Scene& scene, double dt, StepTimes* times) {
  Grid& grid = state.grid;
  Ranks& ranks = grid.ranks();
  ranks.begin_step(state, scene, dt);
  const TransferOptions options{.dt = dt,
                                .density = density_of(scene.material),
                                .affine = scene.numerics.transfer != Transfer::flip,
                                .retained = retained_fraction(state, scene, dt),
                                .shock_viscosity = keeps_compaction(scene.material) ? scene.numerics.shock_viscosity : 0.0};
  const GridConditions conditions{.boundaries = scene.boundaries,
                                  .layered = scene.layered,
                                  .gravity = scene.gravity,
                                  .mirror = scene.mirror,
                                  .density = options.density,
                                  .relaxed = 1.0 - options.retained};
  const ThreadsForWork threads(grid.particle_count());
  const PhaseTimer timed(times);
  StepReport report{.dt = dt};

  if (scene.source) report.entered = timed(&StepTimes::source, [&] { return scene.source->release(state); });

  grid.keep_forces_apart(options.retained > 0.0 || need_lumped_mass_correction(scene.boundaries));
  timed(&StepTimes::particle_to_grid, [&] { particle_to_grid(grid, options); });  // m_i, p_i, dt f_i

  ImpulseRecord record = timed(&StepTimes::grid_update, [&] {
    add_mirror_images(grid, scene.mirror, NodeFields(grid), grid.own_blocks());
    return update_grid(grid, conditions, dt, state.time);  // v_i, contact
  });
  ranks.send_nodes(NodeFields(grid));

  report.left = move_particles(state, scene, options, record, times);  // v_p, C_p, x_p, then the law: tau_p

  BoundaryImpulses taken = timed(&StepTimes::grid_update, [&] { return std::move(record).total(ranks); });
  timed(&StepTimes::sort, [&] { grid.migrate(); });  // into their new blocks; sorts by cell

  report.gravity_impulse = dt * taken.mass * scene.gravity;
  report.impulses = std::move(taken.impulses);
  report.layers = std::move(taken.layers);
  state.time += dt;
  ++state.step;
  state.entered += report.entered;
  state.left += report.left;
  ranks.done();
  return report;
}

double stable_time_step(const AnyMaterial& material, double cfl, double cell_size, double max_speed, bool corrected) {
  constexpr double safety = 0.92, doubled = 2.0;
  double dt = cfl * cell_size / (wave_speed_of(material) + max_speed);
  if (const double speed = bulk_speed_of(material); speed > 0.0) {
    const double response = corrected && !keeps_compaction(material) ? doubled : 1.0;
    dt = std::min(dt, safety * cell_size / (std::sqrt(3.0 * response) * speed));
  }
  if (const double viscosity = viscosity_of(material); viscosity > 0.0) {
    const double diffusion = density_of(material) * cell_size * cell_size / viscosity;
    dt = std::min({dt, 0.5 * cfl * diffusion, 0.25 * safety * diffusion / (corrected ? doubled : 1.0)});
  }
  return dt;
}

double stable_time_step(const State& state, const Scene& scene) {
  const double dx = state.grid.cell_size();
  const bool corrected = need_lumped_mass_correction(scene.boundaries);
  const double dt = stable_time_step(scene.material, scene.numerics.cfl, dx, state.max_speed, corrected);
  const double at_rest = stable_time_step(scene.material, scene.numerics.cfl, dx, 0.0, corrected);
  if (!(dt >= collapse_ratio * at_rest)) {
    throw UnstableError("the time step collapsed at t = " + number_text(state.time) + " s, step " + std::to_string(state.step) + ": " +
                        number_text(dt, 3) + " s, at rest it is " + number_text(at_rest, 3) + " s, because the fastest particle moves at " +
                        number_text(state.max_speed, 4) + " m/s. Try a smaller CFL number or a finer grid");
  }
  return dt;
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
