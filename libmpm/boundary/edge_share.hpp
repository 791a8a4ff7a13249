#pragma once
/// Upper bound of the impulse at the contact point next to an edge.
///
/// Where a flow leaves the edge of a side, the pressure on the side falls to zero like the square root of the distance s from the edge
/// (Kirchhoff's plate: p = rho U^2/2 (1 - tau^2), and s ~ (1 - tau)^2). A point i of the surface acts through the nodes k around it, and
/// the material feels them through their B-splines N_k: an impulse of 1 at the place x_i is the traction a_i(s) = sum_k N_k(s) N_k(x_i)
/// along the side. It reaches two and a half cells beyond the point, so also past the edge. The impulses lambda_i whose traction sum_i
/// lambda_i a_i(s) is nearest to sqrt(s) within the side and 0 beyond the edge, in the sense of least squares, have lambda_0/lambda_1
/// between 0.15 (edge on a row of nodes) and 0.34 (edge midway between two rows): the end point takes this share of what the next one
/// takes. It is smallest for an edge on a row of nodes.

#include "libmpm/boundary/shapes/outline.hpp"

namespace mpm {

/// lambda_0/lambda_1 of the points at edge + (i + 1/2) spacing inward, i = 0, 1, ...; 0 to 1.
/// @param edge  end of the side, in cells in the frame of the grid. @param inward  unit vector along the side, away from the edge
/// @param spacing  of the points, cells
[[nodiscard]] double edge_share(const Vec2& edge, const Vec2& inward, double spacing);

}  // namespace mpm
