"""An avalanche of AvaFrame's com1DFA as the inflow of a case: depth and speed over time at one point of its rasters.

com1DFA writes, for each exported time step, DIR/Outputs/com1DFA/peakFiles/timeSteps/NAME_FT_t12.00.asc (flow thickness, m, normal to the
ground) and NAME_FV_t12.00.asc (speed, m/s), as ESRI ASCII grids or GeoTIFF, on the grid of the DEM in DIR/Inputs. Older versions call the
thickness FD.
"""

import math
import os
import re
from typing import NamedTuple

import numpy as np

from mpmtools.errors import ConfigError, InputError
from mpmtools.equations import STANDARD_GRAVITY
from mpmtools.files import read_text, write_text

NAME = re.compile(r"^(?P<simulation>.+)_(?P<quantity>FT|FD|FV)_t(?P<time>\d+(?:\.\d+)?)\.(?:asc|tif|tiff)$", re.IGNORECASE)
EXPORT = "in com1DFACfg.ini, [GENERAL], set resType = ppr|pft|pfv|FT|FV and tSteps = 0:1 (every second), and run com1DFA again"
LEAST_DEPTH = 0.1  # m: below, the flow is not an avalanche that a grid can resolve (assumed)
MOST_DEPTH, MOST_SPEED = 100.0, 200.0  # m, m/s: beyond, the unit is wrong
STEEPEST, FINEST = 60.0, 0.02  # degrees; m, of the cells of a raster: beyond, the unit is wrong
PATCH = 50.0  # m: way before the point over which the ground is compared with a plane
UNEVEN = 0.1  # flow depths: a case gets the terrain where the ground differs by more from a plane (assumed)
BELT = 9.0  # mast widths: belt of the case below, 6 + 3 log10(hardening_xi / 0.05)


class Raster:
    """A grid of square cells with north up. data[0] is the northern row; x0, y0: centre of the south-western cell, m."""

    def __init__(self, data, x0, y0, cell_size, path):
        self.data, self.x0, self.y0, self.cell_size, self.path = data, x0, y0, cell_size, path

    def at(self, x, y):
        """Bilinear between cell centres; NaN beside cells without data. @throws ConfigError for points outside"""
        rows, columns = self.data.shape
        i, j = (x - self.x0) / self.cell_size, (y - self.y0) / self.cell_size
        if not (0.0 <= i <= columns - 1 and 0.0 <= j <= rows - 1):
            east, north = self.x0 + (columns - 1) * self.cell_size, self.y0 + (rows - 1) * self.cell_size
            raise ConfigError(f"--at {x:g},{y:g} is outside {self.path}, which covers x from {self.x0:g} to {east:g} and y from {self.y0:g} to "
                              f"{north:g}; give coordinates in the system of the raster")
        left, below = min(int(i), columns - 2), min(int(j), rows - 2)
        a, b = i - left, j - below
        corners = self.data[rows - 2 - below:rows - below, left:left + 2]  # north, south
        weights = np.array([[b * (1 - a), b * a], [(1 - b) * (1 - a), (1 - b) * a]])
        return float(np.sum(weights * corners, where=weights > 0.0))


def check_projection(path):
    """The file NAME.prj beside an ASCII grid, which itself names no unit. @return its text; empty: there is none"""
    beside = os.path.splitext(path)[0] + ".prj"
    try:
        with open(beside, encoding="utf-8", errors="replace") as file:
            text = " ".join(file.read().split())
    except FileNotFoundError:
        return ""
    except OSError as error:
        raise InputError(f"cannot read '{beside}': {error.strerror}") from None
    if re.match(r"GEOG(CS|CRS)|GCS", text, re.IGNORECASE):
        raise InputError(f"{beside}: the coordinates are degrees; reproject {path} to a system in metres")
    units = re.findall(r'UNIT\["([^"]+)"', text)  # the last one is that of the coordinates, those before it are of angles
    if units and not re.match(r"met(re|er)|m$", units[-1], re.IGNORECASE):
        raise InputError(f"{beside}: the unit of the coordinates is {units[-1]}; reproject {path} to a system in metres")
    return text


def check_same_projection(paths):
    """Elevation and results lie in one system. @return a line for the user where no file says which"""
    named = {path: text for path in paths if path.lower().endswith(".asc") and (text := check_projection(path))}
    first = next(iter(named), None)
    for path, text in named.items():
        if text != named[first]:
            raise InputError(f"{path} and {first} have different projections (.prj); reproject one of them")
    if first is None and all(path.lower().endswith(".asc") for path in paths):
        return (f"no .prj beside {paths[0]} or the other grids: their coordinates are taken to be metres in one system; put a .prj with the "
                "projection beside the DEM to have this checked")
    return ""


def check_cell(cell, path):
    if not cell >= FINEST:
        raise InputError(f"{path}: its cells are {cell:g} wide, which are degrees or kilometres, no metres; reproject it to a system in metres")


def read_ascii(path):
    """An ESRI ASCII grid."""
    header, values = {}, []
    lines = read_text(path).splitlines()
    start = 0
    for start, line in enumerate(lines):
        words = line.split()
        if len(words) != 2 or not words[0][0].isalpha():
            break
        try:
            header[words[0].lower()] = float(words[1])
        except ValueError:
            raise InputError(f"{path}:{start + 1}: '{line.strip()}' is no entry of the header; export the raster again") from None
    missing = [key for key in ("ncols", "nrows", "cellsize") if key not in header]
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
    check_cell(cell, path)
    half = 0.5 * cell  # corner or centre
    corner = [header.get(f"{axis}llcenter", header.get(f"{axis}llcorner", 0.0) + half) for axis in "xy"]
    return Raster(values.reshape(rows, columns), *corner, cell, path)


def read_geotiff(path):
    try:
        import rasterio
    except ImportError:
        raise InputError(f"{path}: Debian's python3-rasterio is needed for GeoTIFF; install it, or export ESRI ASCII grids") from None
    try:
        with rasterio.open(path) as file:
            data = file.read(1, masked=True).astype(float).filled(np.nan)
            transform, projection = file.transform, file.crs
    except rasterio.errors.RasterioIOError as error:
        raise InputError(f"cannot read '{path}': {error}") from None
    if projection is None:
        raise InputError(f"{path}: it names no projection, so that its unit is not known; set it (gdal_edit.py -a_srs EPSG:25832 {path}, with "
                         "the number of your system)")
    if projection.is_geographic:
        raise InputError(f"{path}: its coordinates are degrees ({projection}); reproject it to a system in metres")
    if transform.b or transform.d or abs(transform.a + transform.e) > 1e-6 * transform.a:
        raise InputError(f"{path}: its cells are turned or not square; resample it with north up")
    check_cell(transform.a, path)
    return Raster(data, transform.c + 0.5 * transform.a, transform.f + (data.shape[0] - 0.5) * transform.e, transform.a, path)


def read_raster(path):
    return read_geotiff(path) if path.lower().endswith((".tif", ".tiff")) else read_ascii(path)


class Ground(NamedTuple):
    """The ground at the point."""

    slope: float  # rad
    direction: float  # of the steepest descent, rad from east, counter-clockwise
    unevenness: float  # m: largest distance from the best plane over PATCH before the point; NaN: not inside the DEM
    mean_slope: float = math.nan  # of that plane, likewise
    mean_direction: float = math.nan


def ground_at(dem, x, y):
    h = dem.cell_size
    gx, gy = (dem.at(x + h, y) - dem.at(x - h, y)) / (2 * h), (dem.at(x, y + h) - dem.at(x, y - h)) / (2 * h)
    if not (math.isfinite(gx) and math.isfinite(gy)):
        raise ConfigError(f"{dem.path}: no elevation at {x:g},{y:g}; give a point inside the terrain")
    slope = math.degrees(math.atan(math.hypot(gx, gy)))
    if slope > STEEPEST:
        raise InputError(f"{dem.path}: the ground at {x:g},{y:g} is {slope:.0f} degrees steep, more than {STEEPEST:g}; check that elevation and "
                         "coordinates have the same unit, metres")
    direction = math.atan2(-gy, -gx)
    along, across = np.meshgrid(np.arange(0.0, PATCH + h, h), np.arange(-0.25 * PATCH, 0.25 * PATCH + h, h))
    c, s = math.cos(direction), math.sin(direction)
    try:
        z = np.array([dem.at(x - a * c - b * s, y - a * s + b * c) for a, b in zip(along.ravel(), across.ravel())])
        plane = np.column_stack([np.ones(z.size), along.ravel(), across.ravel()])
        best = np.linalg.lstsq(plane, z, rcond=None)[0]
        unevenness = float(np.max(np.abs(z - plane @ best)))
        upwards, left = best[1:]  # how much it rises against the direction, and across
        mean = math.atan(math.hypot(upwards, left)), direction + math.atan2(-left, upwards)
    except (ConfigError, np.linalg.LinAlgError):
        unevenness, mean = math.nan, (math.nan, math.nan)
    return Ground(math.atan(math.hypot(gx, gy)), direction, unevenness, *mean)


def terrain_of(dem, x, y, slope, direction, low, high, spacing):
    """Heights over the plane of this slope and direction through the point, normal to it, at regular points along the plane.

    low, high  corners in the frame of the plane, m: x along the direction, y to the left of it. @return heights, a row for each y
    """
    counts = [math.ceil((b - a) / spacing) + 1 for a, b in zip(low, high)]
    along, across = np.meshgrid(low[0] + spacing * np.arange(counts[0]), low[1] + spacing * np.arange(counts[1]))
    c, s = math.cos(direction), math.sin(direction)
    here = dem.at(x, y)

    def residual(a, b):  # vertical distance of the ground from the plane at a horizontal way a
        return dem.at(x + a * c - b * s, y + a * s + b * c) - here + a * math.tan(slope)

    heights = np.empty(along.shape)
    for place, (a, b) in enumerate(zip(along.ravel(), across.ravel())):
        way, rest = a * math.cos(slope), 0.0
        for _ in range(8):  # the point whose foot on the plane is (a, b); each time its error falls by slope times relief
            rest = residual(way, b)
            way = (a + rest * math.sin(slope)) * math.cos(slope)
        heights.ravel()[place] = rest * math.cos(slope)
    return heights


def write_terrain(path, heights, low, spacing):
    """An ESRI ASCII grid in the coordinates of the case."""
    rows = "\n".join(" ".join(f"{h:.4f}" for h in row) for row in heights[::-1])
    head = f"ncols {heights.shape[1]}\nnrows {heights.shape[0]}\nxllcenter {low[0]:.6g}\nyllcenter {low[1]:.6g}\ncellsize {spacing:.6g}\n"
    write_text(path, head + rows + "\n")


def time_steps(folder, simulation=None):
    """{time: {"depth": path, "speed": path}} of one simulation. @param folder of the avalanche, or of the time steps"""
    inside = os.path.join(folder, "Outputs", "com1DFA", "peakFiles", "timeSteps")
    where = inside if os.path.isdir(inside) else folder
    if not os.path.isdir(where):
        raise InputError(f"{folder}: there is no such folder")
    found = {}
    for name in sorted(os.listdir(where)):
        match = NAME.match(name)
        if match:
            quantity = "speed" if match["quantity"].upper() == "FV" else "depth"
            found.setdefault(match["simulation"], {}).setdefault(float(match["time"]), {})[quantity] = os.path.join(where, name)
    if not found:
        raise InputError(f"{where}: no rasters of flow thickness and speed at time steps (NAME_FT_t1.00.asc, NAME_FV_t1.00.asc); peak values "
                         f"alone do not say how the flow varies in time: {EXPORT}")
    if simulation is None and len(found) > 1:
        raise ConfigError(f"{where} holds {len(found)} simulations; choose one with --simulation: {', '.join(found)}")
    name = simulation or next(iter(found))
    if name not in found:
        raise ConfigError(f"--simulation {name}: there is none of this name, only {', '.join(found)}")
    steps = {time: files for time, files in sorted(found[name].items()) if len(files) == 2}
    if len(steps) < 2:
        raise InputError(f"{where}: {len(steps)} time steps of {name} have both FT and FV, two are needed: {EXPORT}")
    return name, steps


def find_dem(folder):
    inputs = os.path.join(folder, "Inputs")
    names = [n for n in sorted(os.listdir(inputs)) if n.lower().endswith((".asc", ".tif", ".tiff"))] if os.path.isdir(inputs) else []
    if len(names) != 1:
        raise ConfigError(f"{inputs}: {len(names)} rasters that may be the DEM; give it with --dem FILE")
    return os.path.join(inputs, names[0])


def flow_at(steps, x, y):
    """Times (s), depths (m) and speeds (m/s) at a point; where there is no data the depth is 0."""
    times = np.array(list(steps))
    depth = np.nan_to_num([read_raster(files["depth"]).at(x, y) for files in steps.values()])
    speed = np.nan_to_num([read_raster(files["speed"]).at(x, y) for files in steps.values()])
    for values, most, unit, what in ((depth, MOST_DEPTH, "m", "thickness"), (speed, MOST_SPEED, "m/s", "speed")):
        if values.max() > most:
            raise InputError(f"the flow's {what} at {x:g},{y:g} reaches {values.max():g}, more than {most:g} {unit}; check the unit of the rasters")
    return times, depth, speed


def passage(times, depth, speed, least_depth):
    """The rows of the flow while it is deeper than `least_depth` and moves, around its strongest moment, from time 0."""
    flows = (depth >= least_depth) & (speed > 0.1)
    if not flows.any():
        raise ConfigError(f"the flow is nowhere deeper than {least_depth:.3g} m at this point (at most {depth.max():.3g} m); choose a point in "
                          "its path, and check that the rasters of thickness are in metres")
    peak = int(np.argmax(np.where(flows, depth * speed**2, -1.0)))
    first, last = peak, peak
    while first > 0 and flows[first - 1]:
        first -= 1
    while last + 1 < len(times) and flows[last + 1]:
        last += 1
    if first == last:
        raise ConfigError("the flow passes this point within one time step; " + EXPORT.replace("0:1", "0:0.2").replace("every second", "every 0.2 s"))
    part = slice(first, last + 1)
    return times[part] - times[first], depth[part], speed[part]


CASE = """\
title = "{title}"

[material]                     # dry, loose snow of the paper (Sect. 4.3); choose your own
critical_state_slope = 0.5
cohesion_beta = 0.15
hardening_xi = 0.5
density_kg_m3 = {density:g}

[conveyor]
inflow_csv = "inflow.csv"      # time, depth normal to the ground, speed
upstream_length_m = {upstream:g}
downstream_length_m = {downstream:g}
{ground}
[obstacle]
width_m = {width:g}
depth_m = {width:g}

[numerics]
cell_size_m = {cell:.6g}
gravity_m_s2 = {gravity:.6g}   # g cos(slope), slope {slope:.1f} degrees: the ground holds the flow at its speed

[output]
duration_s = {duration:g}
"""


TERRAIN = """\
sidewall_contact = "slip"      # side walls that drag the snow would push it into slopes
mirror_y = false

[terrain]
file = "terrain.asc"           # heights over the mean plane of {patch:g} m; it allows upstream_length_m up to {upstream:g}
"""


SITE = """\
title = "{title}"

[flow]                         # the moment of the largest v^2 H, {time:g} s after the arrival; the flow is taken to go on like this
depth_m = {depth:.4g}
velocity_m_s = {speed:.4g}
density_kg_m3 = {density:g}
slope_deg = {slope:.4g}
snow_class = "loose"           # choose: loose, cold_dense, warm_cohesive (assumed), or entries [[snow]]

[mast]
shape = "box"                  # or cylinder
width_m = {width:g}
"""


class CaseTerrain(NamedTuple):
    """Uneven ground of a case, in its frame."""

    heights: np.ndarray  # m
    low: tuple  # south-western point, m
    spacing: float  # m
    text: str  # of the case file


def case_terrain(dem, x, y, ground, width, cell, upstream, downstream):
    """The terrain from PATCH before the mast, or from the inlet where the DEM ends before, to the outlet."""
    if not math.isfinite(ground.mean_slope):
        raise ConfigError(f"{dem.path} does not cover the {PATCH:g} m before {x:g},{y:g}, so that it gives no mean plane; leave --terrain out, or "
                          "give a larger DEM")
    margin, spacing = 5.0 * cell, max(dem.cell_size, cell)
    half = 0.5 * BELT * width + margin
    for before in (max(PATCH, upstream), upstream):
        low = (-before - margin, -half)
        try:
            heights = terrain_of(dem, x, y, ground.mean_slope, ground.mean_direction, low, (downstream + margin, half), spacing)
        except ConfigError:  # it ends before
            continue
        if np.isfinite(heights).all():
            return CaseTerrain(heights, low, spacing, TERRAIN.format(patch=PATCH, upstream=math.floor(before)))
    raise ConfigError(f"{dem.path} does not cover the window of the case, {upstream:g} m before and {half:.3g} m beside {x:g},{y:g}; give a larger "
                      "DEM, or leave the ground plane with --no-terrain")


def import_avalanche(folder, x, y, width, out, simulation=None, dem=None, density=200.0, terrain=None):
    """Writes inflow.csv, case.toml, site.toml and, on uneven ground, terrain.asc. @return lines for the user

    terrain  whether the case gets the terrain; None: where the ground differs from a plane by more than UNEVEN
    """
    name, steps = time_steps(folder, simulation)
    dem = dem or find_dem(folder)
    unchecked = check_same_projection([dem, *(path for files in steps.values() for path in files.values())])
    elevation = read_raster(dem)
    ground = ground_at(elevation, x, y)
    times, depth, speed = flow_at(steps, x, y)
    cell = min(width, depth.max()) / 5.0 if depth.max() > 0.0 else width / 5.0
    times, depth, speed = passage(times, depth, speed, max(LEAST_DEPTH, cell))
    strongest = int(np.argmax(depth * speed**2))
    title = f"{name} at {x:g}, {y:g}".replace('"', "'")
    reach = width * math.ceil(max(width, math.sqrt(width * depth.max())) / width)
    upstream, downstream = 4 * reach, width + reach
    uneven = ground.unevenness > UNEVEN * depth.max() if terrain is None else terrain
    relief = case_terrain(elevation, x, y, ground, width, cell, upstream, downstream) if uneven else None
    slope = ground.mean_slope if relief else ground.slope
    write_text(os.path.join(out, "inflow.csv"),
               "time_s,depth_m,velocity_m_s\n" + "".join(f"{t:.6g},{d:.6g},{v:.6g}\n" for t, d, v in zip(times, depth, speed)))
    write_text(os.path.join(out, "case.toml"),
               CASE.format(title=title, density=density, width=width, cell=cell, upstream=upstream, downstream=downstream,
                           gravity=STANDARD_GRAVITY * math.cos(slope), slope=math.degrees(slope), duration=math.ceil(times[-1]),
                           ground=relief.text if relief else ""))
    if relief:
        write_terrain(os.path.join(out, "terrain.asc"), relief.heights, relief.low, relief.spacing)
    write_text(os.path.join(out, "site.toml"),
               SITE.format(title=title, time=times[strongest], depth=depth[strongest], speed=speed[strongest], density=density,
                           slope=math.degrees(ground.slope), width=width))
    lines = [f"{name}: {len(times)} time steps, {times[-1]:.3g} s; depth up to {depth.max():.3g} m, speed up to {speed.max():.3g} m/s",
             f"slope {math.degrees(ground.slope):.1f} degrees, falling towards {math.degrees(ground.direction) % 360:.0f} degrees from east"]
    if math.isfinite(ground.unevenness):
        size = "less than 0.01" if ground.unevenness < 0.01 else f"up to {ground.unevenness:.2g}"
        takes = (f"terrain.asc, over the mean plane with {math.degrees(slope):.1f} degrees, falling towards "
                 f"{math.degrees(ground.mean_direction) % 360:.0f} degrees from east" if relief else "a plane")
        lines.append(f"the ground differs by {size} m from a plane over {PATCH:g} m before the point; the run takes {takes}")
    if unchecked:
        lines.append(unchecked)
    lines.append(f"largest v^2 H: {depth[strongest]:.3g} m at {speed[strongest]:.3g} m/s, {times[strongest]:.3g} s after the arrival")
    lines.append(f"wrote {os.path.join(out, 'inflow.csv')} and case.toml: mpm check {os.path.join(out, 'case.toml')}")
    lines.append(f"wrote {os.path.join(out, 'site.toml')}: mpm design {os.path.join(out, 'site.toml')} --quick --plan")
    return lines


def run_command(options):
    try:
        x, y = (float(part) for part in options.at.split(","))
    except ValueError:
        raise ConfigError(f"--at {options.at}: give two coordinates, X,Y") from None
    if not 0.05 <= options.mast_width <= 100.0:
        raise ConfigError(f"--mast-width {options.mast_width:g}: give metres from 0.05 to 100")
    print("\n".join(import_avalanche(options.directory, x, y, options.mast_width, options.out, options.simulation, options.dem, options.density,
                                     options.terrain)))
