#!/usr/bin/python3
"""How far uneven ground changes the loads on a mast: four grounds on two grids; prints the table of docs/cases.md.

    PYTHONPATH=python docs/relief.py [--program build/release/bin/mpm] [--out out/relief] [--cells 0.25,0.1666667]

Runs that have finished are not repeated. Every ground is at z = 0 at the mast, and no slope exceeds 1 in 4:

    crest    0.25 m (1 + cos(x + 4 m)) within pi m of x = -4 m, across the whole flow
    hollow   minus that
    gully    0.25 m (1 - cos y) within pi m of the axis, 0.5 m beyond, along the whole flow
"""

import argparse
import math
import pathlib
import subprocess
import sys

from mpmtools import Run

CASE = """title = "A mast behind uneven ground: {name}"
[material]
model = "cohesive_cam_clay"
density_kg_m3 = 200
critical_state_slope = 0.5
cohesion_beta = 0.15
hardening_xi = 0.5
[conveyor]
velocity_m_s = 12
flow_height_m = 1
feed = "window"
upstream_length_m = 8
downstream_length_m = 4
width_m = 12
sidewall_contact = "slip"
{terrain}
[obstacle]
width_m = 1
depth_m = 1
[numerics]
cell_size_m = {cell_size}
[output]
duration_s = 4
frames_per_second = 0
"""
GROUNDS = {
    "level": None,
    "a crest of 0.5 m across the flow, 4 m before the mast": lambda x, y: bump(x + 4.0),
    "a hollow of 0.5 m instead": lambda x, y: -bump(x + 4.0),
    "a gully along the flow, sides 0.5 m higher": lambda x, y: 0.5 - bump(y),
}
STEP = 0.25  # m, between points of the raster
COLUMNS = {  # key of results.json, factor, unit, digits
    "mean force": ("force_mean_n", 1e-3, "kN", 1),
    "run-up": ("runup_mean_m", 1.0, "m", 2),
    "filtered peak of the force": ("force_filtered_peak_n", 1e-3, "kN", 1),
    "height of the resultant": ("force_resultant_height_m", 1.0, "m", 2),
}


def bump(distance):
    return 0.25 * (1.0 + math.cos(distance)) if abs(distance) < math.pi else 0.0


def write_raster(path, height):
    count, origin = 96, -12.0
    along = [origin + STEP * i for i in range(count + 1)]
    rows = [" ".join(f"{height(x, y):.6f}" for x in along) for y in reversed(along)]
    head = f"ncols {len(along)}\nnrows {len(along)}\nxllcenter {origin}\nyllcenter {origin}\ncellsize {STEP}\n"
    path.write_text(head + "\n".join(rows) + "\n", encoding="utf-8")


def finished_run(options, number, name, height, cell_size):
    out = options.out / f"ground{number}_{cell_size:.3f}"
    if not (out / "results.json").exists():
        raster, case = options.out / f"ground{number}.asc", options.out / f"ground{number}_{cell_size:.3f}.toml"
        if height is not None:
            write_raster(raster, height)
        terrain = f'[terrain]\nfile = "{raster.name}"' if height is not None else ""
        case.write_text(CASE.format(name=name, terrain=terrain, cell_size=cell_size), encoding="utf-8")
        subprocess.run([options.program, "run", case, "--out", out, *["--resume"] * out.exists()], check=True,
                       stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    return Run(out)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="build/release/bin/mpm")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/relief"))
    parser.add_argument("--cells", default="0.25,0.1666667", help="m")
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    cells = [float(text) for text in options.cells.split(",")]
    print("| ground before the mast | cells | " + " | ".join(COLUMNS) + " |\n|---|---|" + "---|" * len(COLUMNS))
    level = {}
    for number, (name, height) in enumerate(GROUNDS.items()):
        for cell_size in cells:
            results = finished_run(options, number, name, height, cell_size).results
            values = []
            for key, scale, unit, digits in COLUMNS.values():
                value = scale * (results[key][0] if isinstance(results[key], list) else results[key])
                first = level.setdefault((key, cell_size), value)
                change = f" ({100.0 * (value / first - 1.0):+.0f} %)" if height is not None else ""
                values.append(f"{value:.{digits}f} {unit}{change}")
            print(f"| {name} | {cell_size:.3g} m | " + " | ".join(values) + " |", flush=True)
    return 0


if __name__ == "__main__":
    sys.exit(main())
