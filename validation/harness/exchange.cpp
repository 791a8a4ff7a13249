#include "validation/harness/exchange.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <hdf5.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "libmpm/base/error.hpp"
#include "libmpm/boundary/obstacle.hpp"
#include "libmpm/core/stress_update.hpp"
#include "libmpm/driver/build_info.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"
#include "libmpm/io/hdf5.hpp"

namespace mpm::validation {
namespace {

using nlohmann::json;

// ---- columns -----------------------------------------------------------------------------------------------------------------------

const std::vector<std::string> position_columns{"x_m", "y_m", "z_m"}, velocity_columns{"vx_m_s", "vy_m_s", "vz_m_s"};
const std::vector<std::string> stress_columns{"stress_xx_pa", "stress_yy_pa", "stress_zz_pa",
                                              "stress_xy_pa", "stress_xz_pa", "stress_yz_pa"};
const std::vector<std::string> force_columns{"force_x_n", "force_y_n", "force_z_n"};

/// Columns that the particles of a state must have. A solver with particles of its own gives mass_kg; otherwise id identifies the particle
/// of t = 0 it is.
std::vector<std::string> state_columns(const ParticleFields& fields, bool with_id) {
  std::vector<std::string> columns;
  const auto add = [&](const std::vector<std::string>& more) { columns.insert(columns.end(), more.begin(), more.end()); };
  if (with_id) columns.emplace_back("id");
  if (fields.position) add(position_columns);
  if (fields.velocity) add(velocity_columns);
  if (fields.stress) add(stress_columns);
  if (fields.volume_ratio) columns.emplace_back("volume_ratio");
  return columns;
}

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
    const ObstaclePlan plan = obstacle_plan(*setup.spec.obstacle);
    json outline = json::array();
    if (!plan.radius)
      for (const OutlineSide& side : plan.sides) outline.push_back({side.from.x(), side.from.y()});
    json solid{{"name", names.back()},
               {"shape", plan.radius ? "upright cylinder" : "upright prism"},
               {"contact", "separable"},
               {"friction", setup.spec.obstacle->friction},
               {"velocity_m_s", {0.0, 0.0, 0.0}},
               {"top_m", setup.spec.obstacle->height ? json(*setup.spec.obstacle->height) : json(nullptr)},
               {"rule", rule_of(Contact::separable)}};
    if (plan.radius) {
      solid["centre_m"] = {*plan.radius, 0.0};
      solid["radius_m"] = *plan.radius;
    } else {
      solid["outline_m"] = outline;
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
                         {"columns", {"time_s", "boundary", "force_x_n", "force_y_n", "force_z_n"}},
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

// ---- reading -----------------------------------------------------------------------------------------------------------------------

std::string number_of(std::size_t index) { return fmt::format("{:04}", index + 1); }

/// Named columns of numbers, from a CSV file or from a group of an HDF5 file.
class ColumnSource {
 public:
  virtual ~ColumnSource() = default;
  [[nodiscard]] virtual bool has(const std::string& column) const = 0;
  [[nodiscard]] virtual std::vector<double> numbers(const std::string& column) const = 0;
  std::string name;  ///< of file and group, for messages
};

class CsvColumns : public ColumnSource {
 public:
  explicit CsvColumns(const std::filesystem::path& file) : table_(Table::read(file)) { name = file.string(); }
  [[nodiscard]] bool has(const std::string& column) const override { return table_.has(column); }
  [[nodiscard]] std::vector<double> numbers(const std::string& column) const override { return table_.numbers(column); }

 private:
  Table table_;
};

/// A group of an HDF5 file that any program wrote.
class Hdf5Columns : public ColumnSource {
 public:
  Hdf5Columns(const std::filesystem::path& file, const std::string& group) {
    name = fmt::format("{}, group {}", file.string(), group);
    H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    file_ = H5Fopen(file.c_str(), H5F_ACC_RDONLY, H5P_DEFAULT);
    if (file_ >= 0 && H5Lexists(file_, group.c_str(), H5P_DEFAULT) > 0) group_ = H5Gopen2(file_, group.c_str(), H5P_DEFAULT);
  }
  Hdf5Columns(const Hdf5Columns&) = delete;
  Hdf5Columns& operator=(const Hdf5Columns&) = delete;
  ~Hdf5Columns() override {
    if (group_ >= 0) H5Gclose(group_);
    if (file_ >= 0) H5Fclose(file_);
  }
  [[nodiscard]] bool open() const { return group_ >= 0; }
  [[nodiscard]] bool has(const std::string& column) const override { return H5Lexists(group_, column.c_str(), H5P_DEFAULT) > 0; }
  [[nodiscard]] std::vector<double> numbers(const std::string& column) const override {
    const hid_t data = H5Dopen2(group_, column.c_str(), H5P_DEFAULT);
    if (data < 0) throw IoError(fmt::format("{}: '{}' is no array", name, column));
    const hid_t space = H5Dget_space(data);
    std::vector<double> values(static_cast<std::size_t>(std::max<hssize_t>(H5Sget_simple_extent_npoints(space), 0)));
    const herr_t status = H5Dread(data, H5T_NATIVE_DOUBLE, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data());
    H5Sclose(space);
    H5Dclose(data);
    if (status < 0) throw IoError(fmt::format("{}: '{}' cannot be read as numbers", name, column));
    return values;
  }

 private:
  hid_t file_ = -1, group_ = -1;
};

/// The state of one time; null if there is none.
std::unique_ptr<ColumnSource> open_state(const std::filesystem::path& run, std::size_t index) {
  const std::filesystem::path csv = run / "states" / (number_of(index) + ".csv"), h5 = run / "states.h5";
  if (std::filesystem::exists(csv)) return std::make_unique<CsvColumns>(csv);
  if (std::filesystem::exists(h5)) {
    auto columns = std::make_unique<Hdf5Columns>(h5, number_of(index));
    if (columns->open()) return columns;
  }
  return nullptr;
}

/// What a state lacks of the columns that the set-up asks for, as a message; empty if nothing.
std::string missing_columns(const ColumnSource& columns, const Setup& setup) {
  std::vector<std::string> missing;
  for (const std::string& name : state_columns(setup.fields, setup.fields.identity))
    if (!columns.has(name)) missing.push_back(name);
  if (!setup.fields.identity && !columns.has("id") && !columns.has("mass_kg")) missing.emplace_back("id (or mass_kg)");
  return missing.empty() ? "" : fmt::format("{}: columns missing: {}", columns.name, fmt::join(missing, ", "));
}

/// Forces by time and boundary.
struct ForceTable {
  std::vector<std::vector<Vec3>> forces;
};

ForceTable read_forces(const std::filesystem::path& file, const Setup& setup) {
  const Table table = Table::read(file);
  std::vector<std::string> missing;
  for (const char* column : {"time_s", "boundary", "force_x_n", "force_y_n", "force_z_n"})
    if (!table.has(column)) missing.emplace_back(column);
  if (!missing.empty()) throw IoError(fmt::format("{}: columns missing: {}", file.string(), fmt::join(missing, ", ")));
  const std::vector<std::string> names = boundary_names(setup), boundary = table.text("boundary");
  const std::vector<double> time = table.numbers("time_s"), x = table.numbers("force_x_n"), y = table.numbers("force_y_n"),
                            z = table.numbers("force_z_n");
  std::map<std::string, std::vector<std::pair<double, Vec3>>> rows;
  for (std::size_t i = 0; i < boundary.size(); ++i) rows[boundary[i]].emplace_back(time[i], Vec3(x[i], y[i], z[i]));
  ForceTable result{std::vector<std::vector<Vec3>>(setup.times.size(), std::vector<Vec3>(names.size()))};
  for (std::size_t b = 0; b < names.size(); ++b) {
    const auto& of_boundary = rows[names[b]];
    if (of_boundary.size() != setup.times.size())
      throw IoError(
          fmt::format("{}: {} rows for the boundary '{}', {} times", file.string(), of_boundary.size(), names[b], setup.times.size()));
    for (std::size_t i = 0; i < setup.times.size(); ++i) {
      if (std::abs(of_boundary[i].first - setup.times[i]) > 1e-6 * setup.times.back())
        throw IoError(fmt::format("{}: row {} of the boundary '{}' has time_s {}, not {}", file.string(), i + 1, names[b],
                                  of_boundary[i].first, setup.times[i]));
      result.forces[i][b] = of_boundary[i].second;
    }
  }
  return result;
}

std::vector<ParticleRecord> read_state(const ColumnSource& columns, const Setup& setup, const std::map<std::uint64_t, double>& masses) {
  const std::string lacking = missing_columns(columns, setup);
  if (!lacking.empty()) throw IoError(lacking);
  std::map<std::string, std::vector<double>> data;
  for (const std::string& name : state_columns(setup.fields, columns.has("id"))) data[name] = columns.numbers(name);
  const bool own_mass = columns.has("mass_kg");
  if (own_mass) data["mass_kg"] = columns.numbers("mass_kg");
  const std::size_t count = data.begin()->second.size();
  for (const auto& [name, values] : data)
    if (values.size() != count)
      throw IoError(fmt::format("{}: '{}' has {} values, others have {}", columns.name, name, values.size(), count));
  std::vector<ParticleRecord> records(count);
  const auto fill = [&](const char* name, auto&& put) {
    const auto found = data.find(name);
    if (found == data.end()) return;
    for (std::size_t i = 0; i < count; ++i) put(records[i], found->second[i]);
  };
  fill("id", [](ParticleRecord& r, double v) { r.id = static_cast<std::uint64_t>(v); });
  fill("mass_kg", [](ParticleRecord& r, double v) { r.mass = v; });
  fill("volume_ratio", [](ParticleRecord& r, double v) { r.volume_ratio = v; });
  for (int a = 0; a < 3; ++a) {
    fill(position_columns[static_cast<std::size_t>(a)].c_str(), [a](ParticleRecord& r, double v) { r.position[a] = v; });
    fill(velocity_columns[static_cast<std::size_t>(a)].c_str(), [a](ParticleRecord& r, double v) { r.velocity[a] = v; });
  }
  for (int k = 0; k < 6; ++k)
    fill(stress_columns[static_cast<std::size_t>(k)].c_str(), [k](ParticleRecord& r, double v) { r.stress[k] = v; });
  if (own_mass) return records;
  std::vector<bool> seen(masses.empty() ? 0 : masses.rbegin()->first + 1, false);
  for (ParticleRecord& r : records) {
    const auto mass = masses.find(r.id);
    if (mass == masses.end() || seen[r.id])
      throw IoError(fmt::format("{}: column 'id': {} is {}", columns.name, r.id,
                                mass == masses.end() ? "no particle of particles.csv" : "there twice"));
    seen[r.id] = true;
    r.mass = mass->second;
  }
  return records;
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
                  {"runs", runs}};
  write_file(directory / "case.json", root.dump(1, ' ', false, json::error_handler_t::replace) + "\n");
}

namespace {

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

void export_results(const CaseEntry& entry, const CaseContext& context, const std::filesystem::path& directory) {
  if (!can_be_exported(entry)) throw ConfigError(fmt::format("case '{}' has no set-ups", entry.name));
  for (const Setup& setup : entry.setups(context)) {
    const std::filesystem::path folder = directory / setup.id;
    make_directory(folder);
    const std::vector<std::string> columns = state_columns(setup.fields, true), boundaries = boundary_names(setup);
    std::string forces = csv_line(std::vector<std::string>{"time_s", "boundary", "force_x_n", "force_y_n", "force_z_n"});
    const hid_t file =
        setup.particles ? H5Fcreate((folder / "states.h5").c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, H5P_DEFAULT) : H5I_INVALID_HID;
    if (setup.particles && file < 0) throw IoError(fmt::format("cannot create '{}'", (folder / "states.h5").string()));
    play(context, setup, [&](const Instant& now) {
      if (setup.particles) write_group(file, number_of(now.index), columns, column_values(columns, now.particles));
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

ForeignResults::ForeignResults(std::filesystem::path directory, const CaseEntry& entry, const CaseContext& context)
    : directory_(std::move(directory)) {
  if (!can_be_exported(entry))
    throw ConfigError(fmt::format("case '{}' cannot be graded: it has no set-ups; `mpm-validate list` marks those that have", entry.name));
  if (!std::filesystem::is_directory(directory_)) throw IoError(fmt::format("no folder of results '{}'", directory_.string()));
  read_solver();
  if (std::filesystem::exists(directory_ / "case.json")) {
    const json described = json::parse(read_file(directory_ / "case.json"), nullptr, false);
    const auto text = [&](const char* key) {
      return described.is_object() && described.contains(key) ? described.value(key, "") : std::string();
    };
    if (text("case") != entry.name || text("level") != to_string(context.level())) {
      throw ConfigError(fmt::format("'{}' is of case '{}', level {}; asked for is case '{}', level {}", (directory_ / "case.json").string(),
                                    text("case"), text("level"), entry.name, to_string(context.level())));
    }
  }
  std::vector<std::string> missing;
  for (const Setup& setup : entry.setups(context)) {
    const std::filesystem::path run = directory_ / setup.id;
    if (!std::filesystem::is_directory(run)) {
      missing.push_back(fmt::format("{}: no folder for the run '{}'", run.string(), setup.title));
      continue;
    }
    try {
      if (setup.forces && !std::filesystem::exists(run / "forces.csv"))
        missing.push_back(
            fmt::format("{}: missing; columns time_s, boundary, force_x_n, force_y_n, force_z_n", (run / "forces.csv").string()));
      else if (setup.forces)
        static_cast<void>(read_forces(run / "forces.csv", setup));
      if (!setup.particles) continue;
      const std::unique_ptr<ColumnSource> first = open_state(run, 0);
      if (first == nullptr) {
        missing.push_back(fmt::format("{}: neither states/0001.csv nor group 0001 of states.h5; columns {}", run.string(),
                                      fmt::join(state_columns(setup.fields, true), ", ")));
      } else if (const std::string lacking = missing_columns(*first, setup); !lacking.empty()) {
        missing.push_back(lacking);
      }
    } catch (const IoError& e) {
      missing.emplace_back(e.what());
    }
  }
  if (!missing.empty()) throw IoError(fmt::format("results of case '{}' are not complete:\n  {}", entry.name, fmt::join(missing, "\n  ")));
}

void ForeignResults::read_solver() {
  const std::filesystem::path file = directory_ / "solver.json";
  if (!std::filesystem::exists(file)) return;
  const json described = json::parse(read_file(file), nullptr, false);
  if (!described.is_object()) throw IoError(fmt::format("{}: not a JSON object", file.string()));
  const auto text = [&](const char* key, const std::string& otherwise) {
    if (!described.contains(key)) return otherwise;
    if (!described[key].is_string()) throw IoError(fmt::format("{}: '{}' is no text", file.string(), key));
    return described[key].get<std::string>();
  };
  solver_ = {text("name", solver_.name), text("version", ""), text("remark", "")};
}

RunCost ForeignResults::play(const Setup& setup, const Visitor& visit) const {
  try {
    const std::filesystem::path run = directory_ / setup.id;
    const ForceTable forces = setup.forces ? read_forces(run / "forces.csv", setup) : ForceTable{};
    std::map<std::uint64_t, double> masses;
    if (setup.particles) {
      const CaseScene scene = make_scene(setup.spec);
      for (const ParticleRecord& p : particle_records(setup.start(setup.spec, scene), scene)) masses[p.id] = p.mass;
    }
    Instant now;
    for (std::size_t i = 0; i < setup.times.size(); ++i) {
      now.index = i;
      now.before = i == 0 ? 0.0 : setup.times[i - 1];
      now.time = setup.times[i];
      if (setup.forces) now.forces = forces.forces[i];
      if (setup.particles) {
        const std::unique_ptr<ColumnSource> state = open_state(run, i);
        if (state == nullptr) {
          throw IoError(fmt::format("{}: neither states/{}.csv nor group {} of states.h5, the state at t = {} s", run.string(),
                                    number_of(i), number_of(i), setup.times[i]));
        }
        now.particles = read_state(*state, setup, masses);
      }
      if (!visit(now)) break;
    }
    return {};
  } catch (const IoError& e) {
    damage_ = e.what();
    throw;
  }
}

}  // namespace mpm::validation
