#include "libmpm/driver/checkpoint_blocks.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <optional>
#include <tuple>
#include <utility>

#include "libmpm/driver/pieces.hpp"
#include "libmpm/io/joint_file.hpp"
#include "libmpm/parallel/block_exchange.hpp"

namespace mpm {

namespace {

constexpr std::int32_t most_particles_of_a_block = 65000;  // slots are 16 bits wide
constexpr const char* contradiction = "its block counts contradict its particles";

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

bool all_finite(const Particle& p) {
  const auto finite = [](const auto& numbers) { return std::ranges::all_of(numbers, [](double x) { return std::isfinite(x); }); };
  return finite(p.position) && finite(p.velocity) && finite(p.affine) && finite(p.stress) && std::isfinite(p.internal);
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
  const auto key = [](const Index3& c) { return std::tuple(c[2], c[1], c[0]); };
  const bool far = std::ranges::any_of(block, [](std::int32_t c) { return c > reach || c < -reach; });
  if (far || (before && key(block) <= key(*before)))
    refuse(fmt::format("block ({}, {}, {}) is out of reach or out of order", block[0], block[1], block[2]));
}

std::size_t particles_in(const hdf5::Reader& file) {
  const hdf5::Shape shape = file.shape("cells");
  return shape.empty() ? 0 : shape.front();
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

}  // namespace

StoredBlocks::StoredBlocks(const hdf5::Reader& file, Precision precision)
    : file_(file),
      precision_(precision),
      counts_(file.dataset<std::int32_t>("block_counts", {hdf5::any_extent})),
      coordinates_(file.dataset<std::int32_t>("block_coordinates", {counts_.size(), 3})),
      velocities_(precision == Precision::single_precision ? file.dataset<double>("block_velocities", {counts_.size(), 3})
                                                           : std::vector<double>(3 * counts_.size(), 0.0)),
      particles_(particles_in(file)) {}

std::vector<BlockHead> StoredBlocks::heads(const Refuse& refuse) const {
  std::vector<BlockHead> heads;
  std::size_t particles = 0;
  for (std::size_t b = 0; b < counts_.size(); ++b) {
    if (counts_[b] < 0 || counts_[b] > most_particles_of_a_block) refuse(contradiction);
    particles += size_of(b);
    heads.push_back({coordinate_of(b), counts_[b]});
    check_block(heads.back().block, b == 0 ? std::nullopt : std::optional(heads[b - 1].block), refuse);
  }
  if (particles != particles_) refuse(contradiction);
  return heads;
}

void StoredBlocks::restore_own(Grid& grid, std::uint64_t next_id, const Refuse& refuse) const {
  const auto own = [&](std::size_t b) { return grid.ranks().owns(coordinate_of(b)); };
  std::vector<std::uint64_t> ids;
  std::size_t first = 0;  // particle
  for (std::size_t b = 0; b < counts_.size();) {
    if (!own(b)) {
      first += size_of(b++);
      continue;
    }
    std::size_t end = b, count = 0;
    for (; end < counts_.size() && own(end) && (count == 0 || count + size_of(end) <= PieceSize{}.particles); ++end) count += size_of(end);
    restore_piece(b, end, first, count, grid, next_id, ids, refuse);
    first += count;
    b = end;
  }
  std::ranges::sort(ids);
  if (const auto twice = std::ranges::adjacent_find(ids); twice != ids.end()) refuse(fmt::format("particle {} is there twice", *twice));
}

Index3 StoredBlocks::coordinate_of(std::size_t b) const { return {coordinates_[3 * b], coordinates_[3 * b + 1], coordinates_[3 * b + 2]}; }

void StoredBlocks::restore_piece(std::size_t b, std::size_t end, std::size_t first, std::size_t count, Grid& grid, std::uint64_t next_id,
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

}  // namespace mpm
