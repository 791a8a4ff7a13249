#include "libmpm/driver/case_file.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "libmpm/base/error.hpp"
#include "libmpm/config/guard.hpp"
#include "libmpm/config/reader.hpp"
#include "libmpm/driver/terrain_raster.hpp"
#include "libmpm/impact/inflow.hpp"

namespace mpm {

// ---- Keys ------------------------------------------------------------------------------------------------------------------------------

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
    s.table(
        "domain",
        "Where particles may be. Required in a custom scene; with [conveyor] it may only reduce the domain of the belt, and not the flow "
        "between inlet, outlet and side walls",
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

// ---- Files -----------------------------------------------------------------------------------------------------------------------------

Case parse_case(std::string_view text, std::string_view file_name, const std::vector<std::string>& overrides, std::string_view prefix) {
  const auto resolve = [folder = std::filesystem::path(file_name).parent_path()](Case& c, ParameterReport& report) {
    if (c.conveyor) read_inflow_csv(*c.conveyor, folder, c.material.density(), report);
    if (c.terrain) read_terrain(*c.terrain, folder, report);
    resolve_case(c, report);
  };
  return config::read(case_schema(), text, file_name, overrides, resolve, prefix);
}

Case read_case(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  const std::string text = config::bounded_file_text(file);
  try {
    return parse_case(text, file.string(), overrides);
  } catch (const ConfigError&) {
    if (!config::has_table(text, "flow") || !config::has_table(text, "mast")) throw;
    throw ConfigError(fmt::format("{0}: this is a site file, not a case file; run `mpm design {0}`", file.string()));
  }
}

PathSpec parse_path(std::string_view text, std::string_view file_name, const std::vector<std::string>& overrides) {
  const auto check = [](const PathFile& path, ParameterReport& report) {
    if (path.segments.empty() && report.valid("path.segments"))
      report.problem("path.segments", "is missing or empty; give at least one segment");
  };
  const PathFile file = config::read(path_schema(), text, file_name, overrides, check);
  PathSpec path{file.material, file.steps.per_segment, {}};
  for (const SegmentParameters& s : file.segments) path.segments.push_back(s.segment());
  return path;
}

PathSpec read_path(const std::filesystem::path& file, const std::vector<std::string>& overrides) {
  return parse_path(config::bounded_file_text(file), file.string(), overrides);
}

std::string write_case(const Case& spec) { return config::write(case_schema(), &spec, config::Defaults::all); }

std::optional<std::string> case_value(const Case& spec, const std::string& path) { return config::value_of(case_schema(), &spec, path); }

namespace {

/// Keys without influence on the computed numbers: those that declare it (no_effect_on_results), and two that depend on the case. The
/// duration of a window source is only the length of the run; of a strip source it sets the length of the avalanche.
std::vector<std::string> keys_outside_hash(const Case& spec) {
  std::vector<std::string> skip;
  for (const config::Table& table : case_schema().tables()) {
    for (const config::Key& key : table.keys) {
      if (!key.affects_results) skip.push_back(config::key_path(table.name, key.name));
    }
  }
  if (spec.numerics.precision == Precision::double_precision)
    skip.emplace_back("numerics.precision");  // by a case's hash stored results are found: it stays that of a case without the key
  const bool strip = spec.conveyor && spec.conveyor->feed == ConveyorSpec::Feed::strip;
  if (!strip) skip.emplace_back("output.duration_s");
  return skip;
}

}  // namespace

std::vector<std::string> case_differences(const Case& before, const Case& now) {
  auto skip = keys_outside_hash(before);
  if (before.numerics.precision != now.numerics.precision) std::erase(skip, "numerics.precision");
  return config::differences(case_schema(), &before, &now, skip);
}

std::uint64_t case_hash(const Case& spec) {
  return config::hash(config::write(case_schema(), &spec, config::Defaults::shown, keys_outside_hash(spec)));
}

std::string case_hash_text(const Case& spec) { return fmt::format("{:016x}", case_hash(spec)); }

}  // namespace mpm
