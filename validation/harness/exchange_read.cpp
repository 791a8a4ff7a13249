#include <fmt/format.h>
#include <fmt/ranges.h>
#include <hdf5.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "libmpm/base/error.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"
#include "validation/harness/exchange.hpp"
#include "validation/harness/exchange_columns.hpp"

namespace mpm::validation {
namespace {

using nlohmann::json;

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
  const std::filesystem::path csv = run / "states" / (state_number(index) + ".csv"), h5 = run / "states.h5";
  if (std::filesystem::exists(csv)) return std::make_unique<CsvColumns>(csv);
  if (std::filesystem::exists(h5)) {
    auto columns = std::make_unique<Hdf5Columns>(h5, state_number(index));
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
std::vector<std::vector<Vec3>> read_forces(const std::filesystem::path& file, const Setup& setup) {
  const Table table = Table::read(file);
  std::vector<std::string> missing;
  for (const std::string& column : force_columns)
    if (!table.has(column)) missing.push_back(column);
  if (!missing.empty()) throw IoError(fmt::format("{}: columns missing: {}", file.string(), fmt::join(missing, ", ")));
  const std::vector<std::string> names = boundary_names(setup), boundary = table.text("boundary");
  const std::vector<double> time = table.numbers("time_s"), x = table.numbers("force_x_n"), y = table.numbers("force_y_n"),
                            z = table.numbers("force_z_n");
  std::map<std::string, std::vector<std::pair<double, Vec3>>> rows;
  for (std::size_t i = 0; i < boundary.size(); ++i) rows[boundary[i]].emplace_back(time[i], Vec3(x[i], y[i], z[i]));
  std::vector<std::vector<Vec3>> forces(setup.times.size(), std::vector<Vec3>(names.size()));
  for (std::size_t b = 0; b < names.size(); ++b) {
    const auto& of_boundary = rows[names[b]];
    if (of_boundary.size() != setup.times.size())
      throw IoError(
          fmt::format("{}: {} rows for the boundary '{}', {} times", file.string(), of_boundary.size(), names[b], setup.times.size()));
    for (std::size_t i = 0; i < setup.times.size(); ++i) {
      if (std::abs(of_boundary[i].first - setup.times[i]) > 1e-6 * setup.times.back())
        throw IoError(fmt::format("{}: row {} of the boundary '{}' has time_s {}, not {}", file.string(), i + 1, names[b],
                                  of_boundary[i].first, setup.times[i]));
      forces[i][b] = of_boundary[i].second;
    }
  }
  return forces;
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

ForeignResults::ForeignResults(std::filesystem::path directory, const CaseEntry& entry, const CaseContext& context)
    : directory_(std::move(directory)) {
  if (!can_be_exported(entry))
    throw ConfigError(fmt::format("case '{}' cannot be graded: it has no set-ups; `mpm-validate list` marks those that have", entry.name));
  if (!std::filesystem::is_directory(directory_)) throw IoError(fmt::format("no folder of results '{}'", directory_.string()));
  read_solver();
  const std::filesystem::path description = directory_ / "case.json";
  if (!std::filesystem::exists(description)) {
    throw IoError(fmt::format("{}: missing; copy the file of the exported case, which names the case and the level of the results",
                              description.string()));
  }
  const json described = json::parse(read_file(description), nullptr, false);
  const auto text = [&](const char* key) {
    return described.is_object() && described.contains(key) ? described.value(key, "") : std::string();
  };
  if (text("case") != entry.name || text("level") != to_string(context.level())) {
    throw ConfigError(fmt::format("'{}' is of case '{}', level {}; asked for is case '{}', level {}", description.string(), text("case"),
                                  text("level"), entry.name, to_string(context.level())));
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
        missing.push_back(fmt::format("{}: missing; columns {}", (run / "forces.csv").string(), fmt::join(force_columns, ", ")));
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
    std::vector<std::vector<Vec3>> forces;
    if (setup.forces) forces = read_forces(run / "forces.csv", setup);
    std::map<std::uint64_t, double> masses;
    if (setup.particles) {
      const CaseScene scene = make_scene(setup.spec);
      for (const ParticleRecord& p : particle_records(setup.start(setup.spec, scene), scene)) masses[p.id] = p.mass;
    }
    const auto note = [&](const auto& values) {
      not_finite_ +=
          static_cast<std::size_t>(std::count_if(std::begin(values), std::end(values), [](double v) { return !std::isfinite(v); }));
    };
    for (const auto& of_time : forces)
      for (const Vec3& force : of_time) note(force);
    Instant now;
    for (std::size_t i = 0; i < setup.times.size(); ++i) {
      now.index = i;
      now.before = i == 0 ? 0.0 : setup.times[i - 1];
      now.time = setup.times[i];
      if (setup.forces) now.forces = forces[i];
      if (setup.particles) {
        const std::unique_ptr<ColumnSource> state = open_state(run, i);
        if (state == nullptr) {
          throw IoError(fmt::format("{}: neither states/{}.csv nor group {} of states.h5, the state at t = {} s", run.string(),
                                    state_number(i), state_number(i), setup.times[i]));
        }
        now.particles = read_state(*state, setup, masses);
        for (const ParticleRecord& p : now.particles) {
          note(p.position);
          note(p.velocity);
          note(p.stress);
          note(std::array{p.volume_ratio});
        }
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
