#include "validation/harness/plane_jet.hpp"

#include <algorithm>
#include <cmath>

#include "libmpm/core/step.hpp"

namespace mpm::validation {

PlaneJetForce run_plane_jet(const Case& base, const PlaneJetSetting& s, const PlaneJetObserver& observe) {
  constexpr std::size_t batches = 8, samples = 64;
  Case c = base;
  const double width = c.obstacle->width(), u = c.bodies[0].velocity.x(), density = c.material.density(), dx = width / s.cells;
  const double b = std::max(1.0, std::round(0.5 * width / (s.ratio * dx))) * dx;  // whole cells
  c.numerics.cell_size = dx;
  c.numerics.cfl = s.cfl;
  c.numerics.transfer = s.transfer;
  c.numerics.contact = s.contact;
  c.numerics.grid_offset = Vec3(s.shift_x, s.shift_y, 0.0);
  c.domain.mirror_y = s.shift_y == 0.0;  // a mirror plane stays on the grid
  c.walls[0].point.z() = c.bodies[0].min.z() = dx;
  c.walls[1].point.z() = c.bodies[0].max.z() = 2.0 * dx;
  c.bodies[0].lattice = s.lattice;
  c.bodies[0].min = Vec3(-(jet_means_to + 3.0) * b, -b, dx);
  c.bodies[0].max = Vec3(-dx, b, 2.0 * dx);
  c.domain.min = Vec3(c.bodies[0].min.x() - b, -12.0 * b, 0.0);
  c.domain.max = Vec3(6.0 * b, 12.0 * b, 4.0 * dx);
  const CaseScene scene = make_scene(c);
  State state = make_state(c, scene);

  PlaneJetForce result;
  result.ratio = 0.5 * width / b;
  result.half_thickness = b;
  result.cell_size = dx;
  const double unit = b / u, full = density * u * u * 2.0 * b * dx / scene.mirror.parts();
  const auto go = [&](double until) {
    double impulse = 0.0;
    const double start = state.time;
    advance(state, scene, until * unit, [&](const StepReport& r) {
      impulse += r.impulses[*scene.obstacle].linear.x();
      result.particle_steps += static_cast<double>(state.grid.particle_count());
    });
    result.time.push_back(0.5 * (start / unit + until));
    result.force.push_back(impulse / ((state.time - start) * full));
  };
  constexpr int before = 60;
  for (int i = 1; i <= before; ++i) go(jet_means_from * i / before);
  std::vector<double> steady;
  for (std::size_t i = 0; i < samples; ++i) {
    go(jet_means_from + (jet_means_to - jet_means_from) * static_cast<double>(i + 1) / samples);
    steady.push_back(result.force.back());
    if (observe) observe(state, scene, b);
  }
  result.mean = batch_mean(steady, batches);
  return result;
}

}  // namespace mpm::validation
