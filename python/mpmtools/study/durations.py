"""What the duration of a run does to its heights: the same run cut off earlier.

A slow pile of cohesive snow grows for minutes. The campaigns at w/5 and 0.25 m with the paper's numerics took shorter runs than the paper.
"""

import numpy as np
import pandas as pd

from mpmtools.scores import same_input
from mpmtools.statistics import estimate_mean
from mpmtools.study.fits import NARROW, WIDE, fit_set
from mpmtools.study.histories import last_third, series_of
from mpmtools.study.regression import EQUATIONS
from mpmtools.study.runs import POINT, read_runs_or_refuse

SHORTER_S = {0.1: 60.0, 0.3: 30.0, 1.0: 14.0}  # Froude number: duration of most runs of results/first_w5, s
INPUTS = [*POINT, "effective_friction"]


def cut_heights(table):
    """A row for each slow run whose folder is there and whose series is longer than SHORTER_S: inputs; shorter_s and whole_s, the two
    durations; and for each height over H, its mean over the last third of either (`runup_shorter`, `runup_whole`), the standard error of that
    mean, and the shorter run over the whole one (`runup_ratio`).

    @param table  results.csv of a campaign, beside its folders runs/NAME"""
    rows = []
    for run in read_runs_or_refuse([table]).runs.itertuples():
        shorter = next((s for froude, s in SHORTER_S.items() if same_input(froude, run.froude_number)), None)
        series = series_of(run) if shorter else None
        if series is None or series.index[-1] < shorter * (1.0 + 1e-9):
            continue
        row = {**{name: getattr(run, name) for name in INPUTS}, "shorter_s": shorter, "whole_s": series.index[-1]}
        for height in ("runup", "pressure_height"):
            for name, part in (("shorter", series[series.index <= shorter * (1.0 + 1e-9)]), ("whole", series)):
                row[f"{height}_{name}"], row[f"{height}_{name}_standard_error"] = estimate_mean(last_third(part)[height])
            row[f"{height}_ratio"] = row[f"{height}_shorter"] / row[f"{height}_whole"]
        rows.append(row)
    return pd.DataFrame(rows)


def coefficients_by_duration(runs, cut):
    """Coefficients of all runs, with the heights of the runs in `cut` (cut_heights) taken from the shorter and from the whole series: a row for
    each fitting set, coefficient and duration."""
    rows = []
    for name in ("shorter", "whole"):
        heights = cut[[*POINT, f"runup_{name}", f"pressure_height_{name}"]].round({key: 9 for key in POINT})
        changed = runs.assign(**{key: runs[key].round(9) for key in POINT}).merge(heights, on=POINT, how="left")
        for height in ("runup", "pressure_height"):
            changed[height] = np.where(changed[f"{height}_{name}"].notna(), changed[f"{height}_{name}"], changed[height])
        for fitting_set in (NARROW, WIDE):
            for equation in EQUATIONS:
                found = fit_set(equation, fitting_set, changed)
                for parameter, estimate in (found.fit.estimates if found.fit else {}).items():
                    rows.append({"duration": name, "fitting_set": fitting_set.name, "parameter": parameter, "runs": found.runs,
                                 "value": estimate.value, "standard_error": estimate.standard_error})
    return pd.DataFrame(rows)
