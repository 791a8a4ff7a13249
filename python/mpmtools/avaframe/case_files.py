"""Case and site files of an avalanche of com1DFA at one point."""

import math
import os
from typing import NamedTuple

import jinja2

from mpmtools.avaframe import flow as flows, ground
from mpmtools.avaframe.flow import LEAST_DEPTH, degrees_text, flow_at, passage, remarks_on, strongest
from mpmtools.avaframe.projection import check_same
from mpmtools.avaframe.rasters import place, read_elevation
from mpmtools.avaframe.results import EXPORT, find_dem, simulation_files
from mpmtools.equations import STANDARD_GRAVITY
from mpmtools.errors import ConfigError, InputError, MpmError
from mpmtools.files import require_no_files, write_text
from mpmtools.program import find_program, run_program

UNEVEN = 0.1  # flow depths: a case gets the terrain where the ground differs by more from a plane (assumed)
DENSITIES, WIDTHS = (10.0, 1000.0), (0.05, 100.0)  # kg/m^3, m: the ranges of a site file
OBLIQUE = 10.0  # degrees: a fall across the flow, or a rise along it, beyond is stated


class Setup(NamedTuple):
    """Lengths of the case, m."""

    cell: float
    upstream: float
    downstream: float
    window: ground.Window


def setup(width, depth):
    """@param depth  largest, m"""
    cell = min(width, depth) / 5.0
    size = max(width, math.sqrt(width * depth))
    reach = width * math.ceil(size / width)
    upstream, downstream, half = 4 * reach, width + reach, 0.5 * max(8.0 * width, 6.0 * size)  # the belt of a case that does not give its width
    return Setup(cell, upstream, downstream, ground.Window((-upstream, -half), (downstream, half)))


def relief_for(dem, plane, sizes, flow, asked):
    """(Relief of the case or None, line for the user). @param asked  True: with terrain, False: without, None: where it is uneven"""
    relief = ground.relief_over(dem, plane, sizes.window.grown(5.0 * sizes.cell), sizes.cell)
    window = f"the window of the case ({sizes.upstream:g} m before, {sizes.downstream:g} m behind and {sizes.window.high[1]:g} m beside the mast)"
    if relief is None:
        if asked:
            raise ConfigError(f"{dem.grid.path} does not cover {window}, or has holes or cliffs there; give a larger DEM, or leave the plane with "
                              "--no-terrain")
        return None, f"{dem.grid.path} does not cover {window}, or has holes or cliffs there: the run takes the plane"
    row = strongest(flow)
    depth, speed, most = flow.depth[row], flow.speed[row], max(relief.highest, -relief.lowest)
    size = "less than 0.01" if most < 0.01 else f"up to {most:.2g}"
    differs = f"the ground differs by {size} m from this plane in {window}"
    effect = (f"heights on the mast may move by as much, v^2 by up to 2 g h/v^2 = {200.0 * STANDARD_GRAVITY * most / speed**2:.0f} %"
              if most >= 0.01 else "")
    if asked is False or (asked is None and most <= UNEVEN * depth):
        return None, f"{differs}: the run takes the plane" + f"; {effect}" * bool(effect)
    if relief.steepest >= ground.STEEPEST_RELIEF:
        steep = f"{differs}, and is there up to {relief.steepest:.0f} degrees steep against it, where a run can have {ground.STEEPEST_RELIEF:g}"
        if asked:
            raise ConfigError(f"{dem.grid.path}: {steep}; smooth the DEM, or leave the plane with --no-terrain")
        return None, f"{steep}: the run takes the plane; {effect}, and the relief may steer the flow"
    return relief, (f"{differs}: the run takes terrain.asc, with points {relief.spacing:.3g} m apart on the DEM; the DEM's own points lie within "
                    f"{max(relief.off, 0.001):.2g} m of it")


def ground_lines(plane, direction):
    lines = [f"slope {math.degrees(plane.slope):.1f} degrees, falling towards {degrees_text(plane.fall)}; heights are taken to be metres",
             f"the flow goes towards {degrees_text(direction.angle)}: from {direction.source}"]
    along, across = (math.degrees(plane.inclination(axis)) for axis in (0, 1))
    if along < -1.0:
        lines.append(f"the ground rises by {-along:.1f} degrees along the flow: the run keeps the speed of the path model")
    if abs(across) > OBLIQUE:
        lines.append(f"across the flow the ground falls by {abs(across):.0f} degrees to the {'left' if across > 0 else 'right'}: the run leaves this "
                     "component of gravity out")
    return lines


def write_filled(template, path, **values):
    """Writes a file from its template in this folder."""
    environment = jinja2.Environment(loader=jinja2.FileSystemLoader(os.path.dirname(__file__)), trim_blocks=True, keep_trailing_newline=True,
                                     undefined=jinja2.StrictUndefined)
    write_text(path, environment.get_template(template).render(values))


def import_avalanche(folder, x, y, width, out, simulation=None, dem=None, density=200.0, terrain=None):
    """Writes site.toml and, from results at time steps, case.toml, inflow.csv and, on uneven ground, terrain.asc. @return (lines for the user,
    [path of the case, if there is one, and of the site])

    terrain  whether the case gets the terrain; None: where the ground differs from a plane by more than UNEVEN
    """
    for option, value, unit, (least, most) in (("--mast-width", width, "m", WIDTHS), ("--density", density, "kg/m^3", DENSITIES)):
        if not least <= value <= most:
            raise ConfigError(f"{option} {value:g}: give a number from {least:g} to {most:g} {unit}")
    name, steps, peak, incomplete = simulation_files(folder, simulation)
    peaks_only = len(steps) < 2
    elevation, lines = read_elevation(dem or find_dem(folder))
    fall = ground.local_fall(elevation, x, y)
    whole, grids = flow_at({0.0: peak} if peaks_only else steps, x, y, elevation)
    lines += check_same([elevation.grid, *grids])
    lines += remarks_on(steps, incomplete, whole, x, y)
    rows = passage(whole, LEAST_DEPTH if peaks_only else max(LEAST_DEPTH, min(width, whole.depth.max()) / 5.0))
    flow = whole.part(rows)
    times, row, sizes = flow.times - flow.times[0], strongest(flow), setup(width, whole.depth.max())
    direction = flows.direction_of(whole, rows, x, y)
    if direction is None:
        unsure = "peak values hold no direction" if peaks_only else "the results do not determine it; export Vx and Vy"
        direction = flows.Direction(fall, f"the fall of the ground at the mast, unsure ({unsure})")
    plane = ground.plane_at(elevation, x, y, direction.angle, sizes.window)
    title = f"{name} at {place(x, y)}".replace('"', "'")
    slope = math.degrees(plane.slope)
    moment = "largest depth and largest speed (pft, pfv), which need not coincide" if peaks_only else (
        f"the moment of the largest v^2 H, {times[row]:g} s after the arrival")
    site, case = os.path.join(out, "site.toml"), os.path.join(out, "case.toml")
    lines = [f"{name}: {len(times)} time steps, {times[-1]:.3g} s; depth up to {flow.depth.max():.3g} m, speed up to {flow.speed.max():.3g} m/s"
             if not peaks_only else f"{name}: peak values only", *ground_lines(plane, direction), *lines]
    if peaks_only:
        lines.append(f"depth {flow.depth[row]:.3g} m and speed {flow.speed[row]:.3g} m/s are the largest of the whole avalanche at the point; the two "
                     "need not coincide: no moment has a larger v^2 H, and perhaps none has one as large")
        lines.append(f"no case, since peak values do not say how the flow varies in time: {EXPORT}")
    else:
        relief, relief_line = relief_for(elevation, plane, sizes, flow, terrain)
        lines += [relief_line, f"largest v^2 H: {flow.depth[row]:.3g} m at {flow.speed[row]:.3g} m/s, {times[row]:.3g} s after the arrival"]
        write_text(os.path.join(out, "inflow.csv"), "time_s,depth_m,velocity_m_s\n" +
                   "".join(f"{t:.6g},{d:.6g},{v:.6g}\n" for t, d, v in zip(times, flow.depth, flow.speed)))
        if relief:
            write_text(os.path.join(out, "terrain.asc"), relief.text)
        write_filled("case.toml.j2", case, title=title, density=density, width=width, cell=sizes.cell, upstream=sizes.upstream,
                     downstream=sizes.downstream, gravity=STANDARD_GRAVITY * math.cos(plane.slope), slope=slope,
                     duration=math.floor(times[-1]) + 1, terrain=bool(relief))
        lines.append(f"wrote {os.path.join(out, 'inflow.csv')} and case.toml: mpm check {case}")
    write_filled("site.toml.j2", site, title=title, moment=moment, depth=flow.depth[row], speed=flow.speed[row], density=density, slope=slope,
                 width=width)
    lines.append(f"wrote {site}; choose the kind of snow in it, then: mpm design {site} --quick --out {os.path.join(out, 'design')}")
    return lines, [site] if peaks_only else [case, site]


def check_files(paths):
    """ConfigError if the program refuses a case or a site that was written; without the program a line says that nothing was checked."""
    try:
        find_program()
    except InputError as error:
        print(f"the files were not checked: {error}")
        return
    for path in paths:
        try:
            run_program(*(("check",) if path.endswith("case.toml") else ("design", "--quick", "--plan")), path)
        except MpmError as error:
            raise ConfigError(f"{path} is written, but the program refuses it: {error}") from None


def run_command(options):
    try:
        x, y = (float(part) for part in options.at.split(","))
    except ValueError:
        raise ConfigError(f"--at {options.at}: give two coordinates, X,Y") from None
    if not options.force:
        require_no_files(options.out, ("inflow.csv", "case.toml", "site.toml", "terrain.asc"))
    lines, paths = import_avalanche(options.directory, x, y, options.mast_width, options.out, options.simulation, options.dem, options.density, options.terrain)
    print("\n".join(lines), flush=True)
    check_files(paths)
