"""Heights and force in windows and in the paper's strip (validation/study/jams.md).

The strip is an avalanche of particles from its front to its rear, which are both free; a window has an inlet and an outlet.
"""

import numpy as np
import pandas as pd

from mpmtools.run import Run
from analysis.histories import last_third, run_folder, run_means
from mpmtools.tables import numbers, read_table

STRIP_LASTS = {1.0: (10.0, 22.0), 0.3: (16.0, 32.0)}  # s, by Froude number


def window_means(path, strip_lasts=None):
    """A row for each run of a campaign whose folder is there, steady or not: feed (strip with its duration, which sets its length, or window with
    its lengths upstream and downstream), conveyor_width_m, sidewall_contact, froude_number, effective_friction (M'), steady (0 or 1), from_s and
    to_s, and the means with standard errors over that time of run-up and pressure height (over H) and of the force along the flow (N).

    @param path  results.csv of a campaign, beside its folders runs/NAME
    @param strip_lasts  {Froude number: (from, to)} in s, such as STRIP_LASTS; runs of others are left out. None: the last third of each run"""
    def part(series, run):
        if strip_lasts is None:
            return last_third(series)
        first, last = next((span for froude, span in strip_lasts.items() if np.isclose(float(run.froude_number), froude)), (np.inf, -np.inf))
        return series[(series.index >= first) & (series.index <= last)]

    return _means(path, part)


def highest_means(path, seconds=10.0):
    """window_means() over those `seconds` of each run in which the mean run-up is highest: the most that a strip reaches before its rear
    takes the support away."""
    def part(series, run):
        count = round(seconds / np.median(np.diff(series.index)))
        if count >= len(series):
            return series.iloc[:0]  # the run is shorter
        last = series.runup_m.rolling(count + 1).mean().argmax()
        return series.iloc[last - count:last + 1]

    return _means(path, part)


def _means(path, part):
    table = read_table(path)
    means = run_means(table, part)
    table = table.loc[means.index]
    cases = [Run(run_folder(table, name)).case for name in table["name"]]
    of_run = pd.DataFrame({"feed": [_feed(case) for case in cases], "conveyor_width_m": numbers(table, "conveyor_width_m"),
                           "sidewall_contact": [case["conveyor"]["sidewall_contact"] for case in cases],
                           "froude_number": numbers(table, "froude_number"), "effective_friction": numbers(table, "effective_friction"),
                           "steady": table.steady}, index=table.index)
    return of_run.join(means).reset_index(drop=True)


def _feed(case):
    belt = case["conveyor"]
    if belt["feed"] == "strip":
        return f"strip, {case['output']['duration_s']:g} s"
    return f"window, {belt['upstream_length_m']:g} m + {belt['downstream_length_m']:g} m"
