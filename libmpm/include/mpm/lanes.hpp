#pragma once
/// The number types of the kernels: `double`, and `Lanes` = eight doubles computed at once.
///
/// `Lanes` is a GCC/Clang vector extension: + - * / and comparisons work on it as on a scalar, and the compiler maps it
/// to one AVX-512, two AVX or four SSE2 registers. The functions below exist for both types, so that a template over the
/// number type reads the same for one material point and for eight; branches become `select`.

#include <cmath>
#include <concepts>
#include <cstdint>
#include <cstring>

#include "mpm/types.hpp"

#if defined(__AVX512F__) || defined(__AVX__) || defined(__SSE2__)
#include <immintrin.h>
#endif

namespace mpm {

using Lanes = double __attribute__((vector_size(64)));
using LaneMask = std::int64_t __attribute__((vector_size(64)));  ///< all bits set where true
using Half = double __attribute__((vector_size(32)));            ///< four lanes: a grid node {p_x, p_y, p_z, m}

template <class T>
concept LaneNumber = std::same_as<T, double> || std::same_as<T, Lanes>;

namespace detail {
template <class T>
struct MaskOf {
  using type = bool;
};
template <>
struct MaskOf<Lanes> {
  using type = LaneMask;
};
}  // namespace detail
template <class T>
using Mask = typename detail::MaskOf<T>::type;

/// The same value in every lane.
template <LaneNumber T>
inline T broadcast(double a) {
  return T{} + a;
}

inline double select(bool m, double a, double b) { return m ? a : b; }
inline Lanes select(LaneMask m, Lanes a, Lanes b) { return m ? a : b; }

inline bool any(bool m) { return m; }
inline bool all(bool m) { return m; }
inline bool any(LaneMask m) {
  std::int64_t r = 0;
  for (int i = 0; i < lane_count; ++i) r |= m[i];
  return r != 0;
}
inline bool all(LaneMask m) {
  std::int64_t r = -1;
  for (int i = 0; i < lane_count; ++i) r &= m[i];
  return r != 0;
}
inline bool mask_not(bool m) { return !m; }
inline LaneMask mask_not(LaneMask m) { return ~m; }

inline double max(double a, double b) { return a > b ? a : b; }
inline double min(double a, double b) { return a < b ? a : b; }
inline Lanes max(Lanes a, Lanes b) { return a > b ? a : b; }
inline Lanes min(Lanes a, Lanes b) { return a < b ? a : b; }
inline double abs(double a) { return std::fabs(a); }
inline Lanes abs(Lanes a) { return a < 0.0 ? -a : a; }

inline double sqrt(double a) { return std::sqrt(a); }
inline Lanes sqrt(Lanes a) {
#if defined(__AVX512F__)
  return reinterpret_cast<Lanes>(_mm512_sqrt_pd(reinterpret_cast<__m512d>(a)));
#else
  Lanes r;
  for (int i = 0; i < lane_count; ++i) r[i] = std::sqrt(a[i]);
  return r;
#endif
}

inline double lane(double a, int) { return a; }
inline double lane(Lanes a, int i) { return a[i]; }
inline void set_lane(double& a, int, double v) { a = v; }
inline void set_lane(Lanes& a, int i, double v) { a[i] = v; }
template <LaneNumber T>
inline constexpr int lanes_of = std::same_as<T, double> ? 1 : lane_count;

}  // namespace mpm
