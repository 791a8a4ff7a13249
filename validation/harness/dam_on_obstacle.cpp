#include "validation/harness/dam_on_obstacle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "validation/harness/shallow_flow.hpp"

namespace mpm::validation {
namespace {

/// make_state() with the pressure of the fluid above each particle. Particles stay on their lattice: the reservoir then settles by half of
/// its compression at the floor, some thousandths of its depth.
State at_rest(const Case& c, const Scene& scene) {
  State state = make_state(c, scene);
  const WeaklyCompressibleFluid::Parameters& water = c.material.as<WeaklyCompressibleFluid>();
  const CompressionCurve curve = tait_curve(water.bulk_modulus, water.tait_exponent);
  state.grid.change_particles([&](Particle& p) {
    const Vec3 x = position_of(p) - scene.offset;
    double depth = 0.0;
    for (const BodySpec& body : c.bodies)
      if ((x.array() >= body.min.array()).all() && (x.array() <= body.max.array()).all()) depth = body.max.z() - x.z();
    const double pressure = water.density * c.numerics.gravity * depth, ratio = curve(pressure);
    p.internal = ratio - 1.0;
    p.stress[0] = p.stress[1] = p.stress[2] = -ratio * pressure;
  });
  return state;
}

}  // namespace

Setup dam_on_obstacle_setup(const Case& base, int cells, double length, double duration) {
  Case c = base;
  c.numerics.cell_size = length / cells;
  return {.id = fmt::format("dx{}", cells),
          .title = fmt::format("{}, {} cells in {} m", base.title, cells, length),
          .spec = c,
          .start = at_rest,
          .times = even_times(0.0, duration, static_cast<std::size_t>(std::lround(200.0 * duration))),
          .fields = {.stress = true},
          .forces = true};
}

std::vector<Check*> compare_windows(CaseResult& result, const WindowComparison& comparison, const TimeRecord& measured,
                                    const std::vector<double>& sizes, const std::vector<TimeRecord>& runs) {
  std::vector<TimeWindow> windows = comparison.windows;
  std::erase_if(windows, [&](const TimeWindow& w) { return w.to > runs.back().time.back() + 0.005; });  // half the distance of forces
  std::vector<FollowedQuantity> followed;
  for (const TimeWindow& w : windows)
    followed.push_back({.quantity = fmt::format("{}, mean from {:g} to {:g} s {}", comparison.quantity, w.from, w.to, comparison.clock),
                        .unit = comparison.unit});
  const std::vector<MetricConvergence> judged =
      record_convergence(result, comparison.id, SweepKind::cell_size, sizes, followed, [&](double dx) {
        const TimeRecord& run = runs[static_cast<std::size_t>(std::ranges::find(sizes, dx) - sizes.begin())];
        std::vector<Metric> means;
        for (const TimeWindow& w : windows) means.push_back({run.mean(w.from, w.to)});
        return means;
      });
  std::vector<Check*> checks;
  for (std::size_t i = 0; i < judged.size(); ++i) {
    const TimeWindow& w = windows[i];
    const double value = runs.back().mean(w.from, w.to), reference = measured.mean(w.from, w.to);
    if (!w.judged) {
      result.notes.push_back(fmt::format("{}: measured {:.4g} {}, computed {:.4g} {} ({:+.1f} %).", followed[i].quantity, reference,
                                         comparison.unit, value, comparison.unit, 100.0 * (value / reference - 1.0)));
      continue;
    }
    checks.push_back(&result
                          .check_relative(Label::validation, followed[i].quantity, value, reference, comparison.unit,
                                          2.0 * comparison.uncertainty, comparison.reason)
                          .in_summary(comparison.kind, comparison.uncertainty));
  }
  return checks;
}

Plot record_plot(Plot plot, const TimeRecord& measured, double band, const std::vector<std::string>& names,
                 const std::vector<TimeRecord>& runs) {
  plot.series.push_back({"measured", measured.time, measured.value, Series::Style::reference});
  for (const double sign : {-1.0, 1.0}) {
    Series edge{sign < 0.0 ? "measured, two standard deviations less" : "two more", measured.time, measured.value, Series::Style::bound};
    for (double& value : edge.y) value += sign * band;
    plot.series.push_back(std::move(edge));
  }
  for (std::size_t i = 0; i < runs.size(); ++i) plot.series.push_back({names[i], runs[i].time, runs[i].value, Series::Style::simulation});
  return plot;
}

}  // namespace mpm::validation
