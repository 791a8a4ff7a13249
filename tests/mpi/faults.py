#!/usr/bin/python3
"""Ranks are killed, stopped and starved of disk; after --resume the files have the bytes of an undisturbed run.

    tests/mpi/faults.py [--program build/mpi/bin/mpm] [--kills 20] [--stops 5] [--seed N] [--out DIR]

kill   SIGKILL to a random rank at a random moment of a run by 2 to 4 ranks: the launcher must end the job within a minute, and --resume on
       another number of ranks must give the bytes of the reference
stop   SIGSTOP to a random rank, SIGCONT a second later: the run must end well, with those bytes
disk   the results on a file system that is too small (needs root: a tmpfs): exit code 4 and a message that names the file; with more room
       and --resume those bytes
A checkpoint is written at every sample. One line a fault. Exit code 1 if any expectation failed.
"""

import os
import random
import signal
import subprocess
import sys
import time

import rank_runs as runs

CASE = "aflip_surface"
IO_ERROR = 4
NOTE_PID = 'echo $$ > "$0.$OMPI_COMM_WORLD_RANK"; exec "$@"'  # the shell of a rank becomes the rank


class Disturbed:
    """A run by several ranks whose processes are known by rank."""

    def __init__(self, options, case, out, ranks, more=()):
        self.pids = [options.out / f"{out.name}.pid.{r}" for r in range(ranks)]
        for path in self.pids:
            path.unlink(missing_ok=True)
        plain = runs.command(options, case, out, 1, 1, more)
        self.log = open(options.out / f"{out.name}.err", "a", encoding="utf-8")  # pylint: disable=consider-using-with
        self.process = subprocess.Popen([*runs.launcher(ranks), "bash", "-c", NOTE_PID, str(options.out / f"{out.name}.pid"), *plain],
                                        env=runs.environment(), stdout=subprocess.DEVNULL, stderr=self.log)

    def send(self, rank, number):
        """@returns whether there was a process to send it to"""
        try:
            os.kill(int(self.pids[rank].read_text()), number)
        except (OSError, ValueError):
            return False
        return True

    def end(self, seconds=120):
        """@returns the launcher's exit code; None if it did not end in time"""
        try:
            code = self.process.wait(timeout=seconds)
        except subprocess.TimeoutExpired:
            self.process.kill()
            code = None
        self.log.close()
        return code


def kill_one(options, case, number, length, expected, dice):
    out = options.out / f"killed_{number}"
    ranks, resumed_on = dice.randint(2, 4), dice.choice([1, 2, 3, 4])
    victim, after = dice.randrange(ranks), dice.uniform(0.2, length)
    disturbed = Disturbed(options, case, out, ranks)
    time.sleep(after)
    hit = disturbed.send(victim, signal.SIGKILL)
    start = time.monotonic()
    code = disturbed.end(60)
    ended = time.monotonic() - start
    finished = (out / "results.json").exists()
    sound = code is not None and (code == 0) == finished
    runs.run(options, case, out, resumed_on, 1, ["--resume"])
    differing = runs.differences(expected, out)
    what = "before it had a process" if not hit else "after its end" if finished else f"ended the job in {ended:.1f} s"
    print(f"kill {number}: rank {victim} of {ranks} after {after:.2f} s: {what}, exit code {code}; resumed on {resumed_on}: "
          f"{', '.join(differing) or 'same bytes'}", flush=True)
    return sound and not differing, hit and not finished


def stop_one(options, case, number, length, expected, dice):
    out = options.out / f"stopped_{number}"
    ranks = dice.randint(2, 4)
    victim, after = dice.randrange(ranks), dice.uniform(0.3, 0.7 * length)
    disturbed = Disturbed(options, case, out, ranks)
    time.sleep(after)
    hit = disturbed.send(victim, signal.SIGSTOP)
    time.sleep(1.0)
    disturbed.send(victim, signal.SIGCONT)
    code = disturbed.end(300)
    differing = runs.differences(expected, out) if code == 0 else ["the run failed"]
    print(f"stop {number}: rank {victim} of {ranks} after {after:.2f} s{'' if hit else ' (not there)'}: exit code {code}, "
          f"{', '.join(differing) or 'same bytes'}", flush=True)
    return not differing


def full_disk(options, case, expected):
    if os.geteuid() != 0:
        print("disk: skipped, a file system of its own needs root")
        return True
    small = options.out / "small_disk"
    small.mkdir()
    size = sum(len(content) for content in expected.values())
    if subprocess.run(["mount", "-t", "tmpfs", "-o", f"size={size // 2}", "tmpfs", str(small)], check=False).returncode != 0:
        print("disk: skipped, no file system can be mounted here")
        return True
    try:
        err = runs.run(options, case, small / "run", 3, 1, expected=IO_ERROR)
        message = next((line for line in err.splitlines() if "No space left" in line), "")
        subprocess.run(["mount", "-o", f"remount,size={20 * size}", str(small)], check=True)
        runs.run(options, case, small / "run", 2, 1, ["--resume"])
        differing = runs.differences(expected, small / "run")
    finally:
        subprocess.run(["umount", str(small)], check=True)
    print(f"disk: exit code {IO_ERROR}, '{message}'; with more room: {', '.join(differing) or 'same bytes'}", flush=True)
    return bool(message) and not differing


def main():
    parser = runs.arguments(__doc__)
    parser.add_argument("--kills", type=int, default=20)
    parser.add_argument("--stops", type=int, default=5)
    parser.add_argument("--seed", type=int, default=18)
    options = parser.parse_args()
    runs.prepare(options)
    dice = random.Random(options.seed)
    case = runs.write_case(options.out, CASE)
    runs.run(options, case, options.out / "one")
    expected = runs.files(options.out / "one")
    start = time.monotonic()
    runs.run(options, case, options.out / "three", 3)
    length = time.monotonic() - start
    sound = [runs.differences(expected, options.out / "three") == []]
    kills = in_midrun = 0
    while in_midrun < options.kills and kills < 3 * options.kills:  # those that hit a run under way count
        good, counts = kill_one(options, case, kills, length, expected, dice)
        sound.append(good)
        kills, in_midrun = kills + 1, in_midrun + counts
    sound += [stop_one(options, case, n, length, expected, dice) for n in range(options.stops)]
    sound.append(full_disk(options, case, expected))
    print(f"{in_midrun} kills of a run under way, {kills - in_midrun} others, {options.stops} stops; {sound.count(False)} expectations failed")
    return 0 if all(sound) and in_midrun >= options.kills else 1


if __name__ == "__main__":
    sys.exit(main())
