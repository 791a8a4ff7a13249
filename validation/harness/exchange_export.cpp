#include <fmt/format.h>
#include <hdf5.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <deque>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "libmpm/base/error.hpp"
#include "libmpm/boundary/obstacle_spec.hpp"
#include "libmpm/core/stress_update.hpp"
#include "libmpm/driver/build_info.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"
#include "libmpm/io/hdf5.hpp"
#include "validation/harness/check_text.hpp"
#include "validation/harness/exchange.hpp"
#include "validation/harness/exchange_columns.hpp"

namespace mpm::validation {
namespace {

using nlohmann::json;

const std::map<std::string, std::string>& column_meanings() {
  static const std::map<std::string, std::string> meanings{
      {"id", "identity number of the particle, from particles.csv"},
      {"x_m", "position"},
      {"y_m", "position"},
      {"z_m", "position"},
      {"vx_m_s", "velocity"},
      {"vy_m_s", "velocity"},
      {"vz_m_s", "velocity"},
      {"mass_kg", "mass"},
      {"volume_m3", "volume in the stress-free reference state, mass over density_kg_m3; the present volume is volume_ratio times this"},
      {"stress_xx_pa", "Cauchy stress, tension positive"},
      {"stress_yy_pa", "Cauchy stress, tension positive"},
      {"stress_zz_pa", "Cauchy stress, tension positive"},
      {"stress_xy_pa", "Cauchy stress"},
      {"stress_xz_pa", "Cauchy stress"},
      {"stress_yz_pa", "Cauchy stress"},
      {"volume_ratio", "J: present volume over reference volume"},
      {"internal", "internal variable of the law as in libmpm: see material.law"},
      {"dvx_dx_1_s", "velocity gradient; the other eight columns likewise"}};
  return meanings;
}

// ---- particles of t = 0 ------------------------------------------------------------------------------------------------------------

/// Columns of a table of particles.
struct Columns {
  std::vector<std::string> names;
  std::vector<std::vector<double>> values;
  std::size_t add(const std::string& name) {
    names.push_back(name);
    values.emplace_back();
    return names.size() - 1;
  }
};

Columns start_columns(const State& state, const Scene& scene) {
  Columns c;
  c.add("id");
  for (const auto* group : {&position_columns, &velocity_columns})
    for (const std::string& name : *group) c.add(name);
  for (const char* name : {"mass_kg", "volume_m3"}) c.add(name);
  for (const std::string& name : stress_columns) c.add(name);
  for (const char* name : {"volume_ratio", "internal"}) c.add(name);
  for (const char v : {'x', 'y', 'z'})
    for (const char x : {'x', 'y', 'z'}) c.add(fmt::format("dv{}_d{}_1_s", v, x));
  std::vector<std::pair<std::uint64_t, std::vector<double>>> rows;
  const double density = density_of(scene.material);
  state.grid.for_each_particle([&](const Particle& p) {
    const double j = volume_ratio(scene.material, p);
    std::vector<double> row{static_cast<double>(p.id)};
    for (int i = 0; i < 3; ++i) row.push_back(p.position[i] - scene.offset[i]);
    row.insert(row.end(), p.velocity, p.velocity + 3);
    row.push_back(density * p.volume);
    row.push_back(p.volume);
    for (const double s : p.stress) row.push_back(s / j);
    row.push_back(j);
    row.push_back(p.internal);
    for (int i = 0; i < 3; ++i)
      for (int k = 0; k < 3; ++k) row.push_back(p.affine[3 * k + i]);
    rows.emplace_back(p.id, std::move(row));
  });
  std::sort(rows.begin(), rows.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  for (const auto& [id, row] : rows)
    for (std::size_t i = 0; i < row.size(); ++i) c.values[i].push_back(row[i]);
  return c;
}

void write_particles(const std::filesystem::path& directory, const Columns& c) {
  write_table(directory / "particles.csv", c.names, c.values);
  hdf5::Writer file(directory / "particles.h5");
  for (std::size_t i = 0; i < c.names.size(); ++i) file.dataset<double>(c.names[i], c.values[i]);
  file.commit();
}

// ---- description -------------------------------------------------------------------------------------------------------------------

json vector_json(const Vec3& v) { return {v.x(), v.y(), v.z()}; }

const char* rule_of(Contact contact) {
  switch (contact) {
    case Contact::no_slip: return "the material at the surface has the velocity of the surface";
    case Contact::slip:
      return "the material stays on the surface and slides along it; Coulomb friction takes at most friction times the normal pressure";
    case Contact::separable:
      return "the material does not pass the surface and may leave it freely: the surface pushes and never pulls; while it pushes, Coulomb "
             "friction "
             "takes at most friction times the normal pressure";
  }
  return "";
}

const char* name_of(Contact contact) {
  switch (contact) {
    case Contact::no_slip: return "no_slip";
    case Contact::slip: return "slip";
    case Contact::separable: return "separable";
  }
  return "";
}

json boundaries_json(const Setup& setup) {
  json all = json::array();
  const std::vector<std::string> names = boundary_names(setup);
  for (std::size_t i = 0; i < setup.spec.walls.size(); ++i) {
    const WallSpec& w = setup.spec.walls[i];
    all.push_back({{"name", names[i]},
                   {"shape", "half-space"},
                   {"point_m", vector_json(w.point)},
                   {"normal", vector_json(w.normal.normalized())},
                   {"contact", name_of(w.contact)},
                   {"friction", w.friction},
                   {"velocity_m_s", vector_json(w.velocity)},
                   {"rule", rule_of(w.contact)}});
  }
  if (setup.spec.obstacle) {
    const Outline plan = outline_of(setup.spec.obstacle->shape);
    json solid{{"name", names.back()},
               {"shape", plan.circle() ? "upright cylinder" : "upright prism"},
               {"contact", "separable"},
               {"friction", setup.spec.obstacle->friction},
               {"velocity_m_s", {0.0, 0.0, 0.0}},
               {"top_m", setup.spec.obstacle->height ? json(*setup.spec.obstacle->height) : json(nullptr)},
               {"rule", rule_of(Contact::separable)}};
    if (setup.spec.obstacle->base > 0.0) solid["base_m"] = setup.spec.obstacle->base;
    if (plan.circle()) {
      solid["centre_m"] = {plan.circle()->centre.x(), plan.circle()->centre.y()};
      solid["radius_m"] = plan.circle()->radius;
    } else {
      for (const Outline::Side& side : plan.sides()) solid["outline_m"].push_back({side.from.x(), side.from.y()});
    }
    all.push_back(solid);
  }
  return all;
}

/// The resolved case file as JSON: every key with its unit in its name.
json keys_json(const Case& spec) {
  std::ostringstream text;
  const toml::table table = toml::parse(write_case(spec));
  text << toml::json_formatter{table};
  return json::parse(text.str());
}

json results_json(const Setup& setup) {
  json results{{"times_s", setup.times}};
  if (setup.particles) {
    json columns = json::array();
    for (const std::string& name : state_columns(setup.fields, true))
      columns.push_back({{"name", name}, {"meaning", column_meanings().at(name)}});
    results["states"] = {
        {"files",
         "states/0001.csv, states/0002.csv, ..., one for each of times_s in its order; or all of them as groups 0001, 0002, ... of "
         "states.h5"},
        {"columns", columns},
        {"particles",
         setup.fields.identity
             ? "the particles of particles.csv, in any order"
             : "the particles of particles.csv, in any order; or a discretisation of your own, with a column mass_kg in place of id"}};
  }
  if (setup.forces) {
    results["forces"] = {{"file", "forces.csv"},
                         {"columns", force_columns},
                         {"meaning",
                          "for each of times_s, and each boundary by name, the mean force of the material on it since the time before "
                          "(since 0 for the first)"}};
  }
  return results;
}

json run_json(const Setup& setup, const State& state, const Scene& scene) {
  const Case& c = setup.spec;
  json keys = keys_json(c);
  json run{{"id", setup.id},
           {"title", setup.title},
           {"material", keys["material"]},
           {"gravity_m_s2", vector_json(scene.gravity)},
           {"boundaries", boundaries_json(setup)},
           {"symmetry_planes", json::array()},
           {"domain",
            {{"min_m", vector_json(c.domain.min)}, {"max_m", vector_json(c.domain.max)}, {"rule", "particles that leave it are removed"}}},
           {"particles", {{"files", {"particles.csv", "particles.h5"}}, {"count", state.grid.particle_count()}}},
           {"procedure", setup.procedure.empty() ? "Let the particles move from t = 0 under gravity and the boundaries." : setup.procedure},
           {"suggestion",
            {{"cell_size_m", c.numerics.cell_size},
             {"grid_origin_m", vector_json(-scene.offset)},
             {"particles_per_cell", c.numerics.particles_per_cell},
             {"time_step_s", setup.time_step > 0.0 ? setup.time_step : stable_time_step(state, scene)},
             {"wave_speed_m_s", wave_speed_of(scene.material)}}},
           {"time_step_s", setup.time_step > 0.0 ? json(setup.time_step) : json(nullptr)},
           {"results", results_json(setup)},
           {"libmpm_keys", keys}};
  run["material"]["law"] = c.material.equations();
  if (scene.mirror.x) run["symmetry_planes"].push_back("x = 0: only x >= 0 is given and written back; forces are those of this part");
  if (scene.mirror.y) run["symmetry_planes"].push_back("y = 0: only y >= 0 is given and written back; forces are those of this part");
  return run;
}

// ---- checks ----------------------------------------------------------------------------------------------------------------------------

/// A solver that moves nothing: the particles of t = 0, with their velocities times a factor, and no forces.
class NoMotion : public RunSource {
 public:
  explicit NoMotion(double factor) : factor_(factor) {}
  RunCost play(const Setup& setup, const Visitor& visit) const override {
    const CaseScene scene = make_scene(setup.spec);
    Instant now;
    if (setup.particles) now.particles = particle_records(setup.start(setup.spec, scene), scene);
    for (ParticleRecord& p : now.particles) p.velocity *= factor_;
    now.forces.assign(scene.boundaries.size(), Vec3::Zero());
    for (const double time : setup.times) {
      now.before = now.time;
      now.time = time;
      if (!visit(now)) break;
      ++now.index;
    }
    return {};
  }

 private:
  double factor_;
};

/// The checks that `grade` makes. They are those of two solvers that move nothing: what differs between the two depends on the results, and
/// is null.
json checks_json(const CaseEntry& entry, const CaseContext& context) {
  const auto checks_of = [&](double factor) {
    const NoMotion nothing(factor);
    const CaseContext judging(
        context.level(), 1, context.directory(), entry.directory, [](const std::string&) {}, &nothing);
    return run_case_entry(entry, judging).checks;
  };
  const std::deque<Check> checks = checks_of(1.0), others = checks_of(0.5);
  json all = json::array();
  for (std::size_t i = 0; i < checks.size(); ++i) {
    const Check& c = checks[i];
    const auto fixed = [&](double Check::*number) {
      const bool same = i < others.size() && others[i].quantity == c.quantity && others[i].*number == c.*number;
      return same && std::isfinite(c.*number) ? json(c.*number) : json(nullptr);
    };
    all.push_back({{"quantity", c.quantity},
                   {"label", to_string(c.label)},
                   {"reference", fixed(&Check::reference)},
                   {"unit", c.unit},
                   {"measure", measure_name(c.measure)},
                   {"tolerance", fixed(&Check::tolerance)},
                   {"tolerance_reason", c.tolerance_reason}});
  }
  return all;
}

// ---- results -----------------------------------------------------------------------------------------------------------------------

/// A group of arrays in an HDF5 file that is open.
void write_group(hid_t file, const std::string& name, const std::vector<std::string>& columns,
                 const std::vector<std::vector<double>>& values) {
  const hid_t group = H5Gcreate2(file, name.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
  for (std::size_t i = 0; i < columns.size(); ++i) {
    const hsize_t count = values[i].size();
    const hid_t space = H5Screate_simple(1, &count, nullptr);
    const hid_t data = H5Dcreate2(group, columns[i].c_str(), H5T_NATIVE_DOUBLE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    const herr_t status = H5Dwrite(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values[i].data());
    H5Dclose(data);
    H5Sclose(space);
    if (status < 0) throw IoError(fmt::format("cannot write group {} of states.h5", name));
  }
  H5Gclose(group);
}

/// The columns of particles that a set-up asks for.
std::vector<std::vector<double>> column_values(const std::vector<std::string>& columns, const std::vector<ParticleRecord>& particles) {
  const auto find = [](const std::vector<std::string>& group, const std::string& name) {
    return static_cast<int>(std::ranges::find(group, name) - group.begin());
  };
  std::vector<std::vector<double>> values;
  for (const std::string& name : columns) {
    const int x = find(position_columns, name), v = find(velocity_columns, name), s = find(stress_columns, name);
    std::vector<double>& column = values.emplace_back();
    for (const ParticleRecord& p : particles)
      column.push_back(x < 3          ? p.position[x]
                       : v < 3        ? p.velocity[v]
                       : s < 6        ? p.stress[s]
                       : name == "id" ? static_cast<double>(p.id)
                                      : p.volume_ratio);
  }
  return values;
}

}  // namespace

bool can_be_exported(const CaseEntry& entry) { return static_cast<bool>(entry.setups); }

void export_case(const CaseEntry& entry, const CaseContext& context, const std::filesystem::path& directory) {
  if (!can_be_exported(entry))
    throw ConfigError(
        fmt::format("case '{}' cannot be exported: it has no set-ups; `mpm-validate list` marks those that have", entry.name));
  json runs = json::array();
  for (const Setup& setup : entry.setups(context)) {
    const CaseScene scene = make_scene(setup.spec);
    const State state = setup.start(setup.spec, scene);
    const std::filesystem::path folder = directory / setup.id;
    make_directory(folder);
    write_particles(folder, start_columns(state, scene));
    write_file(folder / "case.toml", write_case(setup.spec));
    runs.push_back(run_json(setup, state, scene));
    context.log(fmt::format("{}: {} particles, {} times", setup.id, state.grid.particle_count(), setup.times.size()));
  }
  const BuildInfo build = build_info();
  const json root{{"format", "libmpm validation case"},
                  {"format_version", exchange_format_version},
                  {"case", entry.name},
                  {"title", entry.title},
                  {"level", to_string(context.level())},
                  {"description", first_paragraph(read_file(entry.directory / "README.md"))},
                  {"units", "SI; every name of a number ends in its unit, numbers without one have none"},
                  {"axes", "right-handed; z points upwards unless gravity_m_s2 has another direction"},
                  {"made_by", fmt::format("libmpm {}, commit {}", build.version, build.commit)},
                  {"grade_with", fmt::format("mpm-validate grade {} --level {} --results DIR", entry.name, to_string(context.level()))},
                  {"columns", column_meanings()},
                  {"checks", checks_json(entry, context)},
                  {"runs", runs}};
  write_file(directory / "case.json", root.dump(1, ' ', false, json::error_handler_t::replace) + "\n");
}

void export_results(const CaseEntry& entry, const CaseContext& context, const std::filesystem::path& directory) {
  if (!can_be_exported(entry)) throw ConfigError(fmt::format("case '{}' has no set-ups", entry.name));
  for (const Setup& setup : entry.setups(context)) {
    const std::filesystem::path folder = directory / setup.id;
    make_directory(folder);
    const std::vector<std::string> columns = state_columns(setup.fields, true), boundaries = boundary_names(setup);
    std::string forces = csv_line(force_columns);
    const hid_t file =
        setup.particles ? H5Fcreate((folder / "states.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT) : H5I_INVALID_HID;
    if (setup.particles && file < 0) throw IoError(fmt::format("cannot create '{}'", (folder / "states.h5").string()));
    play(context, setup, [&](const Instant& now) {
      if (setup.particles) write_group(file, state_number(now.index), columns, column_values(columns, now.particles));
      for (std::size_t b = 0; b < boundaries.size(); ++b) {
        const Vec3& f = now.forces.at(b);
        forces += csv_line(std::vector<std::string>{format_number(setup.times[now.index]), boundaries[b], format_number(f.x()),
                                                    format_number(f.y()), format_number(f.z())});
      }
      return true;
    });
    if (setup.particles) H5Fclose(file);
    if (setup.forces) write_file(folder / "forces.csv", forces);
    context.log(fmt::format("{}: solved", setup.id));
  }
  const json solver{
      {"name", "libmpm"}, {"version", std::string(build_info().version)}, {"remark", "written by mpm-validate export --solve"}};
  write_file(directory / "solver.json", solver.dump(1) + "\n");
}

}  // namespace mpm::validation
