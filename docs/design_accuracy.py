#!/usr/bin/python3
"""How accurate `mpm design` is: computes a square mast on 3, 5 and 7 cells and at four time steps, and writes the tables of docs/design.md.

    docs/design_accuracy.py [--program build/release/bin/mpm] [--out out/design_accuracy]

Runs that have finished are not repeated. The mast is that of examples/design/tower_own_snow.toml, in its snow "medium".
"""

import argparse
import datetime
import json
import os
import pathlib
import re
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT / "python"))
from mpmtools import Run  # noqa: E402  (after the path to the package)
from mpmtools.design.loads import Loads  # noqa: E402
from mpmtools.design.rounding import value_and_error  # noqa: E402
from mpmtools.files import read_toml  # noqa: E402
from mpmtools.program import run_program  # noqa: E402
from mpmtools.toml_text import toml_text  # noqa: E402

PAGE = ROOT / "docs" / "design.md"
SITE = ROOT / "examples" / "design" / "tower_own_snow.toml"
QUANTITIES = [("force_mean_n", "mean force, kN", 1e-3), ("force_first_impact_n", "first impact (0.1 s), kN", 1e-3),
              ("moment_mean_n_m", "overturning moment, kN m", 1e-3), ("runup_p99_mean_m", "run-up, m", 1.0),
              ("runup_mean_m", "highest particle, m", 1.0), ("pressure_height_mean_m", "pressure height, m", 1.0)]
STEPS = (0.2, 0.4, 0.8, 1.0)  # numerics.cfl


def entries_of(cells, out):
    """{quantity: entry of design.json} of a design whose finest grid has so many cells."""
    site, path = read_toml(str(SITE)), out / f"site_{cells}.toml"
    site["snow"], site["plan"] = [snow for snow in site["snow"] if snow["name"] == "medium"], {"finest_cells": cells}
    del site["mode"]
    path.write_text(toml_text(site), encoding="utf-8")
    subprocess.run([os.environ["MPM"], "design", path, "--out", out / "design"], check=True, stdout=subprocess.DEVNULL)
    quantities = json.loads((out / "design" / "design.json").read_text(encoding="utf-8"))["quantities"]
    return {key: quantities[key]["snows"]["medium"] for key, *_ in QUANTITIES}


def grid_table(out):
    coarse, fine = (entries_of(cells, out) for cells in (5, 7))
    rows, shares = [], []
    for key, label, scale in QUANTITIES:
        before, after = coarse[key], fine[key]
        change = after["value"] - before["value"]
        shares.append(abs(change) / before["uncertainty"])
        digits = 1 if scale < 1.0 else 2
        rows.append(f"| {label} | {value_and_error(before['value'], before['uncertainty'], scale)} | {change * scale:+.{digits}f} | "
                    f"{value_and_error(after['value'], after['uncertainty'], scale)} |")
    head = "| quantity | at 5 cells, from 3 and 5 | 7 cells | at 7 cells, from 3, 5, 7 |\n|---|---|---|---|\n"
    return head + "\n".join(rows) + f"\n\nThe differences are at most {100.0 * max(shares):.0f} % of the stated uncertainty."


def step_table(out):
    case = out / "design" / "runs" / "medium_w3" / "case.toml"
    rows = []
    for cfl in STEPS:
        run = out / f"cfl_{cfl:g}"
        run_program("run", case, "--set", f"numerics.cfl={cfl}", "--out", run, *["--resume"] * run.exists())
        values = Loads(Run(run)).values
        cells = [value_and_error(values[key].value, values[key].standard_error, scale) if key != "force_first_impact_n"
                 else f"{values[key].value * scale:.1f}" for key, _, scale in QUANTITIES if key not in ("moment_mean_n_m", "runup_mean_m")]
        rows.append(f"| {cfl:g} | {Run(run).results['steps']} | " + " | ".join(cells) + " |")
    return "| cfl | steps | mean force, kN | first impact (0.1 s), kN | run-up, m | pressure height, m |\n|---|---|---|---|---|---|\n" + "\n".join(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default="build/release/bin/mpm")
    parser.add_argument("--out", type=pathlib.Path, default=pathlib.Path("out/design_accuracy"))
    options = parser.parse_args()
    os.environ["MPM"] = os.path.abspath(options.program)
    options.out.mkdir(parents=True, exist_ok=True)
    commit = re.search(r"commit (\w+)", run_program("--version")[1])[1]
    for name, make in (("grids", grid_table), ("time step", step_table)):
        begin, end = f"<!-- measured: {name} -->\n", "\n<!-- /measured -->"
        text = f"{begin}\n{make(options.out)}\n\n(Commit {commit}, {datetime.date.today()}.)\n{end}"
        page = PAGE.read_text(encoding="utf-8")
        PAGE.write_text(page[:page.index(begin)] + text + page[page.index(end, page.index(begin)) + len(end):], encoding="utf-8")
    return 0


if __name__ == "__main__":
    sys.exit(main())
