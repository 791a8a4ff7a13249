#include "libmpm/driver/case_schema.hpp"

namespace mpm {

const config::SchemaOf<Case>& case_schema() {
  static const config::SchemaOf<Case> schema = [] {
    config::SchemaOf<Case> s;
    s.table(
        "", "Keys above the first table", [](auto& c) -> auto& { return c; });
    s.table("material", "The snow: one constitutive law and its parameters", &Case::material);
    s.table(
        "conveyor",
        "The paper's set-up: snow on a frictionless belt between moving side walls meets the obstacle. It replaces [[body]] and [[wall]]",
        &Case::conveyor);
    s.table("conveyor.inflow",
            "Inflow that varies in time, with feed = \"window\": linear between these rows, constant before the first and after the last",
            [](auto& c) { return c.conveyor ? &c.conveyor->inflow : nullptr; });
    s.table("obstacle", "Rigid obstacle with separable Coulomb contact; left out: none", &Case::obstacle);
    s.table("arm", "Cross-arm of the obstacle: a beam across the flow, whose force is measured by itself; left out: none", &Case::arm);
    s.table("body", "A piece of material in a custom scene (without [conveyor]), any number", &Case::bodies);
    BoundaryTables::for_each([&]<class T>() { s.table(T::name, T::description, [](auto& c) -> decltype(auto) { return T::of(c); }); });
    s.table("domain", "Where particles may be. Required in a custom scene; with [conveyor] it may only reduce the domain of the belt",
            &Case::domain);
    s.table("numerics", "Grid, particles and time step", &Case::numerics);
    s.table("measurement",
            "Bins, filter and box of the pressure profile on the obstacle. If left out, they are multiples of the cell size as in the "
            "paper; set them for a grid study",
            &Case::measurement);
    s.table("output", "Duration and output files", &Case::output);
    return s;
  }();
  return schema;
}

const config::SchemaOf<PathFile>& path_schema() {
  static const config::SchemaOf<PathFile> schema = [] {
    config::SchemaOf<PathFile> s;
    s.table(
        "", "Keys above the first table", [](auto& p) -> auto& { return p; });
    s.table("material", "The snow: one constitutive law and its parameters", &PathFile::material);
    s.table("path", "Strain path of one material point, for `mpm point`", &PathFile::steps);
    s.table("path.segments", "A list of inline tables: {d_eps_v, d_eps_q}, {velocity_gradient, time_s} or {radial_stress_pa, d_eps_axial}",
            &PathFile::segments);
    return s;
  }();
  return schema;
}

const config::Reference& case_reference() {
  static const config::Reference reference = [] {
    config::Reference made{.format_version = case_format_version};
    const Case empty;
    for (const config::Table& t : case_schema().tables()) made.add(t, &empty, true, path_schema().find(t.name) != nullptr);
    const PathFile empty_path;
    for (const config::Table& t : path_schema().tables()) {
      if (case_schema().find(t.name) == nullptr) made.add(t, &empty_path, false, true);
    }
    for (const LawInfo& law : all_laws()) {
      ModelInfo& model = made.models.emplace_back(ModelInfo{law.name, law.description, {}});
      for (const config::Key& key : case_schema().find("material")->keys) {
        if (!key.used.always() && std::ranges::count(key.used.tests.front().words, law.name) > 0) model.keys.push_back(key.name);
      }
    }
    return made;
  }();
  return reference;
}

}  // namespace mpm
