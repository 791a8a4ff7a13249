#pragma once
/// A plane jet of fluid on an obstacle across its middle, horizontal or upright: the flow of Kirchhoff's plate and of a cylinder with
/// smooth separation.

#include <string>
#include <vector>

#include "validation/harness/setup.hpp"
#include "validation/harness/shallow_flow.hpp"

namespace mpm::validation {

/// Times are multiples of b/U, half the jet's thickness over its speed: means from jet_means_from to jet_means_to.
constexpr double jet_means_from = 12.0;
constexpr double jet_means_to = 25.0;  ///< see jet_means_from

/// Numerics of one run, and where it lies on the grid.
struct PlaneJetSetting {
  int cells = 7;                        ///< across the obstacle
  std::string id = {};                  ///< of the set-up; empty: "cells7"
  double ratio = 0.75;                  ///< width of the obstacle over thickness d of the jet, nearly: d is made an even number of cells
  double cfl = 0.4;                     ///< CFL number
  double shift_x = 0.0, shift_y = 0.0;  ///< of the scene against the grid along and across the jet, cells
  bool upright = false;                 ///< the plane of the jet is vertical: the obstacle's width is its height, and all is computed;
                                        ///< else half, if shift_y = 0
  Transfer transfer = Transfer::aflip;  ///< between particles and grid
  double flip_ratio = 0.95;             ///< Transfer::flip: share of FLIP
  ContactRule contact = ContactRule::surface;  ///< of the obstacle
  Lattice lattice = Lattice::staggered;        ///< of the jet's particles
};

/// What a run gave.
struct PlaneJetForce {
  double ratio = 0.0;           ///< width of the obstacle over d, exactly
  double half_thickness = 0.0;  ///< b = d/2, m
  double unit = 0.0;            ///< N: rho U^2 d for a jet one metre wide
  std::vector<double> time;     ///< b/U
  std::vector<double> force;    ///< over rho U^2 d, mean of the time since the row before
  BatchMean mean{};             ///< of the force over rho U^2 d
  double particle_steps = 0.0;  ///< cost; 0 if another solver made the run
};

/// A run by the name under which it is judged.
struct NamedJet {
  std::string name;         ///< "7 cells, CFL 0.2"
  PlaneJetSetting setting;  ///< its numerics
};

/// A slice of the jet one cell high.
/// @param base  the case file: two walls (the slice's), one body (the jet, its velocity), the obstacle, the fluid
Setup plane_jet_setup(const Case& base, const PlaneJetSetting& setting);

/// The set-ups of runs for other solvers.
std::vector<Setup> plane_jet_setups(const CaseContext& context, const std::vector<NamedJet>& runs);

/// Lengths across a jet.
struct JetGeometry {
  double width;           ///< of the obstacle, m
  double half_thickness;  ///< b, m
};
/// Of the scene of a set-up.
JetGeometry jet_geometry(const Case& scene);

/// Makes the run, or reads it. @param observe  called at every sample of the steady flow with the particles, if any: as those of a
/// horizontal jet with its axis on y = 0
PlaneJetForce play_plane_jet(const CaseContext& context, const Setup& setup, const std::function<void(const Instant&)>& observe = {});

}  // namespace mpm::validation
