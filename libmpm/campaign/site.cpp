#include "libmpm/campaign/site.hpp"

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <set>

#include "libmpm/base/error.hpp"
#include "libmpm/campaign/plan.hpp"
#include "libmpm/config/guard.hpp"
#include "libmpm/config/reader.hpp"
#include "libmpm/impact/semi_empirical.hpp"

namespace mpm {

std::string to_string(SnowClass c) {
  static constexpr std::array names{"loose", "cold_dense", "warm_cohesive"};
  return names.at(static_cast<std::size_t>(c));
}

double Site::gravity() const { return standard_gravity * std::cos(flow.slope); }
ObstacleSpec SiteMast::obstacle() const {
  ObstacleSpec made{.height = height};
  if (shape == Shape::cylinder) {
    made.shape = CylinderShape{width};
  } else {
    made.shape = BoxShape{width, depth.value_or(width), angle};
  }
  return made;
}

std::optional<double> Site::exposed_height() const { return mast.height ? std::optional(*mast.height - flow.snow_cover) : std::nullopt; }
double Site::froude_number() const { return mpm::froude_number(flow.velocity, flow.depth, gravity()); }

const config::SchemaOf<Site>& site_schema() {
  static const config::SchemaOf<Site> schema = [] {
    config::SchemaOf<Site> s;
    s.command = "mpm schema --site";
    s.table(
        "", "Keys above the first table", [](auto& site) -> auto& { return site; });
    s.table("flow", "The avalanche before it meets the mast", &Site::flow);
    s.table("snow", "Parameters of the snow, instead of flow.snow_class; the page shows the range over all entries", &Site::snows);
    s.table("mast", "The mast: rigid, upright, with separable Coulomb contact", &Site::mast);
    s.table("arm", "Cross-arm of the mast: a beam across the flow, as in a case file, heights above the ground; left out: none",
            &Site::arm);
    s.table("mode", "Modes of vibration of the mast in the direction of the flow, any number; the ten lowest count", &Site::modes);
    s.table("range", "Uncertainty of the avalanche: the page scales the loads to the ends, without runs", &Site::range);
    s.table("scenario",
            "Up to three other avalanches at the same mast, as of other return periods: the page scales the loads, without runs",
            &Site::scenarios);
    s.table("plan", "Grids and duration; if left out, they follow from the level (--quick or standard)", &Site::plan);
    return s;
  }();
  return schema;
}

namespace {

void resolve_speed(Site& site, ParameterReport& report) {
  const std::string froude = "flow.froude_number", velocity = "flow.velocity_m_s";
  if (!report.given(froude) && !report.given(velocity)) return report.problem("flow", "has no speed; give velocity_m_s, or froude_number");
  if (!site.flow.froude_number) return;
  const double fr = *site.flow.froude_number;
  site.flow.froude_number.reset();
  if (report.all_valid({froude, "flow.depth_m", "flow.slope_deg"})) site.flow.velocity = flow_velocity(fr, site.flow.depth, site.gravity());
}

/// Entries of a table that the page tells apart by their names. @param table  "snow"
template <class Entry>
void refuse_equal_names(const std::vector<Entry>& entries, const std::string& table, ParameterReport& report) {
  std::set<std::string> names;
  for (std::size_t i = 0; i < entries.size(); ++i) {
    const std::string &name = entries[i].name, here = fmt::format("{}[{}].name", table, i);
    if (name.empty() && report.given(here)) report.problem(here, fmt::format("= \"\" is no name; give the {} one", table));
    if (!names.insert(name).second)
      report.problem(here, fmt::format("= \"{}\" is given twice; give each {} a name of its own", name, table));
  }
}

void resolve_snows(Site& site, ParameterReport& report) {
  if (site.snows.empty() && !site.flow.snow_class && report.all_valid({"flow.snow_class", "snow"}))
    return report.problem("flow", "says nothing about the snow; give snow_class = \"loose\", \"cold_dense\" or \"wet_dense\", or [[snow]]");
  if (!site.snows.empty() && report.given("flow.snow_class"))
    report.problem("flow.snow_class", "is given beside [[snow]]; leave out one of the two");
  constexpr std::size_t most_snows = 12;
  if (site.snows.size() > most_snows)
    report.problem("snow[12]", fmt::format("is one of {} sets of parameters; at most {} are possible", site.snows.size(), most_snows));
  std::set<std::array<double, 3>> parameters;
  for (std::size_t i = 0; i < site.snows.size(); ++i) {
    SiteSnow& snow = site.snows[i];
    if (snow.name.empty()) snow.name = fmt::format("snow_{}", i + 1);
    const std::string entry = fmt::format("snow[{}]", i), key = entry + ".name";
    if (const std::string why = name_problem(snow.name); !why.empty()) report.problem(key, "= " + why);
    if (report.all_valid({entry + ".critical_state_slope", entry + ".cohesion_beta", entry + ".hardening_xi"}) &&
        !parameters.insert({snow.critical_state_slope, snow.cohesion_beta, snow.hardening_xi}).second)
      report.problem(entry, "has the parameters of an earlier entry; leave out one of the two");
  }
  refuse_equal_names(site.snows, "snow", report);
}

/// The arm against the mast, as in a case, and against the snow cover.
void check_arm(const Site& site, ParameterReport& report) {
  if (!site.arm) return;
  TableReport own(report, "arm");
  if (site.mast.width > 0.0 && report.all_valid({"mast.shape", "mast.width_m", "mast.depth_m", "mast.angle_deg", "mast.height_m"}))
    site.arm->check_on(site.mast.obstacle(), "mast", own);
  if (report.all_valid({"arm.base_m", "flow.snow_cover_m"}) && site.arm->base < site.flow.snow_cover)
    own.problem("base_m", fmt::format("= {} is in the snow cover, which reaches to {} m; heights are above the ground", site.arm->base,
                                      site.flow.snow_cover));
}

/// The mast against the depth of a flow. @param key  of the depth @param flow  whose it is, for messages
void check_mast_in(const std::string& key, double depth, const std::string& flow, const Site& site, ParameterReport& report) {
  const SiteMast& mast = site.mast;
  if (!report.all_valid({key, "mast.width_m", "mast.depth_m", "mast.angle_deg"}) || !(depth > 0.0) || !(mast.width > 0.0)) return;
  const double cover = site.flow.snow_cover;
  if (report.all_valid({"mast.height_m", "flow.snow_cover_m"}) && mast.height && *site.exposed_height() < depth) {
    report.problem("mast.height_m", fmt::format("= {} m is lower than {}{}, {} m; a mast is higher, check the unit", *mast.height, flow,
                                                cover > 0.0 ? " on its snow cover" : "", depth + cover));
  }
  constexpr double least = 0.1, most = 10.0;
  const double ratio = mast.facing_width() / depth;
  if (ratio < least || ratio > most) {
    report.problem("mast.width_m",
                   fmt::format("= {} m is {:.3g} times the depth of {}; {} to {} times can be computed (the paper: 0.5 to 3)",
                               mast.facing_width(), ratio, flow, least, most));
  }
}

void resolve(Site& site, ParameterReport& report) {
  resolve_speed(site, report);
  resolve_snows(site, report);
  if (site.mast.shape == SiteMast::Shape::box && !site.mast.depth) site.mast.depth = site.mast.width;
  check_mast_in("flow.depth_m", site.flow.depth, "the flow", site, report);
  check_arm(site, report);
  std::set<double> frequencies;
  for (std::size_t i = 0; i < site.modes.size(); ++i) {
    const double frequency = site.modes[i].frequency;
    if (!frequencies.insert(frequency).second)
      report.problem(fmt::format("mode[{}].frequency_hz", i), fmt::format("= {} Hz is given twice; give each mode once", frequency));
  }
  if (site.plan.finest_cells == 5 && site.plan.grids == 3)
    report.problem("plan.grids", "= 3 with finest_cells = 5: below it there is only the grid of 3 cells; give 2, or a larger finest_cells");
  constexpr std::size_t most_scenarios = 3;
  if (site.scenarios.size() > most_scenarios)
    report.problem("scenario[3]", fmt::format("is one of {} scenarios; at most {} are possible", site.scenarios.size(), most_scenarios));
  refuse_equal_names(site.scenarios, "scenario", report);
  for (std::size_t i = 0; i < site.scenarios.size(); ++i) {
    const SiteScenario& scenario = site.scenarios[i];
    check_mast_in(fmt::format("scenario[{}].depth_m", i), scenario.depth, fmt::format("the flow of scenario \"{}\"", scenario.name), site,
                  report);
  }
}

/// Members of a class: M' from low to high, the middle one is the paper's.
std::vector<SiteSnow> members(const char* name, std::array<double, 3> friction, double beta, double xi, const char* source) {
  std::vector<SiteSnow> snows;
  static constexpr std::array ends{"low", "middle", "high"};
  for (std::size_t i = 0; i < 3; ++i) {
    const double slope = std::round(1e3 * friction[i] / effective_friction(1.0, beta)) * 1e-3;
    snows.push_back({fmt::format("{}_{}", name, ends[i]), slope, beta, xi, source});
  }
  return snows;
}

}  // namespace

Site parse_site(std::string_view text, std::string_view file_name) try {
  return config::read(site_schema(), text, file_name, {}, resolve);
} catch (const ConfigError& error) {
  if (config::has_table(text, "numerics") && config::has_table(text, "output"))
    throw ConfigError(fmt::format("{0}: this is a case file, not a site file; run `mpm run {0}`", file_name));
  throw ConfigError(fmt::format("{}\n(keys of a site file: mpm schema --site)", error.what()));
}
Site read_site(const std::filesystem::path& file) { return parse_site(config::bounded_file_text(file), file.string()); }
std::string write_site(const Site& site) { return config::write(site_schema(), &site, config::Defaults::shown); }

std::vector<SiteSnow> design_snows(const Site& site) {
  if (!site.flow.snow_class) return site.snows;
  switch (*site.flow.snow_class) {
    case SnowClass::loose:
      return members(
          "loose", {0.45, 0.5933, 0.65}, 0.15, 0.5,
          "beta and xi of the paper's dry, loose avalanche (Sect. 4.3); M' from 0.45 to 0.65 corresponds to lambda = 1.5 (Sect. 4.2)");
    case SnowClass::cold_dense:
      return members("cold_dense", {1.0, 1.3214, 1.5}, 0.3, 1.5,
                     "beta and xi of the paper's dense avalanche (Sect. 4.3); M' from 1.0 to 1.5 corresponds to lambda = 3 (Sect. 4.2)");
    case SnowClass::warm_cohesive:
      return members("warm_cohesive", {1.0, 1.25, 1.5}, 0.45, 5.0,
                     "assumed: the most cohesive and least compressible snow of the relevant range of the paper's Table 1; M' of dense "
                     "avalanches, among which the guideline counts wet ones");
  }
  return {};
}

config::Reference site_reference() {
  config::Reference made{.format_version = site_format_version, .files = "site files of mpm design"};
  const Site empty;
  for (const config::Table& table : site_schema().tables()) made.add(table, &empty, false, false);
  return made;
}

}  // namespace mpm
