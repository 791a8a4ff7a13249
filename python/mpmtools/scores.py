"""How well predictions meet simulated values: the performance metrics of Appendix A3.1 of the paper."""

import numpy as np
import pandas as pd

from mpmtools.errors import ConfigError

SCORES = ("r2", "r2_log", "nrmse", "rmsle", "bias", "fraction_10", "fraction_25")


def compute_scores(simulated, predicted):
    """Scores of predictions f against simulated values y > 0, as a Series; logarithms are natural, fractions are ratios.

    r2, r2_log                determination of y and of log y: 1 - sum (y - f)^2 / sum (y - mean y)^2; NaN where all y are equal
    nrmse                     sqrt(mean (y - f)^2) / mean y
    rmsle                     sqrt(mean (log y - log f)^2)
    bias                      exp(mean log(y/f)); above 1 the predictions are too low
    fraction_10, fraction_25  part of the predictions with |y - f| <= 0.10 y, 0.25 y
    """
    y, f = np.asarray(simulated, float), np.asarray(predicted, float)
    if y.size == 0 or y.size != f.size:
        raise ConfigError(f"scores: {y.size} simulated and {f.size} predicted values: need the same number, at least one")
    for what, values in (("simulated", y), ("predicted", f)):
        wrong = ~((values > 0.0) & np.isfinite(values))
        if wrong.any():
            raise ConfigError(f"scores: a {what} value is {values[wrong][0]}: must be positive and finite")
    log_ratio = np.log(y / f)
    off = np.abs(y - f) / y
    return pd.Series({
        "r2": _determination(y, y - f),
        "r2_log": _determination(np.log(y), log_ratio),
        "nrmse": np.sqrt(np.mean((y - f) ** 2)) / np.mean(y),
        "rmsle": np.sqrt(np.mean(log_ratio**2)),
        "bias": np.exp(np.mean(log_ratio)),
        "fraction_10": np.mean(off <= 0.10),
        "fraction_25": np.mean(off <= 0.25),
    })


def _determination(values, residuals):
    if np.all(values == values[0]):  # rounding of the mean can leave a total that is not exactly zero
        return np.nan
    return 1.0 - np.sum(residuals**2) / np.sum((values - np.mean(values)) ** 2)


def levels(values):
    """Each value replaced by the smallest of those that are meant to be equal: within 1e-6 of themselves, or of 1.

    Inputs pass through decimal text or another quantity, and then differ by their rounding; a group-by needs them equal.
    """
    values = pd.Series(values, dtype=float)
    level, representative = np.nan, {}
    for value in np.sort(values.dropna().unique()):
        if not same_input(value, level):
            level = value
        representative[value] = level
    return values.map(representative)


def same_input(a, b):
    """Are two inputs meant to be equal? To 1e-6 of themselves, or of 1."""
    return np.abs(a - b) <= 1e-6 * np.maximum(1.0, np.abs(b))


def scores_by_group(keys, simulated, predicted):
    """Scores of the rows that share a value of one input (Figs. A3 and A5), by rising value: at, runs, and the scores."""
    if not len(keys) == len(simulated) == len(predicted):
        raise ConfigError(f"scores by group: {len(keys)} keys, {len(simulated)} simulated and {len(predicted)} predicted values: "
                          "need the same number of each")
    rows = pd.DataFrame({"y": np.asarray(simulated, float), "f": np.asarray(predicted, float)})
    by_level = rows.groupby(levels(np.asarray(keys, float)))
    return pd.DataFrame([{"at": at, "runs": len(group), **compute_scores(group.y, group.f)} for at, group in by_level])
