#pragma once
/// Contact of vertical solids that act at their surface: solves the conditions of boundary/contact_stencil.hpp on the grid's velocities.

#include "libmpm/boundary/impulse.hpp"
#include "libmpm/boundary/surface_solid.hpp"
#include "libmpm/core/grid.hpp"
#include "libmpm/core/mirror.hpp"

namespace mpm {

/// Impulse on a solid in one step: the parts, and their sums in a fixed order.
struct ContactImpulse {
  Impulse total;         ///< sum of all parts
  LayerImpulses layers;  ///< by layer of nodes

  /// The part of one layer.
  struct Part {
    std::int32_t layer = 0;  ///< number of the layer
    Impulse impulse;         ///< on the layer
  };
  std::vector<Impulse> sides;  ///< of the layers from layers.first on
  std::vector<Part> top;       ///< one after another

  ContactImpulse() = default;
  /// @param first  number of the lowest layer. @param sides  impulses on the sides, layer by layer
  ContactImpulse(std::int32_t first, std::vector<Impulse> sides);
  /// Adds the impulse of a node of the top's columns. @param layer  number of its layer, one of layers
  void add_top(std::int32_t layer, const Impulse& impulse);
};

/// Changes the velocities of nodes near a solid so that its conditions hold: eight Gauss-Seidel sweeps over the rows of each layer, in
/// alternating direction, projected: no tension, friction within Coulomb's cone, an extension only behind a point that is in contact. The
/// ends of a side take at most ContactStencil::edge_ratio times the impulse of the next point, or as much as the end round the edge. In a
/// flow the velocities are near their solution from the step before, and more sweeps change no force; eight leave up to 7 % of the speed of
/// a sudden impact.
///
/// Each layer is solved by itself, eight layers in the lanes of one vector; layers do not share nodes, so that the order of layers does
/// not matter and results are the same on any number of threads.
ContactImpulse apply_surface_contact(Grid& grid, const SurfaceSolid& solid);

}  // namespace mpm
