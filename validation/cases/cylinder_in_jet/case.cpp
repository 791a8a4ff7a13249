#include <fmt/format.h>

#include <cmath>
#include <map>
#include <numbers>
#include <string>

#include "libmpm/driver/case_file.hpp"
#include "validation/cases/cylinder_in_jet/smooth_separation.hpp"
#include "validation/harness/case.hpp"
#include "validation/harness/plane_jet.hpp"

namespace mpm::validation::cylinder_in_jet {
namespace {

constexpr double aim = 0.03;

/// Runs whose force is known to be too large, and the bound on force over exact force: what was measured (results.md) and two standard
/// errors of 0.006.
const std::map<std::string, double> known_excess = {
    {"5 cells", 1.075}, {"8 cells, grid moved by 0.3 and 0.4 cells", 1.056}, {"8 cells, CFL 1", 1.042}};

/// The runs that are judged. @param with_variants  also those of another place of the grid or time step
std::vector<NamedJet> named_runs(const CaseContext& context, bool with_variants) {
  // five cells: moved by a whole cell, so that both halves are computed and the statistical error is a third
  std::vector<NamedJet> runs = {{"5 cells", {.cells = 5, .shift_y = 1.0}}, {"8 cells", {.cells = 8}}};
  if (context.level() == Level::quick) return runs;
  for (const int cells : {6, 12, 16}) runs.push_back({fmt::format("{} cells", cells), {.cells = cells}});
  runs.push_back({"8 cells, diameter 0.4 d", {.cells = 8, .id = "ratio-0.4", .ratio = 0.4}});
  if (!with_variants) return runs;
  runs.push_back({"8 cells, grid moved by 0.3 and 0.4 cells", {.cells = 8, .id = "moved", .shift_x = 0.3, .shift_y = 0.4}});
  runs.push_back({"8 cells, CFL 0.1", {.cells = 8, .id = "cfl-0.1", .cfl = 0.1}});
  runs.push_back({"8 cells, CFL 1", {.cells = 8, .id = "cfl-1", .cfl = 1.0}});
  return runs;
}

std::vector<Setup> setups(const CaseContext& context) { return plane_jet_setups(context, named_runs(context, false)); }

void run(const CaseContext& context, CaseResult& result) {
  const Case base = context.read_case();
  {
    const CylinderInJet wide_jet(0.01);
    result.check_relative(Label::verification, "reference: drag coefficient in a jet a hundred times as thick", wide_jet.force() / 0.005,
                          0.4986, "", 0.01, "Brodetsky (1923), endless stream; the jet of finite thickness takes 0.3 % off");
    result.check_absolute(Label::verification, "reference: angle at which the streamlines leave, likewise",
                          wide_jet.separation_angle() * 180.0 / std::numbers::pi, 55.0, "°", 0.5,
                          "Brodetsky (1923), given in whole degrees");
  }

  const std::vector<NamedJet> runs = named_runs(context, own_run(context));
  std::vector<PlaneJetSetting> settings;
  for (const NamedJet& n : runs) settings.push_back(n.setting);
  if (own_run(context))
    settings.push_back({.cells = 8, .id = "nodal", .transfer = Transfer::apic, .contact = ContactRule::nodal, .lattice = Lattice::aligned});
  std::vector<PlaneJetForce> all(settings.size());
  play_in_parallel(context, settings.size(), [&](std::size_t i) { all[i] = play_plane_jet(context, plane_jet_setup(base, settings[i])); });

  const auto over_exact = [](const PlaneJetForce& f) { return f.mean.mean / CylinderInJet(f.ratio).force(); };
  for (std::size_t i = 0; i < runs.size(); ++i) {
    const double exact = CylinderInJet(all[i].ratio).force();
    const std::string name = runs[i].name + ": force over the exact one";
    Check& force = result
                       .check_relative(Label::verification, name, over_exact(all[i]), 1.0, "", aim,
                                       "what the plate reaches; standard errors are up to 0.01")
                       .in_summary(Quantity::force, 0.001, all[i].unit * exact);
    if (const auto known = known_excess.find(runs[i].name); known != known_excess.end())
      force.known_miss(known->second, "the layer at the wall loses speed, and the fluid is compressible: see the README");
    result.notes.push_back(fmt::format("{}: diameter/d {:.4f}, force over ρU²d {:.4f} (standard error {:.4f}), exact {:.4f}.", runs[i].name,
                                       all[i].ratio, all[i].mean.mean, all[i].mean.standard_error, exact));
  }
  const auto relative = [](const PlaneJetForce& f) {
    std::vector<double> values;
    const double exact = CylinderInJet(f.ratio).force();
    for (const double v : f.force) values.push_back(v / exact);
    return values;
  };
  result.plots.push_back({"force",
                          "Force on the cylinder, over the exact one",
                          "time [b/U]",
                          "force / exact force [-]",
                          {{"exact", {0.0, jet_means_to}, {1.0, 1.0}, Series::Style::reference},
                           {"5 cells", all[0].time, relative(all[0]), Series::Style::simulation},
                           {"8 cells", all[1].time, relative(all[1]), Series::Style::simulation}}});
  if (!own_run(context)) return;
  const PlaneJetForce& old = all.back();
  result.notes.push_back(fmt::format(
      "With nodal contact, APIC and an aligned lattice the force at eight cells is {:.3f} times the exact one.", over_exact(old)));
  result.plots.back().series.push_back({"8 cells, contact on nodes, APIC, aligned", old.time, relative(old), Series::Style::simulation});
}

const Registration registered{{.title = "A cylinder in a plane jet: smooth separation", .run = run, .setups = setups}};

}  // namespace
}  // namespace mpm::validation::cylinder_in_jet
