#include "libmpm/base/lane_math.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace {

using namespace mpm;

/// Eight doubles, and four: of the same functions.
template <class V>
class Registers : public testing::Test {
 public:
  static constexpr int count = lanes_of<V>;
  static Mask<V> mask_of(int bits) {
    Mask<V> m{};
    for (int i = 0; i < count; ++i) m[i] = (bits >> i) & 1 ? -1 : 0;
    return m;
  }
};
using RegisterTypes = testing::Types<Lanes, HalfLanes>;
TYPED_TEST_SUITE(Registers, RegisterTypes);

TYPED_TEST(Registers, AnyAndAllSeeEveryLane) {
  constexpr int all_bits = (1 << TestFixture::count) - 1;
  for (int bits = 0; bits <= all_bits; ++bits) {
    EXPECT_EQ(any(TestFixture::mask_of(bits)), bits != 0) << bits;
    EXPECT_EQ(all(TestFixture::mask_of(bits)), bits == all_bits) << bits;
    EXPECT_EQ(any(mask_not(TestFixture::mask_of(bits))), bits != all_bits) << bits;
  }
}

TYPED_TEST(Registers, SelectAndCompareLaneByLane) {
  TypeParam x, y;
  for (int i = 0; i < TestFixture::count; ++i) x[i] = i, y[i] = i % 3 == 0 ? i : 3 - i;
  const TypeParam chosen = select(is_less(x, y), x, y), least = min(x, y), most = max(x, y), root = sqrt(x);
  const Mask<TypeParam> at_most = is_at_most(x, y);
  for (int i = 0; i < TestFixture::count; ++i) {
    EXPECT_EQ(chosen[i], x[i] < y[i] ? x[i] : y[i]);
    EXPECT_EQ(least[i], std::min(x[i], y[i]));
    EXPECT_EQ(most[i], std::max(x[i], y[i]));
    EXPECT_EQ(at_most[i] != 0, x[i] <= y[i]);
    EXPECT_EQ(root[i], std::sqrt(x[i]));
  }
}

/// Largest error over magnitudes 1e-300 to `largest` of both signs, in units of the exact value's last place, against long double.
template <class V, class F, class Exact>
double worst_ulp(F f, Exact exact, double largest, double most_negative) {
  double worst = 0.0;
  for (double size = 1e-300; size < largest; size *= size < 1e-20 ? 1e7 : 1.0037) {
    V x;
    for (int i = 0; i < lanes_of<V>; ++i) {
      const double value = size * (1.0 + 0.1 * i) * (i % 2 ? -1.0 : 1.0);
      x[i] = value > most_negative ? value : -value;
    }
    const V y = f(x);
    for (int i = 0; i < lanes_of<V>; ++i) {
      const long double reference = exact(static_cast<long double>(x[i]));
      worst = std::max(worst, static_cast<double>(std::fabs((y[i] - reference) / reference)) / std::numeric_limits<double>::epsilon());
    }
  }
  return worst;
}

// libmvec promises 4 ulp; a subtraction of 1 at the edge of the series (|x| = 0.35) multiplies its error by at most e^0.35/(1 - e^-0.35)
// = 4.8 on the negative side; sinh's by 1.1.
TYPED_TEST(Registers, ExpAgreesWithLongDouble) {
  EXPECT_LE(worst_ulp<TypeParam>([](const TypeParam& x) { return exp(x); }, [](long double x) { return std::exp(x); }, 300.0, -1e9), 4.0);
}
TYPED_TEST(Registers, LogAgreesWithLongDouble) {
  // Away from 1, where the value itself vanishes.
  double worst = 0.0;
  for (double x = 1e-300; x < 1e300; x *= 3.7) {
    if (std::fabs(std::log(x)) < 0.1) continue;
    const TypeParam y = log(broadcast<TypeParam>(x));
    worst = std::max(worst, static_cast<double>(std::fabs(y[3] / std::log(static_cast<long double>(x)) - 1.0L)));
  }
  EXPECT_LE(worst, 4.0 * std::numeric_limits<double>::epsilon());
}
TYPED_TEST(Registers, Expm1KeepsRelativePrecision) {
  EXPECT_LE(worst_ulp<TypeParam>([](const TypeParam& x) { return expm1(x); }, [](long double x) { return std::expm1(x); }, 100.0, -1e9),
            4.0 * 4.8);
}
TYPED_TEST(Registers, Log1pKeepsRelativePrecision) {
  // Beyond the series 1 + x is rounded: half an ulp over log(1 - 0.35) (1 - 0.35), a factor 3.6; and nearer to -1 its conditioning.
  EXPECT_LE(worst_ulp<TypeParam>([](const TypeParam& x) { return log1p(x); }, [](long double x) { return std::log1p(x); }, 100.0, -0.7),
            4.0 + 3.6);
}
TYPED_TEST(Registers, SinhKeepsRelativePrecision) {
  EXPECT_LE(worst_ulp<TypeParam>([](const TypeParam& x) { return sinh(x); }, [](long double x) { return std::sinh(x); }, 300.0, -1e9),
            4.0 * 1.6);
}

TEST(Lanes, ALaneDoesNotDisturbItsNeighbours) {
  // One lane outside a series' radius, or NaN, sends the group down the general path: the others keep their precision.
  Lanes x = broadcast<Lanes>(1e-9);
  x[2] = 3.0, x[5] = std::numeric_limits<double>::quiet_NaN();
  for (const Lanes& y : {expm1(x), log1p(x), sinh(x)}) {
    EXPECT_NEAR(y[0], 1e-9, 1e-18);  // second-order term
    EXPECT_TRUE(std::isnan(y[5]));
  }
  EXPECT_NEAR(sinh(x)[2], std::sinh(3.0), 4e-15 * std::sinh(3.0));
}

TEST(Lanes, SaturatedBytesKeepWhatFitsAndClampTheRest) {
  const LaneMask x = {0, 3, -4, -1, 127, 128, -129, std::numeric_limits<std::int64_t>::min()};
  const std::int8_t expected[8] = {0, 3, -4, -1, 127, 127, -128, -128};
  const std::uint64_t bytes = saturated_bytes(x);
  for (int i = 0; i < 8; ++i) EXPECT_EQ(static_cast<std::int8_t>(bytes >> (8 * i) & 0xFFU), expected[i]) << i;
}

TEST(HalfLanes, SaturatedBytesKeepWhatFitsAndClampTheRest) {
  const auto byte = [](std::uint32_t bytes, int i) { return static_cast<int>(static_cast<std::int8_t>(bytes >> (8 * i) & 0xFFU)); };
  const std::uint32_t inside = saturated_bytes(HalfMask{0, 3, -4, 127}),
                      outside = saturated_bytes(HalfMask{128, -129, std::numeric_limits<std::int64_t>::min(), -1});
  const int kept[4] = {0, 3, -4, 127}, clamped[4] = {127, -128, -128, -1};
  for (int i = 0; i < 4; ++i) {
    EXPECT_EQ(byte(inside, i), kept[i]) << i;
    EXPECT_EQ(byte(outside, i), clamped[i]) << i;
  }
}

TEST(Lanes, AbsoluteValueOfEveryKind) {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const Lanes y = abs(Lanes{-1.5, 1.5, -0.0, 0.0, -infinity, infinity, -5e-324, std::numeric_limits<double>::quiet_NaN()});
  const double expected[7] = {1.5, 1.5, 0.0, 0.0, infinity, infinity, 5e-324};
  for (int i = 0; i < 7; ++i) EXPECT_EQ(y[i], expected[i]) << i;
  EXPECT_FALSE(std::signbit(y[2]));
  EXPECT_TRUE(std::isnan(y[7]));
  const HalfLanes half = abs(HalfLanes{-1.5, -0.0, -infinity, 5e-324});
  const double expected_half[4] = {1.5, 0.0, infinity, 5e-324};
  for (int i = 0; i < 4; ++i) EXPECT_EQ(half[i], expected_half[i]) << i;
  EXPECT_FALSE(std::signbit(half[1]));
}

}  // namespace
