#pragma once
/// 3x3 tensors over the number types of lanes.hpp: only what the laws need.

#include "mpm/lanes.hpp"

namespace mpm {

/// General 3x3 matrix, m[row][column].
template <LaneNumber T>
struct Matrix3 {
  T m[3][3];
};

/// Symmetric 3x3 tensor.
template <LaneNumber T>
struct Sym3 {
  T xx, yy, zz, xy, xz, yz;
};

template <LaneNumber T>
inline Sym3<T> operator+(const Sym3<T>& a, const Sym3<T>& b) {
  return {a.xx + b.xx, a.yy + b.yy, a.zz + b.zz, a.xy + b.xy, a.xz + b.xz, a.yz + b.yz};
}
template <LaneNumber T>
inline Sym3<T> operator-(const Sym3<T>& a, const Sym3<T>& b) {
  return {a.xx - b.xx, a.yy - b.yy, a.zz - b.zz, a.xy - b.xy, a.xz - b.xz, a.yz - b.yz};
}
template <LaneNumber T>
inline Sym3<T> operator*(T s, const Sym3<T>& a) {
  return {s * a.xx, s * a.yy, s * a.zz, s * a.xy, s * a.xz, s * a.yz};
}
template <LaneNumber T>
inline T trace(const Sym3<T>& a) {
  return a.xx + a.yy + a.zz;
}
/// a : a
template <LaneNumber T>
inline T norm2(const Sym3<T>& a) {
  return a.xx * a.xx + a.yy * a.yy + a.zz * a.zz + 2.0 * (a.xy * a.xy + a.xz * a.xz + a.yz * a.yz);
}
template <LaneNumber T>
inline Sym3<T> deviator(const Sym3<T>& a) {
  const T mean = trace(a) * (1.0 / 3.0);
  return {a.xx - mean, a.yy - mean, a.zz - mean, a.xy, a.xz, a.yz};
}
template <LaneNumber T>
inline T determinant(const Sym3<T>& a) {
  return a.xx * (a.yy * a.zz - a.yz * a.yz) - a.xy * (a.xy * a.zz - a.xz * a.yz) + a.xz * (a.xy * a.yz - a.xz * a.yy);
}

}  // namespace mpm
