#include "validation/harness/plane_jet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "libmpm/driver/case_file.hpp"

namespace mpm::validation {

namespace {

constexpr std::size_t batches = 8, before = 60, mean_samples = 64;

bool upright(const Case& scene) { return scene.obstacle->base > 0.0; }

/// Height of the axis of an upright jet of half thickness b, m.
double axis_height(double b) { return 16.0 * b; }

/// Exchanges y and z, and lifts the scene above the ground.
void turn_upright(Case& c, double b, double width) {
  const auto turned = [&](const Vec3& x) { return Vec3(x.x(), x.z(), x.y() + axis_height(b)); };
  for (WallSpec& wall : c.walls) {
    wall.point = turned(wall.point);
    wall.normal = Vec3(wall.normal.x(), wall.normal.z(), wall.normal.y());
  }
  c.bodies[0].min = turned(c.bodies[0].min), c.bodies[0].max = turned(c.bodies[0].max);
  const double half_span = c.domain.max.z();  // the slice is well within the obstacle's ends
  c.domain.min = turned(c.domain.min), c.domain.max = turned(c.domain.max);
  c.domain.min.y() = -1.5 * half_span, c.domain.max.y() = 1.5 * half_span;
  c.domain.mirror_y = false;
  c.numerics.grid_offset = Vec3(c.numerics.grid_offset.x(), 0.0, c.numerics.grid_offset.y());
  c.obstacle->as<BoxShape>().width = 2.0 * half_span;
  c.obstacle->base = axis_height(b) - 0.5 * width;
  c.obstacle->height = axis_height(b) + 0.5 * width;
}

/// The instant as one of a horizontal jet.
Instant laid_down(Instant now, double b) {
  for (ParticleRecord& p : now.particles) {
    p.position = Vec3(p.position.x(), p.position.z() - axis_height(b), p.position.y());
    p.velocity = Vec3(p.velocity.x(), p.velocity.z(), p.velocity.y());
  }
  return now;
}

}  // namespace

JetGeometry jet_geometry(const Case& scene) {
  const BodySpec& jet = scene.bodies[0];
  const Vec3 size = jet.max - jet.min;
  if (upright(scene)) return {*scene.obstacle->height - scene.obstacle->base, 0.5 * size.z()};
  return {scene.obstacle->width(), 0.5 * size.y()};
}

Setup plane_jet_setup(const Case& base, const PlaneJetSetting& s) {
  Case c = base;
  const double width = c.obstacle->width(), u = c.bodies[0].velocity.x(), dx = width / s.cells;
  const double b = std::max(1.0, std::round(0.5 * width / (s.ratio * dx))) * dx;  // whole cells
  c.numerics.cell_size = dx;
  c.numerics.cfl = s.cfl;
  c.numerics.transfer = s.transfer;
  c.numerics.flip_ratio = s.flip_ratio;
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
  if (s.upright) turn_upright(c, b, width);
  const double unit = b / u;
  std::vector<double> times = even_times(0.0, jet_means_from * unit, before);
  std::ranges::copy(even_times(jet_means_from * unit, jet_means_to * unit, mean_samples), std::back_inserter(times));
  return {
      .id = s.id.empty() ? fmt::format("cells{}", s.cells) : s.id,
      .title = fmt::format("{} cells across the obstacle, width/d = {:.4f}{}", s.cells, 0.5 * width / b, s.id.empty() ? "" : ", " + s.id),
      .spec = std::move(c),
      .times = std::move(times),
      .fields = {.stress = true},
      .forces = true};
}

std::vector<Setup> plane_jet_setups(const CaseContext& context, const std::vector<NamedJet>& runs) {
  const Case base = context.read_case();
  std::vector<Setup> all;
  for (const NamedJet& run : runs) all.push_back(plane_jet_setup(base, run.setting));
  return all;
}

PlaneJetForce play_plane_jet(const CaseContext& context, const Setup& setup, const std::function<void(const Instant&)>& observe) {
  const Case& c = setup.spec;
  const JetGeometry across = jet_geometry(c);
  const double b = across.half_thickness;
  const double u = c.bodies[0].velocity.x();
  PlaneJetForce result;
  result.ratio = 0.5 * across.width / b;
  result.half_thickness = b;
  result.unit = c.material.density() * u * u * 2.0 * b;
  const double full = result.unit * c.numerics.cell_size * (c.domain.mirror_y ? 0.5 : 1.0);
  std::vector<double> steady;
  const RunCost cost = play(context, setup, [&](const Instant& now) {
    result.time.push_back(0.5 * (now.before + now.time) * u / b);
    result.force.push_back(now.forces.back().x() / full);
    if (now.index < before) return true;
    steady.push_back(result.force.back());
    if (observe) observe(upright(c) ? laid_down(now, b) : now);
    return true;
  });
  result.particle_steps = cost.particle_steps;
  result.mean = batch_mean(steady, batches);
  return result;
}

}  // namespace mpm::validation
