#!/usr/bin/python3
"""A long run under watch: `./run soak [--hours H]`.

Slow snow (Fr 0.3) flows past a mast on the endless belt: particles enter and leave all the time, the pages that hold them are taken and
given back, and frames and checkpoints are written as a user would have them. After H hours of wall time the run is stopped by
SIGTERM, and resumed for a moment so that it ends as a run does. Asserted:

memory    the resident memory of the process does not rise: the slope of its samples over the second half (Theil and Sen: the median of
          the slopes between pairs, which single peaks do not move) is below a bound. The first half fills the pools and grows the pile of
          snow in front of the mast. One thing does grow, by design: the measurements from which results.json is made are kept, a known number
          of doubles a sample. The bound is twice that (a vector that grows may hold twice what it needs) plus 1 % of the resident
          memory an hour: what a pile that still moves, and an allocator, may do; a leak of one particle record (192 bytes) in a hundred that
          enter would be twice as much. Nor does its peak rise: checkpoints and frames are put together in memory, and the allocator
          gives that back now and then, so that single samples are up to twice the rest; the highest of the second half is at most a tenth above the
          highest of the first (the number of particles, and so the size of a checkpoint, varies by some per cent).
mass      initial + entered = inside + left, to the last particle: in results.json; inside as counted in final.h5, whose identity numbers
          must all be different and below initial + entered. And the same in kilograms, to the round-off of sums over so many terms.
series    rows of series.csv: one a sample, times increasing.
"""

import argparse
import csv
import json
import os
import pathlib
import re
import signal
import statistics
import subprocess
import sys
import time

import h5py

ROOT = pathlib.Path(__file__).resolve().parent.parent
CASE = ROOT / "examples" / "avalanche_fr03.toml"
SAMPLES_PER_SECOND = 2.0
SETTINGS = {
    "numerics.cell_size_m": 0.4375,  # a quarter of the mast: 21,000 particles, so that an hour is a thousand seconds of snow or more
    "output.series_per_second": SAMPLES_PER_SECOND,
    "output.frames_per_second": 0.05,
    "output.checkpoint_minutes": 1,
}
PAIRS = 400  # samples that the slope looks at, evenly spaced: 80,000 pairs
GROWTH = 0.01  # of the resident memory an hour, see above
PEAK_GROWTH = 0.1  # of the peak, see above
STOP_SECONDS = 120.0  # from SIGTERM to the end: one sample interval and a checkpoint, on a busy machine


def resident_bytes(pid):
    """Resident memory of a process; None when it has ended."""
    try:
        for line in pathlib.Path(f"/proc/{pid}/status").read_text().splitlines():
            if line.startswith("VmRSS:"):
                return int(line.split()[1]) * 1024
    except (FileNotFoundError, ProcessLookupError):
        pass
    return None


def theil_sen(x, y):
    """Median of the slopes between all pairs."""
    return statistics.median((y[j] - y[i]) / (x[j] - x[i]) for i in range(len(x)) for j in range(i + 1, len(x)))


def command(arguments, duration, *more):
    line = [str(arguments.mpm), "run", str(CASE), "--out", str(arguments.out / "run"), "--threads", str(arguments.threads)]
    for key, value in {**SETTINGS, "output.duration_s": duration}.items():
        line += ["--set", f"{key}={value}"]
    return line + list(more)


def watch(arguments, environment):
    """Runs for the hours asked for. Returns samples (s, bytes), and how the process ended."""
    with open(arguments.out / "run.txt", "w") as output:
        process = subprocess.Popen(command(arguments, 1e6, "--force"), stdout=output, stderr=subprocess.STDOUT, env=environment)
        begin, samples = time.monotonic(), []
        try:
            while process.poll() is None and time.monotonic() - begin < 3600.0 * arguments.hours:
                size = resident_bytes(process.pid)
                if size:  # none yet while the program starts
                    samples.append((time.monotonic() - begin, size))
                time.sleep(min(arguments.every, max(0.1, 3600.0 * arguments.hours - (time.monotonic() - begin))))
            process.terminate()
            process.wait(timeout=STOP_SECONDS)
        finally:
            process.kill()
    return samples, process.returncode


def plot(arguments, samples, slope, bound):
    import matplotlib

    matplotlib.use("Agg")
    from matplotlib import pyplot

    minutes = [t / 60.0 for t, _ in samples]
    megabytes = [size / 1e6 for _, size in samples]
    figure, axes = pyplot.subplots(figsize=(8, 4.5))
    axes.plot(minutes, megabytes, ".", markersize=3, color="tab:blue", label="process, sampled (higher: after putting a checkpoint or frame together)")
    half = 0.5 * (minutes[0] + minutes[-1])
    later = [(t, m) for t, m in zip(minutes, megabytes) if t >= half]
    middle_t, middle = statistics.median(t for t, _ in later), statistics.median(m for _, m in later)
    for rate, style, label in ((slope, "-", "slope of the second half"), (bound, "--", "largest slope allowed")):
        line = [middle + rate / 60e6 * (t - middle_t) for t in (half, minutes[-1])]
        axes.plot((half, minutes[-1]), line, style, color="black", linewidth=1.0, label=f"{label}: {rate / 1e6:.2f} MB/h")
    axes.set_ylim(0.0, 1.4 * max(megabytes))
    axes.set_xlabel("wall time / min")
    axes.set_ylabel("resident memory / MB")
    axes.set_title(f"Memory of `mpm run` over {samples[-1][0] / 3600.0:.2g} h: snow at Fr 0.3 flowing past a mast")
    axes.legend(loc="upper right", fontsize="small")
    figure.tight_layout()
    figure.savefig(arguments.out / "memory.png", dpi=110)


class Checks:
    def __init__(self):
        self.rows = []

    def add(self, name, holds, figure):
        self.rows.append((name, figure, "holds" if holds else "FAILS"))

    def all_hold(self):
        return all(verdict == "holds" for _, _, verdict in self.rows)


def main():
    parser = argparse.ArgumentParser(description="A long run under watch: flat memory, and mass conserved to the last particle.")
    parser.add_argument("--hours", type=float, default=1.0, help="wall time (default: %(default)s)")
    parser.add_argument("--every", type=float, default=5.0, help="seconds between samples of the memory (default: %(default)s)")
    parser.add_argument("--threads", type=int, default=os.cpu_count())
    parser.add_argument("--mpm", type=pathlib.Path, default=ROOT / "build" / "release" / "bin" / "mpm", help="program (default: %(default)s)")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out" / "soak", help="folder of the results (default: %(default)s)")
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    environment = {**os.environ, "OMP_WAIT_POLICY": "passive"}
    checks = Checks()

    print(f"soak: {arguments.hours:g} h of wall time, {arguments.threads} thread(s), into {arguments.out}", flush=True)
    samples, code = watch(arguments, environment)
    output = (arguments.out / "run.txt").read_text()
    checks.add("ran until SIGTERM, then stopped with a checkpoint", code == -signal.SIGTERM and "--resume" in output, f"exit by {code}")
    if not checks.all_hold():
        print(output[-2000:], file=sys.stderr)
        return 1

    # The moment after: one more sample than there is, so that the run ends and writes its results.
    with open(arguments.out / "run" / "series.csv", newline="") as file:
        before = sum(1 for _ in csv.reader(file)) - 1
    finished = subprocess.run(command(arguments, before / SAMPLES_PER_SECOND, "--resume"), env=environment, capture_output=True, text=True)
    checks.add("resumed to its end", finished.returncode == 0, f"exit code {finished.returncode}")
    if not checks.all_hold():
        print(finished.stderr, file=sys.stderr)
        return 1

    results = json.loads((arguments.out / "run" / "results.json").read_text())
    with open(arguments.out / "run" / "series.csv", newline="") as file:
        series = [{name: float(value) for name, value in row.items()} for row in csv.DictReader(file)]
    times = [row["time_s"] for row in series]
    steps_in_time = all(b > a for a, b in zip(times, times[1:]))
    checks.add("one row a sample, times increase", len(series) == before + 1 and steps_in_time, f"{len(series)} rows, {times[-1]:g} s")

    came = results["particles_initial"] + results["particles_entered"]
    here = results["particles_final"] + results["particles_left"]
    checks.add("particles: initial + entered = inside + left", came == here,
               f"{results['particles_initial']} + {results['particles_entered']} = {results['particles_final']} + {results['particles_left']}")
    with h5py.File(arguments.out / "run" / "final.h5") as final:
        identities = final["id"][:]
    distinct = set(identities.tolist())
    checks.add("final.h5 holds each of them once", len(identities) == results["particles_final"] == len(distinct) and max(distinct) < came,
               f"{len(distinct)} different numbers below {came}")
    initial_mass, final_mass = series[0]["mass_kg"], series[-1]["mass_kg"]
    difference = initial_mass + results["mass_entered_kg"] - final_mass - results["mass_left_kg"]
    # A sum of n terms in sequence errs by at most n eps of its value.
    allowed = came * sys.float_info.epsilon * (initial_mass + results["mass_entered_kg"])
    checks.add("mass: initial + entered = inside + left", abs(difference) <= allowed, f"differ by {difference:.3g} kg, round-off at most {allowed:.3g} kg")
    turnover = results["particles_left"] / results["particles_initial"]
    checks.add("the snow was replaced at least ten times an hour", turnover >= 10.0 * arguments.hours, f"{turnover:.1f} times")

    half = 0.5 * (samples[0][0] + samples[-1][0])
    later = [s for s in samples if s[0] >= half]
    later = later[:: max(1, len(later) // PAIRS)]
    slope = 3600.0 * theil_sen([t for t, _ in later], [size for _, size in later])  # bytes an hour
    with h5py.File(arguments.out / "run" / "checkpoint.h5") as checkpoint:
        bins = int(checkpoint.attrs["profile_bins"])
    kept = 8 * (12 + bins)  # time, five figures, force and moment; the profile
    rate = kept * len(series) / (samples[-1][0] / 3600.0)
    typical = statistics.median(size for _, size in later)
    bound = 2.0 * rate + GROWTH * typical
    checks.add("memory does not rise in the second half", slope <= bound,
               f"{slope / 1e6:.2f} MB/h at {typical / 1e6:.1f} MB; at most {bound / 1e6:.2f} MB/h, of which {2 * rate / 1e6:.2f} for {kept} bytes a sample")

    peaks = max(size for t, size in samples if t < half), max(size for t, size in samples if t >= half)
    checks.add("nor does its peak", peaks[1] <= (1.0 + PEAK_GROWTH) * peaks[0] + 2.0 * rate, f"{peaks[0] / 1e6:.1f} MB in the first half, {peaks[1] / 1e6:.1f} MB in the second")

    with open(arguments.out / "memory.csv", "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["wall_time_s", "resident_bytes"])
        writer.writerows((f"{t:.1f}", size) for t, size in samples)
    plot(arguments, samples, slope, bound)
    version = re.search(r"commit ([\w-]+)", subprocess.run([arguments.mpm, "--version"], capture_output=True, text=True).stdout)
    lines = [f"`./run soak --hours {arguments.hours:g}`, commit {version.group(1) if version else 'unknown'}, {arguments.threads} thread(s): "
             f"{results['duration_s']:g} s of snow in {samples[-1][0] / 3600.0:.2f} h, {results['steps']} steps, "
             f"{results['particle_steps']:.4g} particle-steps, {len(list((arguments.out / 'run' / 'frames').glob('*.h5')))} frames.", "",
             "| check | figure | verdict |", "|---|---|---|"]
    lines += [f"| {name} | {figure} | {verdict} |" for name, figure, verdict in checks.rows]
    (arguments.out / "soak.md").write_text("\n".join(lines) + "\n")
    print("\n".join(lines))
    print("soak: everything holds" if checks.all_hold() else "soak: FAILED")
    return 0 if checks.all_hold() else 1


if __name__ == "__main__":
    sys.exit(main())
