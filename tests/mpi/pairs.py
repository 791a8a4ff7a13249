#!/usr/bin/python3
"""Speed and memory of ranks against threads: paired runs, interleaved, medians of the ratios.

    tests/mpi/pairs.py CASE.toml [--set table.key=value]... [--pairs 5] [--program build/mpi/bin/mpm] [--plain build/release/bin/mpm]

threads: 1 rank x 2 threads; ranks: 2 ranks x 1 thread, of the same program; and with --plain its 1 rank x 2 threads. Speed is that of
results.json, by wall time: on a loaded machine only the ratios mean something, and these little; the load average is printed with them. Memory is
the sum over the ranks of VmHWM, divided by the particles at the end.
"""

import json
import os
import pathlib
import statistics
import subprocess
import sys
import threading
import time

import rank_runs as runs


def peak_memory(process):
    """VmHWM of all programs `mpm` below a process while it runs, byte: the largest sum seen."""
    most = {}

    def watch():
        while process.poll() is None:
            for status in pathlib.Path("/proc").glob("[0-9]*/status"):
                try:
                    lines = dict(line.split(":\t", 1) for line in status.read_text().splitlines() if ":\t" in line)
                    if lines["Name"].strip() == "mpm" and os.getpgid(int(status.parent.name)) in groups:
                        most[status.parent.name] = 1024 * int(lines["VmHWM"].split()[0])
                except (OSError, KeyError, ValueError):
                    continue  # it has ended
            time.sleep(0.2)

    groups = {os.getpgid(process.pid)}
    # mpirun gives each rank a process group of its own
    def collect_groups():
        while process.poll() is None:
            for stat in pathlib.Path("/proc").glob("[0-9]*/stat"):
                try:
                    fields = stat.read_text().rsplit(")", 1)[1].split()
                    if int(fields[1]) == process.pid:
                        groups.add(int(fields[2]))
                except (OSError, IndexError, ValueError):
                    continue
            time.sleep(0.2)

    threads = [threading.Thread(target=f) for f in (watch, collect_groups)]
    for t in threads:
        t.start()
    process.wait()
    for t in threads:
        t.join()
    return sum(most.values())


def measure(options, program, case, ranks, threads, out):
    options.program = program
    with subprocess.Popen([*runs.command(options, case, out, ranks, threads, ["--force", *options.more])], stdout=subprocess.DEVNULL,
                          stderr=subprocess.PIPE, text=True, start_new_session=True) as process:
        memory = peak_memory(process)
        err = process.stderr.read()
    if process.returncode != 0:
        sys.exit(err)
    results = json.loads((out / "results.json").read_text())
    return results["million_particle_steps_per_s"], memory / results["particles_final"]


def main():
    parser = runs.arguments(__doc__)
    parser.add_argument("case", type=pathlib.Path)
    parser.add_argument("--plain", type=pathlib.Path, help="mpm, built without MPI")
    parser.add_argument("--set", action="append", default=[], metavar="table.key=value")
    parser.add_argument("--pairs", type=int, default=5)
    options = parser.parse_args()
    runs.prepare(options)
    options.more = [word for key in options.set for word in ("--set", key)]
    ways = {"threads": (options.program, 1, 2), "ranks": (options.program, 2, 1)}
    if options.plain:
        ways["plain"] = (options.plain.resolve(), 1, 2)
    found = {name: [] for name in ways}
    for _ in range(options.pairs):
        for name, (program, ranks, threads) in ways.items():
            found[name].append(measure(options, program, options.case.resolve(), ranks, threads, options.out / name))
        print(f"load {os.getloadavg()[0]:.1f}: " + ", ".join(f"{name} {values[-1][0]:.3f} M/s, {values[-1][1]:.0f} bytes a particle"
                                                             for name, values in found.items()), flush=True)
    for other in set(ways) - {"ranks"}:
        for what, place in (("speed", 0), ("memory", 1)):
            ratios = [a[place] / b[place] for a, b in zip(found["ranks"], found[other])]
            print(f"{what} of ranks over {other}: median {statistics.median(ratios):.3f} of {len(ratios)} pairs "
                  f"({min(ratios):.3f} to {max(ratios):.3f})")
    return 0


if __name__ == "__main__":
    sys.exit(main())
