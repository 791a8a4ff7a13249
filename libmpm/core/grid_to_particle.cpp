#include <algorithm>
#include <bit>

#include "libmpm/core/particle_groups.hpp"
#include "libmpm/core/spline_sums.hpp"
#include "libmpm/core/transfer.hpp"

namespace mpm {

namespace {

/// A node in a halo: once for each particle of a group, {v | v}, so that one load serves all without a shuffle. For four particles it is
/// there once, and a load repeats it: a halo with four copies is too large for the first-level cache.
template <class V>
using HaloNode = std::conditional_t<whole_registers && std::same_as<V, SingleLanes>, SingleQuad, V>;

/// The nodes of a block's particles.
template <class V>
struct alignas(64) GroupHalo {
  HaloNode<V> node[halo_nodes];
};

/// Calls f(row of nodes, its first place in the halo, count) for every row of a block's halo.
/// @param before_forces  the velocities before forces in place of those that forces and boundaries have changed
template <class F>
void for_each_row(const Grid& grid, std::int32_t block, bool before_forces, F&& f) {
  for_each_halo_row(
      grid.block(block).neighbour,
      [&](std::int32_t b) -> const NodeBlock& { return before_forces ? grid.velocities_before_forces(b) : grid.velocities(b); }, f);
}

/// A node as a halo holds it.
template <class Held>
Held halo_node(const SingleQuad& node) {
  if constexpr (std::same_as<Held, SingleQuad>) {
    return node;
  } else {
    return repeat_quad(node);
  }
}

template <class V>
void fill(GroupHalo<V>& halo, const Grid& grid, std::int32_t block, bool before_forces, const Vec3& /*relative_to*/) {
  for_each_row(grid, block, before_forces, [&](const Node* from, int first, auto count) {
    for (int i = 0; i < count; ++i) halo.node[first + i] = repeat<V>(from[i]);
  });
}
void fill(GroupHalo<SingleLanes>& halo, const Grid& grid, std::int32_t block, bool before_forces, const Vec3& relative_to) {
  const Node velocity = {relative_to.x(), relative_to.y(), relative_to.z(), 0.0};
  for_each_row(grid, block, before_forces, [&](const Node* from, int first, auto count) {
    for (int i = 0; i < count; ++i) halo.node[first + i] = halo_node<HaloNode<SingleLanes>>(narrow(from[i] - velocity));
  });
}

/// The velocity of a block to which its particles' velocities are relative: mean of the nodes around it, weighted by mass; 0 without mass.
Vec3 mean_velocity(const Grid& grid, std::int32_t block) {
  Node sum{};
  for_each_row(grid, block, false, [&](const Node* from, int, auto count) {
    for (int i = 0; i < count; ++i) {
      sum += spread<3>(from[i]) * select(LoneParticle::mask_w, Node{} + 1.0, from[i]);
    }
  });
  return sum[3] > 0.0 ? Vec3(Vec3(sum[0], sum[1], sum[2]) / sum[3]) : Vec3(Vec3::Zero());
}

/// Some particles of a cell between the two passes of grid_to_particle.
template <class Record>
struct MovingGroup {
  Group<Record> from;
  int used;  ///< particles; the others are padding
  typename Group<Record>::Vector f;
  BsplineWeights<typename Group<Record>::Vector> w;
};

/// The same number, hidden from the optimizer. It would otherwise load all nodes of a cell before the loop over its groups, and, as they
/// do not fit into the registers, store most of them again.
inline int hidden_from_optimizer(int number) {
  asm("" : "+r"(number));
  return number;
}

/// x plus this constant has the nearest integer to x in its low bits, for |x| < 2^51.
constexpr double to_integer_bits = 6755399441055744.0;  // 1.5 * 2^52

/// Moves the particles of a block. Lane 3 of a position is the volume and stays.
template <class Record>
class Displacement;
template <>
class Displacement<Particle> {
 public:
  using Vector = Group<Particle>::Vector;  ///< of all particles of a group
  Displacement(const Grid& grid, const Block& block, double dt)
      : dt_(Group<Particle>::xyz * dt),
        inverse_dx_(grid.inverse_cell_size()),
        to_cell_((Vector{} + (to_integer_bits - 1.0)) - cell_corner<Vector>(block.coordinate, 0)) {}
  [[nodiscard]] Vector moved(Vector position, Vector velocity) const { return position + dt_ * velocity; }
  /// Velocity by which the fastest particle is found.
  [[nodiscard]] Vector absolute(Vector velocity) const { return velocity; }
  /// base = floor(x/dx - 1/2) = nearest(x/dx - 1); relative to the block: 0..3 if the particle stays
  [[nodiscard]] Mask<Vector> cell(Vector position) const {
    return std::bit_cast<Mask<Vector>>(position * inverse_dx_ + to_cell_) - std::bit_cast<Mask<Vector>>(Vector{} + to_integer_bits);
  }
  [[nodiscard]] bool holds(double /*max_speed_squared*/) const { return true; }

 private:
  Vector dt_;
  double inverse_dx_;
  Vector to_cell_;
};
/// The block's displacement is rounded once, the displacement relative to it for each particle.
template <>
class Displacement<SingleRecord> {
 public:
  Displacement(const Grid& grid, const Block& block, double dt) {
    const double units = dt * grid.inverse_cell_size() * (1 << position_bits);
    scale_ = Group<SingleRecord>::xyz * static_cast<float>(units);
    const Vec3& v = block.particles.frame.velocity;
    reach_ = dt > 0.0 ? block_edge * grid.cell_size() / dt : HUGE_VAL;
    for (int i = 0; i < lanes_of<SingleLanes>; ++i) {
      const double common = i % 4 < 3 ? v[i % 4] : 0.0;
      velocity_[i] = static_cast<float>(common);
      const double steps = std::nearbyint(common * units);
      common_[i] = std::abs(steps) < 0x1p31 ? static_cast<std::int32_t>(steps) : 0;  // larger values: holds() returns false
    }
  }
  [[nodiscard]] SingleLanes moved(SingleLanes position, SingleLanes velocity) const {
    return std::bit_cast<SingleLanes>(std::bit_cast<SingleLaneMask>(position) + (common_ + nearest_integers(scale_ * velocity)));
  }
  [[nodiscard]] SingleLanes absolute(SingleLanes velocity) const { return velocity + velocity_; }
  [[nodiscard]] SingleLaneMask cell(SingleLanes position) const { return std::bit_cast<SingleLaneMask>(position) >> position_bits; }
  /// Whether no particle moved further than a block; the integers cannot hold positions beyond.
  [[nodiscard]] bool holds(double max_speed_squared) const { return !(max_speed_squared > reach_ * reach_); }

 private:
  SingleLanes scale_, velocity_{};
  SingleLaneMask common_{};
  double reach_ = 0.0;
};

// In one piece: the two passes over the groups of a cell (weights, then sums and stores) share the groups and a dozen constants of the
// block that stay in registers.
template <class Record>
BlockMotion move_block(Grid& grid, std::int32_t index, const TransferOptions& options, std::int32_t next_index) {
  using V = typename Group<Record>::Vector;
  using Scalar = ScalarOf<V>;
  constexpr int size = Group<Record>::size, batch = batch_of<Record>;
  Block& block = grid.block(index);
  ParticleBin& bin = block.particles;
  const ParticleBin& next = next_index == no_block ? bin : grid.block(next_index).particles;
  const bool retains = options.retained > 0.0;
  // Stored velocities and those before forces, of which only the difference is used, are relative to the old frame, new ones to the new.
  GroupHalo<V> halo, before_forces;  // the second is filled where it is used; to clear it takes a tenth of the time of a small block
  if (retains) fill(before_forces, grid, index, true, bin.frame.velocity);
  if constexpr (std::same_as<Record, SingleRecord>) bin.frame.velocity = mean_velocity(grid, index);
  fill(halo, grid, index, false, bin.frame.velocity);

  const Displacement<Record> displacement(grid, block, options.dt);
  const V affine_scale = V{} + static_cast<Scalar>(4.0 * grid.inverse_cell_size());
  const auto retained = static_cast<Scalar>(options.retained);
  V max_speed_squared = {};
  Record discarded[size] = {};  // written in place of the padding behind a cell's last particle
  std::uint32_t reach = 0;
  MovingGroup<Record> groups[batch];

  for (int cell = 0; cell < block_nodes; ++cell) {
    const int begin = bin.cell_start[cell], end = bin.cell_start[cell + 1];
    if (begin == end) continue;
    const CellOffset<Record> offset(grid, block.coordinate, cell);
    for (int first = begin; first < end; first += size * batch) {
      int count = 0;
      for (int n = first; n < end && count < batch; n += size, ++count) {
        PrefetchGroup<Record>(bin, next, n).request_first();
        MovingGroup<Record>& m = groups[count];
        m.used = std::min(size, end - n);
#pragma GCC unroll 4
        for (int i = 0; i < size; ++i) m.from.p[i] = &bin.record<Record>(bin.order[static_cast<std::size_t>(i < m.used ? n + i : n)]);
        m.f = offset(m.from.position());
        m.w = bspline_weights(m.f);
      }
      for (int n = 0; n < count; ++n) {
        const MovingGroup<Record>& m = groups[n];
        Record* to[size];  // written to
#pragma GCC unroll 4
        // NOLINTNEXTLINE(cppcoreguidelines-pro-type-const-cast): a Group reads only, here the block's own records
        for (int i = 0; i < size; ++i) to[i] = i < m.used ? const_cast<Record*>(m.from.p[i]) : &discarded[i];
        const PrefetchGroup<Record> prefetch(bin, next, first + size * n);
        const int base = hidden_from_optimizer(first_halo_node(cell));
        const Gathered<V> g = gather(halo.node + base, m.w, prefetch);
        const V f = m.f, xv = m.from.position();
        V v = g.v;
        if (retains) v += retained * (m.from.velocity() - gather(before_forces.node + base, m.w, prefetch).v);
        const V cx = affine_scale * (g.x - spread<0>(f) * g.v);
        const V cy = affine_scale * (g.y - spread<1>(f) * g.v);
        const V cz = affine_scale * (g.z - spread<2>(f) * g.v);
        const V x = displacement.moved(xv, g.v);

        Group<Record>::store(to, m.from, x, v, cx, cy, cz);

        const V absolute = displacement.absolute(v);
        const V v2 = absolute * absolute;
        const V speed_squared = v2 + spread<1>(v2) + spread<2>(v2);  // in the first lane of each particle
        max_speed_squared = max(speed_squared, max_speed_squared);

        const auto bytes = Group<Record>::bytes_of(displacement.cell(x));
#pragma GCC unroll 4
        for (int i = 0; i < size; ++i) {
          if (i > 0 && i >= m.used) break;
          const std::uint32_t c = bytes[static_cast<std::size_t>(i)];  // a byte each for x, y, z
          const bool stays = (c & 0xFCFCFCU) == 0;
          bin.cell[bin.order[static_cast<std::size_t>(first + size * n + i)]] =
              stays ? static_cast<std::uint8_t>((c | c >> 6 | c >> 12) & 63U) : ParticleBin::left_block;
          reach |= (((c & 0x7F7F7FU) + 0x040404U) ^ (c & 0x808080U)) & 0xF0F0F0U;  // not zero if a byte is not in -4 .. 11
        }
      }
    }
  }
  BlockMotion motion;
  motion.max_speed_squared = Group<Record>::largest(max_speed_squared);
  motion.within_reach = reach == 0 && displacement.holds(motion.max_speed_squared);
  return motion;
}

/// Cell of a particle along an axis, relative to its block: the same rounding as in move_block, so that both agree on ties.
int local_cell(const Particle& p, int axis, const Grid& grid, const Index3& block) {
  const double rounded =
      p.position[axis] * grid.inverse_cell_size() + ((to_integer_bits - 1.0) - first_node(block[static_cast<std::size_t>(axis)]));
  return static_cast<int>(std::bit_cast<std::int64_t>(rounded) - std::bit_cast<std::int64_t>(to_integer_bits));
}
int local_cell(const SingleRecord& p, int axis, const Grid& /*grid*/, const Index3& /*block*/) {
  return p.position[static_cast<std::size_t>(axis)] >> position_bits;
}

}  // namespace

BlockMotion grid_to_particle(Grid& grid, std::int32_t block, const TransferOptions& options, std::int32_t next) {
  return with_record_type(grid.precision(), [&](auto record) { return move_block<decltype(record)>(grid, block, options, next); });
}

void relocate(Grid& grid, std::int32_t index, int slot, const Particle& particle) {
  Block& block = grid.block(index);
  ParticleBin& bin = block.particles;
  with_record_type(grid.precision(), [&](auto type) {
    auto& record = bin.record<decltype(type)>(slot);
    encode(particle, ParticleBin::left_block, bin.frame, record);
    int cell = 0;
    for (int axis = 0; axis < 3; ++axis) {
      const int local = local_cell(record, axis, grid, block.coordinate);
      cell = local < 0 || local >= block_edge ? int{ParticleBin::left_block} : cell | local << (2 * axis);
      if (cell >= ParticleBin::left_block) break;
    }
    bin.cell[static_cast<std::size_t>(slot)] = static_cast<std::uint8_t>(cell);
  });
}

bool collect_migrants(Grid& grid, std::int32_t index) {
  Block& block = grid.block(index);
  ParticleBin& bin = block.particles;
  for (int s = bin.last_leaver(bin.count()); s >= 0; s = bin.last_leaver(s)) {
    Migrant m{bin[s], 0, 0};
    int offset[3];
    for (int axis = 0; axis < 3; ++axis) {
      const int local = with_record_type(
          grid.precision(), [&](auto record) { return local_cell(bin.record<decltype(record)>(s), axis, grid, block.coordinate); });
      offset[axis] = local >> 2;
      m.cell = static_cast<std::uint8_t>(m.cell | (local & 3) << (2 * axis));
      if (offset[axis] < -1 || offset[axis] > 1) return false;
    }
    m.to = static_cast<std::uint8_t>(direction_of(offset[0], offset[1], offset[2]));
    grid.send(index, m);
    grid.remove(index, s);
  }
  return true;
}

}  // namespace mpm
