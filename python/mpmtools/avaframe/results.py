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
    """{simulation: {time: {quantity: [path, ...]}}}; time 0 where the pattern has none."""
    found = {}
    for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
        if match := pattern.match(name):
            entry, quantity = match.groupdict(), match["quantity"].lower()
            files = found.setdefault(entry["simulation"], {}).setdefault(float(entry.get("time") or 0.0), {})
            files.setdefault(NAMES.get(quantity, quantity), []).append(os.path.join(folder, name))
    return found


def one_each(files):
    """{quantity: path}. @throws InputError where two files hold the same quantity of one time"""
    for quantity, paths in files.items():
        if len(paths) > 1:
            what = {"depth": "the thickness", "speed": "the speed"}.get(quantity, quantity.capitalize())
            raise InputError(f"{paths[0]} and {os.path.basename(paths[1])} both hold {what} of the same time; move one of them to another folder")
    return {quantity: path for quantity, (path,) in files.items()}


def has_flow(files):
    """Whether they give depth and speed."""
    return "depth" in files and ("speed" in files or {"vx", "vy"} <= set(files))


def missing_files(files):
    """Names of the files that a time step without depth or without speed lacks."""
    name = os.path.basename(next(iter(files.values())))
    start, end = STEP.match(name).span("quantity")
    lacks = [] if "depth" in files else ["FT"]
    if "speed" not in files:
        lacks += [component for component in ("Vx", "Vy") if component.lower() not in files] if {"vx", "vy"} & set(files) else ["FV"]
    return " and ".join(name[:start] + quantity + name[end:] for quantity in lacks)


def simulation_files(folder, simulation=None):
    """(name, {time: files}, files of the peaks, {time: files} of incomplete time steps) of one simulation. Less than two time steps: the
    peaks hold depth and speed. Incomplete steps, which lack depth or speed, are before or behind all others.

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
    every = {time: one_each(files) for time, files in sorted(steps.get(name, {}).items())}
    complete, incomplete = ({time: files for time, files in every.items() if has_flow(files) == whole} for whole in (True, False))
    peak = peaks.get(name, {}).get(0.0, {})
    if len(complete) < 2 and not has_flow(peak):
        raise InputError(f"{where}: {name} has {len(complete)} time steps with thickness and speed (FT with FV, or with Vx and Vy), where two are "
                         f"needed, and no largest values (pft and pfv): {EXPORT}")
    between = [time for time in incomplete if len(complete) > 1 and min(complete) < time < max(complete)]
    if between:
        raise InputError(f"{below if os.path.isdir(below) else where}: the time step at {between[0]:g} s has no {missing_files(incomplete[between[0]])}, and others "
                         f"before and behind it are complete; put the file there, or {EXPORT}")
    return name, complete, peak if len(complete) > 1 else one_each(peak), incomplete


def find_dem(folder):
    inputs = os.path.join(folder, "Inputs")
    names = [n for n in sorted(os.listdir(inputs)) if n.lower().endswith((".asc", ".tif", ".tiff"))] if os.path.isdir(inputs) else []
    if len(names) != 1:
        raise ConfigError(f"{inputs}: {len(names)} rasters that may be the DEM; give it with --dem FILE")
    return os.path.join(inputs, names[0])
