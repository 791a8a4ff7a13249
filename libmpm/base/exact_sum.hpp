#pragma once
/// Sums of doubles that do not depend on the order of the addends.

#include <array>
#include <cstdint>
#include <span>

namespace mpm {

/// A fixed-point number that is wide enough to hold a sum without rounding: integer digits of 32 bits, from 2^-256 to 2^256 (Kulisch's
/// accumulator, for part of the range of doubles). Any order and any grouping of the addends gives the same bits, so sums of several
/// processes can be added digit by digit.
///
/// An addend's bits below 2^-256 are cut off, which does not depend on the order either; one of 2^192 or more, or that is not finite, makes
/// the value NaN. Up to 2^30 addends.
class ExactSum {
 public:
  static constexpr int digits = 16;         ///< of the number
  static constexpr int words = digits + 1;  ///< the digits, and the number of addends out of range

  /// Adds a number.
  void add(double x);
  /// The sum, rounded once, to nearest.
  [[nodiscard]] double value() const;
  /// The digits as two's complement, the lowest first, and the number of addends out of range. The words of two sums, added one by one, are
  /// those of the sum of both.
  [[nodiscard]] std::span<std::uint64_t, words> parts() { return parts_; }

 private:
  std::array<std::uint64_t, words> parts_{};
};

}  // namespace mpm
