#include "libmpm/core/block_table.hpp"

#include <algorithm>
#include <numeric>

#include "libmpm/core/grid.hpp"

namespace mpm {

void BlockTable::add(const Index3& block, std::span<const double> row) {
  blocks_.push_back(block);
  numbers_.insert(numbers_.end(), row.begin(), row.end());
}

void BlockTable::add_unless_zero(const Index3& block, std::span<const double> row) {
  const auto all_bits_zero = [](double v) {
    std::uint64_t bits = 0;
    std::memcpy(&bits, &v, sizeof bits);
    return bits == 0;
  };
  if (!std::ranges::all_of(row, all_bits_zero)) add(block, row);
}

void BlockTable::gather(Ranks& ranks) {
  Message mine;
  put(mine, std::span<const Index3>(blocks_));
  put(mine, std::span<const double>(numbers_));
  std::vector<Index3> blocks;
  std::vector<double> numbers;
  for (const Message& message : ranks.gather(std::move(mine))) {
    const std::size_t rows = message.size() / (sizeof(Index3) + width_ * sizeof(double)), before = blocks.size();
    blocks.resize(before + rows);
    numbers.resize((before + rows) * width_);
    MessageReader reader(message);
    reader.get(std::span(blocks).subspan(before));
    reader.get(std::span(numbers).subspan(before * width_));
  }
  std::vector<std::size_t> order(blocks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return comes_before(blocks[a], blocks[b]); });
  blocks_.clear();
  numbers_.clear();
  for (const std::size_t i : order) add(blocks[i], std::span<const double>(numbers).subspan(i * width_, width_));
}

}  // namespace mpm
