// A block of snow, 1 m x 1 m x 0.5 m, lands on a rigid floor at 4 m/s: the force on the floor, from the momentum it took.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "libmpm/driver/scene.hpp"

int main() {
  mpm::Case snow;  // cohesive Cam-Clay with the paper's parameters, by default
  snow.material.as<mpm::CamClay>().cohesion_beta = 0.3;
  snow.numerics.cell_size = 0.125;
  snow.bodies.push_back({.min = {0.0, 0.0, 0.0}, .max = {1.0, 1.0, 0.5}, .velocity = {0.0, 0.0, -4.0}});
  snow.walls.push_back({.normal = mpm::Vec3::UnitZ(), .contact = mpm::Contact::separable, .friction = 0.3});
  const mpm::CaseScene scene = mpm::make_scene(snow);
  mpm::State state = mpm::make_state(snow, scene);

  const auto momentum_z = [&] {
    double sum = 0.0;
    state.grid.for_each_particle([&](const mpm::Particle& p) { sum += snow.material.density() * p.volume * p.velocity[2]; });
    return sum;
  };
  const double before = momentum_z();
  double impulse = 0.0, weight = 0.0, peak_force = 0.0;
  mpm::advance(state, scene, 0.2, [&](const mpm::StepReport& report) {
    impulse += report.impulses[0].linear.z();  // of snow on floor, so downwards
    weight += report.gravity_impulse.z();
    peak_force = std::max(peak_force, -report.impulses[0].linear.z() / report.dt);
  });
  std::printf("%zu particles, %llu steps; peak force on the floor %.1f kN\n", state.grid.particle_count(),
              static_cast<unsigned long long>(state.step), 1e-3 * peak_force);
  // The balance is exact but for rounding, about 1e-16 a particle and step.
  const double defect = momentum_z() - (before + weight - impulse);
  return std::abs(defect) < 1e-10 * std::abs(before) && peak_force > 0.0 ? 0 : 1;
}
