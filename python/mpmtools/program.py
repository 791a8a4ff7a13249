"""The program `mpm`, started from Python: where it is, its errors as exceptions, its progress."""

import os
import pathlib
import pty
import re
import shutil
import subprocess
import sys
from typing import NamedTuple

from mpmtools.errors import ConfigError, InputError, MpmError, UnstableError

ERRORS = {2: ConfigError, 3: UnstableError, 4: InputError}  # the exit codes of `mpm`
PROGRESS = re.compile(r"^\s*([\d.]+) %  t = ([\d.]+) of (\S+) s .* (\S+(?: \w+)?) left$")


class Progress(NamedTuple):
    """How far a run is."""

    fraction: float  # done, 0 to 1
    time_s: float  # simulated
    duration_s: float  # to be simulated
    left: str  # estimated wall time that is left, such as "1:30" (minutes and seconds)


def find_program(name="mpm"):
    """Path of a program of libmpm: what the environment variable MPM names (for others: what is beside it), else what is on the PATH,
    else what was built in the source tree of this package, else what is installed beside this Python.

    name: "mpm", "mpm-validate" or "bench_paired". Raises InputError where there is none.
    """
    if chosen := os.environ.get("MPM"):
        path = pathlib.Path(chosen) if name == "mpm" else pathlib.Path(chosen).with_name(name)
        if not os.access(path, os.X_OK):
            raise InputError(f"MPM={chosen}: there is no program {path}; set MPM to the path of mpm")
        return str(path)
    if on_path := shutil.which(name):
        return on_path
    source = pathlib.Path(__file__).resolve().parents[2]
    for path in (source / "build" / "release" / "bin" / name, pathlib.Path(sys.prefix) / "bin" / name):
        if os.access(path, os.X_OK):
            return str(path)
    raise InputError(f"the program '{name}' is not found; build it with ./run build and put build/release/bin on the PATH, or set MPM "
                     "to the path of mpm")


def run_program(*arguments, name="mpm", accepted=(0,)):
    """Runs a program to its end. Returns (exit code, standard output, standard error); an exit code that is not accepted raises."""
    done = subprocess.run([find_program(name), *map(str, arguments)], stdin=subprocess.DEVNULL, capture_output=True, text=True, check=False)
    if done.returncode not in accepted:
        raise_for(done.returncode, done.stderr, f"{name} {arguments[0]}")
    return done.returncode, done.stdout, done.stderr


def raise_for(code, messages, command):
    """The exception that belongs to an exit code of `mpm`, with its messages other than warnings and progress."""
    errors = [line for line in messages.splitlines() if line.strip() and not line.startswith("warning: ") and not PROGRESS.match(line)]
    raise ERRORS.get(code, MpmError)("\n".join(errors) or f"{command} ended with exit code {code}")


def run_with_progress(*arguments, progress=None):
    """Runs `mpm` to its end and reports how far it is. Returns (standard output, messages).

    progress: a function of a Progress, called a few times a second; None: nothing is reported. An interruption (Ctrl-C, or the stop button of
    a notebook) goes on to the program, which writes a checkpoint.
    """
    try:
        reader, writer = pty.openpty()  # on a terminal the program reports often
    except OSError:  # no terminals here, as in a bare chroot: through a pipe it reports every ten seconds
        reader, writer = os.pipe()
    process = subprocess.Popen([find_program(), *map(str, arguments)], stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=writer)
    os.close(writer)
    messages = []
    try:
        for line in _lines(reader):
            if (found := PROGRESS.match(line)) is None:
                messages.append(line)
            elif progress:
                progress(Progress(float(found[1]) / 100.0, float(found[2]), float(found[3]), found[4]))
        output = process.stdout.read().decode()
        code = process.wait()
    except BaseException:
        process.terminate()
        process.wait()
        raise
    finally:
        os.close(reader)
        process.stdout.close()
    text = "\n".join(messages)
    if code != 0:
        raise_for(code, text, f"mpm {arguments[0]}")
    return output, text


def run_with_bar(label, progress, *arguments):
    """run_with_progress for those who take `progress`: True shows a bar of this label; a function of a Progress is called; False: nothing."""
    bar = ProgressBar(label) if progress is True else None
    try:
        return run_with_progress(*arguments, progress=bar or progress or None)
    finally:
        if bar:
            bar.close()


def _lines(descriptor):
    """What a terminal shows, line by line, without its control sequences."""
    kept = b""
    while True:
        try:
            block = os.read(descriptor, 65536)
        except OSError:  # EIO: the program has ended
            block = b""
        *lines, kept = re.split(rb"[\r\n]+", kept + block)
        if not block and kept:
            lines.append(kept)
        for line in lines:
            if text := re.sub(r"\x1b\[[\d;]*[A-Za-z]", "", line.decode(errors="replace")).rstrip():
                yield text
        if not block:
            return


class ProgressBar:
    """A bar on the standard error, on one line."""

    WIDTH = 30

    def __init__(self, label):
        self.label, self.shown = label, 0

    def __call__(self, progress):
        full = round(self.WIDTH * progress.fraction)
        line = (f"{self.label} [{'#' * full}{' ' * (self.WIDTH - full)}] {100 * progress.fraction:3.0f} %, "
                f"t = {progress.time_s:.2f} of {progress.duration_s:g} s, {progress.left} left")
        print("\r" + line.ljust(self.shown), end="", file=sys.stderr, flush=True)
        self.shown = len(line)

    def close(self):
        if self.shown:
            print(file=sys.stderr)
