"""How long a high run-up lasts.

In fast, cohesive, compressible snow the run-up first stays on a high plateau, for longer than the paper's runs last, and then falls to
a lower one. A mean over a short run is that of the first plateau, of the second, or of both.
"""

import math
from typing import NamedTuple

import numpy as np

from mpmtools.errors import ConfigError

AVERAGE_S = 2.0   # of the running mean
LATE_S = 15.0     # at the end of a series: the lower plateau
FALLEN = 0.75     # a run-up has fallen if its late mean is below this part of its highest running mean


class Plateaus(NamedTuple):
    """Heights in the unit of the series."""

    highest: float  # running mean
    late: float     # mean over the end of the series
    fell_s: float   # end of the last running mean above the middle of both; not a number if the run-up did not fall


def plateaus(times_s, runup):
    """Plateaus of a run-up. @param times_s, runup  evenly spaced, longer than AVERAGE_S and LATE_S together"""
    times, heights = np.asarray(times_s, float), np.asarray(runup, float)
    if len(times) < 3 or times[-1] - times[0] <= AVERAGE_S + LATE_S:
        raise ConfigError(f"a series of more than {AVERAGE_S + LATE_S:g} s is needed")
    width = max(1, round(AVERAGE_S / (times[1] - times[0])))
    running = np.convolve(heights, np.full(width, 1.0 / width), "valid")  # running[i] ends at times[i + width - 1]
    highest, late = running.max(), heights[times > times[-1] - LATE_S].mean()
    if late >= FALLEN * highest:
        return Plateaus(highest, late, math.nan)
    last = np.flatnonzero(running > 0.5 * (highest + late))[-1]
    return Plateaus(highest, late, times[last + width - 1])
