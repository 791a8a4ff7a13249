"""The uneven ground of a case: its raster as an array."""

import numpy as np


class Terrain:
    """Heights of [terrain] raster. x, y: coordinates of its columns and rows, m; height[j, i] at x[i], y[j], m."""

    def __init__(self, raster):
        words = raster.split()
        header = sum(word[0].isalpha() and word != "nan" for word in words)  # each with its number
        head = dict(zip(words[:2 * header:2], words[1:2 * header:2]))
        columns, rows = int(head["ncols"]), int(head["nrows"])
        x, y, spacing = (float(head[name]) for name in ("xllcenter", "yllcenter", "cellsize"))
        self.x, self.y = x + spacing * np.arange(columns), y + spacing * np.arange(rows)
        self.height = np.array(words[2 * header:], float).reshape(rows, columns)[::-1]  # the text begins in the north

    def section(self, y=0.0):
        """Heights along x on the line of this y, linear between rows, m."""
        return np.array([np.interp(y, self.y, column) for column in self.height.T])


def terrain_of(run):
    """The Terrain of a Run; None where its ground is level."""
    raster = run.case.get("terrain", {}).get("raster")
    return Terrain(raster) if raster else None
