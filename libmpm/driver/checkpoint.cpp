#include "libmpm/driver/checkpoint.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <tuple>
#include <utility>
#include <vector>

#include "libmpm/base/error.hpp"
#include "libmpm/core/state.hpp"
#include "libmpm/driver/build_info.hpp"
#include "libmpm/driver/case_file.hpp"
#include "libmpm/driver/pieces.hpp"
#include "libmpm/driver/scene.hpp"
#include "libmpm/io/hdf5.hpp"
#include "libmpm/io/joint_file.hpp"
#include "libmpm/parallel/block_exchange.hpp"
#include "libmpm/parallel/joined_blocks.hpp"
#include "libmpm/parallel/ownership.hpp"

namespace mpm {

// ---- Writing ---------------------------------------------------------------------------------------------------------------------------

namespace {

constexpr const char* file_kind = "libmpm checkpoint";

/// Calls count() with every counter and real() with every other number of a state and its run, in the order of the file.
template <class StateOrConst, class ProgressOrConst, class Count, class Real>
void for_each_number(StateOrConst& s, ProgressOrConst& p, Count&& count, Real&& real) {
  for (auto* x : {&s.step, &s.next_id, &s.source_count}) count(*x);
  for (auto* x : {&s.time, &s.max_speed, &p.wall_time, &p.step_time}) real(*x);
  for (auto* flux : {&s.entered, &s.left}) {
    for (auto* x : {&flux->count, &flux->through_x_max}) count(*x);
    for (auto* x : {&flux->mass, &flux->momentum.x(), &flux->momentum.y(), &flux->momentum.z(), &flux->energy}) real(*x);
  }
  for (auto* x : {&p.samples, &p.particle_steps, &p.initial_particles}) count(*x);
}

/// Datasets of observers have a point in their names; the program's own have none.
bool is_observed(const std::string& dataset) { return dataset.find('.') != std::string::npos; }

/// Writes everything except the blocks.
void write_rest(hdf5::Writer& file, const State& state, const RunProgress& progress, const Arrays& observed) {
  std::vector<std::uint64_t> counters;
  std::vector<double> reals;
  for_each_number(
      state, progress, [&](std::uint64_t x) { counters.push_back(x); }, [&](double x) { reals.push_back(x); });
  file.dataset<std::uint64_t>("counters", counters);
  file.dataset<double>("reals", reals);
  for (const auto& [name, values] : observed) {
    if (!is_observed(name)) throw Error(ExitCode::internal, fmt::format("array '{}' has no observer's name before it", name));
    file.dataset<double>(name, values);
  }
}

/// The occupied blocks of all ranks in their order, on all ranks.
std::vector<BlockHead> heads_of(const Grid& grid) {
  std::vector<BlockHead> heads;
  for (const auto b : grid.occupied_blocks()) heads.push_back({grid.block(b).coordinate, grid.block(b).particles.count()});
  RankGroup& ranks = grid.ranks();
  Message message;
  put(message, std::span<const BlockHead>(heads));
  heads.clear();
  for (const Message& some : ranks.gather(std::move(message))) {
    const auto more = MessageReader(some).values<BlockHead>();
    heads.insert(heads.end(), more.begin(), more.end());
  }
  std::ranges::sort(heads, comes_before, &BlockHead::block);
  Message all;
  put(all, std::span<const BlockHead>(heads));
  ranks.share(all);
  return MessageReader(all).values<BlockHead>();
}

/// Blocks of this rank on their way into a file: those that follow one another there are written together.
class BlockColumns {
 public:
  BlockColumns(hdf5::ArrayWriter& file, Precision precision) : file_(file), precision_(precision) {}
  /// @param row  of the block in the file, and of its first particle
  void append(const Block& block, std::size_t row, std::size_t particle) {
    if (row != row_ + counts_.size() || cells_.size() >= PieceSize{}.particles) {
      flush();
      row_ = row;
      particle_ = particle;
    }
    const ParticleBin& bin = block.particles;
    coordinates_.insert(coordinates_.end(), block.coordinate.begin(), block.coordinate.end());
    counts_.push_back(bin.count());
    for (const double v : bin.frame.velocity) velocities_.push_back(v);
    cells_.insert(cells_.end(), bin.cell.begin(), bin.cell.end());
    for (int s = 0; s < bin.count(); ++s) {
      const std::span<const std::byte> bytes = bin.bytes(s);
      const auto* first = reinterpret_cast<const std::uint8_t*>(bytes.data());
      records_.insert(records_.end(), first, first + bytes.size());
    }
  }
  void flush() {
    write_and_clear("block_coordinates", 3 * row_, coordinates_);
    write_and_clear("block_counts", row_, counts_);
    write_and_clear("cells", particle_, cells_);
    if (precision_ == Precision::single_precision) write_and_clear("block_velocities", 3 * row_, velocities_);
    write_and_clear("particle_records", record_bytes(precision_) * particle_, records_);
    velocities_.clear();
  }

 private:
  template <class T>
  void write_and_clear(const char* name, std::size_t first, std::vector<T>& values) {
    file_.write(name, first, std::span<const T>(values));
    values.clear();
  }

  hdf5::ArrayWriter& file_;
  Precision precision_;
  std::size_t row_ = 0, particle_ = 0;  ///< in the file, of the first that is not written yet
  std::vector<std::int32_t> coordinates_, counts_;
  std::vector<double> velocities_;
  std::vector<std::uint8_t> cells_, records_;
};

/// Declares the arrays of some blocks, for write_blocks().
void declare_blocks(hdf5::Writer& file, Precision precision, std::span<const BlockHead> heads) {
  const std::size_t blocks = heads.size();
  std::size_t particles = 0;
  for (const BlockHead& head : heads) particles += static_cast<std::size_t>(head.count);
  file.declare<std::int32_t>("block_coordinates", {blocks, 3});
  file.declare<std::int32_t>("block_counts", {blocks});
  file.declare<std::uint8_t>("cells", {particles});
  if (precision == Precision::single_precision) file.declare<double>("block_velocities", {blocks, 3});
  file.declare<std::uint8_t>("particle_records", {particles, record_bytes(precision)});
}

/// All ranks call this: writes a file with the blocks of each. @param make  as in JointFile::begin, given all blocks; it declares their
/// arrays. @param keep_as  as in AtomicFile::commit. @throws IoError
void write_blocks(const State& state, const std::function<std::unique_ptr<hdf5::Writer>(std::span<const BlockHead>)>& make,
                  const std::filesystem::path& keep_as) {
  const Grid& grid = state.grid;
  grid.ranks().instruct(Task::blocks, state);
  const std::vector<BlockHead> heads = heads_of(grid);
  JointFile file(grid.ranks());
  Message nothing;
  file.begin([&] { return make(heads); }, nothing);
  file.attempt([&](hdf5::ArrayWriter& values) {
    BlockColumns columns(values, grid.precision());
    std::size_t particle = 0;
    for (std::size_t row = 0; row < heads.size(); ++row) {
      if (const auto b = grid.find(heads[row].block); b != no_block) columns.append(grid.block(b), row, particle);
      particle += static_cast<std::size_t>(heads[row].count);
    }
    columns.flush();
  });
  file.commit(keep_as);
}

}  // namespace

void write_checkpoint(const std::filesystem::path& path, const Case& c, const State& state, const RunProgress& progress,
                      const Arrays& observed, const std::filesystem::path& keep_as) {
  const auto make = [&](std::span<const BlockHead> heads) {
    auto file = std::make_unique<hdf5::Writer>(path);
    file->attribute("kind", std::string(file_kind));
    file->attribute("format_version", std::int64_t{checkpoint_format_version});
    file->attribute("version", std::string(build_info().version));
    file->attribute("case_hash", case_hash_text(c));
    file->attribute("case", write_case(c));
    file->attribute("precision", std::string(name_of(state.grid.precision())));
    declare_blocks(*file, state.grid.precision(), heads);
    write_rest(*file, state, progress, observed);
    return file;
  };
  write_blocks(state, make, keep_as);
}

void write_own_blocks(const State& state) { write_blocks(state, {}, {}); }

// ---- Reading ---------------------------------------------------------------------------------------------------------------------------

namespace {

constexpr const char* contradiction = "its block counts contradict its particles";

/// Throws that a file cannot be used, with the reason.
using Refuse = std::function<void(const std::string& why)>;

/// Whether a particle of the file lies in the cell that the file gives for it; the kernels rely on that. The tolerance is for rounding: a
/// step computes the cell in another order of operations.
bool in_its_cell(const Particle& p, const Index3& block, std::uint8_t cell, double cell_size) {
  constexpr double slack = 1e-6;  // cells
  for (int axis = 0; axis < 3; ++axis) {
    const double node = node_index(block, cell)[static_cast<std::size_t>(axis)];
    if (!(std::abs(p.position[axis] / cell_size - node - 1.0) <= 0.5 + slack)) return false;
  }
  return true;
}

/// Particles of one block, whose identity numbers are appended to ids.
void check_particles(const StoredBlock& stored, Precision precision, double cell_size, std::uint64_t next_id,
                     std::vector<std::uint64_t>& ids, const Refuse& refuse) {
  const Index3& block = stored.coordinate;
  const RecordFrame frame{block, cell_size, stored.velocity};
  const std::size_t size = record_bytes(precision);
  for (std::size_t i = 0; i < stored.cells.size(); ++i) {
    const Particle p = with_record_type(precision, [&](auto record) {
      std::memcpy(&record, stored.records.data() + i * size, size);
      return Particle(decode(record, frame));
    });
    if (p.id >= next_id) refuse(fmt::format("particle {} has a number that is not given yet: the next one is {}", p.id, next_id));
    ids.push_back(p.id);
    const int cell = stored.cells[i];
    if (cell >= block_nodes || !in_its_cell(p, block, stored.cells[i], cell_size)) {
      refuse(fmt::format("particle {} at ({}, {}, {}) m is not in cell {} of block ({}, {}, {})", p.id, p.position[0], p.position[1],
                         p.position[2], cell, block[0], block[1], block[2]));
    }
    if (!all_finite(p) || !(p.volume > 0.0) || !std::isfinite(p.volume))
      refuse(fmt::format("particle {} has a volume of {} m^3 or numbers that are not finite", p.id, p.volume));
  }
}

/// Whether the blocks ascend, so that none occurs twice, and lie within the range of the grid.
void check_block(const Index3& block, const std::optional<Index3>& before, const Refuse& refuse) {
  constexpr std::int32_t reach = (1 << 20) - 2;  // of the grid's coordinates, with a neighbour to each side
  const bool far = std::ranges::any_of(block, [](std::int32_t c) { return c > reach || c < -reach; });
  if (far || (before && !comes_before(*before, block)))
    refuse(fmt::format("block ({}, {}, {}) is out of reach or out of order", block[0], block[1], block[2]));
}

std::size_t particles_in(const hdf5::Reader& file) {
  const hdf5::Shape shape = file.shape("cells");
  return shape.empty() ? 0 : shape.front();
}

/// Reads the particles of a file block by block, a piece at a time.
class StoredBlocks {
 public:
  /// @param file  must outlive this object. @throws IoError if an array is missing or has another shape
  StoredBlocks(const hdf5::Reader& file, Precision precision)
      : file_(file),
        precision_(precision),
        counts_(file.dataset<std::int32_t>("block_counts", {hdf5::any_extent})),
        coordinates_(file.dataset<std::int32_t>("block_coordinates", {counts_.size(), 3})),
        velocities_(precision == Precision::single_precision ? file.dataset<double>("block_velocities", {counts_.size(), 3})
                                                             : std::vector<double>(3 * counts_.size(), 0.0)),
        particles_(particles_in(file)) {}

  /// All blocks, in order. Refuses counts and coordinates that no run can have written.
  [[nodiscard]] std::vector<BlockHead> heads(const Refuse& refuse) const {
    std::vector<BlockHead> heads;
    std::size_t particles = 0;
    for (std::size_t b = 0; b < counts_.size(); ++b) {
      if (counts_[b] < 0 || counts_[b] > max_particles_per_block) refuse(contradiction);
      particles += size_of(b);
      heads.push_back({coordinate_of(b), counts_[b]});
      check_block(heads.back().block, b == 0 ? std::nullopt : std::optional(heads[b - 1].block), refuse);
    }
    if (particles != particles_) refuse(contradiction);
    return heads;
  }

  /// Puts the blocks that this rank owns into a grid; all blocks if there is one rank. heads() must have accepted them. Refuses particles
  /// that are not finite, not in their cell, or whose identity number is not below `next_id` or that of
  /// another one (of this rank), because kernels and output rely on that.
  void restore_own(Grid& grid, std::uint64_t next_id, const Refuse& refuse) const {
    const auto own = [&](std::size_t b) { return grid.ranks().owns(coordinate_of(b)); };
    std::vector<std::uint64_t> ids;
    std::size_t first = 0;  // particle
    for (std::size_t b = 0; b < counts_.size();) {
      if (!own(b)) {
        first += size_of(b++);
        continue;
      }
      std::size_t end = b, count = 0;
      for (; end < counts_.size() && own(end) && (count == 0 || count + size_of(end) <= PieceSize{}.particles); ++end)
        count += size_of(end);
      restore_piece(b, end, first, count, grid, next_id, ids, refuse);
      first += count;
      b = end;
    }
    std::ranges::sort(ids);
    if (const auto twice = std::ranges::adjacent_find(ids); twice != ids.end()) refuse(fmt::format("particle {} is there twice", *twice));
  }

 private:
  [[nodiscard]] std::size_t size_of(std::size_t b) const { return static_cast<std::size_t>(counts_[b]); }
  [[nodiscard]] Index3 coordinate_of(std::size_t b) const {
    return {coordinates_[3 * b], coordinates_[3 * b + 1], coordinates_[3 * b + 2]};
  }

  /// Blocks b .. end - 1, with `count` particles from `first` on.
  void restore_piece(std::size_t b, std::size_t end, std::size_t first, std::size_t count, Grid& grid, std::uint64_t next_id,
                     std::vector<std::uint64_t>& ids, const Refuse& refuse) const {
    const std::size_t size = record_bytes(precision_);
    const auto cells = file_.rows<std::uint8_t>("cells", {particles_}, first, count);
    const auto records = file_.rows<std::uint8_t>("particle_records", {particles_, size}, first, count);
    for (std::size_t at = 0; b < end; ++b) {
      const std::size_t n = size_of(b);
      const StoredBlock block{coordinate_of(b), Vec3(velocities_[3 * b], velocities_[3 * b + 1], velocities_[3 * b + 2]),
                              std::span(cells).subspan(at, n), std::as_bytes(std::span(records)).subspan(at * size, n * size)};
      check_particles(block, grid.precision(), grid.cell_size(), next_id, ids, refuse);
      grid.restore(block);
      at += n;
    }
  }

  const hdf5::Reader& file_;
  Precision precision_;
  std::vector<std::int32_t> counts_, coordinates_;
  std::vector<double> velocities_;
  std::size_t particles_;
};

/// The keys in which the case of a checkpoint differs, for a message.
std::string differences(const std::string& case_text, const Case& c) {
  try {
    const auto keys = case_differences(parse_case(case_text, checkpoint_file), c);
    if (!keys.empty()) return fmt::format("{}", fmt::join(keys, "; "));
  } catch (const ConfigError&) {  // written by another version: report the hashes
  }
  return "its hash differs";
}

/// Checks kind, version and case. @throws IoError, ConfigError
void check_header(const hdf5::Reader& file, const Case& c, const std::filesystem::path& path, const Refuse& refuse) {
  if (file.text("kind") != file_kind) refuse("this is not a checkpoint");
  if (file.integer("format_version") != checkpoint_format_version) {
    refuse(fmt::format("checkpoint format {}, this program reads {}; go on with the version of the program that wrote it",
                       file.integer("format_version"), checkpoint_format_version));
  }
  if (const std::string version = file.text("version"); version != build_info().version)
    refuse(fmt::format("a checkpoint of version {}, this program is {}; go on with that version", version, build_info().version));
  if (file.text("case_hash") != case_hash_text(c)) {
    throw ConfigError(
        fmt::format("{}: it belongs to another case: {}; put the case back, use another --out directory, or overwrite it with --force "
                    "instead of --resume",
                    path.string(), differences(file.text("case"), c)));
  }
}

/// All but the blocks.
void read_rest(const hdf5::Reader& file, State& state, RunProgress& progress, const Refuse& refuse) {
  const auto counters = file.dataset<std::uint64_t>("counters", {10});
  const auto reals = file.dataset<double>("reals", {14});
  if (!std::ranges::all_of(reals, [](double x) { return std::isfinite(x); }) || reals[0] < 0.0 || reals[1] < 0.0)
    refuse(fmt::format("time {} s, speed {} m/s, or a sum that is not finite: no run wrote this", reals[0], reals[1]));
  constexpr std::uint64_t most_ids = std::uint64_t{1} << 60;
  if (counters[1] > most_ids) refuse(fmt::format("the next particle has number {}: no run wrote this", counters[1]));
  auto counter = counters.begin();
  auto number = reals.begin();
  for_each_number(
      state, progress, [&](std::uint64_t& x) { x = *counter++; }, [&](double& x) { x = *number++; });
}

/// Throws that a file cannot be used.
Refuse refusing(const std::filesystem::path& path) {
  return [path](const std::string& why) { throw IoError(fmt::format("{}: {}", path.string(), why)); };
}

}  // namespace

void read_checkpoint(const std::filesystem::path& path, const Case& c, State& state, RunProgress& progress, Arrays& observed,
                     BlockExchange* ranks) {
  const hdf5::Reader file(path);
  const Refuse refuse = refusing(path);
  check_header(file, c, path, refuse);
  State found(c.numerics.cell_size, state.grid.precision());
  RunProgress at;
  read_rest(file, found, at, refuse);
  Arrays arrays;
  for (const std::string& name : file.datasets()) {
    if (is_observed(name)) arrays[name] = file.dataset<double>(name, {hdf5::any_extent});
  }
  const StoredBlocks blocks(file, found.grid.precision());
  const std::vector<BlockHead> heads = blocks.heads(refuse);
  if (ranks != nullptr) {
    const JoinedBlocks joined(make_scene(c), c.numerics.cell_size, found.time);
    ranks->instruct(Task::restore, found);
    Message where;
    put(where, std::span<const char>(std::filesystem::absolute(path).string()));
    ranks->share(where);
    ranks->cut(joined, heads);
    found.grid.divide(*ranks);
  }
  FirstError error;
  error.attempt([&] { blocks.restore_own(found.grid, found.next_id, refuse); });
  agree_on_errors(error, found.grid.ranks());
  found.grid.refresh();
  found.grid.ranks().done();

  // Everything is there: from here on nothing is refused.
  state = std::move(found);
  progress = at;
  observed = std::move(arrays);
}

void read_own_blocks(const Case& c, const Scene& scene, State& state, BlockExchange& ranks) {
  Message where;
  ranks.share(where);
  const std::filesystem::path path = MessageReader(where).text();
  ranks.cut(JoinedBlocks(scene, c.numerics.cell_size, state.time), {});
  Grid grid(c.numerics.cell_size, c.numerics.precision);
  grid.divide(ranks);
  FirstError error;
  error.attempt([&] {
    const hdf5::Reader file(path, hdf5::Seal::known_good);
    StoredBlocks(file, grid.precision()).restore_own(grid, state.next_id, refusing(path));
  });
  if (!agree_on_errors(error, ranks)) return;
  grid.refresh();
  state.grid = std::move(grid);
}

bool has_checkpoint(const std::filesystem::path& directory) {
  return std::filesystem::exists(directory / checkpoint_file) || std::filesystem::exists(directory / previous_checkpoint_file);
}

std::string resume_from_checkpoint(const std::filesystem::path& directory, const Case& c, State& state, RunProgress& progress,
                                   const AcceptCheckpoint& acceptable, BlockExchange* ranks) {
  std::vector<std::string> reasons;
  bool other_case = false;
  for (const char* name : {checkpoint_file, previous_checkpoint_file}) {
    try {
      State found(c.numerics.cell_size, c.numerics.precision);
      RunProgress at;
      Arrays observed;
      read_checkpoint(directory / name, c, found, at, observed, ranks);
      acceptable(found, at, observed);
      state = std::move(found);
      progress = at;
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
      rename_file(directory / checkpoint_file, directory / refused_checkpoint_file);
      kept = fmt::format(" (kept as {})", refused_checkpoint_file);
    }
    return fmt::format("{}{}; going on from {}", reasons.front(), kept, previous_checkpoint_file);
  }
  if (other_case) throw ConfigError(reasons.front());
  throw IoError(fmt::format("there is no checkpoint to go on from: {}; start from the beginning with --force instead of --resume",
                            fmt::join(reasons, "; and ")));
}

}  // namespace mpm
