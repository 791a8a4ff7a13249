#include "validation/harness/impact.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "libmpm/base/error.hpp"
#include "libmpm/impact/semi_empirical.hpp"
#include "libmpm/io/snapshot.hpp"

namespace mpm::validation {

ImpactRun run_impact(const CaseContext& context, const std::string& id, const std::string& name, Case spec) {
  spec.title = name;
  spec.output.frames_per_second = 1.0 / spec.output.duration;
  ImpactRun run{id, name, spec, context.directory() / id, {}, {}, {}};
  run.result = run_case(spec, {.out = run.directory});
  if (!run.result.results.has("steady")) throw UnstableError(name + ": the run left no results of the impact");
  run.series = Table::read(run.directory / "series.csv");
  run.profile = Table::read(run.directory / "profile.csv");
  context.log(fmt::format("{}: {:.3g} particle-steps, {:.0f} s, {:.1f} million a second", name,
                          static_cast<double>(run.result.particle_steps), run.result.wall_time_s, run.result.million_particle_steps_per_s));
  return run;
}

Plot runup_plot(const ImpactRun& run) {
  const auto time = run.series.numbers("time_s");
  const std::vector<double> ends{0.0, run.result.time};
  Plot plot{run.id + "-runup", "Run-up, " + run.name, "time [s]", "height [m]"};
  if (const double predicted = run.value("predicted_runup_m"); std::isfinite(predicted))
    plot.series.push_back({"paper's equation", ends, {predicted, predicted}, Series::Style::reference});
  const double bound = bernoulli_height(run.spec.conveyor->velocity, run.flow_height(), run.spec.numerics.gravity);
  plot.series.push_back({"H + v²/2g", ends, {bound, bound}, Series::Style::bound});
  plot.series.push_back({"99 % of the mass", time, run.series.numbers("runup_p99_m"), Series::Style::simulation});
  plot.series.push_back({"highest particle", time, run.series.numbers("runup_m"), Series::Style::simulation});
  if (run.steady()) {
    const double from = run.value("steady_from_s"), to = run.value("steady_to_s");
    for (const auto& [what, key] : {std::pair{"99 % of the mass", "runup_p99_mean_m"}, {"highest particle", "runup_mean_m"}})
      plot.series.push_back({fmt::format("{}, mean", what), {from, to}, {run.value(key), run.value(key)}, Series::Style::points});
    plot.caption = fmt::format("Steady from {:.2f} to {:.2f} s.", from, to);
  }
  return plot;
}

Plot profile_plot(const ImpactRun& run, double column) {
  auto raw = run.profile.numbers("pressure_pa"), smooth = run.profile.numbers("smoothed_pressure_pa");
  const auto z = run.profile.numbers("z_m");
  for (auto* values : {&raw, &smooth}) {
    for (double& p : *values) p *= 1e-3;
  }
  const double base = run.spec.material.density() * run.spec.numerics.gravity * column * 1e-3;
  Plot plot{run.id + "-profile", "Mean pressure on the face, " + run.name, "pressure [kPa]", "z [m]"};
  plot.series.push_back(
      {fmt::format("hydrostatic, {:.2f} H", column / run.flow_height()), {base, 0.0}, {0.0, column}, Series::Style::reference});
  plot.series.push_back({"raw", raw, z, Series::Style::points});
  plot.series.push_back({"smoothed", smooth, z, Series::Style::simulation});
  const double predicted = run.value("predicted_pressure_height_m");
  if (std::isfinite(predicted) && !raw.empty()) {
    plot.series.push_back({"pressure height of the paper's equation",
                           {0.0, *std::max_element(raw.begin(), raw.end())},
                           {predicted, predicted},
                           Series::Style::bound});
  }
  return plot;
}

FlowPicture last_picture(const ImpactRun& run, FlowField field, const std::array<double, 4>& window) {
  const auto frames = frame_numbers(run.directory);
  if (frames.empty()) throw IoError(run.directory.string() + ": no frames");
  return flow_picture_of_run(run.directory, frames.back(), run.spec,
                             {.id = run.id,
                              .field = field,
                              .title = fmt::format("{}, t = {:.1f} s", run.name, run.result.time),
                              .caption = "The end of the run.",
                              .slice_half_width = 0.2 * run.spec.obstacle->width(),
                              .window = window});
}

SnowInside snow_inside(const Results& results, double cell_size) {
  return {results.number("particles_inside_obstacle"), results.number("volume_inside_obstacle_m3"),
          results.number("depth_inside_obstacle_m") / cell_size};
}

void check_nothing_inside(CaseResult& result, const ImpactRun& run) {
  result.check_at_most(Label::verification, run.name + ": largest depth of a particle behind the surface of the mast, at the end",
                       snow_inside(run.result.results, run.spec.numerics.cell_size).depth_cells, 0.1, "dx", 0.0,
                       "aim: the mast is impermeable; a tenth of a cell for particles that slide along it");
}

std::string run_note(const ImpactRun& run) {
  const double h = run.flow_height();
  const SnowInside inside = snow_inside(run.result.results, run.spec.numerics.cell_size);
  return fmt::format(
      "{}: dx = {} m, {} particles at the end, {:.3g} particle-steps, {:.1f} s of flow; steady from {:.2f} to {:.2f} s; run-up {:.3f} H "
      "(standard error {:.3f} H), highest particle {:.3f} H ({:.3f} H), equation {:.3f} H, Bernoulli {:.3f} H; pressure height {:.3f} H, "
      "equation {:.3f} H; mean force {:.1f} "
      "kN, pressure profile over the face {:.1f} kN; {:.0f} particles ({:.2g} m³) deeper than 0.1 dx inside the mast at the end, at most "
      "{:.2f} "
      "dx.",
      run.name, run.spec.numerics.cell_size, run.result.particles, static_cast<double>(run.result.particle_steps), run.result.time,
      run.value("steady_from_s"), run.value("steady_to_s"), run.value("runup_p99_mean_m") / h, run.value("runup_p99_standard_error_m") / h,
      run.value("runup_mean_m") / h, run.value("runup_standard_error_m") / h, run.value("predicted_runup_m") / h,
      bernoulli_height(run.spec.conveyor->velocity, h, run.spec.numerics.gravity) / h, run.value("pressure_height_mean_m") / h,
      run.value("predicted_pressure_height_m") / h, run.value("force_mean_n") * 1e-3, run.value("profile_force_n") * 1e-3, inside.particles,
      inside.volume, inside.depth_cells);
}

}  // namespace mpm::validation
