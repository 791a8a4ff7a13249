"""The uneven ground of a case: its raster as an array, and its heights between the points."""

import numpy as np

FINER = 4  # intervals of a mesh in one of the raster: flat faces are then 16 times nearer to the cubic
LARGEST = 160  # intervals of a mesh along an axis


def cubic_weights(places, points):
    """Weights (places, points) of the solver's interpolation along one axis (libmpm/boundary/terrain.hpp).

    Catmull-Rom's cubic, and beyond the ends a line with its slope there. @param points  two or more, evenly spaced
    """
    count = len(points)
    at = (np.asarray(places, float) - points[0]) / (points[1] - points[0])
    inside = np.clip(at, 0.0, count - 1)
    first = np.minimum(inside.astype(int), count - 2)
    f, beyond = inside - first, at - inside
    values = [0.5 * f * (-1.0 + f * (2.0 - f)), 1.0 + 0.5 * f**2 * (3.0 * f - 5.0),
              0.5 * f * (1.0 + f * (4.0 - 3.0 * f)), 0.5 * f**2 * (f - 1.0)]
    slopes = [-0.5 + f * (2.0 - 1.5 * f), f * (4.5 * f - 5.0), 0.5 + f * (4.0 - 4.5 * f), f * (1.5 * f - 1.0)]
    # With a point beyond each end, on the line through the last two.
    weights, rows = np.zeros((len(at), count + 2)), np.arange(len(at))
    for k in range(4):
        weights[rows, first + k] = values[k] + slopes[k] * beyond
    weights[:, 1:3] += weights[:, :1] * [2.0, -1.0]
    weights[:, -3:-1] += weights[:, -1:] * [-1.0, 2.0]
    return weights[:, 1:-1]


def crossing(beyond, near, far, halvings):
    """Where many ways pass a surface, by bisection; the end beyond it. @param beyond  function of ways; false at `near`, true at `far`"""
    for _ in range(halvings):
        middle = 0.5 * (near + far)
        passed = beyond(middle)
        near, far = np.where(passed, near, middle), np.where(passed, middle, far)
    return far


class Terrain:
    """Heights of [terrain] raster. x, y: coordinates of its columns and rows, m; height[j, i] at x[i], y[j], m."""

    def __init__(self, raster):
        words = raster.split()
        header = sum(word[0].isalpha() and word != "nan" for word in words)  # each with its number
        head = dict(zip(words[:2 * header:2], words[1:2 * header:2]))
        columns, rows = int(head["ncols"]), int(head["nrows"])
        x, y, spacing = (float(head[name]) for name in ("xllcenter", "yllcenter", "cellsize"))
        self.x, self.y, self.spacing = x + spacing * np.arange(columns), y + spacing * np.arange(rows), spacing
        self.height = np.array(words[2 * header:], float).reshape(rows, columns)[::-1]  # the text begins in the north

    def heights(self, x, y):
        """Heights [j, i] at x[i], y[j], m, as the solver has them: cubics between the points."""
        return cubic_weights(y, self.y) @ self.height @ cubic_weights(x, self.x).T

    def section(self, y=0.0):
        """Heights along x on the line of this y, m."""
        return self.heights(self.x, [y])[0]

    def mesh(self, low, high):
        """(x, y, heights [j, i]) for a picture of the ground over a box in plan, m.

        Finer than the raster where the box is small, coarser where it is large. @param low, high  corners (x, y), m
        """
        def places(a, b):
            return np.linspace(a, b, int(np.clip(np.ceil(FINER * (b - a) / self.spacing), 1, LARGEST)) + 1)

        x, y = places(low[0], high[0]), places(low[1], high[1])
        return x, y, self.heights(x, y)

    def foot(self, outline):
        """The lowest ground around a solid, m: where its sides begin in a picture. @param outline  corners (x, y), m"""
        return float(self.mesh(np.min(outline, axis=0), np.max(outline, axis=0))[2].min())


def terrain_of(run):
    """The Terrain of a Run; None where its ground is level."""
    raster = run.case.get("terrain.raster")
    return Terrain(raster) if raster else None
