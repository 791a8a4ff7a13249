#include "mpm/io/checkpoint.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <optional>
#include <span>
#include <tuple>
#include <utility>

#include "mpm/error.hpp"
#include "mpm/io/atomic_file.hpp"
#include "mpm/io/config.hpp"
#include "mpm/io/hdf5.hpp"

namespace mpm {

namespace {

constexpr const char* kind = "libmpm checkpoint";
constexpr std::int32_t most_particles_of_a_block = 65000;  // slots are 16 bits wide

std::vector<double> packed(const State& s, const RunProgress& p) {
  std::vector<double> v = {s.time, s.max_speed, p.wall_time, p.step_time};
  for (const Passage* q : {&s.entered, &s.left}) v.insert(v.end(), {q->mass, q->momentum.x(), q->momentum.y(), q->momentum.z(), q->energy});
  return v;
}

std::vector<double> flattened(const std::vector<Vec3>& vectors) {
  std::vector<double> flat;
  flat.reserve(3 * vectors.size());
  for (const Vec3& v : vectors) flat.insert(flat.end(), {v.x(), v.y(), v.z()});
  return flat;
}

std::vector<Vec3> vectors_of(const std::vector<double>& flat) {
  std::vector<Vec3> vectors(flat.size() / 3);
  for (std::size_t i = 0; i < vectors.size(); ++i) vectors[i] = Vec3(flat[3 * i], flat[3 * i + 1], flat[3 * i + 2]);
  return vectors;
}

/// Columns of the series under the names of their datasets.
template <class Series, class F>
void for_each_column(Series& series, F&& f) {
  f("series_time_s", series.time);
  f("series_runup_m", series.runup);
  f("series_runup_p99_m", series.runup_p99);
  f("series_pressure_height_m", series.pressure_height);
  f("series_impact_pressure_pa", series.impact_pressure);
  f("series_compaction", series.compaction);
  f("series_profile_pa", series.profile_pressure);
  f("series_force_bins_n", series.force_bins);
  f("series_force_first_moment_n_m", series.force_first_moment);
}

using Refuse = std::function<void(const std::string& why)>;

/// Whether a particle can stand where the file has it: what follows relies on cells that hold their particles. The slack is for rounding:
/// a step computes the cell in another order of operations.
bool in_its_cell(const Particle& p, const Index3& block, std::uint8_t cell, double cell_size) {
  constexpr double slack = 1e-6;  // cells
  for (int axis = 0; axis < 3; ++axis) {
    const double node = 4.0 * block[static_cast<std::size_t>(axis)] + (cell >> (2 * axis) & 3);
    if (!(std::abs(p.position[axis] / cell_size - node - 1.0) <= 0.5 + slack)) return false;
  }
  return true;
}

bool all_finite(const Particle& p) {
  const auto finite = [](const auto& numbers) { return std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); }); };
  return finite(p.position) && finite(p.velocity) && finite(p.affine) && finite(p.stress) && std::isfinite(p.internal);
}

/// Particles of one block, which the file holds behind those of the blocks before.
void check_particles(std::span<const Particle> particles, std::span<const std::uint8_t> cells, const Index3& block, double cell_size,
                     const Refuse& refuse) {
  for (std::size_t i = 0; i < particles.size(); ++i) {
    const Particle& p = particles[i];
    if (cells[i] >= block_nodes || !in_its_cell(p, block, cells[i], cell_size)) {
      refuse(fmt::format("particle {} at ({}, {}, {}) m is not in cell {} of block ({}, {}, {})", p.id, p.position[0], p.position[1],
                         p.position[2], cells[i], block[0], block[1], block[2]));
    }
    if (!all_finite(p) || !(p.volume > 0.0) || !std::isfinite(p.volume))
      refuse(fmt::format("particle {} has a volume of {} m^3 or numbers that are not finite", p.id, p.volume));
  }
}

/// Blocks ascend as they are written, so that none comes twice, within the reach of the grid.
void check_block(const Index3& block, const std::optional<Index3>& before, const Refuse& refuse) {
  constexpr std::int32_t reach = (1 << 20) - 2;  // of the grid's coordinates, with a neighbour to each side
  const auto key = [](const Index3& c) { return std::tuple(c[2], c[1], c[0]); };
  const bool far = std::ranges::any_of(block, [](std::int32_t c) { return c > reach || c < -reach; });
  if (far || (before && key(block) <= key(*before)))
    refuse(fmt::format("block ({}, {}, {}) is out of reach or out of order", block[0], block[1], block[2]));
}

/// Columns of one length: what follows indexes them by each other's.
void check_series(const ImpactSeries& series, const Refuse& refuse) {
  const std::size_t n = series.size(), bins = series.profile_bins;
  constexpr std::size_t most_bins = 1 << 24;
  if (bins > most_bins) refuse(fmt::format("a pressure profile of {} bins", bins));
  const auto check = [&](const std::string& name, std::size_t size) {
    const bool optional = name.starts_with("series_force_bins") || name.starts_with("series_force_first");
    const std::size_t width = name.starts_with("series_profile") ? bins : name.starts_with("series_force_bins") ? bins + 1 : 1;
    if (size != n * width && !(optional && size == 0)) refuse(fmt::format("{} has {} numbers for {} rows", name, size, n));
  };
  for_each_column(series, [&](const char* name, const std::vector<double>& column) { check(name, column.size()); });
  check("series_force_n", series.force.size());
  check("series_moment_n_m", series.moment.size());
}

}  // namespace

void write_checkpoint(const std::filesystem::path& path, const Case& c, const State& state, const RunProgress& progress,
                      const ImpactSeries& series, const std::filesystem::path& keep_as) {
  hdf5::Writer file;
  file.attribute("kind", std::string(kind));
  file.attribute("format_version", std::int64_t{checkpoint_format_version});
  file.attribute("case_hash", case_hash_text(c));
  file.attribute("case", write_case(c));

  std::vector<std::int32_t> coordinates, counts;
  std::vector<std::uint8_t> records, cells;
  records.reserve(state.grid.particle_count() * sizeof(Particle));
  for (const auto b : state.grid.occupied_blocks()) {
    const Block& block = state.grid.block(b);
    coordinates.insert(coordinates.end(), block.coordinate.begin(), block.coordinate.end());
    counts.push_back(block.particles.count());
    cells.insert(cells.end(), block.particles.cell.begin(), block.particles.cell.end());
    for (int s = 0; s < block.particles.count(); ++s) {
      const auto* bytes = reinterpret_cast<const std::uint8_t*>(&block.particles[s]);
      records.insert(records.end(), bytes, bytes + sizeof(Particle));
    }
  }
  file.dataset<std::int32_t>("block_coordinates", coordinates, {counts.size(), 3});
  file.dataset<std::int32_t>("block_counts", counts);
  file.dataset<std::uint8_t>("cells", cells);
  file.dataset<std::uint8_t>("particle_records", records, {cells.size(), sizeof(Particle)});
  const std::vector<std::uint64_t> counters = {
      state.step,       state.next_id,         state.fed_layers, state.entered.count,     state.entered.downstream,
      state.left.count, state.left.downstream, progress.samples, progress.particle_steps, progress.initial_particles};
  file.dataset<std::uint64_t>("counters", counters);
  file.dataset<double>("reals", packed(state, progress));
  for_each_column(series, [&](const char* name, const std::vector<double>& column) { file.dataset<double>(name, column); });
  file.dataset<double>("series_force_n", flattened(series.force));
  file.dataset<double>("series_moment_n_m", flattened(series.moment));
  file.attribute("profile_bins", static_cast<std::int64_t>(series.profile_bins));
  file.save(path, keep_as);
}

namespace {

/// In which keys the case of a checkpoint differs, for a message.
std::string differences(const std::string& case_text, const Case& c) {
  try {
    const auto keys = case_differences(parse_case(case_text, checkpoint_file), c);
    if (!keys.empty()) return fmt::format("{}", fmt::join(keys, "; "));
  } catch (const ConfigError&) {  // written by another version: its hash must do
  }
  return "its hash differs";
}

}  // namespace

void read_checkpoint(const std::filesystem::path& path, const Case& c, State& state, RunProgress& progress, ImpactSeries& series) {
  const hdf5::Reader file(path);
  const Refuse refuse = [&](const std::string& why) { throw IoError(fmt::format("{}: {}", path.string(), why)); };
  if (file.text("kind") != kind) refuse("this is not a checkpoint");
  if (file.integer("format_version") != checkpoint_format_version) {
    refuse(fmt::format("checkpoint format {}, this program reads {}; go on with the version of the program that wrote it",
                       file.integer("format_version"), checkpoint_format_version));
  }
  if (file.text("case_hash") != case_hash_text(c)) {
    throw ConfigError(
        fmt::format("{}: it belongs to another case: {}; put the case back, use another --out directory, or run without --resume",
                    path.string(), differences(file.text("case"), c)));
  }
  const auto counts = file.dataset<std::int32_t>("block_counts", {hdf5::any_extent});
  const auto coordinates = file.dataset<std::int32_t>("block_coordinates", {counts.size(), 3});
  const auto cells = file.dataset<std::uint8_t>("cells", {hdf5::any_extent});
  const auto records = file.dataset<std::uint8_t>("particle_records", {cells.size(), sizeof(Particle)});
  std::size_t first = 0;
  std::vector<Particle> particles;
  std::optional<Index3> before;
  for (std::size_t b = 0; b < counts.size(); ++b) {
    const auto n = static_cast<std::size_t>(counts[b]);
    if (counts[b] < 0 || counts[b] > most_particles_of_a_block || n > cells.size() - first)
      refuse("its block counts contradict its particles");
    const Index3 block{coordinates[3 * b], coordinates[3 * b + 1], coordinates[3 * b + 2]};
    check_block(block, before, refuse);
    before = block;
    particles.resize(n);
    if (n > 0) std::memcpy(particles.data(), records.data() + first * sizeof(Particle), n * sizeof(Particle));
    check_particles(particles, std::span(cells).subspan(first, n), block, c.numerics.cell_size, refuse);
    first += n;
  }
  if (first != cells.size()) refuse("its block counts contradict its particles");
  const auto counters = file.dataset<std::uint64_t>("counters", {10});
  const auto reals = file.dataset<double>("reals", {14});
  if (!std::ranges::all_of(reals, [](double x) { return std::isfinite(x); }) || reals[0] < 0.0 || reals[1] < 0.0)
    refuse(fmt::format("time {} s, speed {} m/s, or a sum that is not finite: no run wrote this", reals[0], reals[1]));
  ImpactSeries measured;
  for_each_column(measured,
                  [&](const char* name, std::vector<double>& column) { column = file.dataset<double>(name, {hdf5::any_extent}); });
  const auto vectors = [&](const char* name) {
    const auto flat = file.dataset<double>(name, {hdf5::any_extent});
    if (flat.size() % 3 != 0) refuse(fmt::format("{} has {} numbers, which are not vectors", name, flat.size()));
    return vectors_of(flat);
  };
  measured.force = vectors("series_force_n");
  measured.moment = vectors("series_moment_n_m");
  measured.profile_bins = static_cast<std::size_t>(file.integer("profile_bins"));
  check_series(measured, refuse);

  // Everything is there: from here on nothing is refused.
  first = 0;
  for (std::size_t b = 0; b < counts.size(); ++b) {
    const auto n = static_cast<std::size_t>(counts[b]);
    particles.resize(n);
    if (n > 0) std::memcpy(particles.data(), records.data() + first * sizeof(Particle), n * sizeof(Particle));
    state.grid.restore({coordinates[3 * b], coordinates[3 * b + 1], coordinates[3 * b + 2]}, particles, std::span(cells).subspan(first, n));
    first += n;
  }
  state.grid.refresh();
  state.step = counters[0];
  state.next_id = counters[1];
  state.fed_layers = counters[2];
  state.entered = {counters[3], counters[4], reals[4], Vec3(reals[5], reals[6], reals[7]), reals[8]};
  state.left = {counters[5], counters[6], reals[9], Vec3(reals[10], reals[11], reals[12]), reals[13]};
  progress.samples = counters[7];
  progress.particle_steps = counters[8];
  progress.initial_particles = counters[9];
  state.time = reals[0];
  state.max_speed = reals[1];
  progress.wall_time = reals[2];
  progress.step_time = reals[3];
  series = std::move(measured);
}

bool has_checkpoint(const std::filesystem::path& directory) {
  return std::filesystem::exists(directory / checkpoint_file) || std::filesystem::exists(directory / previous_checkpoint_file);
}

std::string resume_from_checkpoint(const std::filesystem::path& directory, const Case& c, State& state, RunProgress& progress,
                                   ImpactSeries& series, const std::function<void(const State&, const RunProgress&)>& acceptable) {
  std::vector<std::string> reasons;
  bool other_case = false;
  for (const char* name : {checkpoint_file, previous_checkpoint_file}) {
    try {
      State found(c.numerics.cell_size);
      RunProgress at;
      ImpactSeries measured;
      read_checkpoint(directory / name, c, found, at, measured);
      if (acceptable) acceptable(found, at);
      state = std::move(found);
      progress = at;
      series = std::move(measured);
    } catch (const ConfigError& error) {
      other_case = other_case || reasons.empty();
      reasons.emplace_back(error.what());
      continue;
    } catch (const IoError& error) {
      reasons.emplace_back(error.what());
      continue;
    }
    if (reasons.empty()) return {};
    std::string kept;
    if (std::filesystem::exists(directory / checkpoint_file)) {
      std::error_code error;
      std::filesystem::rename(directory / checkpoint_file, directory / refused_checkpoint_file, error);
      if (error) throw file_error("cannot rename", directory / checkpoint_file, error.value());
      kept = fmt::format(" (kept as {})", refused_checkpoint_file);
    }
    return fmt::format("{}{}; going on from {}", reasons.front(), kept, previous_checkpoint_file);
  }
  if (other_case) throw ConfigError(reasons.front());
  throw IoError(fmt::format("there is no checkpoint to go on from: {}; run without --resume to start from the beginning",
                            fmt::join(reasons, "; and ")));
}

}  // namespace mpm
