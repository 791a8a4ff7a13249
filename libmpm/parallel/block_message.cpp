#include "libmpm/parallel/block_message.hpp"

namespace mpm {

void put_block(Message& message, const Block& block) {
  const ParticleBin& bin = block.particles;
  put(message, block.coordinate);
  const Vec3& v = bin.frame.velocity;
  put(message, std::array<double, 3>{v.x(), v.y(), v.z()});
  put(message, bin.count());
  put(message, std::span<const std::uint8_t>(bin.cell));
  for (int s = 0; s < bin.count(); ++s) put(message, bin.bytes(s));
}

void get_blocks(const Message& message, Grid& grid) {
  MessageReader reader(message);
  std::vector<std::uint8_t> cells;
  std::vector<std::byte> records;
  while (!reader.at_end()) {
    const auto coordinate = reader.get<Index3>();
    const auto velocity = reader.get<std::array<double, 3>>();
    const auto count = static_cast<std::size_t>(reader.get<int>());
    cells.resize(count);
    records.resize(count * record_bytes(grid.precision()));
    reader.get(std::span(cells));
    reader.get(std::span(records));
    grid.restore({coordinate, Vec3(velocity[0], velocity[1], velocity[2]), cells, records});
  }
}

void collect_blocks(const Grid& from, const std::function<bool(const Block&)>& wanted, Grid& into) {
  RankGroup& ranks = from.ranks();
  std::vector<std::int32_t> blocks;
  std::size_t bytes = 0;  // known at the start: a message that grows takes twice the memory
  for (const auto b : from.occupied_blocks()) {
    if (ranks.first() || !wanted(from.block(b))) continue;
    blocks.push_back(b);
    const auto particles = static_cast<std::size_t>(from.block(b).particles.count());
    bytes += sizeof(Index3) + 3 * sizeof(double) + sizeof(int) + particles * (1 + record_bytes(from.precision()));
  }
  Message mine;
  mine.reserve(bytes);
  for (const auto b : blocks) put_block(mine, from.block(b));
  auto all = ranks.gather(std::move(mine));
  for (Message& message : all) {
    get_blocks(message, into);
    message = {};
  }
  into.refresh();
}

}  // namespace mpm
