#pragma once
/// From a case to what the solver works on.

#include "mpm/case.hpp"
#include "mpm/solver.hpp"

namespace mpm {

/// Edge of the cube of one particle, m: dx over the cube root of the particles per cell.
double lattice_spacing(const NumericsSpec& numerics);

/// Law, walls, obstacle, feed and domain of a case. @throws ConfigError
Scene make_scene(const Case& c);

/// The particles of t = 0: bodies and the conveyor's plug.
/// A body is a lattice that fills its shape with the body's exact volume; with mirror planes only the computed part is filled.
/// Identity numbers run from 0 in the order of the bodies, x fastest.
State make_state(const Case& c, const Scene& scene);

}  // namespace mpm
