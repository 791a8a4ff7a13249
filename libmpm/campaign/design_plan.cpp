#include "libmpm/campaign/design_plan.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <nlohmann/json.hpp>
#include <numbers>
#include <optional>
#include <regex>

#include "libmpm/base/error.hpp"
#include "libmpm/driver/build_info.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/sampling.hpp"
#include "libmpm/impact/conveyor_spec.hpp"
#include "libmpm/impact/semi_empirical.hpp"
#include "libmpm/io/json.hpp"

namespace mpm {

namespace {

constexpr std::array ladder{3, 5, 7, 11, 15, 21};  ///< cells in the smaller of w and H

/// Grids up to an entry of the ladder. @param wanted  how many; 0: three
std::vector<int> grids_up_to(std::ptrdiff_t finest, int wanted) {
  const auto count = std::min<std::ptrdiff_t>(wanted == 0 ? 3 : wanted, finest + 1);
  return {ladder.begin() + (finest + 1 - count), ladder.begin() + finest + 1};
}

/// An odd number of cells across the mast that gives at least the requested cells in the smaller of w and H.
double cell_size_of(const Site& site, int cells) {
  const double w = site.mast.facing_width(), across = cells * std::max(1.0, w / site.flow.depth);
  const double odd = 2.0 * std::ceil(0.5 * (across - 1.0) - 1e-9) + 1.0;
  return w / odd;
}

double duration_of(const Site& site) {
  if (site.plan.duration) return *site.plan.duration;
  constexpr double least_steady = 3.0, way = 20.0;  // s; over max(w, H)
  const double rise = site.flow.velocity / site.gravity();
  const double needed = std::max(2.0 * rise + std::max(3.0 * rise, least_steady),
                                 way * std::max(site.mast.facing_width(), site.flow.depth) / site.flow.velocity);
  return std::ceil(10.0 * needed) / 10.0;
}

/// The compact window, in whole widths of the mast, which are whole cells on every grid. That of snow that jams is larger; advice asks for
/// it.
CompactWindow window_of(const Site& site) {
  const SiteMast& mast = site.mast;
  const Eigen::AlignedBox2d plan = outline_of(mast.obstacle().shape).bounds();
  const WindowFlow flow{
      .froude = froude_number(site.flow.velocity, site.flow.depth, site.gravity()), .height = site.flow.depth, .critical_state_ratio = 0.0};
  CompactWindow window = compact_window(flow, plan.sizes().y(), plan.max().x());
  const double w = mast.facing_width();
  constexpr double beside = 2.5;  // of r, between the end of an arm and the side wall: as beside the mast with w = r
  if (site.arm) window.width = std::max(window.width, site.arm->length + 2.0 * beside * std::max(w, std::sqrt(w * flow.height)));
  const auto whole = [&](double length) { return w * std::ceil(length / w - 1e-9); };
  return {2.0 * whole(0.5 * window.width), whole(window.upstream_length), whole(window.downstream_length)};
}

/// The keys of an arm with their values.
std::vector<std::pair<std::string, double>> keys_of(const ArmSpec& arm) {
  std::vector<std::pair<std::string, double>> keys;
  for (const auto& p : parameters_of<ArmSpec>().all()) keys.emplace_back(p.info.name, std::get<double>(*p.get(arm)));
  return keys;
}

/// The common part of all cases as TOML: everything except snow and grid.
std::string base_case(const Site& site) {
  const SiteFlow& flow = site.flow;
  const SiteMast& mast = site.mast;
  const CompactWindow window = window_of(site);
  const double w = mast.facing_width(), smaller = std::min(w, flow.depth);
  const bool box = mast.shape == SiteMast::Shape::box;
  std::string text = fmt::format(
      "[material]\nmodel = \"cohesive_cam_clay\"\ndensity_kg_m3 = {}\ncritical_state_slope = 0.5\ncohesion_beta = 0.0\n"
      "hardening_xi = 5.0\n",
      flow.density);
  text += fmt::format(
      "[conveyor]\nvelocity_m_s = {}\nflow_height_m = {}\nwidth_m = {}\nfeed = \"window\"\nupstream_length_m = {}\ndownstream_length_m = "
      "{}\n"
      "mirror_y = {}\n",
      flow.velocity, flow.depth, window.width, window.upstream_length, window.downstream_length, mast.angle == 0.0);
  text += fmt::format("[obstacle]\nshape = \"{}\"\nwidth_m = {}\nfriction = {}\n", box ? "box" : "cylinder", w, mast.friction);
  if (box) text += fmt::format("depth_m = {}\n", *mast.depth);
  if (mast.angle != 0.0) text += fmt::format("rotation_deg = {}\n", mast.angle * 180.0 / std::numbers::pi);
  if (mast.height) text += fmt::format("height_m = {}\n", *site.exposed_height());
  if (site.arm) {
    ArmSpec arm = *site.arm;  // above the bed
    arm.base -= flow.snow_cover;
    arm.height -= flow.snow_cover;
    text += "[arm]\n";
    for (const auto& [key, value] : keys_of(arm)) text += fmt::format("{} = {}\n", key, value);
  }
  text += fmt::format("[numerics]\ncell_size_m = {}\ngravity_m_s2 = {}\n", cell_size_of(site, 5), site.gravity());
  // The paper's windows at seven cells: bins of dx/2, a filter of 13 bins, a box from -0.5 dx to 2.5 dx.
  const double bin = smaller / 14.0;
  text += fmt::format("[measurement]\nbin_height_m = {}\nfilter_length_m = {}\nbox_upstream_m = {}\nbox_inside_m = {}\n", bin, 13.0 * bin,
                      5.0 * bin, bin);
  text += fmt::format("[output]\nduration_s = {}\nseries_per_second = 100\nframes_per_second = 0\n", duration_of(site));
  return text;
}

/// Keys of a case file, each with the key of the site file that it comes from.
std::vector<std::pair<std::string, std::string>> keys_of_the_site(const Site& site) {
  const std::string above = site.flow.snow_cover > 0.0 ? " less flow.snow_cover_m" : "";
  return {{"obstacle.height_m", "mast.height_m" + above}, {"obstacle.width_m", "mast.width_m"},
          {"obstacle.friction", "mast.friction"},         {"arm.base_m", "arm.base_m" + above},
          {"arm.height_m", "arm.height_m" + above},       {"conveyor.velocity_m_s", "flow.velocity_m_s"},
          {"conveyor.flow_height_m", "flow.depth_m"},     {"material.density_kg_m3", "flow.density_kg_m3"},
          {"numerics.cell_size_m", "plan.finest_cells"},  {"output.duration_s", "plan.duration_s"}};
}

/// A text in which keys of a case file are replaced by those of the site file that they come from.
std::string in_words_of_the_site(std::string text, const Site& site) {
  static const std::regex cell_size(R"(numerics\.cell_size_m = ([0-9]+\.?[0-9]*(e-[0-9]+)?))");
  for (std::smatch found; std::regex_search(text, found, cell_size);) {
    const double needed = std::min(site.mast.facing_width(), site.flow.depth) / std::stod(found[1]);
    const auto cells = std::ranges::find_if(ladder, [&](int n) { return n >= std::max(needed, 5.0) - 1e-6; });
    const std::string key =
        cells == ladder.end() ? "a finer grid than plan.finest_cells = 21" : fmt::format("plan.finest_cells = {}", *cells);
    text = found.prefix().str() + key + found.suffix().str();
  }
  for (const auto& [of_case, of_site] : keys_of_the_site(site)) {
    for (std::size_t at = text.find(of_case); at != std::string::npos; at = text.find(of_case, at + of_site.size()))
      text.replace(at, of_case.size(), of_site);
  }
  return text;
}

/// Refuses overrides of what the site file or the ensemble decides: the page would describe another mast than that of its runs.
/// @param overrides  "table.key=value". @throws ConfigError
void refuse_keys_of_the_site(const std::vector<std::string>& overrides, const Site& site) {
  const std::vector<std::pair<std::string, std::string>> further{{"conveyor.froude_number", "flow.froude_number"},
                                                                 {"conveyor.inflow", "[flow]"},
                                                                 {"conveyor.inflow_csv", "[flow]"},
                                                                 {"material.model", "[[snow]]"},
                                                                 {"material.critical_state_slope", "[[snow]]"},
                                                                 {"material.cohesion_beta", "[[snow]]"},
                                                                 {"material.hardening_xi", "[[snow]]"},
                                                                 {"numerics.gravity_m_s2", "flow.slope_deg"},
                                                                 {"numerics.slope_deg", "flow.slope_deg"},
                                                                 {"obstacle.", "[mast]"},  // all keys of these tables
                                                                 {"arm.", "[arm]"}};
  for (const std::string& text : overrides) {
    std::string key = text.substr(0, text.find('='));
    std::erase_if(key, [](char c) { return c == ' ' || c == '\t'; });  // as the reader does
    for (const auto& keys : {keys_of_the_site(site), further}) {
      const auto decided =
          std::ranges::find_if(keys, [&](const auto& k) { return k.first.ends_with('.') ? key.starts_with(k.first) : key == k.first; });
      if (decided != keys.end())
        throw ConfigError(fmt::format("--set {}: the site file decides {} of every run; give {} there", text, key, decided->second));
    }
  }
}

/// The ensemble on these grids.
DesignPlan ensemble(const Site& site, DesignLevel level, const std::vector<int>& cells, const std::vector<std::string>& overrides) {
  DesignPlan plan{.site = site, .level = level, .overrides = overrides, .snows = design_snows(site), .cells = cells};
  for (const int n : cells) plan.cell_size.push_back(cell_size_of(site, n));
  plan.duration = duration_of(site);
  CampaignPlan campaign;
  campaign.title = site.title.empty() ? "Design" : site.title;
  campaign.base_text = write_case(parse_case(base_case(site), "the case of the site", overrides));
  campaign.base_name = "the case of the site";
  campaign.threads = 2;
  campaign.keep_final = true;
  for (std::size_t s = 0; s < plan.snows.size(); ++s) {
    for (std::size_t g = 0; g < cells.size(); ++g) {
      const SiteSnow& snow = plan.snows[s];
      PlannedRun run{fmt::format("{}_w{}", snow.name, cells[g]),
                     {{"material.critical_state_slope", fmt::format("{}", snow.critical_state_slope)},
                      {"material.cohesion_beta", fmt::format("{}", snow.cohesion_beta)},
                      {"material.hardening_xi", fmt::format("{}", snow.hardening_xi)},
                      {"numerics.cell_size_m", fmt::format("{}", plan.cell_size[g])}}};
      plan.runs.push_back({run.name, s, g});
      campaign.runs.push_back(std::move(run));
    }
  }
  plan.campaign = make_campaign(std::move(campaign));
  for (const CampaignRun& run : plan.campaign.runs) plan.particle_steps += run.cost.particle_steps;
  return plan;
}

}  // namespace

std::string to_string(DesignLevel level) { return level == DesignLevel::quick ? "quick" : "standard"; }

double design_budget(DesignLevel level) {
  constexpr double quick = 600.0, standard = 3600.0, runs = 5.0 / 6.0;  // s; fraction of the time for the runs
  return runs * (level == DesignLevel::quick ? quick : standard) * assumed_particle_steps_per_s;
}

DesignPlan make_design(const Site& site, DesignLevel level, const std::vector<std::string>& overrides) {
  refuse_keys_of_the_site(overrides, site);
  const SitePlan& wanted = site.plan;
  if (wanted.finest_cells != 0) {
    const auto finest = std::ranges::find(ladder, wanted.finest_cells) - ladder.begin();
    return ensemble(site, level, grids_up_to(finest, wanted.grids), overrides);
  }
  const std::ptrdiff_t coarsest = wanted.grids == 3 ? 2 : 1;  // taken if no set is within the budget
  std::optional<DesignPlan> plan;
  for (std::ptrdiff_t finest = ladder.size() - 1; finest >= coarsest; --finest) {
    plan = ensemble(site, level, grids_up_to(finest, wanted.grids), overrides);
    if (plan->particle_steps <= design_budget(level)) break;
  }
  return *std::move(plan);
}

std::vector<DesignAdvice> design_advice(const DesignPlan& plan) {
  std::vector<DesignAdvice> all;
  for (std::size_t r = 0; r < plan.runs.size(); ++r) {
    if (plan.runs[r].grid + 1 != plan.cells.size()) continue;
    for (const Advice& found : advise(plan.campaign.runs[r].spec)) {
      const std::string text = in_words_of_the_site(found.text(), plan.site);
      const auto same = std::ranges::find_if(all, [&](const DesignAdvice& a) { return a.text == text; });
      DesignAdvice& entry = same == all.end() ? all.emplace_back(DesignAdvice{found.rule, text, {}}) : *same;
      entry.snows.push_back(plan.snows[plan.runs[r].snow].name);
    }
  }
  return all;
}

std::string design_plan_json(const DesignPlan& plan) {
  using Json = nlohmann::ordered_json;
  const Site& site = plan.site;
  const BuildInfo build = build_info();
  Json root;
  root["format_version"] = site_format_version;
  root["title"] = site.title;
  root["author"] = site.author;
  root["project"] = site.project;
  root["version"] = build.version;
  root["commit"] = build.commit;
  root["level"] = to_string(plan.level);
  root["flow"] = Json{{"depth_m", site.flow.depth},
                      {"velocity_m_s", site.flow.velocity},
                      {"froude_number", site.froude_number()},
                      {"density_kg_m3", site.flow.density},
                      {"slope_deg", site.flow.slope * 180.0 / std::numbers::pi},
                      {"gravity_m_s2", site.gravity()},
                      {"snow_cover_m", site.flow.snow_cover},
                      {"snow_class", site.flow.snow_class ? Json(to_string(*site.flow.snow_class)) : Json()},
                      {"source", site.flow.source}};
  root["mast"] = Json{{"shape", site.mast.shape == SiteMast::Shape::box ? "box" : "cylinder"},
                      {"width_m", site.mast.width},
                      {"depth_m", site.mast.depth.value_or(site.mast.width)},
                      {"facing_width_m", site.mast.facing_width()},
                      {"height_m", site.mast.height ? Json(*site.mast.height) : Json()},
                      {"angle_deg", site.mast.angle * 180.0 / std::numbers::pi},
                      {"taper", site.mast.taper},
                      {"top_mass_ratio", site.mast.top_mass_ratio},
                      {"friction", site.mast.friction},
                      {"drag_coefficient", site.mast.drag_coefficient ? Json(*site.mast.drag_coefficient) : Json()}};
  if (site.arm) {
    for (const auto& [key, value] : keys_of(*site.arm)) root["arm"][key] = value;
  }
  root["modes"] = Json::array();
  for (const SiteMode& mode : site.modes)
    root["modes"].push_back({{"frequency_hz", mode.frequency},
                             {"damping_ratio", mode.damping_ratio},
                             {"shape_at_load", mode.shape_at_load ? Json(*mode.shape_at_load) : Json()}});
  root["range"] = Json{{"depth_ratio", site.range.depth}, {"velocity_ratio", site.range.velocity}, {"density_ratio", site.range.density}};
  root["scenarios"] = Json::array();
  for (const SiteScenario& scenario : site.scenarios)
    root["scenarios"].push_back({{"name", scenario.name},
                                 {"depth_m", scenario.depth},
                                 {"velocity_m_s", scenario.velocity},
                                 {"density_kg_m3", scenario.density.value_or(site.flow.density)}});
  root["snows"] = Json::array();
  for (const SiteSnow& snow : plan.snows) {
    root["snows"].push_back({{"name", snow.name},
                             {"critical_state_slope", snow.critical_state_slope},
                             {"cohesion_beta", snow.cohesion_beta},
                             {"hardening_xi", snow.hardening_xi},
                             {"effective_friction", effective_friction(snow.critical_state_slope, snow.cohesion_beta)},
                             {"source", snow.source}});
  }
  root["grids"] = Json::array();
  for (std::size_t g = 0; g < plan.cells.size(); ++g)
    root["grids"].push_back({{"cells", plan.cells[g]}, {"cell_size_m", plan.cell_size[g]}});
  const Case& first = plan.campaign.runs.front().spec;
  root["numerics"] =
      Json{{"contact", case_value(first, "numerics.contact").value()}, {"transfer", case_value(first, "numerics.transfer").value()}};
  root["overrides"] = plan.overrides;
  root["duration_s"] = plan.duration;
  root["particle_steps"] = plan.particle_steps;
  root["runs"] = Json::array();
  for (std::size_t r = 0; r < plan.runs.size(); ++r) {
    const CampaignRun& run = plan.campaign.runs[r];
    root["runs"].push_back({{"name", run.name},
                            {"snow", plan.runs[r].snow},
                            {"grid", plan.runs[r].grid},
                            {"case_hash", run.case_hash},
                            {"end_s", Sampling(run.spec).end()}});
  }
  root["advice"] = Json::array();
  for (const DesignAdvice& a : design_advice(plan)) root["advice"].push_back({{"rule", a.rule}, {"text", a.text}, {"snows", a.snows}});
  root[checksum_entry] = no_checksum;
  return with_checksum(root.dump(2) + "\n");
}

}  // namespace mpm
