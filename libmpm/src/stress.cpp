#include "mpm/stress.hpp"

#include "mpm/lanes.hpp"

namespace mpm {

namespace {

/// Transposes eight rows of eight: row r of the result holds element r of every input row.
inline __attribute__((always_inline)) void transpose(Lanes (&r)[8]) {
  Lanes a[8];
#pragma GCC unroll 4
  for (int i = 0; i < 4; ++i) {  // pairs of rows: interleave single elements
    a[2 * i] = __builtin_shufflevector(r[2 * i], r[2 * i + 1], 0, 8, 2, 10, 4, 12, 6, 14);
    a[2 * i + 1] = __builtin_shufflevector(r[2 * i], r[2 * i + 1], 1, 9, 3, 11, 5, 13, 7, 15);
  }
#pragma GCC unroll 2
  for (int h = 0; h < 2; ++h) {  // interleave pairs of elements
#pragma GCC unroll 2
    for (int i = 0; i < 2; ++i) {
      r[4 * h + i] = __builtin_shufflevector(a[4 * h + i], a[4 * h + i + 2], 0, 1, 8, 9, 4, 5, 12, 13);
      r[4 * h + i + 2] = __builtin_shufflevector(a[4 * h + i], a[4 * h + i + 2], 2, 3, 10, 11, 6, 7, 14, 15);
    }
  }
#pragma GCC unroll 4
  for (int i = 0; i < 4; ++i) {  // interleave halves
    a[i] = __builtin_shufflevector(r[i], r[i + 4], 0, 1, 2, 3, 8, 9, 10, 11);
    a[i + 4] = __builtin_shufflevector(r[i], r[i + 4], 4, 5, 6, 7, 12, 13, 14, 15);
  }
  for (int i = 0; i < 8; ++i) r[i] = a[i];
}

inline Lanes* line(Particle& p, int n) { return reinterpret_cast<Lanes*>(&p) + n; }

template <Material Law>
bool update_stress_of(ParticleBin& bin, const Law& law, double dt) {
  Lanes sticky{};
  const int count = bin.count();
  for (int first = 0; first < count; first += lane_count) {
    // a page holds whole groups; slots behind the last particle are allocated and finite, and are masked below
    Particle* const p = &bin[first];
    const int used = count - first < lane_count ? count - first : lane_count;
    Lanes c[8], s[8];  // c0..c7 | c8 xx yy zz xy xz yz internal
    for (int i = 0; i < lane_count; ++i) {
      c[i] = *line(p[i], 1);
      s[i] = *line(p[i], 2);
    }
    transpose(c);
    transpose(s);
    if (used < lane_count) {
      constexpr Lanes number = {0, 1, 2, 3, 4, 5, 6, 7};
      const LaneMask live = number < static_cast<double>(used);
      for (Lanes& v : c) v = live ? v : Lanes{};
      for (int i = 0; i < 7; ++i) s[i] = live ? s[i] : Lanes{};
      s[7] = live ? s[7] : Lanes{} + law.initial_internal();
    }
    const Matrix3<Lanes> dl{{{dt * c[0], dt * c[3], dt * c[6]}, {dt * c[1], dt * c[4], dt * c[7]}, {dt * c[2], dt * c[5], dt * s[0]}}};
    MaterialState<Lanes> state{{s[1], s[2], s[3], s[4], s[5], s[6]}, s[7]};
    law.update_stress(state, dl, dt);
    s[1] = state.stress.xx;
    s[2] = state.stress.yy;
    s[3] = state.stress.zz;
    s[4] = state.stress.xy;
    s[5] = state.stress.xz;
    s[6] = state.stress.yz;
    s[7] = state.internal;
    sticky += 0.0 * (trace(state.stress) + state.stress.xy + state.stress.xz + state.stress.yz + state.internal);
    transpose(s);
    for (int i = 0; i < lane_count; ++i) *line(p[i], 2) = s[i];
  }
  bool finite = true;
  for (int i = 0; i < lane_count; ++i) finite = finite && sticky[i] == 0.0;
  return finite;
}

MaterialState<double> state_of(const Particle& p) {
  return {{p.stress[0], p.stress[1], p.stress[2], p.stress[3], p.stress[4], p.stress[5]}, p.internal};
}

}  // namespace

bool update_stress(Grid& grid, std::int32_t block, const AnyMaterial& material, double dt) {
  return std::visit([&](const auto& law) { return update_stress_of(grid.block(block).particles, law, dt); }, material);
}

double volume_ratio(const AnyMaterial& material, const Particle& p) {
  return std::visit([&](const auto& law) { return law.volume_ratio(state_of(p)); }, material);
}

double stored_energy(const AnyMaterial& material, const Particle& p) {
  return std::visit([&](const auto& law) { return p.volume * law.stored_energy(state_of(p)); }, material);
}

}  // namespace mpm
