/// `mpm check`: the resolved case and its estimated cost.

#include <fmt/format.h>

#include <memory>

#include "arguments.hpp"
#include "commands.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/estimate.hpp"
#include "run_control.hpp"

namespace mpm::app {

namespace {

/// The resolved case as TOML; the estimate as comments below it, so that the output is a case file, too.
void check(const CaseArguments& arguments) {
  const Case spec = read_case(arguments.file, arguments.overrides);
  const Estimate e = estimate(spec);
  require_feasible(e, physical_memory_bytes());
  fmt::print("{}\n", write_case(spec));
  fmt::print("# case hash       {}\n", case_hash_text(spec));
  fmt::print("# particles       {:.0f}\n", e.particles);
  fmt::print("# occupied cells  {:.0f}\n", e.cells);
  fmt::print("# wave speed      {:.2f} m/s\n", e.wave_speed);
  fmt::print("# time step       {:.4g} s\n", e.time_step);
  fmt::print("# steps           {:.0f}\n", e.steps);
  fmt::print("# samples         {:.0f}\n", e.samples);
  fmt::print("# frames          {:.0f}\n", e.frames);
  fmt::print("# memory          {:.3g} GB at its most, {:.0f} bytes a particle\n", e.memory_bytes / 1e9, assumed_bytes_per_particle);
  fmt::print("# disk            {:.3g} GB\n", e.disk_bytes / 1e9);
  fmt::print("# time            {:.3g} s{}, assuming {:.3g} million particle-steps a second (two cores)\n", e.wall_time_s,
             spec.output.stop_when_steady > 0.0 ? " at its most" : "", assumed_particle_steps_per_s / 1e6);
  print_advice(spec);
}

}  // namespace

void add_check(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "check",
      "Validate a case; print every key with its value, and the cost of the run; warn of properties that may make the result inaccurate");
  const auto arguments = std::make_shared<CaseArguments>();
  add_case_arguments(*command, *arguments);
  command->callback([arguments] { check(*arguments); });
}

}  // namespace mpm::app
