#include "libmpm/driver/observers.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>
#include <nlohmann/json.hpp>

#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/run_record.hpp"
#include "libmpm/impact/conveyor.hpp"
#include "libmpm/impact/semi_empirical.hpp"
#include "libmpm/observe/conservation.hpp"
#include "libmpm/observe/contact_force.hpp"
#include "libmpm/observe/force_by_height.hpp"
#include "libmpm/observe/observer_list.hpp"
#include "libmpm/observe/particles_inside_obstacle.hpp"
#include "libmpm/observe/prediction.hpp"
#include "libmpm/observe/pressure_profile.hpp"
#include "libmpm/observe/runup.hpp"
#include "libmpm/observe/steady_interval.hpp"

namespace mpm {

namespace {

/// Arguments for making observers.
struct ObserverArguments {
  const Case& c;
  const CaseScene& scene;
  std::optional<ImpactGeometry> geometry;  ///< of impacts
  ImpactFlow flow;                         ///< of impacts
};

/// Which cases an observer applies to.
struct CaseClass {
  const char* cases;
  bool (*includes)(const ObserverArguments&);
};
constexpr const char* after_post = "folders that mpm post wrote";
constexpr CaseClass always{"every case", [](const ObserverArguments&) { return true; }};
constexpr CaseClass obstacle{"cases with an obstacle", [](const ObserverArguments& s) { return s.scene.obstacle.has_value(); }};
constexpr CaseClass arm{"cases with an arm", [](const ObserverArguments& s) { return s.scene.arm.has_value(); }};
constexpr CaseClass impact_on_arm{"cases with a conveyor and an arm",
                                  [](const ObserverArguments& s) { return s.geometry.has_value() && s.scene.arm.has_value(); }};
constexpr CaseClass impact{"cases with a conveyor and an obstacle", [](const ObserverArguments& s) { return s.geometry.has_value(); }};

template <class T, class... Arguments>
std::shared_ptr<Observer> make(Arguments&&... arguments) {
  return std::make_shared<T>(std::forward<Arguments>(arguments)...);
}

/// A pile is settled when the snow that was there at the start has passed, too.
StopRule stop_rule(const ObserverArguments& s) {
  const ConveyorSpec& belt = *s.c.conveyor;
  const double filled = belt.feed == ConveyorSpec::Feed::window ? belt.upstream_length + belt.downstream_length : 0.0;
  const double passage = std::max(filled, settled_passage_heights * std::max(s.c.obstacle->width(), belt.flow_height));
  return impact_stop_rule(s.c.output.stop_when_steady, s.flow, belt.flow_height, passage);
}

/// Depth of the flow, or of the bodies at the start above the obstacle's foot; of bodies below that its width.
double snow_depth(const Case& c) {
  if (c.conveyor) return c.conveyor->flow_height;
  double top = 0.0;
  for (const BodySpec& body : c.bodies) top = std::max(top, body.max.z());
  const double foot = c.obstacle->solid().foot();
  return top > foot ? top - foot : c.obstacle->width();
}

ParticlesInsideObstacle::Setting inside_setting(const ObserverArguments& s) {
  return {s.c.numerics.cell_size, s.c.material.density(), snow_depth(s.c), s.scene.mirror};
}

/// x of the axis of the obstacle's overturning moment, m.
double mast_axis(const ObserverArguments& s) { return outline_of(s.c.obstacle->shape).centre().x(); }

struct Entry {
  CaseClass applies;
  std::shared_ptr<Observer> (*make)(const ObserverArguments&);
};

/// The list of all observers. A new one needs its file and a line here. The order is that of columns and results.
constexpr Entry list[] = {
    {always, [](const ObserverArguments& s) { return make<RunRecord>(s.c.title, case_hash_text(s.c)); }},
    {always, [](const ObserverArguments& s) { return make<ParticleFlux>(s.c.conveyor.has_value(), s.scene.mirror); }},
    {impact, [](const ObserverArguments& s) { return make<SteadyInterval>(s.flow, s.c.measurement.steady_column()); }},
    {impact, [](const ObserverArguments& s) { return make<StopWhenSteady>(stop_rule(s), s.c.measurement.steady_column()); }},
    {impact, [](const ObserverArguments& s) { return make<Runup>(*s.geometry); }},
    {impact, [](const ObserverArguments& s) { return make<PressureProfile>(*s.geometry); }},
    {obstacle, [](const ObserverArguments& s) { return make<ContactForce>(*s.scene.obstacle); }},
    {arm, [](const ObserverArguments& s) { return make<ContactForce>(*s.scene.arm, ContactForce::On::arm); }},
    {obstacle, [](const ObserverArguments& s) { return make<ParticlesInsideObstacle>(solids_of(s.c), inside_setting(s)); }},
    {impact, [](const ObserverArguments& s) { return make<ForceByHeight>(*s.geometry, 0U); }},
    {impact, [](const ObserverArguments& s) { return make<TransientForce>(s.flow, s.geometry->force_window, mast_axis(s)); }},
    {impact_on_arm, [](const ObserverArguments& s) { return make<ArmLoads>(s.flow, s.geometry->force_window, mast_axis(s)); }},
    {impact, [](const ObserverArguments& s) { return make<NumericalUncertainty>(grid_uncertainty(grid_resolution(s.c)), mast_axis(s)); }},
    {impact, [](const ObserverArguments& s) { return make<Prediction>(s.flow, s.geometry->flow_height); }},
    {always, [](const ObserverArguments&) { return make<Conservation>(); }},
    {always, [](const ObserverArguments&) { return make<HealthCheck>(); }},
};

/// The flow of a case with a conveyor; with M' where the law has one.
ImpactFlow impact_flow(const Case& c) {
  ImpactFlow flow;
  flow.velocity = c.conveyor->velocity;
  flow.gravity = c.numerics.gravity * std::cos(c.numerics.slope);  // along which snow rises and falls
  flow.constant = constant_flow(*c.conveyor, flow.gravity, c.output.duration);
  if (const auto ratio = c.material.critical_state_ratio()) flow.effective_friction = *ratio;
  return flow;
}

ObserverArguments setting_of(const Case& c, const CaseScene& scene) {
  ObserverArguments setting{c, scene, impact_geometry(c), {}};
  if (setting.geometry) setting.flow = impact_flow(c);
  return setting;
}

}  // namespace

std::optional<ImpactGeometry> impact_geometry(const Case& c) {
  if (!c.conveyor || !c.obstacle) return std::nullopt;
  ImpactGeometry geometry = paper_geometry(c.conveyor->flow_height, c.obstacle->width(), c.numerics.cell_size, c.material.density(),
                                           c.conveyor->mirror_y || c.domain.mirror_y, c.measurement);
  geometry.set_obstacle(*c.obstacle);
  geometry.uneven_ground = c.terrain.has_value();
  return geometry;
}

SnowTraits snow_traits(const MaterialParameters& snow) {
  if (snow.internal_friction().value_or(0.0) == 0.0) return {.fluid = true};
  constexpr double studied_xi = 0.5;  // at 1.5 the run-up converges as that of hardly compressible snow
  constexpr double converging = 1.5;  // largest M' of it; 1.42 converges, 1.53 does not
  const bool compressible = snow.hardening_xi().value_or(std::numeric_limits<double>::infinity()) <= studied_xi;
  const bool cohesive = snow.cohesion_beta().value_or(0.0) > 0.0;
  return {.compressible_cohesive = compressible && cohesive, .stiff = snow.critical_state_ratio().value_or(0.0) > converging};
}

GridResolution grid_resolution(const Case& c) {
  constexpr double least_friction = 0.05;  // studied: none at all, and from 0.095 on
  GridResolution r{.contact = c.numerics.contact,
                   .transfer = c.numerics.transfer,
                   .front = c.obstacle->front(),
                   .snow = snow_traits(c.material),
                   .smooth = c.obstacle->friction < least_friction};
  const double width = c.obstacle->width(), dx = c.numerics.cell_size;
  r.cells = std::min(width, c.conveyor->flow_height) / dx;
  r.width_excess = nodal_width_ratio(width / dx) - 1.0;
  return r;
}

std::vector<std::shared_ptr<Observer>> make_observers(const Case& c, const CaseScene& scene,
                                                      const std::vector<std::shared_ptr<Observer>>& more) {
  const ObserverArguments setting = setting_of(c, scene);
  std::vector<std::shared_ptr<Observer>> observers;
  for (const Entry& entry : list) {
    if (entry.applies.includes(setting)) observers.push_back(entry.make(setting));
  }
  observers.insert(observers.end(), more.begin(), more.end());
  return observers;
}

Results expected_results(const Case& c) {
  const ObserverList observers(make_observers(c, make_scene(c)));
  const State nothing(c.numerics.cell_size);
  const RunProgress progress;
  return observers.results(observers.summary(&nothing, &progress));
}

namespace {

std::vector<ObserverDescription> descriptions() {
  Case c;  // with all tables, so that every observer applies
  c.conveyor.emplace().velocity = 1.0;
  c.obstacle.emplace();
  c.arm.emplace();
  const CaseScene scene = make_scene(c);
  const ObserverArguments setting = setting_of(c, scene);
  const ObserverList all(make_observers(c, scene));
  const State nothing(c.numerics.cell_size);
  const RunProgress progress;
  const Summary end = all.summary(&nothing, &progress);
  std::vector<ObserverDescription> described;
  for (const Entry& entry : list) {
    const auto o = entry.make(setting);
    ObserverDescription d{o->name(), entry.applies.cases, o->measured_from(), o->columns(), {}, o->summary(end)};
    for (const HeightProfile& profile : o->profiles(end)) d.profiles.push_back(profile.column);
    described.push_back(std::move(d));
  }
  described.push_back({"post", after_post, MeasuredFrom::frames, {}, {}, origin_in_frames(0)});
  return described;
}

}  // namespace

const std::vector<ObserverDescription>& describe_observers() {
  static const std::vector<ObserverDescription> all = descriptions();
  return all;
}

Nature nature_of(std::string_view name) {
  const std::string_view key = name.substr(0, name.find_first_of(".["));
  for (const ObserverDescription& d : describe_observers()) {
    const auto found = std::ranges::find(d.results, key, &Result::name);
    if (found != d.results.end()) return found->nature;
  }
  return Nature::physics;
}

std::vector<std::string> run_entries(Nature nature) {
  std::vector<std::string> names;
  for (const ObserverDescription& d : describe_observers()) {
    if (d.cases == after_post) continue;
    for (const Result& r : d.results) {
      if (r.nature == nature) names.push_back(r.name);
    }
  }
  return names;
}

namespace {

std::string_view text_of(MeasuredFrom from) { return from == MeasuredFrom::frames ? "frames" : "run"; }
std::string_view text_of(Column::Kind kind) {
  return kind == Column::Kind::instant ? "at the time of the row" : "mean over the interval since the row before";
}
std::string_view text_of(Nature nature) {
  return nature == Nature::physics ? "physics" : nature == Nature::uncertainty ? "uncertainty" : "execution";
}

/// Rows of a table of columns under a heading; the components of a vector share a row.
std::string column_rows(const std::string& heading, const std::vector<Column>& columns) {
  std::string text = heading.empty() || columns.empty() ? "" : fmt::format("| **{}** | | |\n", heading);
  std::string names;
  for (const Column& c : columns) {
    names += fmt::format("{}`{}`", names.empty() ? "" : ", ", c.name());
    if (c.axis == 'x' || c.axis == 'y') continue;
    text += fmt::format("| {} | {} | {}{} |\n", names, c.unit, c.meaning,
                        c.kind == Column::Kind::interval_mean ? "; mean over the interval since the row before" : "");
    names.clear();
  }
  return text;
}

/// Rows of a table of results under a heading. Standard errors and effective samples have one row for all.
std::string result_rows(const std::string& heading, const std::vector<Result>& results) {
  std::string text = results.empty() ? "" : fmt::format("| **{}** | | | |\n", heading);
  bool uncertain = false;
  for (const Result& r : results) {
    const bool of_a_mean = r.name.find("standard_error") != std::string::npos || r.name.find("effective_samples") != std::string::npos;
    uncertain = uncertain || of_a_mean;
    if (of_a_mean) continue;
    text += fmt::format("| `{}` | {} | {} | {} |\n", r.name, r.unit, r.meaning, r.nature == Nature::physics ? "yes" : "no");
  }
  if (uncertain) {
    text +=
        "| `..._standard_error_...`, `..._effective_samples` | | standard error of the mean of that name, which accounts for "
        "autocorrelation, and the number of independent samples behind it | no |\n";
  }
  return text;
}

/// "contact force (cases with an obstacle)"
std::string heading_of(const ObserverDescription& d) {
  std::string name = d.name;
  std::ranges::replace(name, '_', ' ');
  return fmt::format("{} ({})", name, d.cases);
}

}  // namespace

std::string observers_markdown() {
  const auto& all = describe_observers();
  std::string text = "## Columns of `series.csv`\n\n| column | unit | meaning |\n|---|---|---|\n";
  text += column_rows("", {TimeSeries(std::vector<Column>()).columns().front()});
  for (const auto& d : all) text += column_rows(heading_of(d), d.columns);
  text += "\n## Columns of `profile.csv`\n\n| column | unit | meaning |\n|---|---|---|\n";
  for (const auto& d : all) {
    for (Column c : d.profiles) {
      c.kind = Column::Kind::instant;  // rows are heights; values are means over the steady interval
      text += column_rows("", {c});
    }
  }
  text += "\n## Quantities of `results.json`\n\n| quantity | unit | meaning | compared by `mpm compare` |\n|---|---|---|---|\n";
  for (const auto& d : all) text += result_rows(heading_of(d), d.results);
  return text;
}

std::string observers_json() {
  using Json = nlohmann::ordered_json;
  Json columns = Json::array(), profiles = Json::array(), results = Json::array();
  const auto describe = [](const Column& c, const std::string& cases, MeasuredFrom from) {
    return Json{{"name", c.name()}, {"unit", c.unit}, {"meaning", c.meaning},          {"value", text_of(c.kind)},
                {"mean", c.mean},   {"cases", cases}, {"measured_from", text_of(from)}};
  };
  columns.push_back(describe(TimeSeries(std::vector<Column>()).columns().front(), always.cases, MeasuredFrom::frames));
  for (const auto& d : describe_observers()) {
    for (const Column& c : d.columns) columns.push_back(describe(c, d.cases, d.measured_from));
    for (const Column& c : d.profiles) profiles.push_back(describe(c, d.cases, d.measured_from));
    for (const Result& r : d.results) {
      results.push_back(Json{{"name", r.name},
                             {"unit", r.unit},
                             {"meaning", r.meaning},
                             {"kind", text_of(r.nature)},
                             {"cases", d.cases},
                             {"measured_from", text_of(d.measured_from)}});
    }
  }
  return Json{{"columns", columns}, {"profiles", profiles}, {"results", results}}.dump(2) + "\n";
}

}  // namespace mpm
