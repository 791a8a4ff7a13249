#pragma once
/// Contact of vertical solids that act at their surface: solves the conditions of boundary/contact_stencil.hpp on the grid's velocities.

#include "libmpm/boundary/impulse.hpp"
#include "libmpm/boundary/solid.hpp"
#include "libmpm/core/grid.hpp"
#include "libmpm/core/mirror.hpp"

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

/// Changes the velocities of nodes near a solid so that its conditions hold: eight Gauss-Seidel sweeps over the rows of each layer, in
/// alternating direction, projected: no tension, friction within Coulomb's cone, an extension only behind a point that is in contact. The
/// ends of a side take at most what EdgeBound leaves them of the impulse of the next point, or as much as the end round the edge, from the
/// third sweep on; points in margins are bounded from the first, because later sweeps do not undo what they took before. In
/// a flow the velocities are near their solution from the step before, and more sweeps change no force; eight leave up to 7 % of the speed
/// of a sudden impact.
///
/// Each layer is solved by itself, eight layers in the lanes of one vector; layers do not share nodes, so that the order of layers does
/// not matter and results are the same on any number of threads.
/// @param density  of the material at rest, kg/m^3. @param dt  s
ContactImpulse apply_surface_contact(Grid& grid, const SurfaceSolid& solid, double density, double dt);

}  // namespace mpm
