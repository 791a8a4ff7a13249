#include "libmpm/base/exact_sum.hpp"

#include <bit>
#include <cmath>
#include <limits>

namespace mpm {

namespace {

constexpr int digit_bits = 32;
constexpr int lowest = -256;                                         ///< exponent of the lowest bit
constexpr int limit = lowest + digit_bits * (ExactSum::digits - 2);  ///< of addends; two digits remain for the growth of the sum
constexpr std::uint64_t low_digit = (std::uint64_t{1} << digit_bits) - 1;
constexpr int exponent_bias = 1075, mantissa_bits = 52;  ///< of a double as an integer times a power of two

}  // namespace

void ExactSum::add(double x) {
  if (x == 0.0) return;
  const auto bits = std::bit_cast<std::uint64_t>(x);
  const int field = static_cast<int>(bits >> mantissa_bits & 0x7FFU);
  const int exponent = field - exponent_bias;  // x = mantissa 2^exponent; subnormal numbers are cut off anyway
  std::uint64_t mantissa = (bits & ((std::uint64_t{1} << mantissa_bits) - 1)) | std::uint64_t{1} << mantissa_bits;
  if (exponent + mantissa_bits >= limit) {
    ++parts_[digits];
    return;
  }
  int place = exponent - lowest;  // of the mantissa's lowest bit
  if (place <= -mantissa_bits - 1) return;
  if (place < 0) {
    mantissa >>= -place;
    place = 0;
  }
  const auto digit = static_cast<std::size_t>(place / digit_bits);
  const int shift = place % digit_bits;
  const std::uint64_t low = mantissa << shift, high = shift == 0 ? 0 : mantissa >> (64 - shift);
  const std::uint64_t three[] = {low & low_digit, low >> digit_bits, high};
  const bool negative = bits >> 63 != 0;
  for (std::size_t k = 0; k < 3; ++k) {
    if (negative)
      parts_[digit + k] -= three[k];
    else
      parts_[digit + k] += three[k];
  }
}

double ExactSum::value() const {
  if (parts_[digits] != 0) return std::numeric_limits<double>::quiet_NaN();
  // digits of 0 .. 2^32 - 1 and a sign
  std::array<std::int64_t, digits> d{};
  std::int64_t carry = 0;
  for (std::size_t k = 0; k < digits; ++k) {
    const std::int64_t sum = static_cast<std::int64_t>(parts_[k]) + carry;
    d[k] = sum & static_cast<std::int64_t>(low_digit);
    carry = sum >> digit_bits;
  }
  const bool negative = carry < 0;
  if (negative) {
    std::int64_t borrow = 0;
    for (std::int64_t& digit : d) {
      digit = -digit + borrow;
      borrow = digit < 0 ? -1 : 0;
      if (digit < 0) digit += std::int64_t{1} << digit_bits;
    }
  }
  std::size_t top = digits;
  while (top > 0 && d[top - 1] == 0) --top;
  if (top == 0) return 0.0;
  // the first 64 bits, the last of which is set if any lower bit is set: they round to the same double as all bits
  const auto at = [&](std::size_t below_top) {
    return below_top > top ? std::uint64_t{0} : static_cast<std::uint64_t>(d[top - below_top]);
  };
  const int zeros = std::countl_zero(static_cast<std::uint32_t>(at(1)));
  const std::uint64_t third = at(3) >> (digit_bits - zeros);
  std::uint64_t first = (at(1) << digit_bits | at(2)) << zeros | third;
  bool more = (at(3) & ((std::uint64_t{1} << (digit_bits - zeros)) - 1)) != 0;
  for (std::size_t k = 4; k <= top; ++k) more = more || at(k) != 0;
  if (more) first |= 1;
  const double rounded = std::ldexp(static_cast<double>(first), lowest + digit_bits * (static_cast<int>(top) - 2) - zeros);
  return negative ? -rounded : rounded;
}

}  // namespace mpm
