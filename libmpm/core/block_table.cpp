#include "libmpm/core/block_table.hpp"

#include <algorithm>
#include <numeric>

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
  const std::size_t block_bytes = blocks_.size() * sizeof(Index3), number_bytes = numbers_.size() * sizeof(double);
  std::vector<std::byte> mine(block_bytes + number_bytes);
  if (!blocks_.empty()) {
    std::memcpy(mine.data(), blocks_.data(), block_bytes);
    std::memcpy(mine.data() + block_bytes, numbers_.data(), number_bytes);
  }
  const auto all = ranks.gather(std::move(mine));
  std::vector<Index3> blocks;
  std::vector<double> numbers;
  for (const auto& bytes : all) {
    const std::size_t rows = bytes.size() / (sizeof(Index3) + width_ * sizeof(double)), before = blocks.size();
    if (rows == 0) continue;
    blocks.resize(before + rows);
    numbers.resize((before + rows) * width_);
    std::memcpy(blocks.data() + before, bytes.data(), rows * sizeof(Index3));
    std::memcpy(numbers.data() + before * width_, bytes.data() + rows * sizeof(Index3), rows * width_ * sizeof(double));
  }
  std::vector<std::size_t> order(blocks.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return comes_before(blocks[a], blocks[b]); });
  blocks_.clear();
  numbers_.clear();
  for (const std::size_t i : order) add(blocks[i], std::span<const double>(numbers).subspan(i * width_, width_));
}

}  // namespace mpm
