#include "libmpm/core/stress_update.hpp"

#include "libmpm/base/lanes.hpp"

namespace mpm {

namespace {

/// Transposes the two 4 x 4 matrices that stand side by side in four registers.
inline __attribute__((always_inline)) void transpose_halves(Lanes* r) {
  const Lanes a0 = __builtin_shufflevector(r[0], r[1], 0, 8, 2, 10, 4, 12, 6, 14),
              a1 = __builtin_shufflevector(r[0], r[1], 1, 9, 3, 11, 5, 13, 7, 15);
  const Lanes a2 = __builtin_shufflevector(r[2], r[3], 0, 8, 2, 10, 4, 12, 6, 14),
              a3 = __builtin_shufflevector(r[2], r[3], 1, 9, 3, 11, 5, 13, 7, 15);
  r[0] = __builtin_shufflevector(a0, a2, 0, 1, 8, 9, 4, 5, 12, 13);
  r[1] = __builtin_shufflevector(a1, a3, 0, 1, 8, 9, 4, 5, 12, 13);
  r[2] = __builtin_shufflevector(a0, a2, 2, 3, 10, 11, 6, 7, 14, 15);
  r[3] = __builtin_shufflevector(a1, a3, 2, 3, 10, 11, 6, 7, 14, 15);
}

inline HalfLanes* half_line(Particle& p, int n, int half) { return reinterpret_cast<HalfLanes*>(&p) + 2 * n + half; }

/// Cache line n of eight particles by component: v[i] holds its i-th number of each. Half lines are put together as they are loaded, and
/// parted as they are stored: that costs no shuffle.
inline __attribute__((always_inline)) void load_line(Particle* p, int n, Lanes (&v)[8]) {
#pragma GCC unroll 2
  for (int half = 0; half < 2; ++half) {
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i) v[4 * half + i] = join(*half_line(p[i], n, half), *half_line(p[i + 4], n, half));
    transpose_halves(v + 4 * half);
  }
}
inline __attribute__((always_inline)) void store_line(Lanes (&v)[8], Particle* p, int n) {
#pragma GCC unroll 2
  for (int half = 0; half < 2; ++half) {
    transpose_halves(v + 4 * half);
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i) {
      *half_line(p[i], n, half) = lower_half(v[4 * half + i]);
      *half_line(p[i + 4], n, half) = upper_half(v[4 * half + i]);
    }
  }
}

/// Lines 1 and 2 of eight particles by component: c0..c7 and c8 xx yy zz xy xz yz internal.
struct Gathered {
  Lanes c[8], s[8];
};

/// @param used how many of the eight are particles: the others count as at rest and free of stress. Slots behind the last particle are
/// allocated.
inline __attribute__((always_inline)) void gather(Particle* p, int used, double initial_internal, Gathered& g) {
  load_line(p, 1, g.c);
  load_line(p, 2, g.s);
  if (used >= lane_count) return;
  constexpr Lanes number = {0, 1, 2, 3, 4, 5, 6, 7};
  const LaneMask live = number < static_cast<double>(used);
  for (Lanes& v : g.c) v = live ? v : Lanes{};
  for (int i = 0; i < 7; ++i) g.s[i] = live ? g.s[i] : Lanes{};
  g.s[7] = live ? g.s[7] : Lanes{} + initial_internal;
}

constexpr int group = lanes_of<LanePair>;  ///< particles at once
static_assert(page_particles % group == 0, "a page holds whole groups");

/// Asks for lines 1 and 2 of a group before its turn.
inline void prefetch_group(const Particle* p) {
#pragma GCC unroll 16
  for (int i = 0; i < group; ++i) {
    __builtin_prefetch(reinterpret_cast<const char*>(p + i) + 64);
    __builtin_prefetch(reinterpret_cast<const char*>(p + i) + 128);
  }
}

template <Material Law>
bool update_stress_of(ParticleBin& bin, const Law& law, double dt) {
  Lanes sticky{};
  const int count = bin.count();
  for (int first = 0; first < count; first += group) {
    Particle* const p = &bin.record<Particle>(first);
    if (first + group < count) prefetch_group(&bin.record<Particle>(first + group));
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
    store_line(a.s, p, 2);
    store_line(b.s, p + lane_count, 2);
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
