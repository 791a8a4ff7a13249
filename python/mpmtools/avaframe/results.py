"""The files of a simulation of com1DFA.

DIR/Outputs/com1DFA/peakFiles holds NAME_pft.asc (largest flow thickness, m, normal to the ground) and NAME_pfv.asc (largest speed, m/s), as
ESRI ASCII grids or GeoTIFF, on the grid of the DEM in DIR/Inputs; timeSteps in it holds, on request, NAME_FT_t12.00.asc, FV (speed), Vx, Vy
and Vz (velocity: east, north, up). Older versions call the thickness FD, pfd.
"""

import os
import re

from mpmtools.errors import ConfigError, InputError

STEP = re.compile(r"^(?P<simulation>.+)_(?P<quantity>FT|FD|FV|Vx|Vy|Vz)_t(?P<time>\d+(?:\.\d+)?)\.(?:asc|tif|tiff)$", re.IGNORECASE)
PEAK = re.compile(r"^(?P<simulation>.+)_(?P<quantity>pft|pfd|pfv)\.(?:asc|tif|tiff)$", re.IGNORECASE)
NAMES = {"ft": "depth", "fd": "depth", "fv": "speed", "pft": "depth", "pfd": "depth", "pfv": "speed"}  # others keep theirs
EXPORT = "in com1DFACfg.ini, [GENERAL], set resType = ppr|pft|pfv|FT|FV|Vx|Vy|Vz and tSteps = 0:1 (every second), and run com1DFA again"


def files_of(folder, pattern):
    """{simulation: {time: {quantity: path}}}; time 0 where the pattern has none."""
    found = {}
    for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
        if match := pattern.match(name):
            entry = match.groupdict()
            steps = found.setdefault(entry["simulation"], {})
            quantity = entry["quantity"].lower()
            steps.setdefault(float(entry.get("time") or 0.0), {})[NAMES.get(quantity, quantity)] = os.path.join(folder, name)
    return found


def has_flow(files):
    """Whether they give depth and speed."""
    return "depth" in files and ("speed" in files or {"vx", "vy"} <= set(files))


def simulation_files(folder, simulation=None):
    """(name, {time: files}, files of the peaks) of one simulation. Less than two time steps: the peaks hold depth and speed.

    folder: that of the avalanche, of the peak files, or of the time steps
    """
    if not os.path.isdir(folder):
        raise InputError(f"{folder}: there is no such folder")
    inside = os.path.join(folder, "Outputs", "com1DFA", "peakFiles")
    where = inside if os.path.isdir(inside) else folder
    below = os.path.join(where, "timeSteps")
    steps, peaks = files_of(below if os.path.isdir(below) else where, STEP), files_of(where, PEAK)
    names = sorted({*steps, *peaks})
    if not names:
        raise InputError(f"{where}: no rasters of flow thickness and speed (NAME_pft.asc, NAME_pfv.asc; at time steps NAME_FT_t1.00.asc, "
                         f"NAME_FV_t1.00.asc): {EXPORT}")
    if simulation is None and len(names) > 1:
        raise ConfigError(f"{where} holds {len(names)} simulations; choose one with --simulation: {', '.join(names)}")
    name = simulation or names[0]
    if name not in names:
        raise ConfigError(f"--simulation {name}: there is none of this name, only {', '.join(names)}")
    complete = {time: files for time, files in sorted(steps.get(name, {}).items()) if has_flow(files)}
    peak = peaks.get(name, {}).get(0.0, {})
    if len(complete) < 2 and not has_flow(peak):
        raise InputError(f"{where}: {name} has {len(complete)} time steps with thickness and speed (FT with FV, or with Vx and Vy), where two are "
                         f"needed, and no largest values (pft and pfv): {EXPORT}")
    return name, complete, peak


def find_dem(folder):
    inputs = os.path.join(folder, "Inputs")
    names = [n for n in sorted(os.listdir(inputs)) if n.lower().endswith((".asc", ".tif", ".tiff"))] if os.path.isdir(inputs) else []
    if len(names) != 1:
        raise ConfigError(f"{inputs}: {len(names)} rasters that may be the DEM; give it with --dem FILE")
    return os.path.join(inputs, names[0])
