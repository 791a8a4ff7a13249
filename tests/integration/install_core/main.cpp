// The core by itself, without case files: a block of snow, 1 m x 1 m x 0.5 m, lands on a rigid floor at 4 m/s.
#include <cmath>
#include <cstdio>

#include "libmpm/core/diagnostics.hpp"
#include "libmpm/core/step.hpp"
#include "libmpm/source/body.hpp"

int main() {
  constexpr double cell_size = 0.125;
  mpm::Scene scene{.material = mpm::make_material(mpm::CamClay::Parameters{.cohesion_beta = 0.3})};
  scene.gravity = {0.0, 0.0, -9.81};
  scene.boundaries.emplace_back(mpm::Wall{.contact = mpm::Contact::separable, .friction = 0.3});
  mpm::State state(cell_size);
  mpm::fill_body(state, {.min = {0.0, 0.0, 0.0}, .max = {1.0, 1.0, 0.5}, .velocity = {0.0, 0.0, -4.0}}, scene, 0.5 * cell_size);
  state.grid.refresh();

  const double before = mpm::totals(state, scene).momentum.z();
  double impulse = 0.0, weight = 0.0;
  mpm::advance(state, scene, 0.1, [&](const mpm::StepReport& report) {
    impulse += report.impulses[0].linear.z();  // of the snow on the floor, so downwards
    weight += report.gravity_impulse.z();
  });
  std::printf("%zu particles, %llu steps, impulse on the floor %.0f N s\n", state.grid.particle_count(),
              static_cast<unsigned long long>(state.step), -impulse);
  // The balance is exact but for rounding, about 1e-16 a particle and step.
  const double defect = mpm::totals(state, scene).momentum.z() - (before + weight - impulse);
  return std::abs(defect) < 1e-10 * std::abs(before) && impulse < 0.0 ? 0 : 1;
}
