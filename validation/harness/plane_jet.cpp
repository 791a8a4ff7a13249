#include "validation/harness/plane_jet.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "libmpm/driver/case_file.hpp"

namespace mpm::validation {

namespace {

constexpr std::size_t batches = 8, before = 60, mean_samples = 64;

}  // namespace

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
  const double u = c.bodies[0].velocity.x(), b = c.bodies[0].max.y();
  PlaneJetForce result;
  result.ratio = 0.5 * c.obstacle->width() / b;
  result.half_thickness = b;
  result.unit = c.material.density() * u * u * 2.0 * b;
  const double full = result.unit * c.numerics.cell_size * (c.domain.mirror_y ? 0.5 : 1.0);
  std::vector<double> steady;
  const RunCost cost = play(context, setup, [&](const Instant& now) {
    result.time.push_back(0.5 * (now.before + now.time) * u / b);
    result.force.push_back(now.forces.back().x() / full);
    if (now.index < before) return true;
    steady.push_back(result.force.back());
    if (observe) observe(now);
    return true;
  });
  result.particle_steps = cost.particle_steps;
  result.mean = batch_mean(steady, batches);
  return result;
}

}  // namespace mpm::validation
