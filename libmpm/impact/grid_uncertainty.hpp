#pragma once
/// Numerical uncertainty of an impact, from grid studies at the same resolution. A run on one grid cannot
/// determine its own grid error; `mpm converge` estimates it for one case from several grids.

#include "libmpm/boundary/contact.hpp"
#include "libmpm/boundary/outline.hpp"
#include "libmpm/core/numerics.hpp"

namespace mpm {

/// What makes the heights of snow converge more slowly with the grid than those of snow with moderate friction. Several may hold.
struct SnowTraits {
  bool fluid = false;                  ///< without friction: it climbs as a fountain
  bool compressible_cohesive = false;  ///< cohesion, and xi of 0.5 or less
  bool stiff = false;                  ///< M' above 1.5: steep heaps, which break off in pieces

  friend bool operator==(const SnowTraits&, const SnowTraits&) = default;
};

/// Resolution of the obstacle in a run.
struct GridResolution {
  ContactRule contact = ContactRule::nodal;  ///< where the obstacle acts
  Transfer transfer = Transfer::apic;        ///< velocities between grid and particles
  Front front = Front::plane;                ///< how the obstacle meets the flow
  SnowTraits snow;                           ///< what meets it
  bool smooth = false;                       ///< the obstacle has less friction than any that was studied, but for none at all
  double cells = 0.0;                        ///< in the smaller of the obstacle's width and the flow height
  double width_excess = 0.0;  ///< relative increase of the width by nodal contact: rows of nodes on the obstacle, times dx over w, minus 1
};

/// Relative to the value of the run: the value of an infinitely fine grid is expected within this to either side. Contains the distance to
/// the limit and the uncertainty of the limit. NaN: not known (less than three cells; a shape that resembles none that was studied; the
/// highest particle on a smooth obstacle).
struct GridUncertainty {
  double runup = 0.0;             ///< of the height that holds 99 % of the mass before the obstacle
  double highest_particle = 0.0;  ///< of the run-up of the highest particle; unknown on a smooth obstacle, where it belongs to a splash
  double pressure_height = 0.0;   ///< of the pressure height
  double force = 0.0;             ///< of the mean force
  double moment = 0.0;            ///< of the overturning moment
};

/// Linear in the cell size between the grids that were studied; beyond the finest, the distance to the limit is taken to fall with the cell
/// size (first order). The uncertainty of the overturning moment is that of the force and that of the pressure height, on which its arm
/// depends, added.
///
/// Sources: validation/cases/avalanche_convergence (Fr 3, M = 0.4, frictionless mast, w = H: both families of grids, both rules of contact)
/// and docs/cases.md (cylinder, wedge); for a mast with friction, fluids and compressible cohesive snow validation/study/limits.md
/// (contact at the surface; for contact on nodes the larger of this and its own is taken). The errors for other snow, speeds and widths may
/// be larger or smaller.
[[nodiscard]] GridUncertainty grid_uncertainty(const GridResolution& resolution);

/// Rows of nodes on an obstacle with a plane of symmetry on a row, times dx, over its width: 1 + 1/n for an even number n of cells across
/// it, 1 for an odd one. @param cells_across  w/dx > 0
[[nodiscard]] double nodal_width_ratio(double cells_across);

}  // namespace mpm
