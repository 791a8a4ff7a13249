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

/// Lines 1 and 2 of eight particles by component: c0..c7 and c8 xx yy zz xy xz yz internal.
struct Gathered {
  Lanes c[8], s[8];
};

/// @param used how many of the eight are particles: the others count as at rest and free of stress. Slots behind the last particle are
/// allocated.
inline __attribute__((always_inline)) void gather(Particle* p, int used, double initial_internal, Gathered& g) {
#pragma GCC unroll 8
  for (int i = 0; i < lane_count; ++i) {
    g.c[i] = *line(p[i], 1);
    g.s[i] = *line(p[i], 2);
  }
  transpose(g.c);
  transpose(g.s);
  if (used >= lane_count) return;
  constexpr Lanes number = {0, 1, 2, 3, 4, 5, 6, 7};
  const LaneMask live = number < static_cast<double>(used);
  for (Lanes& v : g.c) v = live ? v : Lanes{};
  for (int i = 0; i < 7; ++i) g.s[i] = live ? g.s[i] : Lanes{};
  g.s[7] = live ? g.s[7] : Lanes{} + initial_internal;
}

template <Material Law>
bool update_stress_of(ParticleBin& bin, const Law& law, double dt) {
  constexpr int group = lanes_of<LanePair>;
  static_assert(page_particles % group == 0, "a page holds whole groups");
  Lanes sticky{};
  const int count = bin.count();
  for (int first = 0; first < count; first += group) {
    Particle* const p = &bin[first];
    Gathered a, b;
    gather(p, count - first, law.initial_internal(), a);
    gather(p + lane_count, count - first - lane_count, law.initial_internal(), b);
    const auto pair = [](const Lanes& x, const Lanes& y) { return LanePair{x, y}; };
    const auto dl_of = [&](const Lanes& x, const Lanes& y) { return LanePair{dt * x, dt * y}; };
    const Matrix3<LanePair> dl{{{dl_of(a.c[0], b.c[0]), dl_of(a.c[3], b.c[3]), dl_of(a.c[6], b.c[6])},
                                {dl_of(a.c[1], b.c[1]), dl_of(a.c[4], b.c[4]), dl_of(a.c[7], b.c[7])},
                                {dl_of(a.c[2], b.c[2]), dl_of(a.c[5], b.c[5]), dl_of(a.s[0], b.s[0])}}};
    MaterialState<LanePair> state{{pair(a.s[1], b.s[1]), pair(a.s[2], b.s[2]), pair(a.s[3], b.s[3]), pair(a.s[4], b.s[4]),
                                   pair(a.s[5], b.s[5]), pair(a.s[6], b.s[6])},
                                  pair(a.s[7], b.s[7])};
    law.update_stress(state, dl, dt);
    const Sym3<LanePair>& t = state.stress;
    const LanePair* const updated[7] = {&t.xx, &t.yy, &t.zz, &t.xy, &t.xz, &t.yz, &state.internal};
#pragma GCC unroll 7
    for (int i = 0; i < 7; ++i) {
      a.s[i + 1] = updated[i]->a;
      b.s[i + 1] = updated[i]->b;
    }
    // Every law makes a fault in any of its numbers one of its pressure or of its internal variable: one normal component shows both.
    sticky += 0.0 * ((t.xx.a + t.xx.b) + (state.internal.a + state.internal.b));
    transpose(a.s);
    transpose(b.s);
#pragma GCC unroll 8
    for (int i = 0; i < lane_count; ++i) {
      *line(p[i], 2) = a.s[i];
      *line(p[i + lane_count], 2) = b.s[i];
    }
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

double volume_ratio(const AnyMaterial& material, const Particle& p) { return volume_ratio(material, state_of(p)); }

double stored_energy(const AnyMaterial& material, const Particle& p) {
  return std::visit([&](const auto& law) { return p.volume * law.stored_energy(state_of(p)); }, material);
}

}  // namespace mpm
