"""Rasters with square cells and north up: ESRI ASCII grids, and GeoTIFF by rasterio."""

import os
from typing import NamedTuple

import numpy as np

from mpmtools.avaframe.projection import check_metres, rasterio
from mpmtools.errors import ConfigError, InputError
from mpmtools.files import read_text

FINEST = 0.02  # m, of the cells of a raster: below, the unit is wrong
LARGEST = 1e30  # a value beyond is the missing one of a program that does not say so
LOWEST_GROUND = -1000.0  # m: below, an elevation is missing data
CLIFF = 1.8  # a step of more than 61 degrees from all cells around cells of zero: the zeros are missing data


class Grid(NamedTuple):
    """Where a raster lies."""

    x0: float  # m: centre of the south-western cell
    y0: float
    cell_size: float  # m
    path: str
    projection: str = ""  # WKT; empty: not stated

    def lies_on(self, other):
        """Whether the south-western corners agree within a cell, as those of com1DFA's results and its DEM do."""
        cell = max(self.cell_size, other.cell_size)
        return abs(self.x0 - other.x0) <= cell and abs(self.y0 - other.y0) <= cell


class Raster:
    """Values on a grid. data[0] is the northern row; NaN: no data."""

    def __init__(self, data, grid):
        self.data, self.grid = data, grid

    def values(self, x, y):
        """Bilinear between cell centres; NaN outside, and beside cells without data. @param x, y  arrays of one shape, m"""
        rows, columns = self.data.shape
        i, j = (np.asarray(x, float) - self.grid.x0) / self.grid.cell_size, (np.asarray(y, float) - self.grid.y0) / self.grid.cell_size
        inside = (i >= 0.0) & (i <= columns - 1) & (j >= 0.0) & (j <= rows - 1)
        left, below = (np.clip(np.nan_to_num(k), 0, n - 2).astype(int) for k, n in ((i, columns), (j, rows)))
        a, b = i - left, j - below
        total = np.where(inside, 0.0, np.nan)
        for row, column, weight in ((0, 0, (1 - a) * (1 - b)), (0, 1, a * (1 - b)), (1, 0, (1 - a) * b), (1, 1, a * b)):
            total += np.where(inside & (weight != 0.0), weight * self.data[rows - 1 - below - row, left + column], 0.0)
        return total

    def at(self, x, y):
        """values() at one point. @throws ConfigError for points outside"""
        g, (rows, columns) = self.grid, self.data.shape
        east, north = g.x0 + (columns - 1) * g.cell_size, g.y0 + (rows - 1) * g.cell_size
        if not (g.x0 <= x <= east and g.y0 <= y <= north):
            raise ConfigError(f"--at {place(x, y)} is outside {g.path}, which covers x from {g.x0:.12g} to {east:.12g} and y from {g.y0:.12g} to "
                              f"{north:.12g}; give coordinates in the system of the raster")
        return float(self.values(x, y))

    def points(self):
        """(x, y, value) of all cell centres, m."""
        rows, columns = self.data.shape
        x, y = np.meshgrid(self.grid.x0 + self.grid.cell_size * np.arange(columns), self.grid.y0 + self.grid.cell_size * np.arange(rows)[::-1])
        return x, y, self.data

    def around(self, x, y, reach):
        """The part within `reach`, m, of a point along both axes, as a Raster."""
        g, rows = self.grid, len(self.data)
        west, south = (max(0, int((at - reach - first) / g.cell_size)) for at, first in ((x, g.x0), (y, g.y0)))
        east, north = (int((at + reach - first) / g.cell_size) + 2 for at, first in ((x, g.x0), (y, g.y0)))
        data = self.data[max(0, rows - north):rows - south, west:east]
        return Raster(data.copy(), g._replace(x0=g.x0 + west * g.cell_size, y0=g.y0 + south * g.cell_size))


def place(x, y):
    """A point with the digits that a user gave."""
    return f"{x:.12g},{y:.12g}"


def check_raster(raster):
    if not raster.grid.cell_size >= FINEST:
        raise InputError(f"{raster.grid.path}: its cells are {raster.grid.cell_size:g} wide, which are degrees or kilometres, no metres; reproject it to a "
                         "system in metres")
    if min(raster.data.shape) < 2:
        raise InputError(f"{raster.grid.path}: {raster.data.shape[0]} x {raster.data.shape[1]} cells; 2 x 2 are needed, export the raster again")
    raster.data[~(np.abs(raster.data) < LARGEST)] = np.nan
    return raster


def header_of(lines, path):
    """({entry: number}, index of the first line behind it) of an ESRI ASCII grid."""
    header = {}
    for number, line in enumerate(lines):
        words = line.split()
        if len(words) != 2 or not words[0][0].isalpha() or words[0].lower() == "nan":
            break
        try:
            header[words[0].lower()] = float(words[1])
        except ValueError:
            raise InputError(f"{path}:{number + 1}: '{line.strip()}' is no entry of the header; export the raster again") from None
    else:
        number = len(lines)
    if "cellsize" not in header and {"dx", "dy"} <= set(header):  # which GIS programs write in its place
        if abs(header["dx"] - header["dy"]) > 1e-6 * abs(header["dx"]):
            raise InputError(f"{path}: its cells are {header['dx']:g} x {header['dy']:g}; resample it to square ones")
        header["cellsize"] = header["dx"]
    return header, number


def projection_beside(path):
    """Text of the file NAME.prj beside an ASCII grid, which itself names no system; empty: there is none."""
    beside = os.path.splitext(path)[0] + ".prj"
    text = " ".join(read_text(beside).split()) if os.path.exists(beside) else ""
    check_metres(text, beside)
    return text


def read_ascii(path):
    lines = read_text(path).splitlines()
    header, start = header_of(lines, path)
    missing = [key for key in ("ncols", "nrows", "cellsize") if key not in header]
    missing += [f"{axis}llcorner" for axis in "xy" if f"{axis}llcenter" not in header and f"{axis}llcorner" not in header]
    if missing:
        raise InputError(f"{path}: the header has no {', '.join(missing)}; is it an ESRI ASCII grid?")
    try:
        values = np.array(" ".join(lines[start:]).split(), float)
    except ValueError as error:
        raise InputError(f"{path}: {error}; export the raster again") from None
    rows, columns, cell = int(header["nrows"]), int(header["ncols"]), header["cellsize"]
    if values.size != rows * columns:
        raise InputError(f"{path}: {values.size} values, {rows} x {columns} are needed; the file is cut off, export it again")
    values[values == header.get("nodata_value", -9999.0)] = np.nan
    corner = [header[f"{axis}llcenter"] if f"{axis}llcenter" in header else header[f"{axis}llcorner"] + 0.5 * cell for axis in "xy"]
    return check_raster(Raster(values.reshape(rows, columns), Grid(*corner, cell, path, projection_beside(path))))


def read_geotiff(path):
    if rasterio is None:
        raise InputError(f"{path}: Debian's python3-rasterio is needed for GeoTIFF; install it, or export ESRI ASCII grids")
    try:
        with rasterio.open(path) as file:
            data = file.read(1, masked=True).astype(float).filled(np.nan)
            transform, projection, unit = file.transform, file.crs, file.units[0]
    except rasterio.errors.RasterioError as error:
        raise InputError(f"cannot read '{path}': {error}") from None
    if projection is None:
        raise InputError(f"{path}: it names no projection, so that its unit is not known; set it (gdal_edit.py -a_srs EPSG:25832 {path}, with "
                         "the number of your system)")
    check_metres(projection.wkt, path)
    if unit and ("ft" in unit.lower() or "foot" in unit.lower() or "feet" in unit.lower()):
        raise InputError(f"{path}: the unit of the values is {unit}; convert them to metres (gdal_calc.py)")
    if transform.b or transform.d or abs(transform.a + transform.e) > 1e-6 * transform.a:
        raise InputError(f"{path}: its cells are turned or not square; resample it with north up")
    return check_raster(Raster(data, Grid(transform.c + 0.5 * transform.a, transform.f + (data.shape[0] - 0.5) * transform.e, transform.a, path,
                                          projection.wkt)))


def read_raster(path):
    return read_geotiff(path) if path.lower().endswith((".tif", ".tiff")) else read_ascii(path)


def read_elevation(path):
    """(Raster, lines for the user). Zeros that all cells around them are far above or below are missing data."""
    dem = read_raster(path)
    dem.data[dem.data < LOWEST_GROUND] = np.nan
    zero = dem.data == 0.0
    steps = np.concatenate([np.abs(np.diff(dem.data, axis=axis))[np.diff(zero, axis=axis)] for axis in (0, 1)])  # from or to a zero
    steps = steps[np.isfinite(steps)]
    if not zero.any() or not steps.size or steps.min() < CLIFF * dem.grid.cell_size:
        return dem, []
    dem.data[zero] = np.nan
    return dem, [f"{path}: {np.count_nonzero(zero)} cells are exactly 0, at least {steps.min():.3g} m from their neighbours: taken as missing data"]
