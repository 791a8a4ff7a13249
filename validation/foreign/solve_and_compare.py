#!/usr/bin/python3
"""Solves validation cases with libmpm and with the solvers of this folder, grades all results, and puts them on one page.

usage: solve_and_compare.py BIN OUT [--record FILE] [CASE...]    BIN: the folder with mpm-validate and plain-mpm

OUT/index.html is the page, OUT/results.csv has a row for each check and solver. What OUT already has is not computed again. --record copies
results.csv to FILE. libmpm is graded like the others: by the states and forces that it writes. A check that fails is on the page and does
not change the exit code: 1 only if a solver or a grading did not end.
"""

import argparse
import csv
import json
import pathlib
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent.parent / "scripts"), str(HERE.parent.parent / "python")]
from reports.solver_comparison import draw_comparison  # noqa: E402  (after the path to the package)

# Which solvers are compared on a case: those that have its laws and boundaries, without the long runs of plain_mpm.
CASES = {
    "sliding_block": ("numpy_mpm", "plain_mpm"),
    "bar_on_wall": ("numpy_mpm", "plain_mpm"),
    "elastic_wave": ("numpy_mpm", "plain_mpm"),
    "dam_break": ("numpy_mpm",),
    "full_width_wall": ("numpy_mpm",),
    "free_flight": ("plain_mpm",),
    "compaction_shock": ("plain_mpm",),
}
COLUMNS = ("case", "quantity", "unit", "measure", "reference", "tolerance", "solver", "value", "error", "tolerance_used", "verdict")


def run(*command, accepted=(0,)):
    done = subprocess.run([str(part) for part in command], stdout=subprocess.DEVNULL, check=False)
    if done.returncode not in accepted:
        sys.exit(f"solve_and_compare: exit code {done.returncode} of: {' '.join(str(part) for part in command)}")


def reports_of(case, binaries, out):
    """Makes the reports of a case that are not there yet, libmpm's first."""
    validate, folder = binaries / "mpm-validate", out / case
    exported = folder / "exported"  # with the results of libmpm
    programs = {"libmpm": (validate, "export", case, "--out", exported, "--solve"),
                "numpy_mpm": (sys.executable, HERE / "numpy_mpm.py", exported, folder / "numpy_mpm"),
                "plain_mpm": (binaries / "plain-mpm", exported, folder / "plain_mpm")}
    reports = []
    for solver in ("libmpm", *CASES[case]):
        report, results = folder / f"{solver}-report", exported if solver == "libmpm" else folder / solver
        if not (report / "results.json").exists():
            print(f"{case}: {solver}", file=sys.stderr, flush=True)
            run(*programs[solver])
            run(validate, "grade", case, "--results", results, "--out", report, accepted=(0, 1))
        reports.append(report)
    return reports


def write_results(reports, file):
    """The checks of all reports as a table. Its first line says which program judged, and when."""
    all_results = [json.loads((report / "results.json").read_text(encoding="utf-8")) for report in reports]
    rows = [[{**check, "case": case["name"], "solver": results["solver"]}[name] for name in COLUMNS]
            for results in all_results for case in results["cases"] for check in case["checks"]]
    with open(file, "w", newline="", encoding="utf-8") as stream:
        made_by = sorted({f"libmpm {r['version']}, commit {r['commit']}, level {r['level']}, {r['started'][:10]}" for r in all_results})
        stream.write(f"# validation/foreign/solve_and_compare.py; {'; '.join(made_by)}\n")
        writer = csv.writer(stream, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows(rows)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("binaries", type=pathlib.Path, metavar="BIN")
    parser.add_argument("out", type=pathlib.Path, metavar="OUT")
    parser.add_argument("--record", type=pathlib.Path, metavar="FILE")
    parser.add_argument("cases", nargs="*", metavar="CASE")
    options = parser.parse_intermixed_args()  # CASE may follow an option
    if unknown := set(options.cases) - set(CASES):
        sys.exit(f"solve_and_compare: no solver for {', '.join(sorted(unknown))}; there are {', '.join(CASES)}")
    reports = [report for case in options.cases or CASES for report in reports_of(case, options.binaries, options.out)]
    draw_comparison(reports, options.out / "index.html")
    write_results(reports, options.out / "results.csv")
    if options.record:
        shutil.copy(options.out / "results.csv", options.record)
    print(options.out / "index.html", file=sys.stderr)


if __name__ == "__main__":
    main()
