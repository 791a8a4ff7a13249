"""What the scripts beside this file share: cases, runs by ranks, and the comparison of what they leave."""

import argparse
import datetime
import json
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import time

ROOT = pathlib.Path(__file__).resolve().parents[2]
# A checkpoint at every sample.
CONVEYOR = """title = "{name}"
[material]
model = "cohesive_cam_clay"
critical_state_slope = 0.4
cohesion_beta = {beta}
hardening_xi = 5.0
[conveyor]
froude_number = 3.0
width_m = {width}
{feed}
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
WINDOW = 'feed = "window"\nupstream_length_m = 3.0\ndownstream_length_m = 2.0'
DEFAULTS = {"beta": 0.0, "width": 7.0, "feed": WINDOW, "mirror": "true", "shape": "", "numerics": "", "cell_size": 0.35, "duration": 0.2}
NODAL, SURFACE = 'contact = "nodal"\n', 'contact = "surface"\n'
# The cases by name, each with its changes of DEFAULTS: every transfer, both rules of contact, both feeds, a round mast in a whole flow, both
# precisions.
CASES = {
    "apic_window": {"numerics": NODAL + 'transfer = "apic"'},
    "flip_cohesion_window": {"beta": 0.3, "numerics": NODAL + 'transfer = "flip"\nflip_ratio = 0.95'},
    "aflip_window": {"numerics": SURFACE + 'transfer = "aflip"'},
    "aflip_round_mast": {"mirror": "false", "width": 14.0, "shape": 'shape = "cylinder"\nwidth_m = 0.8\nheight_m = 1.0',
                         "numerics": SURFACE + 'transfer = "aflip"', "cell_size": 0.4375},
    "aflip_strip": {"feed": 'feed = "strip"', "numerics": SURFACE + 'transfer = "aflip"'},
    "single_precision": {"numerics": SURFACE + 'transfer = "aflip"\nprecision = "single"'},
}
OF_THE_MACHINE = r"results\.json|run\.log|ranks\.json|\.lock|checkpoint.*"
NOTE_PID = 'echo $$ > "$0.$OMPI_COMM_WORLD_RANK"; exec "$@"'  # the shell of a rank becomes the rank


def arguments(text):
    parser = argparse.ArgumentParser(description=text, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/mpi/bin/mpm", help="mpm, built with MPI (default: %(default)s)")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out/ranks", help="folder for the runs; it is emptied (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=18, help="of random ranks and moments (default: %(default)s)")
    return parser


def prepare(options):
    if not options.program.exists():
        sys.exit(f"{options.program} is not there: `./run build mpi`")
    options.program = options.program.resolve()
    shutil.rmtree(options.out, ignore_errors=True)
    options.out.mkdir(parents=True)
    options.out = options.out.resolve()


def provenance(options):
    """@returns command, commit of the program, date: one line"""
    version = subprocess.run([options.program, "--version"], capture_output=True, text=True, check=True).stdout
    commit = re.search(r"commit ([\w-]+)", version)
    return f"`{' '.join([str(pathlib.Path(sys.argv[0]).resolve().relative_to(ROOT)), *sys.argv[1:]])}`, commit " \
           f"{commit.group(1) if commit else 'unknown'}, {datetime.date.today()}"


def write_case(folder, name, **changes):
    path = folder / f"{name}.toml"
    path.write_text(CONVEYOR.format(name=name, **{**DEFAULTS, **CASES[name], **changes}), encoding="utf-8")
    return path


def launcher(ranks):
    """Open MPI on a machine with fewer cores than ranks: who waits gives way."""
    return ["mpirun", "--allow-run-as-root", "--oversubscribe", "--bind-to", "none", "--mca", "mpi_yield_when_idle", "1",
            "--mca", "btl_vader_single_copy_mechanism", "none", "-np", str(ranks)]


def command(options, case, out, threads=1, more=()):
    return [str(options.program), "run", str(case), "--out", str(out), "--threads", str(threads), *more]


def environment(rebalance=0):
    variables = {**os.environ, "OMP_WAIT_POLICY": "passive"}
    if rebalance:
        variables["MPM_REBALANCE_STEPS"] = str(rebalance)
    return variables


def run(options, case, out, ranks=1, threads=1, more=(), rebalance=0, expected=0):
    """@returns what the run wrote to stderr. Ends the script where the exit code is not the expected one."""
    words = [*(launcher(ranks) if ranks > 1 else []), *command(options, case, out, threads, more)]
    done = subprocess.run(words, env=environment(rebalance), capture_output=True, text=True, check=False)
    if done.returncode != expected:
        sys.exit(f"{out}: exit code {done.returncode}, not {expected}:\n{done.stderr}")
    return done.stderr


class Disturbed:
    """A run by ranks whose processes are known by rank."""

    def __init__(self, options, case, out, ranks, threads=1, rebalance=0):
        notes = options.out / f"{out.name}.pid"
        self.hanging = 0
        self.out, self.pids = out, [pathlib.Path(f"{notes}.{r}") for r in range(ranks)]
        self.log = options.out / f"{out.name}.err"
        with open(self.log, "w", encoding="utf-8") as log:
            words = [*launcher(ranks), "bash", "-c", NOTE_PID, str(notes), *command(options, case, out, threads)]
            self.process = subprocess.Popen(words, env=environment(rebalance), stdout=subprocess.DEVNULL, stderr=log)  # pylint: disable=consider-using-with

    def rows(self):
        """Rows of series.csv by now."""
        try:
            return max(0, (self.out / "series.csv").read_bytes().count(b"\n") - 1)
        except FileNotFoundError:
            return 0

    def wait_for_rows(self, number):
        while self.rows() < number and self.process.poll() is None:
            time.sleep(0.002)

    def send(self, rank, number):
        """@returns whether there was a process of that rank to send it to"""
        try:
            os.kill(int(self.pids[rank].read_text()), number)
        except (OSError, ValueError):
            return False
        return True

    def kill(self, rank):
        return self.send(rank, signal.SIGKILL)

    def end(self, seconds):
        """@returns the launcher's exit code; None if it did not end in time: it is killed, and `hanging` says how many ranks were still there"""
        try:
            return self.process.wait(timeout=seconds)
        except subprocess.TimeoutExpired:
            self.hanging = sum(self.lives(r) for r in range(len(self.pids)))
            self.process.kill()
            self.process.wait()
            return None

    def lives(self, rank):
        try:
            return pathlib.Path(f"/proc/{self.pids[rank].read_text().strip()}/stat").read_text().rsplit(")", 1)[1].split()[0] != "Z"
        except FileNotFoundError:
            return False

    def finished(self):
        return (self.out / "results.json").exists()


def files(folder):
    """Contents of the files that must not depend on ranks, by name."""
    return {str(path.relative_to(folder)): path.read_bytes() for path in sorted(folder.rglob("*"))
            if path.is_file() and not re.fullmatch(OF_THE_MACHINE, path.name)}


def differences(expected, folder):
    """Names of files that are missing, new, or of other bytes. @param expected: files() of another run"""
    if not {"final.h5", "series.csv", "profile.csv", "frames/00003.h5"} <= set(expected):
        sys.exit(f"{folder}: the reference is not complete: {sorted(expected)}")
    found = files(folder)
    return sorted(name for name in expected.keys() | found.keys() if expected.get(name) != found.get(name))


def busiest(out):
    """The largest share of the particles that a rank held at the end, of all."""
    held = [rank["particles"] for rank in json.loads((out / "ranks.json").read_text())["ranks"]]
    return max(held) / sum(held)
