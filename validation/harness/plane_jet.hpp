#pragma once
/// A plane jet of fluid on an obstacle across its middle: the flow of Kirchhoff's plate and of Levi-Civita's curved obstacles.

#include <functional>
#include <vector>

#include "libmpm/driver/case.hpp"
#include "libmpm/driver/scene.hpp"
#include "validation/harness/shallow_flow.hpp"

namespace mpm::validation {

/// Times are multiples of b/U, half the jet's thickness over its speed: means from jet_means_from to jet_means_to.
constexpr double jet_means_from = 12.0;
constexpr double jet_means_to = 25.0;  ///< see jet_means_from

/// Numerics of one run, and where it lies on the grid.
struct PlaneJetSetting {
  int cells = 7;                        ///< across the obstacle
  double ratio = 0.75;                  ///< width of the obstacle over thickness d of the jet, nearly: d is made an even number of cells
  double cfl = 0.4;                     ///< CFL number
  double shift_x = 0.0;                 ///< of the scene against the grid, cells
  double shift_y = 0.0;                 ///< likewise; 0: only half of the jet is computed
  Transfer transfer = Transfer::aflip;  ///< between particles and grid
  ContactRule contact = ContactRule::surface;                ///< of the obstacle
  BodySpec::Lattice lattice = BodySpec::Lattice::staggered;  ///< of the jet's particles
};

/// What a run gave.
struct PlaneJetForce {
  double ratio = 0.0;           ///< width of the obstacle over d, exactly
  double half_thickness = 0.0;  ///< b = d/2, m
  double cell_size = 0.0;       ///< m
  std::vector<double> time;     ///< b/U
  std::vector<double> force;    ///< over rho U^2 d, mean of the time since the row before
  BatchMean mean{};             ///< of the force over rho U^2 d
  double particle_steps = 0.0;  ///< cost
};

/// Called at every sample of the steady flow. @param b  half the thickness of the jet, m
using PlaneJetObserver = std::function<void(const State& state, const CaseScene& scene, double b)>;

/// Runs a slice of the jet one cell high.
/// @param base  the case file: two walls (the slice's), one body (the jet, its velocity), the obstacle, the fluid
PlaneJetForce run_plane_jet(const Case& base, const PlaneJetSetting& setting, const PlaneJetObserver& observe = {});

}  // namespace mpm::validation
