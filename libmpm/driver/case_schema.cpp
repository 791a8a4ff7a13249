#include "libmpm/driver/case_schema.hpp"

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
    s.table(
        "arm", "Cross-arm of the obstacle: a beam across the flow, whose force is measured by itself; left out: none",
        [](auto& c) -> auto& { return c.arm; });
    s.table("body", "A piece of material in a custom scene (without [conveyor]), any number", [](auto& c) { return &c.bodies; });
    BoundaryTables::for_each([&]<class T>() { s.table(T::name, T::description, [](auto& c) -> decltype(auto) { return T::of(c); }); });
    s.table(
        "domain", "Where particles may be. Required in a custom scene; with [conveyor] it may only reduce the domain of the belt",
        [](auto& c) -> auto& { return c.domain; });
    s.table(
        "numerics", "Grid, particles and time step", [](auto& c) -> auto& { return c.numerics; });
    s.table(
        "measurement",
        "Bins, filter and box of the pressure profile on the obstacle. If left out, they are multiples of the cell size as in the paper; "
        "set them for a grid study",
        [](auto& c) -> auto& { return c.measurement; });
    s.table(
        "output", "Duration and output files", [](auto& c) -> auto& { return c.output; });
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

// ---- reference ---------------------------------------------------------------------------------------------------------------------

const std::vector<TableInfo>& schema_tables() {
  static const std::vector<TableInfo> tables = [] {
    std::vector<TableInfo> list;
    const Case empty;
    for (const config::Table& t : case_schema().tables())
      list.push_back(config::table_info(t, &empty, true, path_schema().find(t.name) != nullptr));
    const PathFile empty_path;
    for (const config::Table& t : path_schema().tables()) {
      if (case_schema().find(t.name) == nullptr) list.push_back(config::table_info(t, &empty_path, false, true));
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
