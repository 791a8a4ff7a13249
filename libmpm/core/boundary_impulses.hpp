#pragma once
/// What the boundaries took from the grid in a step: recorded block by block and rank by rank, then summed so that neither the number of
/// threads nor that of ranks matters.

#include <array>
#include <cstdint>
#include <map>
#include <span>
#include <vector>

#include "libmpm/boundary/impulse.hpp"
#include "libmpm/core/block_sums.hpp"
#include "libmpm/core/node_index.hpp"

namespace mpm {

/// Impulse on a solid in one step, in parts whose sums have a fixed order.
struct ContactImpulse {
  /// The part of one layer.
  struct Part {
    std::int32_t layer = 0;  ///< number of the layer
    Impulse impulse;         ///< on the layer
  };
  std::int32_t first = 0;                  ///< number of the lowest layer
  std::vector<Impulse> sides;              ///< of the layers from `first` on
  std::array<std::vector<Part>, 2> faces;  ///< top, underside: of the nodes of its columns, one after another; on layers of `sides`

  /// The impulse on the sides in one layer, to be changed; layers are added as needed.
  Impulse& side(std::int32_t layer);
  ContactImpulse& operator+=(const ContactImpulse& other);  ///< adds what another rank recorded
  [[nodiscard]] Impulse total() const;                      ///< sum of all parts
  [[nodiscard]] LayerImpulses layers() const;               ///< by layer of nodes
};

/// The sums over the grid; with mirror planes, over the computed part.
struct BoundaryImpulses {
  double mass = 0.0;                  ///< on the grid, kg: its momentum grew by dt g m
  std::vector<Impulse> impulses;      ///< on each boundary. At a node of several boundaries each has its own part
  std::vector<LayerImpulses> layers;  ///< of the boundaries in GridConditions::layered, in that order
};

/// What one rank records. The sum comes later, so that no rank has to wait for the others between its grid and its particles.
class ImpulseRecord {
 public:
  /// @param boundaries  their number. @param layered  GridConditions::layered
  ImpulseRecord(std::size_t boundaries, std::span<const std::size_t> layered)
      : layered_(layered), boundaries_(boundaries), sums_(1 + impulse_numbers * boundaries), layers_(layered.size()) {}

  /// Adds the mass of a block, kg.
  void add_mass(double mass) { sums_.add(0, mass); }
  /// Adds the impulse that boundary b took from the nodes of a block.
  void add_impulse(std::size_t b, const Impulse& taken);
  /// Adds the impulses on the four layers of nodes of a block, of the k-th layered boundary, N s.
  void add_layers(std::size_t k, const Index3& block, std::span<const Vec3, block_edge> layers);
  /// The impulse on boundary b, which acts on the nodes of many blocks together.
  void add_contact(std::size_t b, ContactImpulse impulse) { contacts_[b] = std::move(impulse); }
  /// Adds what such a boundary took from particles besides. @param layer  number of the layer of nodes near them
  void add_to_contact(std::size_t b, std::int32_t layer, const Impulse& taken) { contacts_[b].side(layer) += taken; }

  /// The sum over all ranks; all ranks call it. @returns on ranks other than the first without layers and without the impulses of
  /// add_contact()
  BoundaryImpulses total(RankGroup& ranks) &&;

 private:
  static constexpr std::size_t impulse_numbers = sizeof(Impulse) / sizeof(double);
  /// The layers of one block.
  struct BlockLayers {
    Index3 block;
    std::array<double, 3 * block_edge> numbers;
  };
  void gather_layers(std::vector<BlockLayers>& rows, RankGroup& ranks) const;
  void gather_contacts(RankGroup& ranks);
  [[nodiscard]] static LayerImpulses sum_of(std::span<const BlockLayers> rows);

  std::span<const std::size_t> layered_;
  std::size_t boundaries_;
  BlockSums sums_;                                  ///< the mass, then the impulse on each boundary
  std::vector<std::vector<BlockLayers>> layers_;    ///< of each layered boundary, in the order of the blocks
  std::map<std::size_t, ContactImpulse> contacts_;  ///< by boundary
};

}  // namespace mpm
