"""Heights and force in windows and in the paper's strip (validation/study/jams.md).

The strip, an avalanche that consists of particles from its front to its rear, ends when the rear reaches the mast; a window has an inlet.
"""

import numpy as np
import pandas as pd

from mpmtools.study.histories import last_third, run_means
from mpmtools.tables import numbers, read_table

STRIP_LASTS = {1.0: (10.0, 22.0), 0.3: (16.0, 32.0)}  # s: from the first impact on, until the rear is near; by Froude number
LENGTHS, WALLS = ("conveyor.upstream_length_m", "conveyor.downstream_length_m"), "conveyor.sidewall_contact"


def window_means(path, strip_lasts=None):
    """A row for each run of a campaign whose folder is there, steady or not: feed (strip, or window with its lengths upstream and downstream),
    conveyor_width_m, sidewall_contact, froude_number, effective_friction (M'), steady (0 or 1), from_s and to_s, and the means with standard
    errors over that time of run-up and pressure height (over H) and of the force along the flow (N).

    @param path  results.csv of a campaign, beside its folders runs/NAME
    @param strip_lasts  {Froude number: (from, to)} in s, such as STRIP_LASTS; runs of others are left out. None: the last third of each run"""
    table = read_table(path)
    of_run = pd.DataFrame({"feed": "strip" if LENGTHS[0] not in table else "window, " + table[LENGTHS[0]] + " m + " + table[LENGTHS[1]] + " m",
                           "conveyor_width_m": numbers(table, "conveyor_width_m"), "sidewall_contact": table.get(WALLS, "no_slip"),
                           "froude_number": numbers(table, "froude_number"), "effective_friction": numbers(table, "effective_friction"),
                           "steady": table.steady})

    def part(series, run):
        if strip_lasts is None:
            return last_third(series)
        first, last = next((span for froude, span in strip_lasts.items() if np.isclose(float(run.froude_number), froude)), (np.inf, -np.inf))
        return series[(series.index >= first) & (series.index <= last)]

    return of_run.join(run_means(path, part), how="inner").reset_index(drop=True)
