#!/usr/bin/python3
"""Counts the verdicts of the tracker's statistics on synthetic measurements: check_bench_statistics.py PYTHON_DIR OUTPUT.json"""

import json
import sys

import numpy

sys.path.insert(0, sys.argv[1])
from mpmtools import paired_times  # noqa: E402

LAUNCHES, PAIRS, RUNS = 8, 40, 100


def measure(ratio, random):
    """A busy machine: speed that drifts by tens of per cent and is shared by a pair, 5 % jitter of each, one sample in ten disturbed by up to
    three times, and 1 % for the memory layout of each process."""
    launches = []
    for _ in range(LAUNCHES):
        drift = numpy.exp(0.3 * numpy.sin(numpy.arange(PAIRS) / 5.0 + random.uniform(0.0, 6.0)))
        pairs = drift[:, None] * numpy.array([1.0, ratio]) * numpy.exp(0.01 * random.standard_normal(2))
        pairs *= numpy.exp(0.05 * random.standard_normal((PAIRS, 2)))
        pairs *= numpy.where(random.random((PAIRS, 2)) < 0.1, random.uniform(1.0, 3.0, (PAIRS, 2)), 1.0)
        launches.append(pairs)
    return launches


counts = {}
for ratio in (0.95, 1.0, 1.05):
    random = numpy.random.default_rng(7)
    results = [paired_times.compare(measure(ratio, random), resamples=400) for _ in range(RUNS)]
    verdicts = [r.verdict for r in results]
    counts[f"{ratio:.2f}"] = {name: verdicts.count(name) for name in ("slower", "faster", "no change")} | {
        "covered": sum(r.low <= ratio <= r.high for r in results)
    }
with open(sys.argv[2], "w", encoding="utf-8") as file:
    json.dump(counts, file)
