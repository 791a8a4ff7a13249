#!/usr/bin/python3
"""Speed of 2 ranks x 1 thread over that of 1 rank x 2 threads: pairs of runs, and the median of the ratios.

    tests/mpi/pairs.py CASE.toml... [--set table.key=value]... [--pairs 9] [--program build/mpi/bin/mpm] [--plain build/release/bin/mpm]

Each pair runs `threads` (1 rank, 2 threads) and `ranks` (2 ranks, 1 thread each) of the same program one after the other; with --plain also its
1 rank x 2 threads. The order alternates from pair to pair, so that a slow change of the machine's speed cancels. Speed is that of results.json:
particle-steps over the time of the steps, without files. Run it on an idle machine of two cores: the load average is printed with each pair.
The last lines give, for each case, the median and the range of the ratios, and the time that a rank waited in a step (ranks.json).
"""

import json
import os
import pathlib
import statistics
import subprocess
import sys

import rank_runs as runs


def measure(options, program, case, ranks, out):
    """@returns million particle-steps per second"""
    words = [str(program), "run", str(case), "--out", str(out), "--force", "--threads", str(2 // ranks), *options.more]
    launched = [*runs.launcher(ranks), *words] if ranks > 1 else words
    # not runs.environment(): threads that wait passively would slow the run on threads
    done = subprocess.run(launched, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True, check=False)
    if done.returncode != 0:
        sys.exit(f"{out}: exit code {done.returncode}:\n{done.stderr}")
    return json.loads((out / "results.json").read_text())["million_particle_steps_per_s"]


def waiting(out):
    """@returns a line: the longest times that a rank waited, for each step"""
    ranks = json.loads((out / "ranks.json").read_text())["ranks"]
    names = [name for name in ranks[0] if name.endswith("_wait_s")]
    times = ", ".join(f"{name.removesuffix('_wait_s')} {1e6 * max(r[name] for r in ranks) / ranks[0]['steps']:.0f}" for name in names)
    return f"longest waiting of a rank, us in a step, last run: {times}"


def compare(options, case):
    ways = {"threads": (options.program, 1), "ranks": (options.program, 2)}
    if options.plain:
        ways["plain"] = (options.plain.resolve(), 1)
    speeds = {name: [] for name in ways}
    for pair in range(options.pairs):
        for name in list(ways)[:: 1 if pair % 2 == 0 else -1]:
            program, ranks = ways[name]
            speeds[name].append(measure(options, program, case, ranks, options.out / f"{case.stem}_{name}"))
        print(f"{case.stem}, load {os.getloadavg()[0]:.1f}: " + ", ".join(f"{name} {values[-1]:.3f} M/s" for name, values in speeds.items()), flush=True)
    lines = []
    for other in set(ways) - {"ranks"}:
        ratios = [a / b for a, b in zip(speeds["ranks"], speeds[other])]
        lines.append(f"{case.stem}: ranks over {other}: median {statistics.median(ratios):.3f} of {len(ratios)} pairs "
                     f"({min(ratios):.3f} to {max(ratios):.3f})")
    return [*lines, f"{case.stem}: {waiting(options.out / f'{case.stem}_ranks')}"]


def main():
    parser = runs.arguments(__doc__)
    parser.add_argument("case", type=pathlib.Path, nargs="+")
    parser.add_argument("--plain", type=pathlib.Path, help="mpm, built without MPI")
    parser.add_argument("--set", action="append", default=[], metavar="table.key=value", help="for all cases; may be repeated")
    parser.add_argument("--pairs", type=int, default=9, help="for each case (default: %(default)s)")
    options = parser.parse_args()
    options.more = [word for key in options.set for word in ("--set", key)]
    cases = [case.resolve() for case in options.case]
    runs.prepare(options)
    lines = [line for case in cases for line in compare(options, case)]
    print("\n".join([runs.provenance(options), *lines]))
    return 0


if __name__ == "__main__":
    sys.exit(main())
