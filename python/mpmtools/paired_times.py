"""How much slower is one program than another? Two programs are timed in turn on a noisy machine, and their ratio gets an interval.

Measured are pairs (baseline, current) of times taken right after each other, so that both meet much the same disturbance; several launches
of the two processes, because where memory happens to lie changes a program's speed by a few per cent for as long as it runs.

Estimate: the mean over launches of the median, in a launch, of log(current / baseline). Interval: percentile bootstrap on two levels,
launches and the pairs within them (Davison & Hinkley 1997, Sect. 3.8).
"""

import math
import os
import subprocess
import sys
import time
from dataclasses import dataclass

import numpy

from mpmtools.errors import ConfigError, InputError

THRESHOLD = 0.02  # smaller changes are not called: memory layout alone can do that
CONFIDENCE = 0.99  # of the interval: eight kernels a run, so that a false alarm comes in fewer than one run in ten even without the threshold


class TimedProgram:
    """A process that runs a kernel when it is asked: it reads lines with a number of passes from its standard input, and answers each with the
    nanoseconds that one pass took (a mean over the passes). `bench_paired KERNEL PARTICLES` is one; serve() makes one of a Python function.

    command: the words of the command; core: where it is pinned, None: anywhere. It gets one thread.
    """

    def __init__(self, command, core=None):
        environment = {**os.environ, "OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1", "OMP_PROC_BIND": "false"}
        pin = None if core is None else lambda: os.sched_setaffinity(0, {core})
        try:
            self.process = subprocess.Popen([str(word) for word in command], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True,
                                            env=environment, preexec_fn=pin)
        except OSError as error:
            raise InputError(f"cannot start '{command[0]}': {error.strerror}") from None

    def ask(self, passes):
        """Nanoseconds of a pass, mean of `passes` passes."""
        try:
            self.process.stdin.write(f"{passes}\n")
            self.process.stdin.flush()
            return float(self.process.stdout.readline())
        except (BrokenPipeError, ValueError):
            code = self.process.wait()
            raise InputError(f"{' '.join(self.process.args)} ended with code {code} instead of answering with a time") from None

    def close(self):
        self.process.stdin.close()
        self.process.stdout.close()
        if self.process.wait() != 0:
            raise InputError(f"exit code {self.process.returncode} of {' '.join(self.process.args)}")


def serve(kernel):
    """Makes a Python function a TimedProgram: answers on standard output until standard input ends. The processor time of this thread counts."""
    for line in sys.stdin:
        passes = int(line)
        begin = time.thread_time_ns()
        for _ in range(passes):
            kernel()
        print((time.thread_time_ns() - begin) / passes, flush=True)


def measure(baseline, current, launches=8, pairs=40, slice_ms=4.0, work=1, core=None):
    """Times two commands in turn: arrays of (baseline, current) nanoseconds, one list a launch; the order within pairs is ABBA.

    slice_ms: time of one sample: short against the drift of a busy machine, long against the clock. work: what a pass does of the thing that
    the answers are about (particles of bench_paired, whose answers are nanoseconds a particle).
    """
    result = []
    for launch in range(launches):
        programs = [None, None]
        for i in (0, 1) if launch % 2 == 0 else (1, 0):  # which is started first gets the memory it gets
            programs[i] = TimedProgram((baseline, current)[i], core)
        passes = max(1, round(slice_ms * 1e6 / max(1.0, programs[0].ask(1) * work)))
        programs[1].ask(1)
        samples = []
        for pair in range(pairs):
            sample = [0.0, 0.0]
            for i in (0, 1) if pair % 2 == 0 else (1, 0):
                sample[i] = programs[i].ask(passes)
            samples.append(sample)
        for program in programs:
            program.close()
        result.append(samples)
    return result


@dataclass
class Comparison:
    ratio: float  # current / baseline
    low: float
    high: float

    def __str__(self):
        return f"{self.ratio:.3f} times the time of the baseline ({100 * CONFIDENCE:.0f} % interval {self.low:.3f} to {self.high:.3f}): {self.verdict}"

    @property
    def verdict(self):
        """slower | faster, if the interval excludes 1 and the ratio is off by more than the threshold; else no change."""
        if self.low > 1.0 and self.ratio > 1.0 + THRESHOLD:
            return "slower"
        if self.high < 1.0 and self.ratio < 1.0 - THRESHOLD:
            return "faster"
        return "no change"


def compare(launches, resamples=2000, seed=1):
    """@param launches  list of arrays of shape (pairs, 2): times of baseline and current"""
    logs = [numpy.log(numpy.asarray(pairs, dtype=float)[:, 1] / numpy.asarray(pairs, dtype=float)[:, 0]) for pairs in launches]
    if len(logs) < 2 or min(len(l) for l in logs) < 2:
        raise ConfigError(f"{len(logs)} launches, the shortest of {min(map(len, logs), default=0)} pairs: at least two launches of two pairs are needed")
    random = numpy.random.default_rng(seed)
    medians = numpy.empty((len(logs), resamples))  # bootstrapped median of each launch
    for i, log in enumerate(logs):
        medians[i] = numpy.median(log[random.integers(len(log), size=(resamples, len(log)))], axis=1)
    chosen = random.integers(len(logs), size=(len(logs), resamples))
    means = medians[chosen, numpy.arange(resamples)].mean(axis=0)
    tail = 50.0 * (1.0 - CONFIDENCE)
    low, high = numpy.percentile(means, [tail, 100.0 - tail])
    centre = float(numpy.mean([numpy.median(log) for log in logs]))
    return Comparison(math.exp(centre), math.exp(low), math.exp(high))
