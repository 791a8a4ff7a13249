#pragma once
/// Contributions of single blocks, collected on the first rank; for sums over all blocks see block_sums.hpp.

#include <cstring>
#include <span>
#include <vector>

#include "libmpm/base/types.hpp"
#include "libmpm/core/ranks.hpp"

namespace mpm {

/// Rows of numbers, one or more for a block.
class BlockTable {
 public:
  /// @param width  numbers of a row
  explicit BlockTable(std::size_t width) : width_(width) {}
  /// A table of structs. @tparam T  a struct of double and 64-bit integers
  template <class T>
  static BlockTable of() {
    static_assert(sizeof(T) % sizeof(double) == 0);
    return BlockTable(sizeof(T) / sizeof(double));
  }

  [[nodiscard]] std::size_t size() const { return blocks_.size(); }                                                           ///< rows
  [[nodiscard]] const Index3& block(std::size_t i) const { return blocks_[i]; }                                               ///< of row i
  [[nodiscard]] std::span<const double> row(std::size_t i) const { return std::span(numbers_).subspan(i * width_, width_); }  ///< row i
  /// Row i of a table of T.
  template <class T>
  [[nodiscard]] T get(std::size_t i) const {
    T part;
    std::memcpy(static_cast<void*>(&part), numbers_.data() + i * width_, sizeof(T));
    return part;
  }

  /// A new row. @param row  as many numbers as the table is wide
  void add(const Index3& block, std::span<const double> row);
  /// A new row of a table of T.
  template <class T>
  void add_part(const Index3& block, const T& part) {
    double row[sizeof(T) / sizeof(double)];
    std::memcpy(row, static_cast<const void*>(&part), sizeof(T));
    add(block, row);
  }
  /// Adds a row unless all its bits are zero, which would change no sum.
  void add_unless_zero(const Index3& block, std::span<const double> row);

  /// Collects the rows of all ranks on the first, in the order of the blocks; the tables of the others become empty.
  void gather(Ranks& ranks);

 private:
  std::size_t width_;
  std::vector<Index3> blocks_;
  std::vector<double> numbers_;
};

}  // namespace mpm
