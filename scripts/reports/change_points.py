"""At which commit did the speed change? A series of ratios to one baseline, each with an interval, is cut into stretches of constant speed.

The cuts minimise sum((x - mean of its stretch)^2 / sigma^2) + penalty * (number of cuts), x the logarithms of the ratios: optimal partitioning
(Jackson et al. 2005), exact. A change that stays is seen by all the commits after it, so that it is found where a comparison of two neighbours
would leave it in doubt; a single disturbed measurement needs two cuts and is not called so easily. The penalty is the level that the best of all
cuts in all series exceeds by chance in FALSE_ALARMS of the runs (normal errors, Bonferroni). Changes below THRESHOLD are not called.
"""

import math
from dataclasses import dataclass
from statistics import NormalDist

import numpy as np

from mpmtools.paired_times import CONFIDENCE, THRESHOLD

FALSE_ALARMS = 0.01  # runs with one, of those without any change
SMALLEST_SIGMA = 0.003  # of a logarithm: two builds of the same source differ by as much, whatever their intervals say
INSTRUCTIONS = 0.005  # a smaller change of a count of instructions is of no interest


@dataclass
class Change:
    """Between the measurements `place` - 1 and `place` of a series."""

    place: int
    ratio: float  # mean of the stretch from here on / mean of the stretch before
    low: float  # interval of the ratio
    high: float


def sigma_of(low, high):
    """Standard error of log(ratio), from the interval of the ratio."""
    z = NormalDist().inv_cdf(0.5 + 0.5 * CONFIDENCE)
    return np.maximum((np.log(high) - np.log(low)) / (2.0 * z), SMALLEST_SIGMA)


def changes(ratio, low, high, series=1, threshold=THRESHOLD):
    """The changes in a series of ratios. @param series  how many series are looked at together: one false alarm is for all of them"""
    value, weight = np.log(np.asarray(ratio, float)), sigma_of(np.asarray(low, float), np.asarray(high, float)) ** -2.0
    n = len(value)
    if n < 2:
        return []
    penalty = NormalDist().inv_cdf(1.0 - FALSE_ALARMS / (2.0 * (n - 1) * series)) ** 2
    ends = _partition(value, weight, penalty)
    while True:
        found = _changes_at(ends, value, weight)
        smallest = min(found, key=lambda c: abs(math.log(c.ratio)), default=None)
        if smallest is None or abs(smallest.ratio - 1.0) > threshold:
            return found
        ends.remove(smallest.place)


def _partition(value, weight, penalty):
    """Places where a stretch begins, without the first."""
    sums = [np.concatenate([[0.0], np.cumsum(weight * value**k)]) for k in range(3)]

    def cost(a, b):
        w, wx, wxx = (s[b] - s[a] for s in sums)
        return wxx - wx * wx / w

    n = len(value)
    best, previous = [-penalty], [0]
    for end in range(1, n + 1):
        options = [best[begin] + cost(begin, end) + penalty for begin in range(end)]
        previous.append(int(np.argmin(options)))
        best.append(options[previous[-1]])
    places, at = [], n
    while previous[at] > 0:
        at = previous[at]
        places.append(at)
    return places[::-1]


def _changes_at(places, value, weight):
    z = NormalDist().inv_cdf(0.5 + 0.5 * CONFIDENCE)
    edges = [0, *places, len(value)]
    means = [np.average(value[a:b], weights=weight[a:b]) for a, b in zip(edges, edges[1:])]
    variances = [1.0 / weight[a:b].sum() for a, b in zip(edges, edges[1:])]
    result = []
    for i, place in enumerate(places):
        step, reach = means[i + 1] - means[i], z * math.sqrt(variances[i] + variances[i + 1])
        result.append(Change(place, math.exp(step), math.exp(step - reach), math.exp(step + reach)))
    return result


def instruction_changes(counts):
    """The same for counts of instructions, which have no noise: every step above INSTRUCTIONS. NaN: not counted"""
    counts = np.asarray(counts, float)
    known = np.flatnonzero(np.isfinite(counts))
    ratios = [(int(b), counts[b] / counts[a]) for a, b in zip(known, known[1:])]
    return [Change(place, ratio, ratio, ratio) for place, ratio in ratios if abs(ratio - 1.0) > INSTRUCTIONS]
