#!/usr/bin/python3
"""What may happen to a run and to its results on the disk, done on purpose: `./run faults [--seed N] [--kills N] [--quick]`.

A small avalanche (a checkpoint at every sample, so that most of its time is spent in writing) is computed once undisturbed: the reference.
Then it is killed, starved, and damaged in every way below, and resumed. Expected of every fault: a message that names the file or the
remedy, the exit code of its kind (README), and after `--resume` (or a new run where there is nothing to resume) the very bytes of the
reference: final.h5, series.csv, profile.csv, every frame, frames.xdmf, case.toml, and results.json without what belongs to the machine
(times, memory, threads).

One line a fault; faults.md and faults.csv hold them as tables. Exit code 1 if any expectation failed.
"""

import argparse
import json
import os
import pathlib
import random
import re
import resource
import shutil
import signal
import subprocess
import sys
import time
import zlib

from fault_tools import IO, OK, ROOT, USAGE, compile_failing_calls, memory_folder, write_report

CASE = """title = "a small avalanche to be disturbed"
[material]
model = "cohesive_cam_clay"
critical_state_slope = 0.4
cohesion_beta = 0.0
hardening_xi = 5.0
[conveyor]
froude_number = 3.0
width_m = 3.5
upstream_length_m = 3.0
downstream_length_m = 3.0
[obstacle]
friction = 0.0
[numerics]
cell_size_m = 0.4375
[output]
duration_s = 0.4
series_per_second = 50
frames_per_second = 25
checkpoint_minutes = 1e-6
"""
SAMPLES = 21  # rows of series.csv
OF_THE_MACHINE = ("wall_time_s", "solver_time_s", "million_particle_steps_per_s", "peak_memory_bytes", "threads", "ranks", "crc32")
NOBODY = 65534
PATIENCE = 600.0  # seconds after which a run hangs, on a very busy machine
INTERNAL = 5  # exit code


class Outcome:
    def __init__(self, code, err):
        self.code, self.err = code, err

    def message(self):
        """The line that matters: the last one that is neither progress nor empty."""
        lines = [line for line in self.err.splitlines() if line.strip() and not re.match(r"\s*[\d.]+ %", line) and not line.startswith("results in")]
        return lines[-1].strip() if lines else ""


class Campaign:
    def __init__(self, arguments):
        self.quick, self.kills, self.random = arguments.quick, arguments.kills, random.Random(arguments.seed)
        self.sanitized = arguments.sanitized
        self.folder = memory_folder("mpm-faults-", arguments.scratch)
        self.folder.chmod(0o755)
        self.mpm = self.folder / "mpm"  # a copy, which no build replaces meanwhile and every user may run
        shutil.copy2(arguments.mpm, self.mpm)
        self.mpm.chmod(0o755)
        self.case = self.folder / "case.toml"
        self.case.write_text(CASE)
        self.environment = {**os.environ, "OMP_WAIT_POLICY": "passive"}
        self.root = os.geteuid() == 0
        self.rows, self.number, self.mounts = [], 0, []

    def close(self):
        for place in self.mounts:
            subprocess.run(["umount", str(place)], check=False)
        shutil.rmtree(self.folder, ignore_errors=True)

    # --- running ---
    def place(self):
        self.number += 1
        return self.folder / f"run{self.number}"

    def command(self, out, *more, threads=1):
        return [str(self.mpm), "run", str(self.case), "--out", str(out), "--threads", str(threads), *more]

    def start(self, out, *more, threads=1, environment=None, stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, **how):
        return subprocess.Popen(self.command(out, *more, threads=threads), stdout=stdout, stderr=stderr, text=True,
                                env={**self.environment, **(environment or {})}, **how)

    def run(self, out, *more, **how):
        process = self.start(out, *more, **how)
        return self.end_of(process)

    def end_of(self, process):
        try:
            _, err = process.communicate(timeout=PATIENCE)
        except subprocess.TimeoutExpired:
            process.kill()
            process.communicate()
            return Outcome("hangs", "")
        return Outcome(process.returncode, err or "")

    def halted(self, rows, *more, prepare=None, **how):
        """A run that has reached this point and is suspended (SIGSTOP), so that it can be disturbed there."""
        for _ in range(20):  # on a busy machine the whole run may go by between two looks at it
            out = self.place()
            if prepare:
                prepare(out)
            process = self.start(out, *more, **how)
            while process.poll() is None:
                try:
                    there = (out / "series.csv").read_bytes().count(b"\n") - 1
                except FileNotFoundError:
                    there = 0
                if there >= rows:
                    process.send_signal(signal.SIGSTOP)
                    time.sleep(0.02)
                    if process.poll() is None and (out / "series.csv").read_bytes().count(b"\n") - 1 < SAMPLES - 1:
                        return out, process
                    process.send_signal(signal.SIGCONT)
                    break
                time.sleep(0.001)
            self.end_of(process)
        raise SystemExit("faults: the run cannot be halted in its midst: the machine is too busy")

    def go_on(self, process):
        process.send_signal(signal.SIGCONT)
        return self.end_of(process)

    # --- judging ---
    def content(self, out):
        """Everything that a run promises to leave, by name."""
        found = {}
        names = ["final.h5", "series.csv", "profile.csv", "frames.xdmf", "case.toml", "results.json"]
        frames = sorted((out / "frames").glob("*")) if (out / "frames").is_dir() else []
        for path in [out / name for name in names] + frames:
            if path.name == "results.json" and path.exists():
                results = json.loads(path.read_text())
                for key in OF_THE_MACHINE:
                    results.pop(key, None)
                found["results.json"] = results
            else:
                found[str(path.relative_to(out))] = path.read_bytes() if path.exists() else None
        return found

    def compute_reference(self):
        self.reference_folder = self.place()
        begin = time.monotonic()
        outcome = self.run(self.reference_folder)
        self.seconds = time.monotonic() - begin
        if outcome.code != OK:
            raise SystemExit(f"faults: the undisturbed run failed ({outcome.code}): {outcome.err}")
        self.reference = self.content(self.reference_folder)
        self.size = sum(path.stat().st_size for path in self.reference_folder.rglob("*") if path.is_file())
        if self.reference["series.csv"].count(b"\n") != SAMPLES + 1 or len([n for n in self.reference if n.startswith("frames/")]) != 11:
            raise SystemExit("faults: the undisturbed run is not the one that the expectations are about")

    def differences(self, out):
        found = self.content(out)
        return [name for name in sorted(self.reference.keys() | found.keys()) if self.reference.get(name) != found.get(name)]

    def note(self, fault, holds, expected, seen, code, lost="none", tries=1):
        self.rows.append({"fault": fault, "tries": tries, "expected": expected, "exit code": code, "message seen": seen, "data lost": lost,
                          "verdict": "holds" if holds else "FAILS"})
        print(f"{'ok  ' if holds else 'FAIL'}  {fault} (x{tries}) | {seen} | exit {code} | expected: {expected} | data lost: {lost}", flush=True)

    def expect(self, fault, outcome, codes, words, out, resume=True, threads=1, lost="none", expected="", also=True, more=()):
        """A fault is over: its exit code and its message are as expected, and what --resume (or a new run) gives is the reference."""
        codes = codes if isinstance(codes, tuple) else (codes,)
        right = outcome.code in codes and all(re.search(word, outcome.err) for word in words) and also
        again = self.run(out, *more, *(["--force"] if not resume else ["--resume"] if os.path.exists(out) else []), threads=threads)
        differ = self.differences(out) if again.code == OK else [f"exit {again.code}: {again.message()}"]
        if differ:
            lost = "differs: " + ", ".join(differ)
        seen = self.shown(outcome.message())
        self.note(fault, right and not differ, expected or f"exit {'/'.join(map(str, codes))}, then the reference", seen, outcome.code, lost)

    def shown(self, message):
        message = message.replace(str(self.folder), "DIR")
        message = re.sub(r"DIR/run\d+", "OUT", message)
        return message if len(message) < 160 else message[:157] + "..."

    # --- faults ---
    def random_kills(self):
        """kill -9 at random moments; what was killed is resumed, and may be killed again."""
        done, chains, writing, wrong, worst = 0, 0, 0, [], 0
        while done < self.kills:
            out = self.place()
            chains += 1
            in_a_row = 0
            while True:
                process = self.start(out, *(["--resume"] if in_a_row and os.path.exists(out) else []), threads=self.random.choice((1, 2)), stderr=subprocess.DEVNULL)
                if done < self.kills:
                    try:
                        process.wait(timeout=self.random.uniform(0.0, 1.1 * self.seconds))
                    except subprocess.TimeoutExpired:
                        process.kill()
                code = process.wait(timeout=PATIENCE)
                if code == OK:
                    break
                if code != -signal.SIGKILL:
                    wrong.append(f"exit {code} after {in_a_row} kills")
                    break
                done += 1
                in_a_row += 1
                worst = max(worst, in_a_row)
                writing += any(out.rglob(".*.tmp"))
            wrong += [f"after {in_a_row} kills: {name} differs" for name in self.differences(out)]
            wrong += [f"{path.name} is left over" for path in out.rglob(".*.tmp")]
            shutil.rmtree(out)
        self.note(f"kill -9 at random moments, {writing} of them with a file half written; up to {worst} in one run", not wrong,
                  "every run ends with the reference", "; ".join(wrong[:3]) or "-", -9, "; ".join(wrong[:3]) or "none", tries=done)

    def at_every_file_call(self):
        library, count = compile_failing_calls(self.folder), self.folder / "count"
        short = ["--set", "output.duration_s=0.04"]  # three samples, two frames, three checkpoints
        self.run(self.place(), *short, environment={"LD_PRELOAD": str(library), "COUNT_FILE": str(count)})
        calls = int(count.read_text())
        full = self.reference
        whole = self.place()
        self.run(whole, *short)
        self.reference = self.content(whole)
        modes = [("kill", "kill -9 in place of the n-th file operation"), ("half", "kill -9 in the middle of the n-th file operation"),
                 ("28", "no space left (ENOSPC) at the n-th file operation"), ("5", "the device fails (EIO) at the n-th file operation"),
                 ("122", "quota exceeded (EDQUOT) at the n-th file operation"),
                 ("memory", "no memory (std::bad_alloc) after the n-th file operation")]
        for with_, text in modes:
            numbers = range(1, calls + 1) if not self.quick else sorted(self.random.sample(range(1, calls + 1), 3))
            wrong, codes, reported = [], {}, ""
            code, reason = (INTERNAL, "out of memory") if with_ == "memory" else (IO, os.strerror(int(with_)) if with_.isdigit() else "")
            for n in numbers:
                out = self.place()
                outcome = self.run(out, *short, environment={"LD_PRELOAD": str(library), "FAIL_AT": str(n), "FAIL_WITH": with_})
                codes[outcome.code] = codes.get(outcome.code, 0) + 1
                killed = with_ in ("kill", "half")
                if killed and outcome.code != -signal.SIGKILL:
                    wrong.append(f"{n}: exit {outcome.code}")
                if not killed:
                    # A log line that is lost and a directory that cannot be forced to the disk do not end a run; its results must be whole then.
                    if outcome.code == OK:
                        wrong += [f"{n}: {name} differs" for name in self.differences(out)]
                    elif outcome.code != code or not re.search(reason, outcome.err):
                        wrong.append(f"{n}: exit {outcome.code}: {outcome.message()}")
                    else:
                        reported = outcome.message()
                again = self.run(out, *short, "--resume", threads=2)
                if again.code != OK and "no checkpoint to go on from" in again.err and (out / "results.json").exists():
                    again = Outcome(OK, "")
                wrong += [f"{n}: {name} differs" for name in self.differences(out)] if again.code == OK else [f"{n}: resumed: {again.message()}"]
                wrong += [f"{n}: {path.name} is left over" for path in out.rglob(".*.tmp")]
                shutil.rmtree(out)
            self.note(f"{text}, n = 1 ... {calls}" if not self.quick else text, not wrong, "killed, then the reference" if with_ in ("kill", "half") else
                      f"exit {code} with the reason (exit 0 for a lost line of run.log), then the reference", self.shown("; ".join(wrong[:3]) or reported or "-"),
                      " ".join(f"{code} ({times}x)" for code, times in sorted(codes.items())), "; ".join(wrong[:3]) or "none", tries=len(numbers))
        self.reference = full

    def signals(self):
        for name in ("SIGTERM", "SIGINT", "SIGHUP", "SIGUSR2"):
            out, process = self.halted(6, preexec_fn=lambda: signal.signal(signal.SIGHUP, signal.SIG_DFL))  # nohup may have started us
            process.send_signal(getattr(signal, name))
            outcome = self.go_on(process)
            self.expect(name, outcome, -getattr(signal, name), ["stopped at t = ", "--resume"], out, threads=2,
                        expected="a checkpoint, then ended by the signal; the reference after --resume")
        out, process = self.halted(6, "--set", "output.checkpoint_minutes=1e4")
        process.send_signal(signal.SIGUSR1)
        outcome = self.go_on(process)
        asked = "(asked for)" in (out / "run.log").read_text()
        differ = [name for name in self.differences(out) if name != "case.toml"]
        self.note("SIGUSR1", outcome.code == OK and asked and not differ, "a checkpoint, and the run goes on to the reference",
                  "run.log: checkpoint (asked for)" if asked else "nothing", outcome.code, ", ".join(differ) or "none")

    def on_small_disk(self, text, size, more=()):
        """@returns whether a file system of this size can be mounted here"""
        out = self.place()
        out.mkdir()
        if not self.root or subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size}", "tmpfs", str(out)], capture_output=True).returncode != 0:
            return False
        self.mounts.append(out)
        outcome = self.run(out, *more)
        subprocess.run(["mount", "-o", "remount,size=1g", str(out)], check=True)
        self.expect(f"disk full: tmpfs of {size / 1e6:.2f} MB, {text}", outcome, IO, ["No space left on device", "free space"], out, more=more)
        subprocess.run(["umount", str(out)], check=True)
        self.mounts.remove(out)
        return True

    def full_disk_between_pieces(self):
        """Files of more particles than are written at once: the first pieces of one have room."""
        more = ["--set", "numerics.cell_size_m=0.15", "--set", "output.duration_s=0.02"]  # two samples, one frame, three pieces
        small, whole = self.reference, self.place()
        self.run(whole, *more)
        self.reference = self.content(whole)
        frame, checkpoint, final = ((whole / name).stat().st_size for name in ("frames/00000.h5", "checkpoint.h5", "final.h5"))
        # One checkpoint follows the second sample, another the end; the older one stays.
        before = {"the frame": (0, frame), "the first checkpoint": (frame, checkpoint), "final.h5": (frame + 2 * checkpoint, final)}
        for name, (others, size) in list(before.items())[:1 if self.quick else None]:
            self.on_small_disk(f"half of {name} has room", others + size // 2, more)
        self.reference = small

    def full_disk(self):
        for share in (0.5,) if self.quick else (0.05, 0.2, 0.4, 0.6, 0.8, 0.95):
            if not self.on_small_disk(f"{100 * share:.0f} % of what the run needs", int(share * self.size)):
                print("      (no tmpfs can be mounted here: the limit on file sizes must stand for the full disk)")
                break
        else:
            self.full_disk_between_pieces()
        # The limit on the size of a file: write() fails in the middle of a file, as on a disk that is full or beyond its quota.
        sizes = sorted(path.stat().st_size for path in self.reference_folder.rglob("*.h5"))
        for limit in (sizes[0] // 2,) if self.quick else (1000, sizes[0] // 2, sizes[len(sizes) // 2], sizes[-1] - 1):
            out = self.place()
            outcome = self.run(out, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (limit, resource.RLIM_INFINITY)))
            self.expect(f"write fails in the middle of a file (ulimit -f, {limit} bytes)", outcome, IO, ["File too large", "ulimit -f"], out)

    def permissions(self):
        drop = {"user": NOBODY, "group": NOBODY, "extra_groups": []} if self.root else {}
        locked = self.place()
        locked.mkdir(mode=0o555)
        outcome = self.run(locked / "below", **drop)
        locked.chmod(0o777)
        self.expect("directory without the right to write", outcome, IO, ["Permission denied", "permissions"], locked / "below", resume=False)

        def of_nobody(out):
            out.mkdir()
            if self.root:
                os.chown(out, NOBODY, NOBODY)

        out, process = self.halted(5, prepare=of_nobody, **drop)
        out.chmod(0o555)
        outcome = self.go_on(process)
        out.chmod(0o777)
        self.expect("directory loses the right to write while the run goes on", outcome, IO, ["Permission denied"], out)

        out = self.place()
        of_nobody(out)
        (out / "run.log").write_text("")
        (out / "run.log").chmod(0o444)
        outcome = self.run(out, **drop)
        (out / "run.log").chmod(0o666)
        self.expect("read-only file (run.log)", outcome, IO, ["run.log", "Permission denied", "permissions"], out)

        out = self.place()
        out.write_text("a file, not a directory")
        outcome = self.run(out)
        out.unlink()
        self.expect("file in the place of the directory", outcome, IO, ["directory"], out, resume=False)

        if self.root:
            out = self.place()
            out.mkdir()
            if subprocess.run(["mount", "-t", "tmpfs", "-o", "ro", "tmpfs", str(out)], capture_output=True).returncode == 0:
                self.mounts.append(out)
                outcome = self.run(out)
                subprocess.run(["umount", str(out)], check=True)
                self.mounts.remove(out)
                self.expect("read-only file system", outcome, IO, ["Read-only file system", "choose another output directory"], out, resume=False)

    def memory(self):
        """Address space limited to points between what starting takes and what the run takes."""
        def limited(out, limit):
            return self.run(out, threads=2, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))

        def starts(limit):
            return subprocess.run([self.mpm, "--version"], capture_output=True, preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit))).returncode == 0

        low, high = 1 << 20, 1 << 31
        while high - low > 1 << 18:
            middle = (low + high) // 2
            low, high = (low, middle) if starts(middle) else (middle, high)
        floor = high
        enough = floor
        while limited(self.place(), enough).code != OK:
            enough += 16 << 20
        points = 4 if self.quick else 12
        for i in range(points):
            limit = floor + (enough - floor) * (i + 1) // (points + 1) // 4096 * 4096
            out = self.place()
            outcome = limited(out, limit)
            if outcome.code == OK:
                differ = self.differences(out)
                self.note(f"{limit / 1e6:.1f} MB of address space (ulimit -v)", not differ, "enough: the reference", "-", OK, ", ".join(differ) or "none")
            else:
                self.expect(f"{limit / 1e6:.1f} MB of address space (ulimit -v)", outcome, INTERNAL, ["memory"], out)

    def deleted(self):
        out, process = self.halted(5)
        moved = self.place()
        out.rename(moved)
        outcome = self.go_on(process)
        stray = out.exists()
        self.expect("directory moved away while the run goes on", outcome, IO, [r"deleted, moved or replaced|No such file"], moved, also=not stray)
        out, process = self.halted(5)
        shutil.rmtree(out)
        outcome = self.go_on(process)
        self.expect("directory deleted while the run goes on", outcome, IO, [r"deleted, moved or replaced|No such file"], out, resume=False,
                    lost="what was deleted")

    def two_processes(self):
        for more in ([], ["--resume"]):
            out, first = self.halted(3)
            second = self.run(out, *more)
            outcome = self.go_on(first)
            differ = self.differences(out) if outcome.code == OK else [f"exit {outcome.code}"]
            self.note(f"a second process on the same directory{' with --resume' if more else ''}",
                      second.code == IO and "another process" in second.err and not differ, "the second: exit 4; the first: the reference",
                      self.shown(second.message()), second.code, ", ".join(differ) or "none")

    def damaged_checkpoints(self):
        import h5py

        stopped, process = self.halted(8)
        process.terminate()
        self.go_on(process)
        good = (stopped / "checkpoint.h5").read_bytes()

        def sealed(edit):
            path = self.folder / "edited.h5"
            path.write_bytes(good[:-16])
            with h5py.File(path, "r+") as file:
                edit(file)
            content = path.read_bytes()
            return content + b"MPMCRC32%08x" % zlib.crc32(content)

        def flipped():
            content = bytearray(good)
            content[self.random.randrange(len(good))] ^= 1 << self.random.randrange(8)
            return bytes(content)

        other = self.place()
        self.run(other, "--set", "output.duration_s=0.02", "--set", "obstacle.friction=0.25")
        damages = [("of no bytes", b"", "cut off"), ("cut to 1000 bytes", good[:1000], "cut off"), ("cut by its last byte", good[:-1], "cut off|checksum|damaged")]
        damages += [(f"with one bit flipped, {i + 1}", flipped(), "checksum|damaged|does not end") for i in range(1 if self.quick else 10)]
        damages += [("that is a frame", (stopped / "frames" / "00002.h5").read_bytes(), "not a checkpoint"),
                    ("that is a text", b"To whom it may concern. " * 100, "another program"),
                    ("of another case", (other / "checkpoint.h5").read_bytes(), "obstacle.friction was 0.25, is 0.0"),
                    ("of a future version", sealed(lambda f: f.attrs.__setitem__("format_version", f.attrs["format_version"] + 1)), "format .*, this program reads"),
                    ("that is missing", None, "does not exist")]
        for text, content, reason in damages:
            # The previous one is good: it is used, and the message says why.
            out = self.place()
            shutil.copytree(stopped, out)
            (out / "checkpoint.h5").unlink()
            if content is not None:
                (out / "checkpoint.h5").write_bytes(content)
            outcome = self.run(out, "--resume", threads=2)
            differ = self.differences(out) if outcome.code == OK else [f"exit {outcome.code}"]
            reported = next((line for line in outcome.err.splitlines() if "going on from checkpoint.previous.h5" in line), "")
            self.note(f"newest checkpoint {text}", not differ and re.search(reason, reported) is not None, f"the previous one is used, with the reason ({reason})",
                      self.shown(reported), outcome.code, ", ".join(differ) or "none")
            if content is None or (self.quick and text != "of another case"):
                continue
            # Both are bad: refused, and nothing is touched.
            out = self.place()
            shutil.copytree(stopped, out)
            for name in ("checkpoint.h5", "checkpoint.previous.h5"):
                (out / name).write_bytes(content)
            before = {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
            outcome = self.run(out, "--resume")
            untouched = before == {path: path.read_bytes() for path in out.rglob("*") if path.is_file()}
            self.expect(f"both checkpoints {text}", outcome, USAGE if text == "of another case" else IO, [reason, "--force instead of --resume"], out, resume=False,
                        expected="refused, nothing touched; a new run gives the reference", also=untouched)
        out = self.place()
        shutil.copytree(stopped, out)
        rows = (out / "series.csv").read_bytes().splitlines(keepends=True)
        (out / "series.csv").write_bytes(b"".join(rows[:4]))
        outcome = self.run(out, "--resume")
        self.expect("series.csv cut to 3 rows", outcome, OK, ["series.csv was missing or damaged"], out, expected="the reference, with a message")
        out = self.place()
        shutil.copytree(self.reference_folder, out)
        for name in ("checkpoint.h5", "checkpoint.previous.h5"):
            (out / name).unlink()
        outcome = self.run(out, "--resume")
        differ = self.differences(out)
        self.note("--resume of a finished run without checkpoints", outcome.code == IO and not differ, "exit 4, the results stay", self.shown(outcome.message()),
                  outcome.code, ", ".join(differ) or "none")

    def damaged(self, path):
        """Damages a file at a random place. @return how"""
        content = bytearray(path.read_bytes())
        kind = self.random.choice(("digit", "bit", "cut", "zeros", "missing"))
        at = self.random.randrange(len(content))
        if kind == "missing":
            path.unlink()
            return kind
        if kind == "digit":
            digits = [i for i, c in enumerate(content) if c in b"0123456789"]
            at = self.random.choice(digits)
            content[at] = ord(str((int(chr(content[at])) + self.random.randint(1, 9)) % 10))
        elif kind == "bit":
            content[at] ^= 1 << self.random.randrange(8)
        elif kind == "cut":
            del content[at:]
        else:
            content[at:at + 64] = bytes(len(content[at:at + 64]))
        path.write_bytes(content)
        return f"{kind} at {at}"

    def damaged_results(self):
        """Finished runs of which one file is damaged: Python readers refuse it or read what was written, and --resume gives the reference."""
        sys.path.insert(0, str(ROOT / "python"))
        import numpy
        from mpmtools import InputError, Run

        def read(folder, name):
            run = Run(folder)
            if name.endswith(".h5"):
                frame = run.final if name == "final.h5" else run.frames[5]
                return [frame[array].tobytes() for array in frame] if frame else None
            value = run.results if name == "results.json" else run.series
            return value if name == "results.json" else numpy.nan_to_num(value.to_numpy(), nan=-1.0).tolist()

        for name in ("series.csv", "results.json", "final.h5", "frames/00005.h5"):
            wrong, tries, refused = [], 2 if self.quick else 100, 0
            whole = read(self.reference_folder, name)
            for _ in range(tries):
                out = self.place()
                shutil.copytree(self.reference_folder, out)
                how = self.damaged(out / name)
                try:
                    found = read(out, name)
                    if how != "missing" and found != whole:
                        wrong.append(f"{how}: read")
                except InputError:
                    refused += 1
                except Exception as error:  # noqa: BLE001  (what a reader must not raise)
                    wrong.append(f"{how}: {type(error).__name__}: {error}")
                if not name.startswith("frames"):  # frames before the checkpoint are not computed again
                    again = self.run(out, "--resume", threads=2)
                    wrong += [f"{how}: resumed: {file}" for file in (self.differences(out) if again.code == OK else [again.message()])]
                shutil.rmtree(out)
            self.note(f"{name} of a finished run damaged at random", not wrong, "Python refuses it or reads what was written; the reference after --resume",
                      self.shown("; ".join(wrong[:3])) or f"refused by Python {refused} times", OK, "; ".join(wrong[:3]) or "none", tries=tries)

    def streams(self):
        if pathlib.Path("/dev/full").exists():
            out = self.place()
            with open("/dev/full", "w") as full:
                outcome = self.run(out, stderr=full)
            differ = self.differences(out)
            self.note("no space for messages (2>/dev/full)", outcome.code == OK and not differ, "the run goes on to the reference", "-", outcome.code,
                      ", ".join(differ) or "none")
            out = self.place()
            with open("/dev/full", "w") as full:
                outcome = self.run(out, stdout=full)
            differ = self.differences(out)
            self.note("no space for the printed results (>/dev/full)", outcome.code == IO and not differ and bool(outcome.message()),
                      "exit 4, results.json is whole", self.shown(outcome.message()), outcome.code, ", ".join(differ) or "none")
        out = self.place()
        read, written = os.pipe()
        process = self.start(out, stderr=written)
        os.close(written)
        os.close(read)
        outcome = self.end_of(process)
        differ = self.differences(out)
        self.note("the pipe of the messages is closed", outcome.code == OK and not differ, "the run goes on to the reference", "-", outcome.code,
                  ", ".join(differ) or "none")

    def everything(self):
        self.compute_reference()
        self.random_kills()
        if not self.sanitized:  # a sanitizer's runtime must come first, and reserves terabytes
            self.at_every_file_call()
            self.memory()
        self.signals()
        self.full_disk()
        self.permissions()
        self.deleted()
        self.two_processes()
        self.damaged_checkpoints()
        self.damaged_results()
        self.streams()


def main():
    parser = argparse.ArgumentParser(description="What may happen to a run, done to runs on purpose.")
    parser.add_argument("--seed", type=int, default=1, help="of the random moments and bits (default: %(default)s)")
    parser.add_argument("--kills", type=int, help="kills at random moments (default: 100, or 4 with --quick)")
    parser.add_argument("--quick", action="store_true", help="a few of each kind, in seconds")
    parser.add_argument("--sanitized", action="store_true", help="the program is built with sanitizers: leave out what they cannot do")
    parser.add_argument("--mpm", type=pathlib.Path, default=ROOT / "build" / "release" / "bin" / "mpm", help="program (default: %(default)s)")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "out" / "faults", help="folder of the tables (default: %(default)s)")
    parser.add_argument("--scratch", type=pathlib.Path, help="where the runs go (default: memory, /dev/shm, if there is one)")
    arguments = parser.parse_args()
    if arguments.kills is None:
        arguments.kills = 4 if arguments.quick else 100
    campaign = Campaign(arguments)
    begin = time.monotonic()
    try:
        campaign.everything()
    finally:
        campaign.close()
    command = f"./run faults --seed {arguments.seed} --kills {arguments.kills}{' --quick' if arguments.quick else ''}"
    return write_report(campaign.rows, command, arguments.mpm, arguments.out, time.monotonic() - begin)


if __name__ == "__main__":
    sys.exit(main())
