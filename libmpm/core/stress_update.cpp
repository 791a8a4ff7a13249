#include "libmpm/core/stress_update.hpp"

#include "libmpm/base/lane_pair.hpp"
#include "libmpm/base/registers.hpp"

namespace mpm {

namespace {

/// Transposes the 4 x 4 matrices that four registers of doubles hold: two side by side, or one in short registers.
template <class V>
inline __attribute__((always_inline)) void transpose_halves(V* r) {
  const V a0 = shuffle_halves<0, 4, 2, 6>(r[0], r[1]), a1 = shuffle_halves<1, 5, 3, 7>(r[0], r[1]);
  const V a2 = shuffle_halves<0, 4, 2, 6>(r[2], r[3]), a3 = shuffle_halves<1, 5, 3, 7>(r[2], r[3]);
  r[0] = shuffle_halves<0, 1, 4, 5>(a0, a2);
  r[1] = shuffle_halves<0, 1, 4, 5>(a1, a3);
  r[2] = shuffle_halves<2, 3, 6, 7>(a0, a2);
  r[3] = shuffle_halves<2, 3, 6, 7>(a1, a3);
}

inline HalfLanes* half_line(Particle& p, int n, int half) { return reinterpret_cast<HalfLanes*>(&p) + 2 * n + half; }

/// Half n of a cache line of the particles that share row i of a transposition: i, and i + 4 where a register holds eight. The halves are
/// joined as they are loaded, and separated as they are stored, which needs no shuffle.
template <class V>
inline __attribute__((always_inline)) V load_half_line(Particle* p, int i, int line, int half) {
  if constexpr (std::same_as<V, Lanes>) {
    return join(*half_line(p[i], line, half), *half_line(p[i + 4], line, half));
  } else {
    return *half_line(p[i], line, half);
  }
}
inline __attribute__((always_inline)) void store_half_line(const Lanes& v, Particle* p, int i, int line, int half) {
  *half_line(p[i], line, half) = lower_half(v);
  *half_line(p[i + 4], line, half) = upper_half(v);
}
inline __attribute__((always_inline)) void store_half_line(const HalfLanes& v, Particle* p, int i, int line, int half) {
  *half_line(p[i], line, half) = v;
}

/// A cache line of as many particles as V has lanes, by component: v[i] holds the i-th number of each.
template <class V>
inline __attribute__((always_inline)) void load_line(Particle* p, int line, V (&v)[8]) {
#pragma GCC unroll 2
  for (int half = 0; half < 2; ++half) {
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i) v[4 * half + i] = load_half_line<V>(p, i, line, half);
    transpose_halves(v + 4 * half);
  }
}
template <class V>
inline __attribute__((always_inline)) void store_line(V (&v)[8], Particle* p, int line) {
#pragma GCC unroll 2
  for (int half = 0; half < 2; ++half) {
    transpose_halves(v + 4 * half);
#pragma GCC unroll 4
    for (int i = 0; i < 4; ++i) store_half_line(v[4 * half + i], p, i, line, half);
  }
}

/// {0, 1, 2, ...}
template <class V>
constexpr V lane_numbers = []<int... i>(std::integer_sequence<int, i...>) {
  return V{static_cast<ScalarOf<V>>(i)...};
}
(std::make_integer_sequence<int, lanes_of<V>>{});

/// Lines 1 and 2 of a register's particles by component: c0..c7 and c8 xx yy zz xy xz yz internal.
struct Particles {
  static constexpr int count = lanes_of<DoubleLanes>;
  DoubleLanes c[8], s[8];
};

/// @param used number of particles among them; the others are treated as at rest and without stress. Slots behind the last particle
/// are allocated.
inline __attribute__((always_inline)) void load(Particle* p, int used, double initial_internal, Particles& g) {
  load_line(p, 1, g.c);
  load_line(p, 2, g.s);
  if (used >= Particles::count) return;
  const Mask<DoubleLanes> live = lane_numbers<DoubleLanes> < static_cast<double>(used);
  for (DoubleLanes& v : g.c) v = select(live, v, DoubleLanes{});
  for (int i = 0; i < 7; ++i) g.s[i] = select(live, g.s[i], DoubleLanes{});
  g.s[7] = select(live, g.s[7], DoubleLanes{} + initial_internal);
}

/// The numbers of a group of particles that the law needs, by component. @tparam Record what the run stores
template <class Record>
class LawGroup;

/// Two registers of particles: sixteen, or eight if registers are shorter, because the variables of a law for sixteen would not fit into
/// them.
template <>
class LawGroup<Particle> {
 public:
  using Number = WidePair;
  LawGroup(Particle* p, int used, double initial_internal) : p_(p) {
    load(p, used, initial_internal, a_);
    load(p + Particles::count, used - Particles::count, initial_internal, b_);
  }
  [[nodiscard]] Matrix3<Number> increment(double dt) const {
    const auto c = [&](int i) { return Number{dt * a_.c[i], dt * b_.c[i]}; };
    return {{{c(0), c(3), c(6)}, {c(1), c(4), c(7)}, {c(2), c(5), Number{dt * a_.s[0], dt * b_.s[0]}}}};
  }
  [[nodiscard]] MaterialState<Number> state() const {
    const auto s = [&](int i) { return Number{a_.s[i], b_.s[i]}; };
    return {{s(1), s(2), s(3), s(4), s(5), s(6)}, s(7)};
  }
  void store(const MaterialState<Number>& state) {
    const Sym3<Number>& t = state.stress;
    const Number* const updated[7] = {&t.xx, &t.yy, &t.zz, &t.xy, &t.xz, &t.yz, &state.internal};
#pragma GCC unroll 7
    for (int i = 0; i < 7; ++i) {
      a_.s[i + 1] = updated[i]->a;
      b_.s[i + 1] = updated[i]->b;
    }
    store_line(a_.s, p_, 2);
    store_line(b_.s, p_ + Particles::count, 2);
  }
  /// Prefetches the lines.
  static void prefetch(const Particle* p) {
#pragma GCC unroll 16
    for (int i = 0; i < lanes_of<Number>; ++i) {
      __builtin_prefetch(reinterpret_cast<const char*>(p + i) + 64);
      __builtin_prefetch(reinterpret_cast<const char*>(p + i) + 128);
    }
  }

 private:
  Particle* p_;
  Particles a_, b_;
};

/// Transposes several 4 x 4 matrices, side by side in four registers.
inline __attribute__((always_inline)) void transpose_quads(SingleLanes* r) {
  const SingleLanes a0 = shuffle_halves<0, 8, 2, 10, 4, 12, 6, 14>(r[0], r[1]), a1 = shuffle_halves<1, 9, 3, 11, 5, 13, 7, 15>(r[0], r[1]);
  const SingleLanes a2 = shuffle_halves<0, 8, 2, 10, 4, 12, 6, 14>(r[2], r[3]), a3 = shuffle_halves<1, 9, 3, 11, 5, 13, 7, 15>(r[2], r[3]);
  r[0] = shuffle_halves<0, 1, 8, 9, 4, 5, 12, 13>(a0, a2);
  r[1] = shuffle_halves<0, 1, 8, 9, 4, 5, 12, 13>(a1, a3);
  r[2] = shuffle_halves<2, 3, 10, 11, 6, 7, 14, 15>(a0, a2);
  r[3] = shuffle_halves<2, 3, 10, 11, 6, 7, 14, 15>(a1, a3);
}

/// Quad n of a register's records by component. @param n 2 3 4: a column of C and a normal stress; 5: shear stresses and internal
inline __attribute__((always_inline)) void load_quads(SingleRecord* p, int n, SingleLanes (&v)[4]) {
#pragma GCC unroll 4
  for (int i = 0; i < 4; ++i) {
    v[i] = join_quads([&](int k) { return reinterpret_cast<const AliasingQuad*>(p + i + 4 * k) + n; });
  }
  transpose_quads(v);
}
inline __attribute__((always_inline)) void store_quads(SingleLanes (&v)[4], SingleRecord* p, int n) {
  transpose_quads(v);
#pragma GCC unroll 4
  for (int i = 0; i < 4; ++i) {
    for_each_quad([&](auto k) { reinterpret_cast<AliasingQuad*>(p + i + 4 * k)[n] = quad_of<k>(v[i]); });
  }
}

/// Records by component: [column of C or shear][row, or the number in the fourth place].
struct Records {
  static constexpr int count = lanes_of<SingleLanes>;
  SingleLanes q[4][4];
};
inline __attribute__((always_inline)) void load(SingleRecord* p, int used, double initial_internal, Records& g) {
#pragma GCC unroll 4
  for (int n = 0; n < 4; ++n) load_quads(p, 2 + n, g.q[n]);
  if (used >= Records::count) return;
  const SingleLaneMask live = lane_numbers<SingleLanes> < static_cast<float>(used);
  for (auto& quad : g.q) {
    for (SingleLanes& v : quad) v = select(live, v, SingleLanes{});
  }
  g.q[3][3] = select(live, g.q[3][3], SingleLanes{} + static_cast<float>(initial_internal));
}

template <>
class LawGroup<SingleRecord> {
 public:
  using Number = SinglePair;
  LawGroup(SingleRecord* p, int used, double initial_internal) : p_(p) {
    load(p, used, initial_internal, a);
    load(p + Records::count, used - Records::count, initial_internal, b);
  }
  [[nodiscard]] Matrix3<SinglePair> increment(double dt) const {
    const auto step = static_cast<float>(dt);
    const auto c = [&](int column, int row) { return SinglePair{step * a.q[column][row], step * b.q[column][row]}; };
    return {{{c(0, 0), c(1, 0), c(2, 0)}, {c(0, 1), c(1, 1), c(2, 1)}, {c(0, 2), c(1, 2), c(2, 2)}}};
  }
  [[nodiscard]] MaterialState<SinglePair> state() const {
    const auto at = [&](int n, int i) { return SinglePair{a.q[n][i], b.q[n][i]}; };
    return {{at(0, 3), at(1, 3), at(2, 3), at(3, 0), at(3, 1), at(3, 2)}, at(3, 3)};
  }
  void store(const MaterialState<SinglePair>& state) {
    const auto put = [&](int n, int i, const SinglePair& v) {
      a.q[n][i] = v.a;
      b.q[n][i] = v.b;
    };
    const Sym3<SinglePair>& t = state.stress;
    put(0, 3, t.xx), put(1, 3, t.yy), put(2, 3, t.zz), put(3, 0, t.xy), put(3, 1, t.xz), put(3, 2, t.yz), put(3, 3, state.internal);
#pragma GCC unroll 4
    for (int n = 0; n < 4; ++n) {
      store_quads(a.q[n], p_, 2 + n);
      store_quads(b.q[n], p_ + Records::count, 2 + n);
    }
  }
  static void prefetch(const SingleRecord* p) {
    for (std::size_t line = 0; line < lanes_of<SinglePair> * sizeof(SingleRecord) / 64; ++line)
      __builtin_prefetch(reinterpret_cast<const char*>(p) + 64 * line);
  }

 private:
  SingleRecord* p_;
  Records a, b;
};

/// One half of a group of single records in double precision.
inline MaterialState<WidePair> half_of(const MaterialState<SinglePair>& s, SingleLanes SinglePair::*half) {
  const Sym3<SinglePair>& t = s.stress;
  return {{widen(t.xx.*half), widen(t.yy.*half), widen(t.zz.*half), widen(t.xy.*half), widen(t.xz.*half), widen(t.yz.*half)},
          widen(s.internal.*half)};
}

/// The law in double precision, for a group of single records. Not inlined: a copy in the loop costs the usual path more than the call.
template <Material Law>
__attribute__((noinline)) void update_in_double(const Law& law, MaterialState<SinglePair>& state, const Matrix3<SinglePair>& dl,
                                                double dt) {
  for (SingleLanes SinglePair::*half : {&SinglePair::a, &SinglePair::b}) {
    MaterialState<WidePair> wide = half_of(state, half);
    Matrix3<WidePair> wide_dl;
    for (int i = 0; i < 3; ++i) {
      for (int j = 0; j < 3; ++j) wide_dl.m[i][j] = widen(dl.m[i][j].*half);
    }
    law.update_stress(wide, wide_dl, dt);
    const Sym3<WidePair>& from = wide.stress;
    Sym3<SinglePair>& to = state.stress;
    to.xx.*half = narrow(from.xx), to.yy.*half = narrow(from.yy), to.zz.*half = narrow(from.zz);
    to.xy.*half = narrow(from.xy), to.xz.*half = narrow(from.xz), to.yz.*half = narrow(from.yz);
    state.internal.*half = narrow(wide.internal);
  }
}

template <Material Law, class Number>
inline __attribute__((always_inline)) void update_group(const Law& law, MaterialState<Number>& state, const Matrix3<Number>& dl,
                                                        double dt) {
  if constexpr (!is_single<Number>) {
    law.update_stress(state, dl, dt);
  } else {
    if constexpr (UpdatesStressInSingle<Law>) {
      if (law.try_update_stress(state, dl, dt)) return;
    }
    update_in_double(law, state, dl, dt);
  }
}

// Flattened: the functions of a law have several callers here, so GCC would call them, and pass the states of a group through memory.
template <class Record, Material Law>
__attribute__((flatten)) bool update_stress_of(ParticleBin& bin, const Law& law, double dt) {
  using Number = typename LawGroup<Record>::Number;
  using V = decltype(Number::a);
  constexpr int group = lanes_of<Number>;  // particles for each update
  static_assert(page_particles % group == 0, "a page holds whole groups");
  V sticky{};
  const int count = bin.count();
  for (int first = 0; first < count; first += group) {
    if (first + group < count) LawGroup<Record>::prefetch(&bin.record<Record>(first + group));
    LawGroup<Record> points(&bin.record<Record>(first), count - first, law.initial_internal());
    MaterialState<Number> state = points.state();
    update_group(law, state, points.increment(dt), dt);
    // The concept Material requires that NaN in any variable reaches the pressure or the internal variable, so one normal component
    // suffices.
    sticky += 0.0 * ((state.stress.xx.a + state.stress.xx.b) + (state.internal.a + state.internal.b));
    points.store(state);
  }
  bool finite = true;
  for (std::size_t i = 0; i < sizeof(V) / sizeof(ScalarOf<V>); ++i) finite = finite && sticky[i] == 0;
  return finite;
}

MaterialState<double> state_of(const Particle& p) {
  return {{p.stress[0], p.stress[1], p.stress[2], p.stress[3], p.stress[4], p.stress[5]}, p.internal};
}

}  // namespace

bool update_stress(Grid& grid, std::int32_t block, const AnyMaterial& material, double dt) {
  return with_record_type(grid.precision(), [&](auto record) {
    return std::visit([&](const auto& law) { return update_stress_of<decltype(record)>(grid.block(block).particles, law, dt); }, material);
  });
}

double volume_ratio(const AnyMaterial& material, const Particle& p) { return volume_ratio(material, state_of(p)); }

double stored_energy(const AnyMaterial& material, const Particle& p) {
  return std::visit([&](const auto& law) { return p.volume * law.stored_energy(state_of(p)); }, material);
}

}  // namespace mpm
