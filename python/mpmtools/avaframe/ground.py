"""The ground in the window of a case: a plane, and the relief over it in the frame of this plane.

The frame: origin at the foot of the mast, x along the plane in the direction of flow, y to its left, z normal to the plane.
"""

import math
from typing import NamedTuple

import numpy as np

from mpmtools.avaframe.rasters import place
from mpmtools.errors import ConfigError, InputError
from mpmtools.terrain import Terrain, crossing, cubic_weights

STEEPEST = 60.0  # degrees: beyond, the unit is wrong
STEEPEST_RELIEF = 30.0  # degrees, of the relief over the plane: libmpm/boundary/terrain.hpp
TOLERANCE = 0.01  # m, of terrain.asc from the DEM
FINEST = 4.0  # cells of the grid: points of terrain.asc that are nearer make waves that the grid does not resolve (docs/cases.md)
ROUNDS = 60  # halvings: each interval is then shorter than 1e-15 of the first


class Window(NamedTuple):
    """A rectangle in the frame, m."""

    low: tuple
    high: tuple

    def grown(self, by):
        return Window(tuple(a - by for a in self.low), tuple(b + by for b in self.high))

    def points(self, spacing):
        """(x, y) arrays of regular points that cover it, and at least three along each axis."""
        counts = [max(3, math.ceil((b - a) / spacing - 1e-9) + 1) for a, b in zip(self.low, self.high)]
        return np.meshgrid(*(a + spacing * np.arange(count) for a, count in zip(self.low, counts)))


class Plane(NamedTuple):
    """A plane through the ground at the mast."""

    foot: np.ndarray  # x, y, z of the map, m
    frame: np.ndarray  # rows: unit vectors of the frame, in the map

    @property
    def slope(self):
        """rad"""
        return math.acos(min(1.0, self.frame[2, 2]))

    @property
    def fall(self):
        """Direction of its steepest descent, rad from east."""
        return math.atan2(self.frame[2, 1], self.frame[2, 0])

    def inclination(self, axis):
        """By how much it falls along x (0), or to the left (1), rad."""
        return -math.asin(self.frame[axis, 2])

    def to_map(self, x, y, z):
        """Map coordinates (3, ...) of points of the frame."""
        return np.tensordot(self.frame.T, np.stack(np.broadcast_arrays(x, y, z)), 1) + self.foot.reshape(3, *[1] * np.ndim(x))


def local_fall(dem, x, y):
    """Direction of the steepest descent at a point, rad from east; over two cells."""
    h = dem.grid.cell_size
    dem.at(x, y)  # says where the raster ends
    gx, gy = dem.values(x + h, y) - dem.values(x - h, y), dem.values(x, y + h) - dem.values(x, y - h)
    if not (math.isfinite(gx) and math.isfinite(gy)):
        raise ConfigError(f"{dem.grid.path}: no elevation at {place(x, y)}; give a point inside the terrain")
    return math.atan2(-gy, -gx)


def plane_at(dem, x, y, direction, window):
    """The Plane that fits the ground in a window best (least squares), turned so that x points in a direction, rad from east.

    The window covers at least three cells of the DEM along both axes.
    """
    cell = dem.grid.cell_size
    low, high = np.array(window)
    centre, half = 0.5 * (low + high), np.maximum(0.5 * (high - low), 1.5 * cell)
    wide = Window(tuple(centre - half), tuple(centre + half))
    a, b = (points.ravel() for points in wide.points(min(0.5 * cell, 0.25 * min(half))))
    c, s = math.cos(direction), math.sin(direction)
    z, here = dem.values(x + a * c - b * s, y + a * s + b * c), dem.at(x, y)
    known = np.isfinite(z)
    if not math.isfinite(here) or np.count_nonzero(known) < 0.5 * z.size:
        raise ConfigError(f"{dem.grid.path}: no elevation at {place(x, y)}, or at less than half of the {2 * half[0]:.3g} m along and "
                          f"{2 * half[1]:.3g} m across the flow there; give a point inside the terrain")
    _, along, left = np.linalg.lstsq(np.column_stack([np.ones(z.size), a, b])[known], z[known], rcond=None)[0]
    slope = math.degrees(math.atan(math.hypot(along, left)))
    if slope > STEEPEST:
        raise InputError(f"{dem.grid.path}: the ground at {place(x, y)} is {slope:.0f} degrees steep, more than {STEEPEST:g}; check that elevation "
                         "and coordinates have the same unit, metres, and that missing data are marked")
    normal = np.array([-along * c + left * s, -along * s - left * c, 1.0])
    ahead = np.array([c, s, along])
    normal, ahead = normal / np.linalg.norm(normal), ahead / np.linalg.norm(ahead)
    return Plane(np.array([x, y, here]), np.array([ahead, np.cross(normal, ahead), normal]))


def heights_over(dem, plane, x, y):
    """Heights of the ground over the plane, normal to it, at points of the plane; NaN where the DEM does not reach.

    The ground nearest to the plane along its normal: a step from the plane towards the ground that grows until it is crossed, then halvings.
    """
    def above(z):  # vertical distance of the place from the ground
        at = plane.to_map(x, y, z)
        return at[2] - dem.values(at[0], at[1])

    near = np.zeros(np.shape(x))
    first = above(near)
    way = -first * plane.frame[2, 2]
    far = near + way
    for _ in range(ROUNDS):
        short = above(far) * first > 0.0
        if not short.any():
            break
        near, far = np.where(short, far, near), np.where(short, far + 0.5 * way, far)
    far = crossing(lambda z: above(z) * first <= 0.0, near, far, ROUNDS)
    return np.where(np.abs(above(far)) <= 0.1 * TOLERANCE, far, np.nan)


class Relief(NamedTuple):
    """Uneven ground of a case as terrain.asc."""

    text: str  # of the file
    spacing: float  # m
    steepest: float  # degrees, of the ground as the solver has it
    lowest: float  # m over the plane
    highest: float
    off: float  # m: largest distance of the DEM's own points in the window from it


def grid_text(heights, low, spacing):
    """An ESRI ASCII grid in the coordinates of the case."""
    head = f"ncols {heights.shape[1]}\nnrows {heights.shape[0]}\nxllcenter {low[0]:.9g}\nyllcenter {low[1]:.9g}\ncellsize {spacing:.9g}\n"
    return head + "\n".join(" ".join(f"{h:.4f}" for h in row) for row in heights[::-1]) + "\n"


def steepest_slope(surface, window):
    """Degrees; at places half as far apart as the points, as the solver looks for it."""
    x, y = (np.linspace(a, b, math.ceil(2.0 * (b - a) / surface.spacing) + 1) for a, b in zip(window.low, window.high))
    d = 1e-4 * surface.spacing
    slopes = [surface.heights(x + d, y) - surface.heights(x - d, y), surface.heights(x, y + d) - surface.heights(x, y - d)]
    return math.degrees(math.atan(np.max(np.hypot(*slopes)) / (2.0 * d)))


def distance_of_points(dem, plane, surface, window):
    """The largest distance from the surface of the DEM's own points in a window, m."""
    reach = max(map(abs, (*window.low, *window.high))) * 1.5
    x, y, z = (values.ravel() for values in dem.around(*plane.foot[:2], reach).points())
    a, b, h = plane.frame @ (np.stack([x, y, z]) - plane.foot[:, None])
    inside = (a >= window.low[0]) & (a <= window.high[0]) & (b >= window.low[1]) & (b <= window.high[1]) & np.isfinite(h)
    along, across = cubic_weights(a[inside], surface.x), cubic_weights(b[inside], surface.y)
    return float(np.max(np.abs(np.einsum("nj,ji,ni->n", across, surface.height, along) - h[inside]), initial=0.0))


def relief_over(dem, plane, window, cell):
    """The Relief in a window; None where the DEM does not cover it. @param cell  m, of the case

    Its points are those of the DEM's spacing, and nearer where the ground turns between them, as far as the grid resolves it.
    """
    spacing = max(dem.grid.cell_size, cell)
    while True:
        x, y = window.points(spacing)
        heights = heights_over(dem, plane, x, y)
        if not np.isfinite(heights).all():
            return None
        text = grid_text(heights, window.low, spacing)
        surface = Terrain(text)
        off = distance_of_points(dem, plane, surface, window)
        if off <= TOLERANCE or 0.5 * spacing < FINEST * cell:
            return Relief(text, spacing, steepest_slope(surface, window), heights.min(), heights.max(), off)
        spacing *= 0.5
