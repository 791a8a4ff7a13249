"""The flow at a point: depth, speed and direction over time."""

import itertools
import math
from typing import NamedTuple

import numpy as np
from scipy.ndimage import label

from mpmtools.avaframe.rasters import Raster, place, read_raster
from mpmtools.avaframe.results import EXPORT, missing_files
from mpmtools.errors import ConfigError, InputError

LEAST_DEPTH = 0.1  # m: below, the flow is not an avalanche that a grid can resolve (assumed)
LEAST_SPEED = 0.1  # m/s: below, the snow rests
MOST_DEPTH, MOST_SPEED = 100.0, 200.0  # m, m/s: beyond, the unit is wrong
REACH = 100.0  # m around the point, for the balance of volume
LEAST_BALANCE, MOST_SCATTER = 0.5, 20.0  # |e|, degrees: a balance of volume beyond does not determine the direction (assumed)


class Flow(NamedTuple):
    """Rows of the flow at the point, one for each time step."""

    times: np.ndarray  # s
    depth: np.ndarray  # m, normal to the ground
    speed: np.ndarray  # m/s
    directions: np.ndarray  # of the velocity, rad from east, counter-clockwise; NaN without components
    surroundings: list  # (Raster of depth, Raster of speed) around the point at each time, where there are no components

    def part(self, rows):
        return Flow(*(values[rows] for values in self))


class Direction(NamedTuple):
    """Where the flow goes in plan."""

    angle: float  # rad from east, counter-clockwise
    source: str  # where this comes from, and how sure it is


def degrees_text(angle):
    return f"{round(math.degrees(angle)) % 360} degrees from east (counter-clockwise)"


def speed_raster(rasters, dem):
    """FV, or what the components give. Without Vz the velocity follows the ground: Vz = V . grad z."""
    if "speed" in rasters:
        return rasters["speed"]
    vx, vy = rasters["vx"], rasters["vy"]
    if "vz" in rasters:
        vertical = rasters["vz"].data
    else:
        x, y, _ = vx.points()
        h = dem.grid.cell_size
        slopes = (dem.values(x + h, y) - dem.values(x - h, y)) / (2 * h), (dem.values(x, y + h) - dem.values(x, y - h)) / (2 * h)
        vertical = vx.data * np.nan_to_num(slopes[0]) + vy.data * np.nan_to_num(slopes[1])
    return Raster(np.sqrt(vx.data**2 + vy.data**2 + vertical**2), vx.grid)


def flow_at(steps, x, y, dem):
    """(Flow at a point, grids of all rasters that were read). Where there is no data the depth is 0."""
    rows, surroundings, grids = [], [], []
    known = has_directions(steps)
    for files in steps.values():
        rasters = {quantity: read_raster(path) for quantity, path in files.items()}
        at = {quantity: np.nan_to_num(raster.at(x, y)) for quantity, raster in rasters.items()}
        near = {quantity: raster.around(x, y, REACH) for quantity, raster in rasters.items()}
        grids += [raster.grid for raster in rasters.values()]
        speed = speed_raster(near, dem)
        rows.append((max(at["depth"], 0.0), np.nan_to_num(speed.at(x, y)), math.atan2(at["vy"], at["vx"]) if known else math.nan))
        surroundings.append(None if known else (near["depth"], speed))
    depth, speed, directions = np.array(rows).T
    for values, most, unit, what in ((depth, MOST_DEPTH, "m", "thickness"), (speed, MOST_SPEED, "m/s", "speed")):
        if values.max() > most:
            raise InputError(f"the flow's {what} at {place(x, y)} reaches {values.max():g}, more than {most:g} {unit}; check the unit of the rasters")
    return Flow(np.array(list(steps)), depth, speed, directions, surroundings), grids


def has_directions(steps):
    """Whether all time steps hold the components of the velocity."""
    return all({"vx", "vy"} <= set(files) for files in steps.values())


def remarks_on(steps, incomplete, flow, x, y):
    """Lines for the user about time steps of whose files some are missing.

    @param incomplete  those that lack depth or speed. @throws InputError where such a step is the deepest or the fastest of all at the point
    """
    for time, files in incomplete.items() if len(steps) > 1 else ():  # else the peaks count
        for quantity, values, what, unit in (("depth", flow.depth, "deeper", "m"), ("speed", flow.speed, "faster", "m/s")):
            if quantity in files and (value := read_raster(files[quantity]).at(x, y)) > values.max():
                raise InputError(f"the time step at {time:g} s has no {missing_files(files)}, and there the flow at {place(x, y)} is {what}, {value:.3g} {unit}, than at "
                                 f"all complete time steps, {values.max():.3g} {unit}; put the file beside {files[quantity]}, or {EXPORT}")
    lines = []
    if incomplete:
        first, files = next(iter(incomplete.items()))
        which = f"the time step at {first:g} s is" if len(incomplete) == 1 else f"{len(incomplete)} time steps are"
        lines.append(f"warning: {which} left out: there is no {missing_files(files)}" + ", ..." * (len(incomplete) > 1))
    some = [time for time, files in steps.items() if {"vx", "vy"} <= set(files)]
    if some and not has_directions(steps):
        lacking = next(time for time in steps if time not in some)
        lines.append(f"warning: {len(steps) - len(some)} of {len(steps)} time steps have no Vx and Vy, the first at {lacking:g} s: the direction is found without them")
    return lines


def strongest(flow):
    """Row of the largest v^2 H."""
    return int(np.argmax(flow.depth * flow.speed**2))


def passage(flow, least_depth):
    """The rows around the strongest moment while the flow is deeper than `least_depth` and moves."""
    flows = (flow.depth >= least_depth) & (flow.speed > LEAST_SPEED)
    if not flows.any():
        raise ConfigError(f"the flow is nowhere deeper than {least_depth:.3g} m at this point (at most {flow.depth.max():.3g} m); choose a point in "
                          "its path, and check that the rasters of thickness are in metres")
    passages, _ = label(flows)
    first, last = np.flatnonzero(passages == passages[np.argmax(np.where(flows, flow.depth * flow.speed**2, -1.0))])[[0, -1]]
    if first == last and len(flows) > 1:
        raise ConfigError("the flow passes this point within one time step; " + EXPORT.replace("0:1", "0:0.2").replace("every second", "every 0.2 s"))
    return slice(first, last + 1)


def balance_rows(before, after, step, x, y, width):
    """Rows (a, b) with a . e = b for the unit vector e of the flow, from the change of volume in one time step.

    dh/dt + div(h v e) = 0, weighed with bells w around nine places at and beside the point and integrated by parts:
    int w (h1 - h0) dA = e . int grad w q dA, with q the integral of h v over the step. One e holds for all bells.
    """
    px, py, old = before[0].points()
    depths = np.nan_to_num(old), np.nan_to_num(after[0].data)
    passed = 0.5 * step * (depths[0] * np.nan_to_num(before[1].data) + depths[1] * np.nan_to_num(after[1].data))
    rows = []
    for i, j in itertools.product((-1, 0, 1), repeat=2):
        dx, dy = px - x - 0.5 * i * width, py - y - 0.5 * j * width
        bell = np.exp(-0.5 * (dx**2 + dy**2) / width**2)
        rows.append((-np.sum(bell * dx * passed) / width**2, -np.sum(bell * dy * passed) / width**2, np.sum(bell * (depths[1] - depths[0]))))
    return rows


def of_volume(flow, x, y):
    """From the balance of volume between time steps around the point; None: it does not determine the direction.

    How sure: |e|, which is 1 if volume is conserved, and the standard error of the angle if one step at a time is left out (jackknife).
    """
    steps = np.diff(flow.times)
    cell = flow.surroundings[0][0].grid.cell_size
    width = np.clip(0.5 * flow.speed.max() * steps.max(), 2.0 * cell, REACH / 3.0)
    blocks = np.array([balance_rows(*flow.surroundings[k:k + 2], step, x, y, width) for k, step in enumerate(steps)])

    def solution(chosen):
        rows = np.concatenate(chosen)
        return np.linalg.lstsq(rows[:, :2], rows[:, 2], rcond=None)[0]

    e = solution(blocks)
    angle, size, n = math.atan2(e[1], e[0]), math.hypot(*e), len(blocks)
    others = [solution(np.delete(blocks, k, axis=0)) for k in range(n)] if n > 2 else []
    turns = [np.angle(np.exp(1j * (math.atan2(o[1], o[0]) - angle))) for o in others]
    scatter = math.degrees(math.sqrt((n - 1) / n * np.sum(np.square(turns)))) if turns else math.nan
    if size < LEAST_BALANCE or scatter > MOST_SCATTER:
        return None
    sure = f"standard error {scatter:.0f} degrees" if turns else "two time steps, so that its error is not known"
    return Direction(angle, f"the balance of volume between time steps, which closes to {100 * size:.0f} %; {sure}")


def direction_of(flow, rows, x, y):
    """Direction of the flow; None: nothing in the results determines it. @param rows  those of the passage"""
    passing = flow.part(rows)
    angle = passing.directions[strongest(passing)]
    if np.isfinite(angle):  # how sure: by how much it turns during the passage, weighed with v^2 H
        turn = np.angle(np.exp(1j * (passing.directions - angle)))
        scatter = math.degrees(math.sqrt(np.average(turn**2, weights=passing.depth * passing.speed**2)))
        return Direction(angle, f"Vx and Vy at the strongest moment; it turns by +- {scatter:.0f} degrees while the flow passes")
    wider = flow.part(slice(max(0, rows.start - 2), rows.stop + 2))  # with the arrival
    return of_volume(wider, x, y) if len(wider.times) > 1 else None
