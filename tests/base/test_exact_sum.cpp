#include "libmpm/base/exact_sum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace mpm {
namespace {

double sum_of(const std::vector<double>& numbers) {
  ExactSum sum;
  for (const double x : numbers) sum.add(x);
  return sum.value();
}

TEST(ExactSum, IsTheSumRoundedOnce) {
  // multiples of 2^-40 below 2^20: a sum of 1000 is a whole number of 70 bits, which long arithmetic holds
  std::mt19937_64 random(1);
  for (int turn = 0; turn < 100; ++turn) {
    std::vector<double> numbers;
    __extension__ __int128 whole = 0;
    for (int i = 0; i < 1000; ++i) {
      const std::int64_t n = static_cast<std::int64_t>(random() >> 11) * (random() % 2 == 0 ? 1 : -1);  // exact as a double
      whole += n;
      numbers.push_back(std::ldexp(static_cast<double>(n), -40));
    }
    EXPECT_EQ(sum_of(numbers), std::ldexp(static_cast<double>(whole), -40));
  }
}

TEST(ExactSum, DoesNotDependOnOrderOrGrouping) {
  std::mt19937_64 random(2);
  std::vector<double> numbers;
  for (int i = 0; i < 300; ++i) {
    const double x = std::ldexp(std::uniform_real_distribution<>(-1.0, 1.0)(random), static_cast<int>(random() % 300) - 150);
    numbers.insert(numbers.end(), {x, i % 3 == 0 ? -x : x});
  }
  const double expected = sum_of(numbers);
  EXPECT_TRUE(std::isfinite(expected));
  for (int turn = 0; turn < 20; ++turn) {
    std::ranges::shuffle(numbers, random);
    EXPECT_EQ(sum_of(numbers), expected);
    const auto cut = numbers.begin() + static_cast<std::ptrdiff_t>(random() % numbers.size());
    ExactSum a, b;
    std::for_each(numbers.begin(), cut, [&](double x) { a.add(x); });
    std::for_each(cut, numbers.end(), [&](double x) { b.add(x); });
    for (std::size_t i = 0; i < ExactSum::words; ++i) a.parts()[i] += b.parts()[i];
    EXPECT_EQ(a.value(), expected);
  }
}

TEST(ExactSum, RoundsToNearestAndTiesToEven) {
  const double large = std::ldexp(1.0, 53);
  EXPECT_EQ(sum_of({large, 1.0}), large);
  EXPECT_EQ(sum_of({large, 1.0, 1e-60}), large + 2.0);
  EXPECT_EQ(sum_of({large, 1.0, -1e-60}), large);
  EXPECT_EQ(sum_of({large, 3.0}), large + 4.0);
  EXPECT_EQ(sum_of({-large, -1.0, -1e-60}), -large - 2.0);
  EXPECT_EQ(sum_of({1e50, 1.0, -1e50}), 1.0);
  EXPECT_EQ(sum_of({1e-60, -1e50, 1e50}), 1e-60);  // its last bit is above 2^-256
}

TEST(ExactSum, KeepsSingleNumbersAndOppositesCancel) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 1000; ++i) {
    const double x = std::ldexp(std::uniform_real_distribution<>(-1.0, 1.0)(random), static_cast<int>(random() % 380) - 190);
    EXPECT_EQ(sum_of({x}), x);
    EXPECT_EQ(sum_of({x, -x}), 0.0);
  }
  EXPECT_EQ(sum_of({}), 0.0);
  EXPECT_EQ(sum_of({0.0, -0.0}), 0.0);
}

TEST(ExactSum, CutsOffBelowItsRangeAndIsNoNumberAboveIt) {
  EXPECT_EQ(sum_of({std::ldexp(1.0, -257)}), 0.0);
  EXPECT_EQ(sum_of({std::numeric_limits<double>::denorm_min(), -1e-300}), 0.0);
  EXPECT_EQ(sum_of({std::ldexp(1.5, -256), std::ldexp(1.5, -256)}), std::ldexp(1.0, -255));  // each to 2^-256
  EXPECT_EQ(sum_of({std::ldexp(1.0, 191)}), std::ldexp(1.0, 191));
  for (const double x : {std::ldexp(1.0, 192), std::numeric_limits<double>::infinity(), std::numeric_limits<double>::quiet_NaN()})
    EXPECT_TRUE(std::isnan(sum_of({1.0, x, -x})));
}

}  // namespace
}  // namespace mpm
