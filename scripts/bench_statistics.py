"""Statistics of the regression tracker: how much slower is one program than another, measured in turn on a noisy machine?

Measured are pairs (baseline, current) of times taken right after each other, so that both meet much the same disturbance; several launches
of the two processes, because where memory happens to lie changes a program's speed by a few per cent for as long as it runs.

Estimate: the mean over launches of the median, in a launch, of log(current / baseline). Interval: percentile bootstrap on two levels,
launches and the pairs within them (Davison & Hinkley 1997, Sect. 3.8).
"""

import math
from dataclasses import dataclass

import numpy

THRESHOLD = 0.02  # smaller changes are not called: memory layout alone can do that
CONFIDENCE = 0.99  # of the interval: eight kernels a run, so that a false alarm comes in fewer than one run in ten even without the threshold


@dataclass
class Comparison:
    ratio: float  # current / baseline
    low: float
    high: float

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
        raise ValueError("at least two launches of two pairs are needed")
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
