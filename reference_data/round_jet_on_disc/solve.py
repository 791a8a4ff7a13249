#!/usr/bin/env python3
"""Force of a round jet on a flat disc: steady, axisymmetric, incompressible potential flow with free surfaces. Writes data.csv.

    python3 reference_data/round_jet_on_disc/solve.py        # some minutes

Units: radius and speed of the jet are 1. x points along the jet, r is the distance from the axis, phi the potential, psi the stream
function (u = dpsi/dr / r). With phi and psi as coordinates the fluid fills a strip, -inf < phi < inf, 0 < psi < 1/2, so that the free
surfaces are not searched for. The unknown is s = r^2/2. From the definitions of phi and psi,

    dx/dphi = ds/dpsi,    ds/dphi = -2 s dx/dpsi,    hence  d/dphi (d ln s/dphi) / 2 + d^2 s/dpsi^2 = 0,

and 1/q^2 = (ds/dpsi)^2 + (ds/dphi)^2 / (2 s) for the speed q. Boundaries:

    psi = 1/2                 outer free surface     q = 1
    psi = 0, phi < 0          axis                   s = 0         (the stagnation point is phi = 0)
    psi = 0, 0 < phi < phi_e  disc, x = const        ds/dpsi = 0
    psi = 0, phi_e < phi      inner free surface     q = 1
    phi -> -inf               jet                    s = psi
    phi -> +inf               sheet                  q = 1

At the edge, phi_e, the fluid leaves the disc smoothly: q rises to 1 like 1 - c sqrt(phi_e - phi). phi_e is given; the radius of the disc
follows. Finite volumes on a grid that is refined towards the stagnation point and the edge; Newton's method in ln s.

Two forces, equal for the exact flow: from the pressure on the disc, and from the momentum of the sheet, pi (1 - cos theta).
"""

import csv
import pathlib

import numpy as np
import scipy.interpolate
import scipy.sparse
import scipy.sparse.linalg

UPSTREAM, DOWNSTREAM = 4.0, 6.0  # length of jet and sheet; both have settled to 1e-4 long before
FLUX = 0.5                       # psi at the outer surface


def graded_faces(length, first, growth, largest):
    """Faces of cells from 0 to `length`; their sizes grow from `first` to at most `largest`."""
    sizes = [first]
    while sum(sizes) < length:
        sizes.append(min(sizes[-1] * growth, largest))
    faces = np.concatenate([[0.0], np.cumsum(sizes)])
    return faces * length / faces[-1]


class Grid:
    """Cells in phi and psi, `refinement` times as fine as the coarsest grid that is of use."""

    def __init__(self, edge, refinement):
        growth, largest, first = 1.0 + 0.3 / refinement, 0.12 / refinement, 2e-4 * min(1.0, edge) / refinement
        disc = np.concatenate([graded_faces(0.5 * edge, 3.0 * first, growth, largest), edge - graded_faces(0.5 * edge, first, growth, largest)[-2::-1]])
        self.edge = edge
        self.phi_faces = np.concatenate([-graded_faces(UPSTREAM, 3.0 * first, growth, largest)[:0:-1], disc, edge + graded_faces(DOWNSTREAM, first, growth, largest)[1:]])
        self.psi_faces = graded_faces(FLUX, 0.3 * first, growth, 0.25 * largest)
        self.phi, self.psi = 0.5 * (self.phi_faces[1:] + self.phi_faces[:-1]), 0.5 * (self.psi_faces[1:] + self.psi_faces[:-1])
        self.levels = np.concatenate([[0.0], self.psi, [FLUX]])  # where s is known in psi: both boundaries and the cells
        self.axis, self.free = self.phi < 0.0, self.phi > edge
        self.disc = ~self.axis & ~self.free
        self.first_free = int(np.argmax(self.free))


def slope_at_end(x, y):
    """dy/dx at x[0], second order, from three points."""
    h, k = x[1] - x[0], x[2] - x[0]
    return (y[1] - y[0]) * k / (h * (k - h)) - (y[2] - y[0]) * h / (k * (k - h))


def slope_from_upstream(grid, y, start, two_points=()):
    """dy/dphi at the cells from those upstream: second order, first order in the cells `two_points`. start: y where the grid begins."""
    x, slope = grid.phi, np.empty_like(y)
    h, k = x[2:] - x[1:-1], x[2:] - x[:-2]
    slope[2:] = ((y[2:] - y[1:-1]) * k / h - (y[2:] - y[:-2]) * h / k) / (k - h)
    slope[0], slope[1] = (y[0] - start) / (x[0] - grid.phi_faces[0]), (y[1] - y[0]) / (x[1] - x[0])
    for i in two_points:
        slope[i] = (y[i] - y[i - 1]) / (x[i] - x[i - 1])
    return slope


def speed_condition(along, across, s):
    """0 where the speed is 1 and r grows. along: ds/dphi; across: ds/dpsi"""
    return across**2 + np.sign(along.real) * along**2 / (2.0 * s) - 1.0


def separation_condition(grid, s):
    """0 if q -> 1 at the edge: there r = a - d - c d^1.5 on the disc, with d = phi_e - phi, a and c from the last three cells."""
    cells = slice(grid.first_free - 3, grid.first_free)
    d, r = (grid.edge - grid.phi[cells])[::-1], np.sqrt(2.0 * s[cells])[::-1]
    excess, root = (r[:-1] - r[1:]) / np.diff(d) - 1.0, np.diff(d**1.5) / np.diff(d)
    return (excess[0] * root[1] - excess[1] * root[0]) / (root[1] - root[0])


def residual(grid, s):
    """What is left of the equations. s: (cells in phi, 2 + cells in psi), of the lower boundary, the cells, and the upper boundary"""
    lower, inner, upper = s[:, 0], s[:, 1:-1], s[:, -1]
    across_lower, across_upper = slope_at_end(grid.levels, s.T), slope_at_end(grid.levels[::-1], s.T[::-1])
    across = np.empty((inner.shape[0], inner.shape[1] + 1), s.dtype)  # ds/dpsi through the faces
    across[:, 1:-1] = np.diff(inner, axis=1) / np.diff(grid.psi)
    across[:, 0], across[:, -1] = np.where(grid.disc, 0.0, across_lower), across_upper
    along = np.empty((inner.shape[0] + 1, inner.shape[1]), s.dtype)  # -dx/dpsi through the faces
    along[1:-1] = 0.5 * np.diff(np.log(inner), axis=0) / np.diff(grid.phi)[:, None]
    along[0] = 0.5 * (np.log(inner[0]) - np.log(grid.psi)) / (grid.phi[0] - grid.phi_faces[0])
    along[-1] = np.sqrt((1.0 - 0.25 * (across[-1, 1:] + across[-1, :-1]) ** 2) / (2.0 * inner[-1]))
    left = np.empty_like(s)
    left[:, 1:-1] = np.diff(along, axis=0) * np.diff(grid.psi_faces) + np.diff(across, axis=1) * np.diff(grid.phi_faces)[:, None]
    left[:, -1] = speed_condition(slope_from_upstream(grid, upper, FLUX), across_upper, upper)
    left[:, 0] = np.where(grid.axis, lower, across_lower)
    free = grid.free
    left[free, 0] = speed_condition(slope_from_upstream(grid, lower, 0.0, [grid.first_free + 1]), across_lower, np.where(free, lower, 1.0))[free]
    left[grid.first_free, 0] = separation_condition(grid, lower)
    return left


def jacobian(grid, s):
    """d residual / d s by complex steps. A residual depends on s from three cells before to one behind it in phi, two to each side in psi."""
    number, step, parts = np.arange(s.size).reshape(s.shape), 1e-30, []
    place = np.indices(s.shape) % 5
    for colour in np.ndindex(5, 5):
        change = residual(grid, s + 1j * step * ((place[0] == colour[0]) & (place[1] == colour[1]))).imag / step
        i, j = np.nonzero(change)
        column = number[i + (colour[0] - i + 3) % 5 - 3, j + (colour[1] - j + 2) % 5 - 2]
        parts.append((change[i, j], number[i, j], column))
    values, rows, columns = (np.concatenate(p) for p in zip(*parts))
    return scipy.sparse.csc_matrix((values, (rows, columns)), (s.size, s.size))


def solve(grid, s):
    """Newton's method in ln s, from a guess. ArithmeticError if it does not converge."""
    s = s.copy()
    s[grid.axis, 0] = 0.0
    scale = np.where(s > 0.0, s, 1.0)
    for _ in range(60):
        left = residual(grid, s)
        scale = np.where(s > 0.0, s, 1.0)
        step = scipy.sparse.linalg.spsolve((jacobian(grid, s) @ scipy.sparse.diags(scale.ravel())).tocsc(), -left.ravel()).reshape(s.shape)
        if np.abs(step).max() < 1e-8:
            return s
        share = min(1.0, 1.0 / np.abs(step).max())
        with np.errstate(all="ignore"):
            while share > 1e-2 and not np.linalg.norm(residual(grid, s * np.exp(share * step))) < (1.0 - 0.1 * share) * np.linalg.norm(left):
                share *= 0.5
        s = s * np.exp(share * step)
    raise ArithmeticError(f"no convergence for phi_e = {grid.edge}")


def first_guess(grid, radius, angle):
    """A straight sheet at `angle` from a disc of about `radius`."""
    phi = grid.phi[:, None]
    lower = np.where(phi < 0.0, 0.0, np.where(phi < grid.edge, 0.5 * radius**2 * phi / grid.edge, 0.5 * (radius + (phi - grid.edge) * np.sin(angle)) ** 2))
    slope = np.interp(phi, [-0.5, grid.edge], [1.0, np.cos(angle)])
    return lower + slope * grid.levels + 1e-9 * (grid.levels > 0.0)


def carried_over(old, s, new):
    """s of one grid as a guess for another."""
    phi = np.interp(new.phi, [-UPSTREAM, 0.0, new.edge, new.edge + DOWNSTREAM], [-UPSTREAM, 0.0, old.edge, old.edge + DOWNSTREAM])
    points = np.stack(np.meshgrid(phi, new.levels, indexing="ij"), axis=-1)
    return np.maximum(scipy.interpolate.RegularGridInterpolator((old.phi, old.levels), s, bounds_error=False, fill_value=None)(points), 1e-9)


def results(grid, s):
    """Radius of the disc, force from the pressure over that of the jet's momentum, cosine of the sheet's angle."""
    i = grid.first_free
    edge = np.interp(grid.edge, grid.phi[i - 1:i + 1], s[i - 1:i + 1, 0])
    on_disc, phi = np.concatenate([[0.0], s[grid.disc, 0], [edge]]), np.concatenate([[0.0], grid.phi[grid.disc], [grid.edge]])
    middle = 0.5 * (on_disc[1:] + on_disc[:-1])  # pressure (1 - q^2)/2, q^2 = 2 s / (ds/dphi)^2, on the area 2 pi ds; the jet has pi
    force = edge - np.sum(2.0 * middle * np.diff(phi) ** 2 / np.diff(on_disc))
    return np.array([np.sqrt(2.0 * edge), force, (s[-20, -1] - s[-20, 0]) / FLUX])


def limit(values):
    """Values at refinements 1, 2, 4, ... extrapolated with the second order of the scheme, and the distance from the finest value."""
    extrapolated = values[-1] + (values[-1] - values[-2]) / 3.0
    return extrapolated, np.abs(extrapolated - values[-1])


def main():
    grid = Grid(1.0, 0.25)
    s = solve(grid, first_guess(grid, 1.5, np.radians(70.0)))
    coarse = Grid(1.0, 0.5)
    at_one = coarse, solve(coarse, carried_over(grid, s, coarse))
    rows = []
    for edges in (0.8 ** np.arange(9), 1.25 ** np.arange(1, 6)):
        grid, s = at_one
        for edge in edges:
            new = Grid(edge, 0.5)
            s, grid = solve(new, carried_over(grid, s, new)), new
            finer, t, found = grid, s, []
            for refinement in (1, 2, 4):
                new = Grid(edge, refinement)
                t, finer = solve(new, carried_over(finer, t, new)), new
                found.append(results(finer, t))
            (radius, force, cosine), change = limit(found)
            rows.append([radius, 1.0 - cosine, force, np.degrees(np.arccos(cosine)), 2.0 * force / radius**2, np.abs(force / (1.0 - cosine) - 1.0),
                         change[2] / (1.0 - cosine), change[0] / radius])
            print(f"phi_e {edge:.4f}: d/D {radius:.5f}", *(f"{f[0]:.5f} {f[1]:.5f} {1.0 - f[2]:.5f};" for f in found), *(f"{v:.6g}" for v in rows[-1]), flush=True)
    with open(pathlib.Path(__file__).with_name("data.csv"), "w", encoding="utf-8", newline="") as file:
        table = csv.writer(file, lineterminator="\n")
        table.writerow(["d_over_D", "force", "force_from_pressure", "angle_deg", "drag_coefficient", "apart", "change_of_force", "change_of_d"])
        table.writerows([[f"{v:.6g}" for v in row] for row in sorted(rows)])


if __name__ == "__main__":
    main()
