#include "libmpm/base/lane_pair.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <concepts>
#include <limits>

namespace {

using namespace mpm;

/// Eight doubles, four, and a register of floats: of the same functions.
template <class V>
class Registers : public testing::Test {
 public:
  using Scalar = ScalarOf<V>;
  static constexpr int count = lanes_of<V>;
  /// Magnitudes that the numbers hold; 1.7 times the largest exponent is one whose exp they hold.
  static constexpr double smallest = std::same_as<Scalar, float> ? 1e-35 : 1e-300, largest = 1.0 / smallest,
                          largest_exponent = std::same_as<Scalar, float> ? 48.0 : 300.0;
  static Mask<V> mask_of(int bits) {
    Mask<V> m{};
    for (int i = 0; i < count; ++i) m[i] = (bits >> i) & 1 ? -1 : 0;
    return m;
  }
};
using RegisterTypes = testing::Types<Lanes, HalfLanes, SingleLanes>;
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
  for (int i = 0; i < TestFixture::count; ++i) {
    x[i] = static_cast<ScalarOf<TypeParam>>(i);
    y[i] = i % 3 == 0 ? x[i] : 3 - x[i];
  }
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

/// Largest error over magnitudes `smallest` to `largest` of both signs, in units of the exact value's last place, against long double.
template <class V, class F, class Exact>
double worst_ulp(F f, Exact exact, double largest, double most_negative) {
  double worst = 0.0;
  for (double size = Registers<V>::smallest; size < largest; size *= size < 1e-20 ? 1e7 : 1.0037) {
    V x;
    for (int i = 0; i < lanes_of<V>; ++i) {
      const double value = size * (1.0 + 0.1 * (i % 8)) * (i % 2 ? -1.0 : 1.0);
      x[i] = static_cast<ScalarOf<V>>(value > most_negative ? value : -value);
    }
    const V y = f(x);
    for (int i = 0; i < lanes_of<V>; ++i) {
      const long double reference = exact(static_cast<long double>(x[i]));
      worst = std::max(worst, static_cast<double>(std::fabs((y[i] - reference) / reference)) / std::numeric_limits<ScalarOf<V>>::epsilon());
    }
  }
  return worst;
}

// libmvec promises 4 ulp; a subtraction of 1 at the edge of the series (|x| = 0.35) multiplies its error by at most e^0.35/(1 - e^-0.35)
// = 4.8 on the negative side; sinh's by 1.1.
TYPED_TEST(Registers, ExpAgreesWithLongDouble) {
  EXPECT_LE(worst_ulp<TypeParam>([](const TypeParam& x) { return exp(x); }, [](long double x) { return std::exp(x); },
                                 TestFixture::largest_exponent, -1e9),
            4.0);
}
TYPED_TEST(Registers, LogAgreesWithLongDouble) {
  // Away from 1, where the value itself vanishes.
  double worst = 0.0;
  for (double size = TestFixture::smallest; size < TestFixture::largest; size *= 3.7) {
    const auto x = static_cast<ScalarOf<TypeParam>>(size);
    if (std::fabs(std::log(x)) < 0.1) continue;
    const TypeParam y = log(TypeParam{} + x);
    worst = std::max(worst, static_cast<double>(std::fabs(y[3] / std::log(static_cast<long double>(x)) - 1.0L)));
  }
  EXPECT_LE(worst, 4.0 * std::numeric_limits<ScalarOf<TypeParam>>::epsilon());
}
TYPED_TEST(Registers, Expm1KeepsRelativePrecision) {
  EXPECT_LE(worst_ulp<TypeParam>([](const TypeParam& x) { return expm1(x); }, [](long double x) { return std::expm1(x); },
                                 std::min(100.0, TestFixture::largest_exponent), -1e9),
            4.0 * 4.8);
}
TYPED_TEST(Registers, Log1pKeepsRelativePrecision) {
  // Beyond the series 1 + x is rounded: half an ulp over log(1 - 0.35) (1 - 0.35), a factor 3.6; and nearer to -1 its conditioning.
  EXPECT_LE(worst_ulp<TypeParam>([](const TypeParam& x) { return log1p(x); }, [](long double x) { return std::log1p(x); }, 100.0, -0.7),
            4.0 + 3.6);
}
TYPED_TEST(Registers, SinhKeepsRelativePrecision) {
  EXPECT_LE(worst_ulp<TypeParam>([](const TypeParam& x) { return sinh(x); }, [](long double x) { return std::sinh(x); },
                                 TestFixture::largest_exponent, -1e9),
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

TEST(SingleLanes, SaturatedBytesKeepWhatFitsAndClampTheRest) {
  const int value[8] = {0, 3, -4, 127, 128, -129, std::numeric_limits<int>::min(), -1};
  const int expected[8] = {0, 3, -4, 127, 127, -128, -128, -1};
  SingleLaneMask x;
  for (int i = 0; i < lanes_of<SingleLanes>; ++i) x[i] = value[i % 8];
  const auto words = saturated_bytes(x);
  for (int i = 0; i < lanes_of<SingleLanes>; ++i) {
    const std::uint32_t byte = words[static_cast<std::size_t>(i / 4)] >> (8 * (i % 4)) & 0xFFU;
    EXPECT_EQ(static_cast<int>(static_cast<std::int8_t>(byte)), expected[i % 8]) << i;
  }
}

TEST(SingleLanes, NearestIntegersWithTiesToEven) {
  constexpr int none = std::numeric_limits<int>::min();
  const float value[8] = {0.5F, 1.5F, -2.5F, -0.49F, 3e9F, std::numeric_limits<float>::quiet_NaN(), 1e7F, -7.0F};
  const int expected[8] = {0, 2, -2, 0, none, none, 10000000, -7};
  SingleLanes x;
  for (int i = 0; i < lanes_of<SingleLanes>; ++i) x[i] = value[i % 8];
  const SingleLaneMask nearest = nearest_integers(x);
  for (int i = 0; i < lanes_of<SingleLanes>; ++i) EXPECT_EQ(nearest[i], expected[i % 8]) << i;
}

TEST(SingleLanes, WidenedAndNarrowedKeepEveryLane) {
  SingleLanes x;
  for (int i = 0; i < lanes_of<SingleLanes>; ++i) x[i] = 0.1F * static_cast<float>(i + 1);
  const WidePair wide = widen(x);
  for (int i = 0; i < lanes_of<SingleLanes>; ++i) EXPECT_EQ(lane(wide, i), double{x[i]}) << i;
  const SingleLanes rounded = narrow(wide + 1e-12);  // far below half a unit
  for (int i = 0; i < lanes_of<SingleLanes>; ++i) EXPECT_EQ(rounded[i], x[i]) << i;
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
  SingleLanes single{};
  single[0] = -1.5F, single[1] = -0.0F, single[2] = -std::numeric_limits<float>::infinity(), single[3] = -1e-45F;
  single = abs(single);
  const float expected_single[4] = {1.5F, 0.0F, std::numeric_limits<float>::infinity(), 1e-45F};
  for (int i = 0; i < 4; ++i) EXPECT_EQ(single[i], expected_single[i]) << i;
  EXPECT_FALSE(std::signbit(single[1]));
}

}  // namespace
