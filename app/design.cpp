/// `mpm design`: the loads on a mast at a site, as a page for a report.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <cstdio>
#include <memory>
#include <numbers>

#include "arguments.hpp"
#include "campaign_control.hpp"
#include "commands.hpp"
#include "libmpm/base/error.hpp"
#include "libmpm/campaign/design_plan.hpp"
#include "libmpm/driver/run_folder.hpp"
#include "libmpm/impact/semi_empirical.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "python_script.hpp"
#include "run_control.hpp"

namespace mpm::app {

namespace {

struct DesignArguments {
  CampaignArguments campaign;
  std::vector<std::string> overrides;
  bool quick = false, plan_only = false, json = false, page_only = false;
};

/// The plan for people: what is assumed, what would be run, and what it costs.
void print_plan(std::FILE* to, const DesignPlan& plan, const std::filesystem::path& out) {
  const SiteFlow& flow = plan.site.flow;
  const SiteMast& mast = plan.site.mast;
  fmt::print(to, "flow   {:.3g} m deep, {:.3g} m/s, Fr {:.3g}, {:.3g} kg/m^3; g cos(slope) = {:.3g} m/s^2{}\n", flow.depth, flow.velocity,
             plan.site.froude_number(), flow.density, plan.site.gravity(),
             flow.snow_cover > 0.0 ? fmt::format("; on {:.3g} m of snow", flow.snow_cover) : "");
  fmt::print(to, "mast   {} {:.3g} m wide, {}{}, friction {:.3g}\n", mast.shape == SiteMast::Shape::box ? "box" : "cylinder", mast.width,
             mast.height ? fmt::format("{:.3g} m high", *mast.height) : "taller than any jet",
             mast.angle != 0.0 ? fmt::format(", turned by {:.3g} degrees", mast.angle * 180.0 / std::numbers::pi) : "", mast.friction);
  if (const auto& arm = plan.site.arm)
    fmt::print(to, "arm    {:.3g} m long, {:.3g} to {:.3g} m above the ground\n", arm->length, arm->base, arm->height);
  for (const SiteMode& mode : plan.site.modes)
    fmt::print(to, "mode   {:.3g} Hz, damping {:.3g} %\n", mode.frequency, 100.0 * mode.damping_ratio);
  std::string source;
  for (const SiteSnow& snow : plan.snows) {
    fmt::print(to, "snow   {}: M = {:.3g}, beta = {:.3g}, xi = {:.3g} (M' = {:.3g})\n", snow.name, snow.critical_state_slope,
               snow.cohesion_beta, snow.hardening_xi, effective_friction(snow.critical_state_slope, snow.cohesion_beta));
    if (!snow.source.empty() && snow.source != source) fmt::print(to, "       {}\n", snow.source);
    source = snow.source;
  }
  std::string grids;
  for (std::size_t g = 0; g < plan.cells.size(); ++g)
    grids += fmt::format("{}{} cells ({:.3g} m)", g > 0 ? ", " : "", plan.cells[g], plan.cell_size[g]);
  fmt::print(to, "grids  {} in the smaller of mast width and flow depth\n", grids);
  fmt::print(to, "runs   {} of {:.3g} s each in {}; {:.3g} particle-steps, about {} at {:.0f} million a second (two cores)\n",
             plan.runs.size(), plan.duration, out.string(), plan.particle_steps,
             clock_text(plan.particle_steps / assumed_particle_steps_per_s), 1e-6 * assumed_particle_steps_per_s);
  if (!plan.overrides.empty()) fmt::print(to, "set    {} in all runs\n", fmt::join(plan.overrides, ", "));
  if (plan.particle_steps > design_budget(plan.level))
    fmt::print(to, "warning: this is more than the time of the level \"{}\"; --executor slurm, or more cores, make it shorter\n",
               to_string(plan.level));
  for (const DesignAdvice& a : design_advice(plan)) {
    const std::string of = a.snows.size() == plan.snows.size() ? "" : fmt::format("snow {}: ", fmt::join(a.snows, ", "));
    fmt::print(to, "warning: {}{}\n", of, a.text);
  }
}

/// Refuses a page of runs that do not belong to the site: those that are missing, unfinished, or of another case or duration.
void require_finished(const DesignPlan& plan, const std::filesystem::path& out) {
  std::vector<std::string> missing;
  for (const CampaignRun& run : plan.campaign.runs) {
    if (!finished_results(run_directory(out, run), run.spec)) missing.push_back(run_directory(out, run).string());
  }
  if (missing.empty()) return;
  throw IoError(fmt::format("{} not finished for this site, first {}; run the same command without --page",
                            missing.size() == 1 ? "1 run is" : fmt::format("{} runs are", missing.size()), missing.front()));
}

/// The page and what it is made from. Site, plan and page are written together under the lock of the folder, so that they belong to one
/// another whatever another process does before and after.
void make_page(const Site& site, const DesignPlan& plan, const std::filesystem::path& out) {
  make_directory(out);
  const DirectoryLock lock(out);
  require_finished(plan, out);
  write_file(out / "site.toml", write_site(site));
  write_file(out / "design_plan.json", design_plan_json(plan));
  const auto script = find_script("design_page.py");
  if (!script)
    throw IoError(fmt::format("design_page.py was found neither in share/mpm/scripts beside this program nor in {}", MPM_SCRIPT_DIR));
  std::fflush(stdout);
  const int status = run_script(*script, {out.string()});
  if (status == 2 || status == 4) throw CLI::RuntimeError(status);  // the script has printed the reason
  if (status != 0) {
    throw Error(ExitCode::internal,
                fmt::format("no page: {} {} ended with {}; Debian's {} are needed. The runs are kept: the same command makes "
                            "the page",
                            python, script->string(), status, python_packages));
  }
}

void design(DesignArguments a) {
  const Site site = read_site(a.campaign.plan);
  const DesignPlan plan = make_design(site, a.quick ? DesignLevel::quick : DesignLevel::standard, a.overrides);
  const std::filesystem::path out = folder_of(a.campaign);
  if (a.plan_only && a.json) return fmt::print("{}", design_plan_json(plan));
  print_plan(a.plan_only ? stdout : stderr, plan, out);
  if (a.plan_only) return;
  require_no_other_files(out, {"site.toml", "plan.toml", "results.csv", "runs.csv", "design.json", "design.html"},
                         {"runs", "design_plan.json"});
  if (!a.page_only) {
    a.campaign.progress = true;
    run_campaign(plan.campaign, a.campaign);
  }
  make_page(site, plan, out);
}

}  // namespace

void add_design(CLI::App& app) {
  CLI::App* command = app.add_subcommand(
      "design",
      "Loads of an avalanche on a mast, as a page for a report: runs an ensemble of snows and grids for a site file.\n"
      "Writes design.html, design.json and tables (CSV) to the folder, beside the runs. An interrupted ensemble continues with the same "
      "command; finished runs of --quick are used again by the standard level. Keys of a site file: `mpm schema --site`; example: "
      "examples/design/. Standard output: the summary of the runs and of the page");
  const auto a = std::make_shared<DesignArguments>();
  command->add_option("site", a->campaign.plan, "Site file: flow, snow, mast")->required()->type_name("SITE.toml");
  command->add_option("--out", a->campaign.out, "Folder of the design (default: out/<name of the site file>)")->type_name("DIR");
  command->add_flag("--quick", a->quick, "Coarser grids: at most ten minutes on two cores instead of an hour");
  add_jobs_argument(*command, a->campaign, "Runs at a time, of two threads each (default: half the cores; Slurm: as many as it grants)");
  add_execution_arguments(*command, a->campaign);
  add_overrides_argument(*command, a->overrides, "Replace a key of the cases of all runs: conveyor.lattice=aligned");
  CLI::Option* plan = command->add_flag("--plan", a->plan_only, "Only print what would be run, and its cost");
  command->add_flag("--json", a->json, "With --plan: as JSON")->needs(plan);
  command->add_flag("--page", a->page_only, "Only make the page again, from finished runs")->excludes(plan);
  command->callback([a] { design(*a); });
}

}  // namespace mpm::app
