#pragma once
/// The number types of the kernels: `double`, `Lanes` = eight doubles computed at once, `HalfLanes` = four doubles, and `SingleLanes` = as
/// many floats as a register holds. Two of them side by side are in lane_pair.hpp.
///
/// `Lanes` is a GCC/Clang vector extension: + - * / and comparisons work on it as on a scalar, and the compiler maps it
/// to one AVX-512, two AVX or four SSE2 registers. The functions below exist for all types, so that a template over the
/// number type reads the same for one material point and for many; branches become `select`.

#include <array>
#include <bit>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstring>
#include <type_traits>

#include "libmpm/base/registers.hpp"
#include "libmpm/base/types.hpp"

namespace mpm {

/// One number in all lanes of one register.
template <class V>
concept OneRegister = std::same_as<V, Lanes> || std::same_as<V, HalfLanes> || std::same_as<V, SingleLanes>;
/// Type of the lanes of a V: double or float.
template <OneRegister V>
using ScalarOf = std::conditional_t<std::same_as<V, SingleLanes>, float, double>;

/// {a, b}: lanes 0 to 3 from a, 4 to 7 from b.
inline Lanes join(HalfLanes a, HalfLanes b) {
  if constexpr (whole_registers) {
    return __builtin_shufflevector(a, b, 0, 1, 2, 3, 4, 5, 6, 7);
  } else {
    return from_halves<Lanes>(a, b);
  }
}
/// Lanes 0 to 3, and 4 to 7. A whole register is shuffled: half() would take it, and the array that it is in, through memory.
/// @{
inline HalfLanes lower_half(const Lanes& v) {
  if constexpr (whole_registers) return __builtin_shufflevector(v, v, 0, 1, 2, 3);
  return half(v, 0);
}
inline HalfLanes upper_half(const Lanes& v) {
  if constexpr (whole_registers) return __builtin_shufflevector(v, v, 4, 5, 6, 7);
  return half(v, 1);
}
/// @}

/// Four floats as doubles. Without the intrinsic GCC takes two at a time.
inline HalfLanes widen(SingleQuad a) {
#if defined(__AVX__)
  return reinterpret_cast<HalfLanes>(_mm256_cvtps_pd(reinterpret_cast<__m128>(a)));
#else
  return __builtin_convertvector(a, HalfLanes);
#endif
}
/// Four doubles as floats, likewise.
inline SingleQuad narrow(HalfLanes a) {
#if defined(__AVX__)
  return reinterpret_cast<SingleQuad>(_mm256_cvtpd_ps(reinterpret_cast<__m256d>(a)));
#else
  return __builtin_convertvector(a, SingleQuad);
#endif
}

/// Whether a T computes in single precision.
template <class T>
inline constexpr bool is_single = std::same_as<T, SingleLanes>;
/// A constant that depends on the precision of T, such as a tolerance or the order of a series.
template <class T, class Value>
constexpr Value by_precision(Value in_double, Value in_single) {
  return is_single<T> ? in_single : in_double;
}

namespace detail {
template <class T>
struct MaskOf {
  using type = bool;
};
template <>
struct MaskOf<Lanes> {
  using type = LaneMask;
};
template <>
struct MaskOf<HalfLanes> {
  using type = HalfMask;
};
template <>
struct MaskOf<SingleLanes> {
  using type = SingleLaneMask;
};
}  // namespace detail
/// Result of a comparison of two T.
template <class T>
using Mask = typename detail::MaskOf<T>::type;

/// The same value in every lane.
template <class T>
inline T broadcast(double a) {
  return T{} + a;
}

/// Number of lanes of a T: 1, 4, 8, 16 or 32.
template <class T>
inline constexpr int lanes_of = std::same_as<T, double> ? 1 : static_cast<int>(sizeof(T) / (is_single<T> ? sizeof(float) : sizeof(double)));

/// a where m is true, else b; lane by lane. Both are evaluated.
/// @{
inline double select(bool m, double a, double b) { return m ? a : b; }
template <OneRegister V>
inline V select(const Mask<V>& m, const V& a, const V& b) {
  return by_halves<V>([](auto x, auto y, auto z) { return x ? y : z; }, m, a, b);
}
/// @}
/// Comparisons of registers; the operators do the same.
/// @{
template <OneRegister V>
inline Mask<V> is_less(const V& x, const V& y) {
  return by_halves<Mask<V>>([](auto a, auto b) { return a < b; }, x, y);
}
template <OneRegister V>
inline Mask<V> is_at_most(const V& x, const V& y) {
  return by_halves<Mask<V>>([](auto a, auto b) { return a <= b; }, x, y);
}
/// @}

/// Whether m is true in some lane (any), in every lane (all).
/// @{
inline bool any(bool m) { return m; }
inline bool all(bool m) { return m; }
inline bool any(HalfMask m) {
#if defined(__AVX__)
  return _mm256_testz_si256(reinterpret_cast<__m256i>(m), reinterpret_cast<__m256i>(m)) == 0;
#else
  return (m[0] | m[1] | m[2] | m[3]) != 0;
#endif
}
inline bool all(HalfMask m) { return !any(~m); }
inline bool any(LaneMask m) {
#if defined(__AVX512F__)
  return _mm512_test_epi64_mask(reinterpret_cast<__m512i>(m), reinterpret_cast<__m512i>(m)) != 0;
#else
  return any(HalfMask(half(m, 0) | half(m, 1)));
#endif
}
inline bool all(LaneMask m) {
#if defined(__AVX512F__)
  return _mm512_test_epi64_mask(reinterpret_cast<__m512i>(m), reinterpret_cast<__m512i>(m)) == 0xFF;
#else
  return !any(~m);
#endif
}
inline bool any(SingleLaneMask m) {
#if defined(__AVX512F__)
  return _mm512_test_epi32_mask(reinterpret_cast<__m512i>(m), reinterpret_cast<__m512i>(m)) != 0;
#else
  return any(std::bit_cast<HalfMask>(m));
#endif
}
inline bool all(SingleLaneMask m) {
#if defined(__AVX512F__)
  return _mm512_test_epi32_mask(reinterpret_cast<__m512i>(m), reinterpret_cast<__m512i>(m)) == 0xFFFF;
#else
  return !any(~m);
#endif
}
/// @}
/// The opposite, lane by lane.
/// @{
inline bool mask_not(bool m) { return !m; }
inline LaneMask mask_not(LaneMask m) { return ~m; }
inline HalfMask mask_not(HalfMask m) { return ~m; }
inline SingleLaneMask mask_not(SingleLaneMask m) { return ~m; }
/// @}

/// Lane by lane. Where an operand of max or min is NaN, the result is b.
/// @{
inline double max(double a, double b) { return a > b ? a : b; }
inline double min(double a, double b) { return a < b ? a : b; }
template <OneRegister V>
inline V max(const V& a, const V& b) {
  return by_halves<V>([](auto x, auto y) { return x > y ? x : y; }, a, b);
}
template <OneRegister V>
inline V min(const V& a, const V& b) {
  return by_halves<V>([](auto x, auto y) { return x < y ? x : y; }, a, b);
}
inline double abs(double a) { return std::fabs(a); }
inline Lanes abs(Lanes a) { return std::bit_cast<Lanes>(std::bit_cast<LaneMask>(a) & std::int64_t{0x7FFFFFFFFFFFFFFF}); }
inline HalfLanes abs(HalfLanes a) { return std::bit_cast<HalfLanes>(std::bit_cast<HalfMask>(a) & std::int64_t{0x7FFFFFFFFFFFFFFF}); }
inline SingleLanes abs(SingleLanes a) { return std::bit_cast<SingleLanes>(std::bit_cast<SingleLaneMask>(a) & 0x7FFFFFFF); }
/// @}

/// Square root, lane by lane; NaN for a negative number.
/// @{
inline double sqrt(double a) { return std::sqrt(a); }
inline HalfLanes sqrt(HalfLanes a) {
#if defined(__AVX__)
  return reinterpret_cast<HalfLanes>(_mm256_sqrt_pd(reinterpret_cast<__m256d>(a)));
#else
  for (int i = 0; i < 4; ++i) a[i] = std::sqrt(a[i]);
  return a;
#endif
}
inline Lanes sqrt(Lanes a) {
#if defined(__AVX512F__)
  return reinterpret_cast<Lanes>(_mm512_maskz_sqrt_pd(0xFF, reinterpret_cast<__m512d>(a)));
#else
  return by_halves<Lanes>([](const HalfLanes& v) { return sqrt(v); }, a);
#endif
}
inline SingleLanes sqrt(SingleLanes a) {
#if defined(__AVX512F__)
  return reinterpret_cast<SingleLanes>(_mm512_maskz_sqrt_ps(0xFFFF, reinterpret_cast<__m512>(a)));
#elif defined(__AVX__)
  return reinterpret_cast<SingleLanes>(_mm256_sqrt_ps(reinterpret_cast<__m256>(a)));
#else
  for (int i = 0; i < lanes_of<SingleLanes>; ++i) a[i] = std::sqrt(a[i]);
  return a;
#endif
}
/// @}

/// The nearest integers, ties to even; the smallest integer for a number out of range or NaN.
inline SingleLaneMask nearest_integers(SingleLanes a) {
#if defined(__AVX512F__)
  return reinterpret_cast<SingleLaneMask>(_mm512_maskz_cvtps_epi32(0xFFFF, reinterpret_cast<__m512>(a)));
#elif defined(__AVX__)
  return reinterpret_cast<SingleLaneMask>(_mm256_cvtps_epi32(reinterpret_cast<__m256>(a)));
#else
  __m128 part[2];
  std::memcpy(part, &a, sizeof a);
  const __m128i nearest[2] = {_mm_cvtps_epi32(part[0]), _mm_cvtps_epi32(part[1])};
  return std::bit_cast<SingleLaneMask>(nearest);
#endif
}

/// Four integers as signed bytes, lane 0 lowest; limited to the range of a byte.
inline std::uint32_t saturated_bytes(HalfMask a) {
  const HalfMask low = a < -128 ? HalfMask{} - 128 : a, fits = low > 127 ? HalfMask{} + 127 : low;
  std::uint32_t bytes = 0;
  for (int i = 0; i < 4; ++i) bytes |= (static_cast<std::uint32_t>(fits[i]) & 0xFFU) << (8 * i);
  return bytes;
}
/// Likewise eight.
inline std::uint64_t saturated_bytes(LaneMask a) {
#if defined(__AVX512F__)
  return static_cast<std::uint64_t>(_mm_cvtsi128_si64(_mm512_maskz_cvtsepi64_epi8(0xFF, reinterpret_cast<__m512i>(a))));
#else
  return saturated_bytes(HalfMask(half(a, 0))) | std::uint64_t{saturated_bytes(HalfMask(half(a, 1)))} << 32;
#endif
}
/// The integers of a register as signed bytes: four in each word, lane 0 lowest; limited to the range of a byte.
inline std::array<std::uint32_t, lanes_of<SingleLanes> / 4> saturated_bytes(SingleLaneMask a) {
  std::array<std::uint32_t, lanes_of<SingleLanes> / 4> words{};
#if defined(__AVX512F__)
  const __m128i bytes = _mm512_maskz_cvtsepi32_epi8(0xFFFF, reinterpret_cast<__m512i>(a));
#else
  __m128i part[2];
  std::memcpy(part, &a, sizeof part);
  const __m128i shorts = _mm_packs_epi32(part[0], part[1]), bytes = _mm_packs_epi16(shorts, shorts);
#endif
  std::memcpy(words.data(), &bytes, sizeof words);
  return words;
}

/// The number in lane i; a double is its own only lane.
/// @{
inline double lane(double a, int) { return a; }
inline double lane(Lanes a, int i) { return a[i]; }
/// @}
/// Sets lane i to v.
/// @{
inline void set_lane(double& a, int, double v) { a = v; }
inline void set_lane(Lanes& a, int i, double v) { a[i] = v; }
/// @}

}  // namespace mpm
