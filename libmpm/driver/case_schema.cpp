#include "libmpm/driver/case_schema.hpp"

#include <fmt/format.h>

#include "libmpm/driver/scene.hpp"
#include "libmpm/driver/schema.hpp"

namespace mpm {

const config::SchemaOf<Case>& case_schema() {
  static const config::SchemaOf<Case> schema = [] {
    config::SchemaOf<Case> s;
    s.table(
        "", "Keys above the first table", [](auto& c) -> auto& { return c; });
    s.table(
        "material", "The snow: one constitutive law and its parameters", [](auto& c) -> auto& { return c.material; });
    s.table(
        "conveyor",
        "The paper's set-up: snow on a frictionless belt between moving side walls meets the obstacle. It replaces [[body]] and [[wall]]",
        [](auto& c) -> auto& { return c.conveyor; });
    s.table("conveyor.inflow",
            "Inflow that varies in time, with feed = \"window\": linear between these rows, constant before the first and after the last",
            [](auto& c) { return c.conveyor ? &c.conveyor->inflow : nullptr; });
    s.table(
        "obstacle", "Rigid obstacle with separable Coulomb contact; left out: none", [](auto& c) -> auto& { return c.obstacle; });
    s.table("body", "A piece of material in a scene by hand (without [conveyor]), any number", [](auto& c) { return &c.bodies; });
    s.table("wall", "A half-space in a scene by hand, any number; the material is on the side of its normal",
            [](auto& c) { return &c.walls; });
    s.table(
        "domain", "Where particles may be. Required in a scene by hand; with [conveyor] it may only cut the belt's own domain",
        [](auto& c) -> auto& { return c.domain; });
    s.table(
        "numerics", "Grid, particles and time step", [](auto& c) -> auto& { return c.numerics; });
    s.table(
        "measurement",
        "Windows of the pressure profile on the obstacle. Left out, they follow the cell size as in the paper; a grid study fixes them",
        [](auto& c) -> auto& { return c.measurement; });
    s.table(
        "output", "How long, and what is written", [](auto& c) -> auto& { return c.output; });
    return s;
  }();
  return schema;
}

const config::SchemaOf<PathFile>& path_schema() {
  static const config::SchemaOf<PathFile> schema = [] {
    config::SchemaOf<PathFile> s;
    s.table(
        "", "Keys above the first table", [](auto& p) -> auto& { return p; });
    s.table(
        "material", "The snow: one constitutive law and its parameters", [](auto& p) -> auto& { return p.material; });
    s.table(
        "path", "Strain path of one material point, for `mpm point`", [](auto& p) -> auto& { return p.steps; });
    s.table("path.segments", "A list of inline tables: {d_eps_v, d_eps_q}, {velocity_gradient, time_s} or {radial_stress_pa, d_eps_axial}",
            [](auto& p) { return &p.segments; });
    return s;
  }();
  return schema;
}

namespace {

/// A mirror plane must lie on a plane of nodes.
void check_grid_offset(const Case& c, ParameterReport& report) {
  if (!report.all_sound({"numerics.grid_offset_cells", "conveyor.mirror_y", "domain.mirror"})) return;
  TableReport own(report, "numerics");
  c.numerics.check_offset(mirror_planes(c), own);
}

/// Either bodies, walls and a domain, or a conveyor, which provides its own.
void check_scene(const Case& c, ParameterReport& report) {
  if (c.conveyor) {
    for (const auto& [table, count] : {std::pair{"body", c.bodies.size()}, {"wall", c.walls.size()}}) {
      for (std::size_t i = 0; i < count; ++i)
        report.problem(fmt::format("{}[{}]", table, i), "is given beside [conveyor], which brings its own; leave out one of the two");
    }
  } else if (c.bodies.empty() && report.sound("body")) {
    report.problem("", "the scene is empty; give [conveyor], or at least one [[body]]");
  }
  const BodySurroundings around{c.numerics.cell_size, c.numerics.particle_spacing(), c.domain.min, c.domain.max,
                                c.obstacle ? &*c.obstacle : nullptr};
  for (std::size_t i = 0; i < c.bodies.size(); ++i) check_body(c.bodies[i], fmt::format("body[{}]", i), around, report);
}

/// Means belong to one state of a flow that meets an obstacle.
void check_stop(const Case& c, ParameterReport& report) {
  const std::string name = "output.stop_when_steady";
  if (!report.all_sound({name, "obstacle", "conveyor"}) || c.output.stop_when_steady == 0.0 || !c.conveyor) return;
  if (!c.obstacle) {
    report.problem(name, fmt::format("= {} has no obstacle to wait for; give [obstacle], or leave the key out", c.output.stop_when_steady));
  } else if (!c.conveyor->inflow.empty()) {
    report.problem(name, fmt::format("= {} needs a steady inflow, and [[conveyor.inflow]] varies it; leave out one of the two",
                                     c.output.stop_when_steady));
  }
}

}  // namespace

void resolve_case(Case& c, ParameterReport& report) {
  check_grid_offset(c, report);
  check_measurement(c.measurement, c.numerics.cell_size, report);
  if (c.obstacle) resolve_friction(*c.obstacle, c.material, report);
  if (!report.sound("conveyor")) return;
  if (c.conveyor)
    resolve_conveyor(*c.conveyor, {c.numerics.cell_size, c.numerics.gravity, c.material, c.obstacle ? &*c.obstacle : nullptr}, report);
  check_scene(c, report);
  check_stop(c, report);
}

// ---- reference ---------------------------------------------------------------------------------------------------------------------

const std::vector<TableInfo>& schema_tables() {
  static const std::vector<TableInfo> tables = [] {
    std::vector<TableInfo> list;
    for (const config::Table& t : case_schema().tables())
      list.push_back({t.name, t.repeated, true, path_schema().find(t.name) != nullptr, t.description});
    for (const config::Table& t : path_schema().tables()) {
      if (case_schema().find(t.name) == nullptr) list.push_back({t.name, t.repeated, false, true, t.description});
    }
    return list;
  }();
  return tables;
}

const std::vector<KeyInfo>& schema_keys() {
  static const std::vector<KeyInfo> keys = [] {
    std::vector<KeyInfo> list;
    for (const TableInfo& info : schema_tables()) {
      const config::Table& table = *(info.in_case ? case_schema().find(info.name) : path_schema().find(info.name));
      list.insert(list.end(), table.keys.begin(), table.keys.end());
    }
    return list;
  }();
  return keys;
}

const std::vector<ModelInfo>& schema_models() {
  static const std::vector<ModelInfo> models = [] {
    std::vector<ModelInfo> list;
    for (const LawInfo& law : all_laws()) {
      ModelInfo& model = list.emplace_back(ModelInfo{law.name, law.description, {}});
      for (const config::Key& key : case_schema().find("material")->keys) {
        if (key.used.always()) continue;
        const std::vector<std::string>& laws = key.used.tests.front().words;
        if (std::find(laws.begin(), laws.end(), law.name) != laws.end()) model.keys.push_back(key.name);
      }
    }
    return list;
  }();
  return models;
}

namespace {

config::Reference reference() { return {case_format_version, schema_tables(), schema_keys(), schema_models()}; }

}  // namespace

std::string schema_text() { return config::reference_text(reference()); }
std::string schema_json() { return config::reference_json(reference()); }

}  // namespace mpm
