#include "libmpm/core/time_step.hpp"

#include <algorithm>

#include "libmpm/base/error.hpp"
#include "libmpm/base/text.hpp"

namespace mpm {

namespace {

constexpr double collapse_ratio = 1e-4;  ///< a step below this fraction of the step at rest is a collapse: the run would never end

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

}  // namespace mpm
