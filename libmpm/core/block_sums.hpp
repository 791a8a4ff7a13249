#pragma once
/// Sums over the blocks of all ranks.

#include <bit>
#include <cstring>
#include <iterator>
#include <vector>

#include "libmpm/base/exact_sum.hpp"
#include "libmpm/core/ranks.hpp"

namespace mpm {

/// Several sums at once, exact (base/exact_sum.hpp): the order of the additions does not matter, so any number of threads and ranks gives
/// the same bits.
class BlockSums {
 public:
  /// @param count  number of sums
  explicit BlockSums(std::size_t count) : sums_(count) {}

  /// Adds to sum number `at`.
  void add(std::size_t at, double number) { sums_[at].add(number); }
  /// Adds a struct of 64-bit integers followed by doubles, each member to a sum of its own. @tparam integers  number of integers
  template <std::size_t integers = 0, class T>
  void add_members(std::size_t at, const T& values) {
    static_assert(sizeof(T) % sizeof(double) == 0);
    double numbers[sizeof(T) / sizeof(double)];
    std::memcpy(numbers, static_cast<const void*>(&values), sizeof(T));
    for (std::size_t i = 0; i < std::size(numbers); ++i)
      add(at + i, i < integers ? static_cast<double>(std::bit_cast<std::uint64_t>(numbers[i])) : numbers[i]);
  }

  /// Adds the sums of the other ranks; all ranks call it.
  void add_ranks(RankGroup& ranks) {
    std::vector<std::uint64_t> all;
    for (ExactSum& sum : sums_) all.insert(all.end(), sum.parts().begin(), sum.parts().end());
    ranks.sum(all);
    auto words = all.cbegin();
    for (ExactSum& sum : sums_) {
      for (std::uint64_t& word : sum.parts()) word = *words++;
    }
  }

  [[nodiscard]] double value(std::size_t at) const { return sums_[at].value(); }  ///< sum number `at`
  /// The sums of such a struct. @tparam integers  number of integers
  template <class T, std::size_t integers = 0>
  [[nodiscard]] T members(std::size_t at) const {
    double numbers[sizeof(T) / sizeof(double)];
    for (std::size_t i = 0; i < std::size(numbers); ++i) {
      const double sum = value(at + i);
      numbers[i] = i < integers ? std::bit_cast<double>(static_cast<std::uint64_t>(sum)) : sum;
    }
    T whole;
    std::memcpy(static_cast<void*>(&whole), numbers, sizeof(T));
    return whole;
  }

 private:
  std::vector<ExactSum> sums_;
};

}  // namespace mpm
