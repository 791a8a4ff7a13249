"""What the scripts beside this file share: cases, runs by ranks, and the comparison of what they leave."""

import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
CONVEYOR = """title = "{name}"
[material]
model = "cohesive_cam_clay"
critical_state_slope = 0.4
cohesion_beta = {beta}
hardening_xi = 5.0
[conveyor]
froude_number = 3.0
width_m = 3.5
upstream_length_m = {upstream}
downstream_length_m = 2.0
feed = "{feed}"
mirror_y = {mirror}
[obstacle]
friction = 0.3
{shape}
[numerics]
cell_size_m = {cell_size}
{numerics}
[output]
duration_s = {duration}
series_per_second = 50
frames_per_second = 25
checkpoint_minutes = 1e-6
"""
DEFAULTS = {"beta": 0.0, "upstream": 2.0, "feed": "window", "mirror": "true", "shape": "", "numerics": "", "cell_size": 0.35, "duration": 0.16}
NODAL, SURFACE = 'contact = "nodal"\nlattice = "aligned"\n', 'contact = "surface"\n'
# feed by a window unless it says otherwise; a checkpoint at every sample
CASES = {
    "apic": {"numerics": NODAL + 'transfer = "apic"'},
    "flip_cohesion": {"beta": 0.3, "numerics": NODAL + 'transfer = "flip"\nflip_ratio = 0.95'},
    "aflip_surface": {"numerics": SURFACE + 'transfer = "aflip"'},
    "cylinder_whole": {"mirror": "false", "shape": 'shape = "cylinder"\nwidth_m = 1.75\nheight_m = 1.0', "numerics": SURFACE + 'transfer = "aflip"',
                       "cell_size": 0.4375},
    "strip": {"feed": "strip", "numerics": SURFACE + 'transfer = "aflip"', "duration": 0.12},
    "single_precision": {"numerics": SURFACE + 'transfer = "aflip"\nprecision = "single"'},
}
OF_THE_MACHINE = ("results.json", "run.log", "ranks.json", ".lock", "checkpoint.h5", "checkpoint_previous.h5")


def arguments(text):
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/mpi/bin/mpm", help="mpm, built with MPI")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out/ranks", help="folder for the runs; it is emptied")
    return parser


def prepare(options):
    if not options.program.exists():
        sys.exit(f"{options.program} is not there: `./run build mpi`")
    options.program = options.program.resolve()
    shutil.rmtree(options.out, ignore_errors=True)
    options.out.mkdir(parents=True)
    options.out = options.out.resolve()


def write_case(folder, name, **changes):
    path = folder / f"{name}.toml"
    path.write_text(CONVEYOR.format(name=name, **{**DEFAULTS, **CASES[name], **changes}), encoding="utf-8")
    return path


def launcher(ranks):
    """Open MPI on a machine with fewer cores than ranks: who waits gives way."""
    if ranks == 1:
        return []
    return ["mpirun", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "--mca", "mpi_yield_when_idle", "1",
            "--mca", "btl_vader_single_copy_mechanism", "none", "-np", str(ranks)]


def command(options, case, out, ranks=1, threads=1, more=()):
    return [*launcher(ranks), str(options.program), "run", str(case), "--out", str(out), "--threads", str(threads), *more]


def environment(rebalance=0):
    variables = {**os.environ, "OMP_WAIT_POLICY": "passive"}
    if rebalance:
        variables["MPM_REBALANCE_STEPS"] = str(rebalance)
    return variables


def run(options, case, out, ranks=1, threads=1, more=(), rebalance=0, expected=0):
    """@returns what the run wrote to stderr. Ends the script where the exit code is not the expected one."""
    done = subprocess.run(command(options, case, out, ranks, threads, more), env=environment(rebalance), capture_output=True, text=True, check=False)
    if done.returncode != expected:
        sys.exit(f"{out}: exit code {done.returncode}, not {expected}:\n{done.stderr}")
    return done.stderr


def files(folder):
    found = {}
    for path in sorted(folder.rglob("*")):
        name = str(path.relative_to(folder))
        if path.is_file() and name not in OF_THE_MACHINE and not re.fullmatch(r"checkpoint.*", name):
            found[name] = path.read_bytes()
    return found


def differences(expected, folder):
    """Names of files that are missing, new, or of other bytes. @param expected: files() of another run"""
    found = files(folder)
    if not {"final.h5", "series.csv"} <= set(expected):
        sys.exit(f"{folder}: the reference is not complete: {sorted(expected)}")
    return sorted(name for name in expected.keys() | found.keys() if expected.get(name) != found.get(name))
