#pragma once
/// Blocks that must have one owner, because a boundary acts on nodes of several of them together.

#include <array>
#include <cstdint>
#include <map>

#include "libmpm/core/state.hpp"

namespace mpm {

/// The blocks that are joined in a scene at some time:
/// - the two layers that the columns of a folded wall or of a solid's top or underside reach into, where these are two,
/// - those of the layers of nodes at a solid's top or underside, and of those that bound them (core/surface_contact.hpp),
/// - all layers from the lowest to the highest that the columns on uneven ground reach into,
/// - around a solid that acts at its surface: all columns of blocks that its stencil touches, two blocks in height, because the
///   contact is solved for two at once.
class JoinedBlocks {
 public:
  /// None.
  JoinedBlocks() = default;
  /// @param cell_size  m. @param time  s: walls travel
  JoinedBlocks(const Scene& scene, double cell_size, double time);
  bool operator==(const JoinedBlocks&) const = default;

  /// The representative of a group of joined blocks; the block itself if it is not joined.
  [[nodiscard]] Index3 representative(const Index3& block) const;

 private:
  using Layers = std::map<std::int32_t, std::int32_t>;  ///< lowest layer of the group, for each layer that is joined with one below
  using Column = std::array<std::int32_t, 2>;
  void join_columns(const SurfaceSolid& solid);

  std::array<Layers, 3> layers_;      ///< by axis
  std::map<Column, Column> columns_;  ///< around solids, after `layers_`: the representative of each joined column
  Layers pairs_;                      ///< around solids: pairs of blocks in height, z >> 1
};

}  // namespace mpm
