"""Source trees whose speed is compared: copies of this tree, of a folder or of a commit, built alike beside each other under build/bench."""

import os
import pathlib
import re
import shutil
import subprocess
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
WORK = ROOT / "build" / "bench"
CALLGRIND_FLAGS = "-march=haswell"  # valgrind 3.19 knows no AVX-512


class Failure(Exception):
    """A tool failed: exit code 1."""

    code = 1


class UsageError(Failure):
    code = 2


def say(text):
    print(f"== {text}", file=sys.stderr, flush=True)


def run(command, **options):
    """Output of a command; Failure with the last lines of it if the command fails."""
    result = subprocess.run([str(c) for c in command], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, check=False, **options)
    if result.returncode != 0:
        tail = "\n".join(result.stdout.splitlines()[-30:])
        raise Failure(f"exit code {result.returncode} of: {' '.join(str(c) for c in command)}\n{tail}")
    return result.stdout


def machine():
    model = re.search(r"model name\s*:\s*(.+)", pathlib.Path("/proc/cpuinfo").read_text(encoding="utf-8"))
    return f"{model[1] if model else 'unknown'}, {os.cpu_count()} cores"


def git(*arguments):
    return run(["git", "-C", ROOT, *arguments]).strip()


def default_baseline():
    """HEAD if libmpm differs from it, else the commit before the last one that touched libmpm."""
    if subprocess.run(["git", "-C", str(ROOT), "diff", "--quiet", "HEAD", "--", "libmpm"], check=False).returncode != 0:
        return "HEAD"
    commits = git("log", "-2", "--format=%H", "--", "libmpm").split()
    if len(commits) < 2:
        raise Failure("no earlier commit touched libmpm; name one with --baseline REV")
    return commits[1]


def last_commits(number):
    """The last `number` commits of this branch that touched libmpm, oldest first."""
    return git("log", "--first-parent", f"-{number}", "--format=%H", "--", "libmpm").split()[::-1]


class Tree:
    """A source tree whose library is measured: a folder, or a commit. It is copied into build/bench, so that both trees are built alike and
    nothing that is edited meanwhile gets in. own_benchmarks: its own benchmark programs; None where they are this tree's, or in use."""

    def __init__(self, what, fallback_name):
        if what is None or pathlib.Path(what).is_dir():
            origin = pathlib.Path(what or ROOT).resolve()
            self.name = fallback_name
            self.label = git("describe", "--always", "--abbrev=12", "--exclude=*", "--dirty") if origin == ROOT else origin.name
            self.source = WORK / self.name / "source"
            self.own_benchmarks = None if origin == ROOT else origin / "benchmarks"
            mirror(origin, self.source, {name for name in os.listdir(origin) if name.startswith("build")} | {"out", ".git"})
        else:
            try:
                commit = git("rev-parse", "--verify", what + "^{commit}")
            except Failure:
                raise UsageError(f"'{what}' is neither a folder nor a commit of this repository") from None
            self.label = self.name = commit[:12]
            self.source = WORK / self.name / "source"
            self.own_benchmarks = self.source.with_name("own_benchmarks")
            if not self.own_benchmarks.exists():
                export(commit, self.source)
                mirror(self.source / "benchmarks", self.own_benchmarks)
        mirror(ROOT / "benchmarks", self.source / "benchmarks")  # one yardstick for both

    def build(self, kind):
        """Path of bench_paired, with this tree's library and ROOT's benchmark programs. @param kind native | callgrind"""
        folder = WORK / self.name / kind
        options = ["-DCMAKE_BUILD_TYPE=Release", "-DMPM_BUILD_APP=OFF", "-DMPM_BUILD_TESTS=OFF", "-DMPM_BUILD_VALIDATION=OFF", "-DMPM_BUILD_BENCHMARKS=ON"]
        if kind == "callgrind":
            options += ["-DMPM_NATIVE=OFF", f"-DMPM_BASELINE_FLAGS={CALLGRIND_FLAGS}"]
        # both trees have the same relative paths: what they share is compiled once, where ccache is there
        environment = {**os.environ, "CCACHE_BASEDIR": str(WORK / self.name), "CCACHE_NOHASHDIR": "1"}
        cache = folder / "CMakeCache.txt"
        if cache.exists() and f"CMAKE_HOME_DIRECTORY:INTERNAL={self.source}\n" not in cache.read_text(encoding="utf-8"):
            shutil.rmtree(folder)  # came here with a copied source tree
        say(f"build of {self.label} ({kind})" + ("" if cache.exists() else "; the first build takes some minutes"))
        try:
            run(["cmake", "-S", self.source, "-B", folder, "-G", "Ninja", *options])
            run(["cmake", "--build", folder, "--target", "bench_paired"], env=environment)
        except Failure as failure:
            if self.own_benchmarks is None:
                raise Failure(f"{self.label}: {failure}") from None
            say(f"{self.label} does not build with this tree's benchmark programs, whose calls it may lack; with its own")
            mirror(self.own_benchmarks, self.source / "benchmarks")
            self.own_benchmarks = None
            return self.build(kind)
        return folder / "bin" / "bench_paired"


def export(commit, target):
    """The files of a commit."""
    partial = target.with_name("partial")
    for old in (partial, target):
        shutil.rmtree(old, ignore_errors=True)
    partial.mkdir(parents=True)
    archive = subprocess.run(["git", "-C", str(ROOT), "archive", commit], stdout=subprocess.PIPE, check=True).stdout
    subprocess.run(["tar", "-x", "-C", str(partial)], input=archive, check=True)
    partial.rename(target)


def mirror(source, target, skip=frozenset()):
    """Makes target a copy of source; files that are equal keep their time, so that nothing is rebuilt without need."""
    names = set(os.listdir(source)) - skip - {"__pycache__"}
    target.mkdir(parents=True, exist_ok=True)
    for name in set(os.listdir(target)) - names:
        victim = target / name
        shutil.rmtree(victim) if victim.is_dir() else victim.unlink()
    for name in names:
        a, b = pathlib.Path(source) / name, target / name
        if a.is_dir():
            mirror(a, b)
        elif a.is_file() and (not b.exists() or a.read_bytes() != b.read_bytes()):
            shutil.copy(a, b)


def instructions(program, kernel, particles):
    """Instructions a particle of one pass."""
    environment = {**os.environ, "OMP_NUM_THREADS": "1"}
    output = run(["valgrind", "--tool=callgrind", "--callgrind-out-file=/dev/null", "--collect-atstart=no",
                  "--toggle-collect=mpm::benchmarks::measured_pass*", program, kernel, particles, "--once"], env=environment)
    count = int(re.search(r"Collected : (\d+)", output)[1])
    if count == 0:
        raise Failure(f"callgrind counted nothing in {kernel}")
    return count / particles
