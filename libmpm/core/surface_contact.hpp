#pragma once
/// Contact of vertical solids that act at their surface: solves the conditions of boundary/contact_stencil.hpp on the grid's velocities.

#include "libmpm/boundary/solid.hpp"
#include "libmpm/core/boundary_impulses.hpp"
#include "libmpm/core/grid.hpp"

namespace mpm {

/// Changes the velocities of nodes near a solid so that its conditions hold: eight Gauss-Seidel sweeps over the rows of each layer, in
/// alternating direction, projected: no tension, friction within Coulomb's cone, an extension only behind a point that is in contact. The
/// ends of a side take at most what EdgeBound leaves them of the impulse of the next point, or as much as the end round the edge, from the
/// third sweep on; points in margins are bounded from the first, because later sweeps do not undo what they took before. In
/// a flow the velocities are near their solution from the step before, and more sweeps change no force; eight leave up to 7 % of the speed
/// of a sudden impact.
///
/// Eight layers are solved in the lanes of one vector; layers do not share nodes, so that the order of layers does not matter and results
/// are the same on any number of threads. Only those at the top and at the underside, the last inside and one within half a cell outside,
/// come after the next one inwards. Their points take at most what EdgeBound leaves them of the impulses there and, at the underside, what
/// gravity adds to the pressure. Without these bounds an element 6 cells high takes 1.06 to 1.22 times the exact force in a jet, with them
/// 0.98 to 1.02 times (validation/cases/plate_in_jet).
/// @param density  of the material at rest, kg/m^3. @param gravity  along z, m/s^2. @param dt  s
ContactImpulse apply_surface_contact(Grid& grid, const SurfaceSolid& solid, double density, double gravity, double dt);

/// The layers of blocks that hold a layer of nodes at a face and the one that bounds it, for each of them. @param cell_size  m
std::vector<LayerRange> layers_of_ends(const UprightSolid& solid, double cell_size);

}  // namespace mpm
