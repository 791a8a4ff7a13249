#!/usr/bin/python3
"""Ranks are killed, stopped and starved of disk; after --resume the files have the bytes of an undisturbed run.

    tests/mpi/faults.py [--kills 20] [--stops 10] [--seed N] [--program build/mpi/bin/mpm] [--out DIR]

kill   SIGKILL to a rank at a random moment of a run by 2 to 4 ranks: the launcher ends the job, with an error, within a minute. Kills before the
       run has begun to write, while the ranks find each other, are listed apart
stop   SIGSTOP to a random rank in the middle, SIGCONT two seconds later: the run ends well
ask    SIGUSR2 to the launcher in the middle: a checkpoint, and the run ends
disk   the file system is too small (a tmpfs, needs root): exit code 4 with the reason, once, and no temporary is left
limit  a rank other than the first may write only the first 16 kB of a file (ulimit -f): the same
After each of them, --resume on another number of ranks gives the bytes of one rank. A checkpoint is written at every sample. A line a fault,
then a table. Exit code 1 if any expectation failed.
"""

import os
import random
import shutil
import signal
import subprocess
import sys
import time

import rank_runs as runs

CASE = "aflip_window"
IO_ERROR = 4
PATIENCE = 60.0  # seconds in which the launcher must notice, on a busy machine
LIMIT = 'test "$OMPI_COMM_WORLD_RANK" != "$0" || ulimit -f 16; exec "$@"'  # shared memory of messages is a file, too: sockets in its place
LIMITS = 5
SHARES = (0.1, 0.3, 0.5, 0.7, 0.9)  # of the room that a run needs


class Faults:
    def __init__(self, options):
        self.options, self.dice = options, random.Random(options.seed)
        self.case = runs.write_case(options.out, CASE, duration=0.4)
        runs.run(options, self.case, options.out / "one")
        self.expected = runs.files(options.out / "one")
        self.size = sum(path.stat().st_size for path in (options.out / "one").rglob("*") if path.is_file())
        self.rows = (options.out / "one" / "series.csv").read_bytes().count(b"\n") - 1
        start = time.monotonic()
        runs.run(options, self.case, options.out / "three", 3)
        self.length = time.monotonic() - start
        self.table, self.failed = {}, 0

    def resumed(self, out):
        """Resumes on another number of ranks. @returns their number, and the files that differ from the reference"""
        ranks = self.dice.choice([1, 2, 3, 4])
        runs.run(self.options, self.case, out, ranks, 1, ["--resume"] if out.exists() else [])
        return ranks, runs.differences(self.expected, out)

    def note(self, fault, sound, differing, text):
        """@param differing: files whose bytes are not those of the reference, at the end"""
        tries, as_expected, same = self.table.get(fault, (0, 0, 0))
        self.table[fault] = tries + 1, as_expected + sound, same + (not differing)
        self.failed += not sound or bool(differing)
        print(f"{'ok  ' if sound and not differing else 'FAIL'} {fault}: {text}: {', '.join(differing) or 'same bytes'}", flush=True)

    def kill(self, number):
        """@returns whether it hit a run that had begun"""
        ranks = self.dice.randint(2, 4)
        victim, after = number % ranks, self.dice.uniform(0.0, self.length)
        out = self.options.out / f"killed_{number}"
        run = runs.Disturbed(self.options, self.case, out, ranks)
        time.sleep(after)
        begun, rows, hit, start = (out / "run.log").exists(), run.rows(), run.kill(victim), time.monotonic()
        code = run.end(PATIENCE)
        text = f"rank {victim} of {ranks} after {after:.2f} s and {rows} rows"
        if not hit or run.finished():
            print(f"     {text}: {'already over' if run.finished() else 'not yet there'}; does not count", flush=True)
            return False
        how = f"the job ended {time.monotonic() - start:.1f} s later with exit code {code}"
        if code is None:
            how = f"the launcher hung, {run.hanging} ranks were left ({run.log.read_text().strip().splitlines()[-1:]})"
        again, differing = self.resumed(out)
        self.note("SIGKILL of a rank" if begun else "SIGKILL while the ranks start", code not in (0, None), differing, f"{text}, {how}, resumed on {again}")
        return begun

    def in_the_middle(self, out):
        ranks = self.dice.randint(2, 4)
        run = runs.Disturbed(self.options, self.case, out, ranks)
        run.wait_for_rows(self.dice.randint(1, self.rows - 4))
        return run, ranks

    def stop(self, number):
        out = self.options.out / f"stopped_{number}"
        run, ranks = self.in_the_middle(out)
        victim = self.dice.randrange(ranks)
        hit, rows = run.send(victim, signal.SIGSTOP), run.rows()
        time.sleep(2.0)
        later = run.rows()
        over = run.process.poll() is not None
        run.send(victim, signal.SIGCONT)
        code = run.end(300)
        self.note("SIGSTOP of a rank, SIGCONT after 2 s", hit and not over and code == 0, runs.differences(self.expected, out) if code == 0 else ["no results"],
                  f"rank {victim} of {ranks} at {rows} rows ({later} when it went on), exit code {code}")

    def ask(self, number):
        out = self.options.out / f"asked_{number}"
        run, ranks = self.in_the_middle(out)
        run.process.send_signal(signal.SIGUSR2)
        code = run.end(PATIENCE)
        sound = code == 128 + signal.SIGUSR2 and not run.finished() and "stopped at t = " in run.log.read_text()
        again, differing = self.resumed(out)
        self.note("SIGUSR2 to the launcher", sound, differing, f"{ranks} ranks, exit code {code}, resumed on {again}")

    def full_disk(self, share):
        small = self.options.out / "small_disk"
        small.mkdir(exist_ok=True)
        if os.geteuid() != 0 or subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={int(share * self.size)}", "tmpfs", small], check=False).returncode:
            print("     full disk: skipped, no file system can be mounted here (needs root)")
            return
        try:
            err = runs.run(self.options, self.case, small / "run", 3, 1, expected=IO_ERROR)
            lines = [line for line in err.splitlines() if "No space left" in line]
            temporaries = list(small.rglob("*.tmp"))
            subprocess.run(["mount", "-o", f"remount,size={20 * self.size}", small], check=True)
            if not (small / "run" / "checkpoint.h5").exists():  # nothing to go on from: --resume would say so
                shutil.rmtree(small / "run")
            again, differing = self.resumed(small / "run")
        finally:
            subprocess.run(["umount", small], check=True)
        self.note("full disk", len(lines) == 1 and not temporaries, differing,
                  f"room for {share:.0%}, 3 ranks, exit code {IO_ERROR}, '{' / '.join(lines)}', with more room resumed on {again}")

    def limit(self, number):
        out, ranks = self.options.out / f"limited_{number}", self.dice.randint(2, 4)
        victim = self.dice.randint(1, ranks - 1)
        runs.run(self.options, self.case, out, ranks, 1, ["--set", "output.duration_s=0.2"])
        words = [*runs.launcher(ranks), "--mca", "btl", "tcp,self", "bash", "-c", LIMIT, str(victim), *runs.command(self.options, self.case, out, 1, ["--resume"])]
        done = subprocess.run(words, env=runs.environment(), capture_output=True, text=True, check=False)
        lines = [line for line in done.stderr.splitlines() if f"rank {victim} on " in line and "File too large" in line]
        sound = done.returncode == IO_ERROR and len(lines) == 1 and not list(out.rglob("*.tmp"))
        again, differing = self.resumed(out)
        self.note("failed write of another rank", sound, differing, f"{ranks} ranks, exit code {done.returncode}, '{' / '.join(lines)}', resumed on {again}")

    def everything(self):
        kills = hits = 0
        while hits < self.options.kills and kills < 4 * self.options.kills:
            hits += self.kill(kills)
            kills += 1
        for number in range(self.options.stops):
            self.stop(number)
            self.ask(number)
        for share in SHARES:
            self.full_disk(share)
        for number in range(LIMITS):
            self.limit(number)
        lines = [runs.provenance(self.options), "", "| disturbance | times | job ended as expected | same bytes at the end |", "|---|---|---|---|"]
        lines += [f"| {fault} | {tries} | {sound} | {same} |" for fault, (tries, sound, same) in self.table.items()]
        (self.options.out / "faults.md").write_text("\n".join(lines) + "\n", encoding="utf-8")
        print("\n".join(lines))
        return 1 if self.failed or hits < self.options.kills else 0


def main():
    parser = runs.arguments(__doc__)
    parser.add_argument("--kills", type=int, default=20, help="that hit a run which has begun (default: %(default)s)")
    parser.add_argument("--stops", type=int, default=10, help="(default: %(default)s)")
    options = parser.parse_args()
    runs.prepare(options)
    return Faults(options).everything()


if __name__ == "__main__":
    sys.exit(main())
