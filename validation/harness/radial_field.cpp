#include "validation/harness/radial_field.hpp"

#include <algorithm>
#include <cmath>

#include "libmpm/driver/scene.hpp"
#include "validation/harness/particle_access.hpp"

namespace mpm::validation {

namespace {

/// Cells: nodes within one and a half of the free particles get all they have from exact ones, and none of it from nodes next to the edge.
constexpr double depth_of_driver = 3.5;

/// Fraction of a square cell of the lattice, centred at (x, y), that lies within a radius.
double fraction_within(double x, double y, double side, double radius) {
  const double distance = std::hypot(x, y);
  if (distance + side < radius) return 1.0;
  if (distance - side > radius) return 0.0;
  constexpr int samples = 32;
  int inside = 0;
  for (int j = 0; j < samples; ++j) {
    for (int i = 0; i < samples; ++i) {
      const double u = x + ((i + 0.5) / samples - 0.5) * side, v = y + ((j + 0.5) / samples - 0.5) * side;
      inside += u * u + v * v < radius * radius ? 1 : 0;
    }
  }
  return static_cast<double>(inside) / (samples * samples);
}

/// Gives a particle the exact stress and internal variable. @param c, s  cosine and sine of its direction
void set_stress(Particle& p, const RadialPoint& at, double c, double s) {
  p.stress[0] = at.radial * c * c + at.hoop * s * s;
  p.stress[1] = at.radial * s * s + at.hoop * c * c;
  p.stress[2] = at.axial;
  p.stress[3] = (at.radial - at.hoop) * c * s;
  p.stress[4] = p.stress[5] = 0.0;
  p.internal = at.internal;
}

/// Removes the particles with a property from the grid.
template <class Property>
std::vector<Particle> take_out(State& state, const Property& property) {
  std::vector<Particle> taken;
  const std::vector<std::int32_t> blocks(state.grid.occupied_blocks().begin(), state.grid.occupied_blocks().end());
  for (const std::int32_t b : blocks) {
    const ParticleBin& bin = state.grid.block(b).particles;
    for (int slot = bin.count() - 1; slot >= 0; --slot) {
      if (!property(bin[slot])) continue;
      taken.push_back(bin[slot]);
      state.grid.remove(b, slot);
    }
  }
  return taken;
}

}  // namespace

RadialErrors run_radial(const Case& base, const RadialSetting& s, const RadialMotion& exact) {
  Case c = base;
  const double dx = s.inner / s.cells, spacing = dx / s.per_axis, side = spacing;
  c.numerics.cell_size = dx;
  c.numerics.transfer = s.transfer;
  c.numerics.flip_ratio = s.flip_ratio;
  c.numerics.particles_per_cell = s.per_axis * s.per_axis * s.per_axis;
  c.domain.mirror_x = c.domain.mirror_y = true;
  c.domain.min = Vec3(-1.0, -1.0, -1.0) * s.outer;
  c.domain.max = Vec3(3.0, 3.0, 3.0) * s.outer;
  c.walls[1].point.z() = side;
  const CaseScene scene = make_scene(c);
  State state(dx);
  const double innermost = s.inner - depth_of_driver * dx, outermost = s.free_surface ? s.outer : s.outer + depth_of_driver * dx;
  std::vector<Vec3> reference;
  const RadialState start = exact(0.0), end = exact(s.duration);
  const auto count = static_cast<int>(std::ceil(outermost / spacing)) + 1;
  for (int j = 0; j < count; ++j) {
    for (int i = 0; i < count; ++i) {
      const double x = (i + 0.5) * spacing, y = (j + 0.5) * spacing, radius = std::hypot(x, y);
      if (radius < innermost) continue;
      const double fraction = s.free_surface ? fraction_within(x, y, spacing, s.outer) : radius <= outermost ? 1.0 : 0.0;
      if (fraction < 0.05) continue;  // less mass than this would only be noise at the surface
      Particle p{};
      p.position[0] = x, p.position[1] = y, p.position[2] = 0.5 * side;
      p.volume = fraction * spacing * spacing * side / s.initial_volume_ratio;
      p.id = state.next_id++;
      set_stress(p, start(radius), x / radius, y / radius);
      reference.emplace_back(x, y, 0.0);
      state.grid.insert(p);
    }
  }
  state.grid.refresh();

  const double wanted = c.numerics.cfl * dx / wave_speed_of(scene.material);
  const auto steps = static_cast<int>(std::ceil(s.duration / wanted));
  const double dt = s.duration / steps;
  const auto is_moved = [&](double radius) { return radius < s.inner || (!s.free_surface && radius > s.outer); };
  RadialErrors e;
  e.cell = 1.0 / s.cells;
  for (int n = 0; n < steps; ++n) {
    const double t = n * dt;
    const RadialState at_step = exact(t), half_before = exact(t - 0.5 * dt);
    state.grid.change_particles([&](Particle& p) {
      const Vec3& at = reference[p.id];
      const double radius = at.norm();
      if (is_moved(radius)) return;
      const double gain = dt * at_step(radius).acceleration / radius;
      p.velocity[0] += gain * at.x();
      p.velocity[1] += gain * at.y();
    });
    for (Particle p : take_out(state, [&](const Particle& q) { return is_moved(reference[q.id].norm()); })) {
      const Vec3& at = reference[p.id];
      const double radius = at.norm(), cosine = at.x() / radius, sine = at.y() / radius;
      const RadialPoint now = at_step(radius), before = half_before(radius);
      p.position[0] = now.r * cosine, p.position[1] = now.r * sine, p.position[2] = 0.5 * side;
      // velocities live at half steps: the body force of this step brings that of t - dt/2 to t + dt/2
      const double v = before.velocity + dt * now.acceleration, difference = before.radial_rate - before.hoop_rate;
      p.velocity[0] = v * cosine, p.velocity[1] = v * sine, p.velocity[2] = 0.0;
      std::fill(std::begin(p.affine), std::end(p.affine), 0.0);
      p.affine[0] = before.hoop_rate + difference * cosine * cosine;
      p.affine[4] = before.hoop_rate + difference * sine * sine;
      p.affine[1] = p.affine[3] = difference * cosine * sine;
      set_stress(p, now, cosine, sine);
      state.grid.insert(p);
    }
    state.grid.refresh();
    step(state, scene, dt);
    e.particle_steps += static_cast<double>(state.grid.particle_count());
  }

  double number = 0.0, judged = 0.0, at_wall = 0.0;
  const double judged_to = s.judged_to > 0.0 ? s.judged_to : s.outer;
  state.grid.for_each_particle([&](const Particle& p) {
    const Vec3& at = reference[p.id];
    const double radius = at.norm(), cosine = at.x() / radius, sine = at.y() / radius;
    if (is_moved(radius)) return;
    const RadialPoint last = end(radius);
    const double radial = p.stress[0] * cosine * cosine + p.stress[1] * sine * sine + 2.0 * p.stress[3] * cosine * sine;
    const double hoop = p.stress[0] * sine * sine + p.stress[1] * cosine * cosine - 2.0 * p.stress[3] * cosine * sine;
    number += 1.0;
    e.displacement += std::pow(p.position[0] - last.r * cosine, 2) + std::pow(p.position[1] - last.r * sine, 2);
    if (radius >= s.judged_from && radius <= judged_to) {
      judged += 1.0;
      e.radial += std::pow(radial - last.radial, 2);
      e.hoop += std::pow(hoop - last.hoop, 2);
      e.axial += std::pow(p.stress[2] - last.axial, 2);
      e.internal += std::pow(p.internal - last.internal, 2);
    }
    if (radius < 1.125 * s.inner) {
      e.wall_stress += radial;
      e.wall_exact += last.radial;
      at_wall += 1.0;
    }
    constexpr std::uint64_t drawn = 400;
    if (p.id % std::max<std::uint64_t>(1, state.next_id / drawn) != 0) return;
    e.place.push_back(radius / s.inner);
    e.radial_values.push_back(radial);
    e.hoop_values.push_back(hoop);
    e.internal_values.push_back(p.internal);
  });
  e.displacement = std::sqrt(e.displacement / number);
  for (double* sum : {&e.radial, &e.hoop, &e.axial, &e.internal}) *sum = std::sqrt(*sum / judged);
  e.wall_stress /= at_wall;
  e.wall_exact /= at_wall;
  return e;
}

}  // namespace mpm::validation
