#include "libmpm/io/snapshot.hpp"

#include <fmt/format.h>

#include <charconv>
#include <cmath>
#include <numeric>
#include <optional>
#include <utility>

#include "libmpm/core/step.hpp"
#include "libmpm/core/stress_update.hpp"
#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/hdf5.hpp"
#include "libmpm/io/joint_file.hpp"

namespace mpm {
namespace {

using Kind = SnapshotKind;

constexpr int snapshot_format_version = 1;  // another version is refused

constexpr std::string_view name_of(Kind kind) { return kind == Kind::frame ? "frame" : "final"; }

/// Calls f(name in the file, column, numbers a particle) for each column that a kind of file holds as it is.
template <class F>
void for_each_stored(Kind kind, F&& f) {
  f("position_m", &ParticleTable::position, 3);
  f("velocity_m_s", &ParticleTable::velocity, 3);
  if (kind == Kind::final) f("velocity_gradient_1_s", &ParticleTable::affine, 9);
  f("kirchhoff_stress_pa", &ParticleTable::stress, 6);
  f("internal", &ParticleTable::internal, 1);
  f("volume_ratio", &ParticleTable::volume_ratio, 1);
  f("reference_volume_m3", &ParticleTable::volume, 1);
}

void check_columns(const std::filesystem::path& path, Kind kind, const ParticleTable& p) {
  for_each_stored(kind, [&](const char* name, auto column, std::size_t numbers) {
    if ((p.*column).size() == numbers * p.size()) return;
    throw IoError(fmt::format("cannot write '{}': column {} has {} numbers for {} particles, {} are needed", path.string(), name,
                              (p.*column).size(), p.size(), numbers * p.size()));
  });
}

std::vector<float> narrow(const std::vector<double>& values) { return {values.begin(), values.end()}; }

void put_info(hdf5::Writer& file, std::string_view kind, const SnapshotInfo& info) {
  file.attribute("format_version", std::int64_t{snapshot_format_version});
  file.attribute("kind", std::string(kind));
  file.attribute("time_s", info.time);
  file.attribute("step", info.step);
  file.attribute("case_hash", info.case_hash);
  file.attribute("version", info.version);
  file.attribute("reference_density_kg_m3", info.reference_density);
  file.attribute("mirror_x", std::int64_t{info.mirror_x});
  file.attribute("mirror_y", std::int64_t{info.mirror_y});
  file.attribute("precision", std::string(name_of(info.precision)));
}

SnapshotInfo get_info(const hdf5::Reader& file, const std::filesystem::path& path, Kind kind) {
  if (const auto version = file.integer("format_version"); version != snapshot_format_version) {
    throw IoError(fmt::format("cannot read '{}': format version {}, this program reads version {}; use the program that wrote it",
                              path.string(), version, snapshot_format_version));
  }
  if (const auto found = file.text("kind"); found != name_of(kind)) {
    throw IoError(fmt::format("cannot read '{}': it holds a '{}' state, a '{}' state was expected", path.string(), found, name_of(kind)));
  }
  SnapshotInfo info;
  info.time = file.real("time_s");
  info.step = file.integer("step");
  info.case_hash = file.text("case_hash");
  info.version = file.text("version");
  info.reference_density = file.real("reference_density_kg_m3");
  info.mirror_x = file.integer("mirror_x") != 0;
  info.mirror_y = file.integer("mirror_y") != 0;
  if (file.text("precision") == name_of(Precision::single_precision)) info.precision = Precision::single_precision;
  if (!std::isfinite(info.time) || !(info.reference_density > 0.0) || !std::isfinite(info.reference_density)) {
    throw IoError(fmt::format("cannot read '{}': time {} s and reference density {} kg/m^3 belong to no run; write the file again",
                              path.string(), info.time, info.reference_density));
  }
  return info;
}

/// Checks properties of every state of a run: each particle once, finite, with a volume. Measurements of other files would be wrong without
/// notice.
void check_content(const std::filesystem::path& path, const ParticleTable& p) {
  const auto refuse = [&](std::size_t row, const std::string& what) {
    throw IoError(fmt::format("cannot read '{}': row {}, particle {}: {}; write the file again", path.string(), row, p.id[row], what));
  };
  for (std::size_t i = 1; i < p.size(); ++i) {
    if (p.id[i] <= p.id[i - 1]) refuse(i, fmt::format("it follows particle {}, identity numbers ascend", p.id[i - 1]));
  }
  for_each_stored(Kind::final, [&](const char* name, auto member, std::size_t numbers) {
    const std::vector<double>& column = p.*member;
    const bool positive = member == &ParticleTable::volume_ratio || member == &ParticleTable::volume;
    for (std::size_t i = 0; i < column.size(); ++i) {
      if (!std::isfinite(column[i]) || (positive && !(column[i] > 0.0)))
        refuse(i / numbers, fmt::format("{} = {}, {} is needed", name, column[i], positive ? "a number above 0" : "a finite number"));
    }
  });
}

/// Converts between columns first (core/particle.hpp) and rows first (numpy): the transpose of each 3x3.
std::vector<double> transposed(const std::vector<double>& m) {
  std::vector<double> t(m.size());
  for (std::size_t p = 0; p < m.size(); p += 9) {
    for (std::size_t i = 0; i < 3; ++i) {
      for (std::size_t j = 0; j < 3; ++j) t[p + 3 * i + j] = m[p + 3 * j + i];
    }
  }
  return t;
}

/// @param get  the i-th particle, by rising identity number
template <class Get>
ParticleTable table_of(std::size_t n, Get&& get, const Scene& scene) {
  ParticleTable t;
  t.id.resize(n);
  for_each_stored(Kind::final, [&](const char*, auto column, std::size_t numbers) { (t.*column).resize(numbers * n); });
#pragma omp parallel for schedule(static)
  for (std::size_t i = 0; i < n; ++i) {
    const Particle& p = get(i);
    t.id[i] = p.id;
    for (int axis = 0; axis < 3; ++axis) t.position[3 * i + static_cast<std::size_t>(axis)] = p.position[axis] - scene.offset[axis];
    std::copy_n(p.velocity, 3, &t.velocity[3 * i]);
    std::copy_n(p.affine, 9, &t.affine[9 * i]);
    std::copy_n(p.stress, 6, &t.stress[6 * i]);
    t.internal[i] = p.internal;
    t.volume[i] = p.volume;
    t.volume_ratio[i] = volume_ratio(scene.material, p);
  }
  return t;
}

/// Calls f(name, extents of a row, function that computes the values of some particles) for each column of a kind, in the order of the
/// file.
/// @param first  row of the first of these particles
template <class F>
void for_each_column(Kind kind, const SnapshotInfo& info, std::size_t first, F&& f) {
  const auto whole = [](auto member) {
    return [member](const ParticleTable& p) -> const auto& { return p.*member; };
  };
  const auto narrowed = [](auto member) { return [member](const ParticleTable& p) { return narrow(p.*member); }; };
  const auto derived = [](auto of) {  // of the Kirchhoff stress and J
    return [of](const ParticleTable& p) {
      std::vector<float> values(p.size());
      for (std::size_t i = 0; i < p.size(); ++i) values[i] = static_cast<float>(of(&p.stress[6 * i], p.volume_ratio[i]));
      return values;
    };
  };
  const bool final = kind == Kind::final;
  f("id", {}, whole(&ParticleTable::id));
  f("position_m", {3}, whole(&ParticleTable::position));
  if (final) f("velocity_m_s", {3}, whole(&ParticleTable::velocity));
  if (!final) f("velocity_m_s", {3}, narrowed(&ParticleTable::velocity));
  if (final) f("velocity_gradient_1_s", {3, 3}, [](const ParticleTable& p) { return transposed(p.affine); });
  f("kirchhoff_stress_pa", {6}, whole(&ParticleTable::stress));
  f("volume_ratio", {}, whole(&ParticleTable::volume_ratio));
  f("reference_volume_m3", {}, whole(&ParticleTable::volume));
  if (final) return f("internal", {}, whole(&ParticleTable::internal));
  f("internal", {}, narrowed(&ParticleTable::internal));
  f("pressure_pa", {}, derived([](const double* tau, double j) { return -(tau[0] + tau[1] + tau[2]) / (3.0 * j); }));
  f("stress_xx_pa", {}, derived([](const double* tau, double j) { return tau[0] / j; }));
  f("density_kg_m3", {}, derived([&info](const double*, double j) { return info.reference_density / j; }));
  f("vertex", {}, [first](const ParticleTable& p) {
    std::vector<std::int32_t> vertex(p.size());
    std::iota(vertex.begin(), vertex.end(), static_cast<std::int32_t>(first));
    return vertex;
  });
}

}  // namespace

ParticleTable particle_table(std::span<const Particle> particles, const Scene& scene) {
  return table_of(
      particles.size(), [&](std::size_t i) -> const Particle& { return particles[i]; }, scene);
}

ParticleTable particle_table(const State& state, const Scene& scene, const std::function<bool(const Particle&)>& keep) {
  const ParticleOrder order(state.grid, keep);
  return table_of(
      order.size(), [&](std::size_t i) { return order[i]; }, scene);
}

std::filesystem::path frame_path(const std::filesystem::path& directory, int index) {
  return directory / "frames" / fmt::format("{:05d}.h5", index);
}

struct SnapshotWriter::File {
  Kind kind = Kind::frame;
  std::filesystem::path path;
  SnapshotInfo info;
  std::size_t particles = 0;  ///< of all ranks
  std::size_t next = 0;       ///< row of the next particle of this one
  std::optional<JointFile> out;

  [[nodiscard]] std::unique_ptr<hdf5::Writer> made() const {
    auto file = std::make_unique<hdf5::Writer>(path);
    put_info(*file, name_of(kind), info);
    for_each_column(kind, info, 0, [&](const char* name, std::initializer_list<std::size_t> row, auto&& values_of) {
      hdf5::Shape shape = {particles};
      shape.insert(shape.end(), row);
      using Values = std::decay_t<decltype(values_of(ParticleTable{}))>;
      file->declare<typename Values::value_type>(name, shape);
    });
    return file;
  }
  void write(hdf5::ArrayWriter& values_writer, const ParticleTable& piece) {
    check_columns(path, kind, piece);
    for_each_column(kind, info, next, [&](const char* name, std::initializer_list<std::size_t> row, auto&& values_of) {
      const auto& values = values_of(piece);
      using Values = std::decay_t<decltype(values)>;
      const std::size_t numbers_of_a_row = std::accumulate(row.begin(), row.end(), std::size_t{1}, std::multiplies<>());
      values_writer.write(name, numbers_of_a_row * next, std::span<const typename Values::value_type>(values));
    });
    next += piece.size();
  }
};

SnapshotWriter::SnapshotWriter() : file_(std::make_unique<File>()) {}
SnapshotWriter::SnapshotWriter(Kind kind, std::filesystem::path path, SnapshotInfo info) : SnapshotWriter() {
  file_->kind = kind;
  file_->path = std::move(path);
  file_->info = std::move(info);
}
SnapshotWriter::~SnapshotWriter() = default;

void SnapshotWriter::begin(std::size_t particles, std::size_t first, Ranks& ranks) {
  file_->particles = particles;
  file_->next = first;
  Message about;  // what the columns of another rank depend on
  put(about, file_->kind);
  put(about, file_->info.reference_density);
  file_->out.emplace(ranks).begin([this] { return file_->made(); }, about);
  MessageReader reader(about);
  file_->kind = reader.get<Kind>();
  file_->info.reference_density = reader.get<double>();
}

void SnapshotWriter::append(const ParticleTable& piece) {
  file_->out->attempt([&](hdf5::ArrayWriter& values) { file_->write(values, piece); });
}

void SnapshotWriter::append(std::span<const Particle> piece, const Scene& scene) {
  file_->out->attempt([&](hdf5::ArrayWriter& values) { file_->write(values, particle_table(piece, scene)); });
}

void SnapshotWriter::commit() { file_->out->commit(); }
void SnapshotWriter::write(const ParticleTable& particles) {
  begin(particles.size());
  append(particles);
  commit();
}

std::size_t SnapshotWriter::particles() const { return file_->particles; }

SnapshotWriter frame_writer(const std::filesystem::path& directory, int index, const SnapshotInfo& info) {
  const std::filesystem::path path = frame_path(directory, index), frames = path.parent_path();
  std::error_code error;
  std::filesystem::create_directory(frames, error);
  if (error) throw file_error("cannot create directory", frames, error.value());
  return SnapshotWriter(SnapshotKind::frame, path, info);
}

Snapshot read_snapshot(const std::filesystem::path& path, SnapshotKind kind) {
  const hdf5::Reader file(path);
  Snapshot s;
  s.info = get_info(file, path, kind);
  ParticleTable& p = s.particles;
  p.id = file.dataset<std::uint64_t>("id", {hdf5::any_extent});
  const std::size_t n = p.size();
  for_each_stored(kind, [&](const char* name, auto column, std::size_t numbers) {
    const hdf5::Shape shape = numbers == 1 ? hdf5::Shape{n} : numbers == 9 ? hdf5::Shape{n, 3, 3} : hdf5::Shape{n, numbers};
    p.*column = file.dataset<double>(name, shape);
  });
  p.affine = transposed(p.affine);
  check_content(path, p);
  return s;
}

std::vector<int> frame_numbers(const std::filesystem::path& directory) {
  std::vector<int> numbers;
  for (const std::string& name : names_in(directory / "frames")) {
    int index = 0;
    const auto [end, failure] = std::from_chars(name.data(), name.data() + name.size(), index);
    if (failure == std::errc() && std::string_view(end) == ".h5" && frame_path(directory, index).filename() == name)
      numbers.push_back(index);
  }
  std::ranges::sort(numbers);
  return numbers;
}

FrameEntry read_frame_entry(const std::filesystem::path& directory, int index) {
  const std::filesystem::path path = frame_path(directory, index);
  const hdf5::Reader file(path);
  const SnapshotInfo info = get_info(file, path, Kind::frame);
  const hdf5::Shape rows = file.shape("id");
  if (rows.size() != 1) throw IoError(fmt::format("cannot read '{}': dataset 'id' is not a list; write the file again", path.string()));
  return {index, info.time, rows.front()};
}

}  // namespace mpm
