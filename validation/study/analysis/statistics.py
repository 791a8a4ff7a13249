"""Means of correlated samples, and quotients of means, with their standard errors."""

from typing import NamedTuple

import numpy as np


class MeanEstimate(NamedTuple):
    mean: float
    standard_error: float  # of the mean; NaN with fewer than ten samples


def estimate_mean(values):
    """Mean and standard error by non-overlapping batch means (Schmeiser 1982, Oper. Res. 30, 556); NaN is left out.

    The samples are cut into 20, 10 or 5 equal batches: the most that are each five autocorrelation times long, 5 if none are.
    """
    finite = np.asarray(values, float)
    finite = finite[np.isfinite(finite)]
    if finite.size < 10:
        return MeanEstimate(float(np.mean(finite)) if finite.size else np.nan, np.nan)
    wanted = 5.0 * autocorrelation_time(finite)
    batches = next((b for b in (20, 10) if finite.size // b >= wanted), 5)
    length = finite.size // batches
    means = finite[finite.size - batches * length:].reshape(batches, length).mean(axis=1)
    return MeanEstimate(float(np.mean(finite)), float(np.std(means, ddof=1) / np.sqrt(batches)))


def autocorrelation_time(values):
    """1 + 2 sum rho_k in samples, summed up to the first lag beyond five times itself (Sokal 1997); at least 1."""
    deviation = values - np.mean(values)
    zero_lag = np.sum(deviation**2)
    if zero_lag == 0.0:
        return 1.0
    time, lag = 1.0, 1
    while lag < values.size and lag < 5.0 * time:
        time += 2.0 * np.sum(deviation[lag:] * deviation[:-lag]) / zero_lag
        lag += 1
    return max(time, 1.0)


def ratio_of_means(mean, error, reference, reference_error):
    """Quotient of two independent means, and its standard error by propagation of theirs. Numbers or arrays."""
    ratio = mean / reference
    return ratio, np.abs(ratio) * np.hypot(error / mean, reference_error / reference)
