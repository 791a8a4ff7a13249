"""Coordinate systems of rasters: they must be in metres, and the same for elevation and results."""

import re

from mpmtools.errors import InputError

try:
    import rasterio
except ImportError:
    rasterio = None

UNIT = re.compile(r'\b(LENGTH|ANGLE|SCALE)?UNIT\["([^"]*)",\s*([-+.\deE]+)', re.IGNORECASE)  # of WKT 1 and 2
ANGLE = re.compile(r"deg|rad|gra?d|gon|unity", re.IGNORECASE)
METRE = re.compile(r"met(re|er)s?$|m$", re.IGNORECASE)
GEOGRAPHIC = re.compile(r"\s*GEO(G|D|GRAPHIC|DETIC)(CRS|CS)", re.IGNORECASE)


def check_metres(wkt, path):
    """Coordinates and, where it names them, heights are metres. @param wkt  text of the coordinate system, @param path of the file that has it"""
    plan = horizontal(wkt)
    if GEOGRAPHIC.match(plan):
        raise InputError(f"{path}: the coordinates are degrees; reproject the raster to a system in metres")
    for what, part in (("coordinates", plan), ("heights", wkt.replace(plan, "", 1))):
        for kind, name, factor in UNIT.findall(part):
            if kind.upper() not in ("ANGLE", "SCALE") and not ANGLE.match(name) and not (METRE.match(name) and float(factor) == 1.0):
                raise InputError(f"{path}: the unit of the {what} is {name}; convert the raster to metres (gdalwarp -t_srs EPSG:25832, with the "
                                 "number of your system; heights with gdal_calc.py)")


def horizontal(wkt):
    """The system of the coordinates in plan: the first of a compound system, and of those that ESRI's programs write one after the other."""
    first = re.match(r'\s*(COMP(D_?CS|OUNDCRS)\["[^"]*",\s*)?', wkt, re.IGNORECASE).end()
    depth = 0
    for at in range(first, len(wkt)):
        depth += (wkt[at] == "[") - (wkt[at] == "]")
        if depth == 0 and wkt[at] == "]":
            return wkt[first:at + 1]
    return wkt


def same(one, other):
    """Whether two texts name one system in plan, by rasterio; where it is missing, by the texts without blanks and cases."""
    one, other = horizontal(one), horizontal(other)
    plain = [re.sub(r"\s", "", wkt).lower() for wkt in (one, other)]
    if plain[0] == plain[1]:
        return True
    if rasterio is None:
        return False
    try:
        a, b = (rasterio.crs.CRS.from_user_input(wkt, morph_from_esri_dialect=True) for wkt in (one, other))
    except rasterio.errors.CRSError:
        return False
    return a == b or (a.to_epsg() is not None and a.to_epsg() == b.to_epsg())


def check_same(grids):
    """Elevation and results lie in one system. @param grids  that of the elevation first @return lines for the user"""
    named = {}
    for grid in grids:
        if grid.projection:
            named.setdefault(grid.projection, grid)
    first = next(iter(named.values()), None)
    for wkt, grid in named.items():
        if not same(wkt, first.projection):
            only_text = "" if rasterio else (" (compared as text, since Debian's python3-rasterio is missing; two spellings of one system are told apart "
                                             "only with it)")
            raise InputError(f"{grid.path} and {first.path} have different projections; reproject one of them{only_text}")
    if first is None:
        return [f"no projection is stated for {grids[0].path} or the other rasters: their coordinates are taken to be metres in one system; "
                "put a .prj with the projection beside the DEM and the results to have this checked"]
    unnamed = [grid for grid in grids if not grid.projection]
    for grid in unnamed:
        if not grid.lies_on(first):
            raise InputError(f"{first.path} states its projection, {grid.path} does not, and its grid is another one: they may lie in different "
                             "projections; put the .prj of its projection beside it")
    return [f"{first.path} states its projection; {unnamed[0].path}{' and others' * (len(unnamed) > 1)} do not, but lie on the same grid: taken "
            "to have the same"] if unnamed else []
