"""Numerical uncertainty from two or three grids, and how it adds to the statistical error.

Three grids: observed order by Celik et al. (2008, J. Fluids Eng. 130, 078001), grid convergence index (GCI) by Roache with a safety factor
of 1.25 for a credible order, CREDIBLE. A faster order is not believed: 1.25 times the range of the values. Without an order (oscillation,
growing differences, slower than CREDIBLE) three times the range of the values (both after Eca and Hoekstra 2009, Computers & Fluids 38,
1580). Both are at least what two grids give: first order is taken, and a safety factor of 3 (Roache).
"""

import math
from typing import NamedTuple

import scipy.stats
from scipy.optimize import brentq

CREDIBLE = (0.5, 2.0)  # orders, as in validation/cases/avalanche_convergence: 1 at walls, 2 in the interior
TWO_GRIDS_ORDER = 1.0  # cannot be observed: the lower of the two formal ones


class GridEstimate(NamedTuple):
    """Of the value on the finest grid."""

    uncertainty: float  # GCI times the value, in its unit; NaN: not known
    order: float  # observed; NaN: none
    limit: float  # Richardson; NaN without a credible order
    note: str  # how it was found


def observed_order(sizes, values):
    """p of three grids, coarse first; NaN where the values do not approach a limit from one side."""
    (h3, h2, h1), (f3, f2, f1) = sizes, values
    e32, e21 = f3 - f2, f2 - f1
    if e21 == 0.0 or e32 == 0.0 or e32 * e21 < 0.0:
        return math.nan
    r21, r32 = h2 / h1, h3 / h2

    def excess(p):  # grows with p; p -> 0: ratio of the logarithms
        steps = math.log(r32) / math.log(r21) if abs(p) < 1e-9 else math.expm1(p * math.log(r32)) / math.expm1(p * math.log(r21))
        return math.log(r21**p * steps) - math.log(e32 / e21)

    low, high = -20.0, 20.0
    if excess(low) > 0.0 or excess(high) < 0.0:
        return math.nan
    return brentq(excess, low, high)


def grid_estimate(sizes, values):
    """@param sizes cell sizes, coarse first; @param values as many; values that are None or NaN drop out with their grid"""
    known = [(h, f) for h, f in zip(sizes, values) if f is not None and math.isfinite(f)]
    if len(known) < 2 or known[-1][0] != sizes[-1]:
        return GridEstimate(math.nan, math.nan, math.nan, "fewer than two grids have a value")
    sizes, values = zip(*known[-3:])
    ratio = sizes[-2] / sizes[-1]
    two_finest = 3.0 * abs(values[-1] - values[-2]) / (ratio**TWO_GRIDS_ORDER - 1.0)
    if len(known) == 2:
        return GridEstimate(two_finest, math.nan, math.nan, "two grids: first order taken, safety factor 3")
    order = observed_order(sizes, values)
    spread = max(values) - min(values)
    if CREDIBLE[0] <= order <= CREDIBLE[1]:
        step = (values[-1] - values[-2]) / (ratio**order - 1.0)
        return GridEstimate(1.25 * abs(step), order, values[-1] + step, "three grids, observed order, safety factor 1.25")
    factor, text = 1.25 if order > CREDIBLE[1] else 3.0, "the observed order is not believed" if math.isfinite(order) else "no order is observed"
    method = f"{factor:g} times the range of the values" if factor * spread >= two_finest else "first order taken, safety factor 3"
    return GridEstimate(max(factor * spread, two_finest), order, math.nan, f"three grids, {text}: {method}")


BATCHES = (20, 10, 5)  # into which the program cuts a series for the standard error of its mean
LENGTH = 5.0  # least length of a batch, in independent samples, unless there are only 5


def batches_of(effective_samples):
    """How many batches the program took, by its rule; 5 where it does not say how many independent samples there are."""
    return next((number for number in BATCHES if effective_samples >= LENGTH * number), BATCHES[-1])


def statistical(standard_error, effective_samples):
    """Half width of a mean's interval of 95 %: standard errors of the mean by Student's t of the batches."""
    return float(scipy.stats.t.ppf(0.975, batches_of(effective_samples) - 1)) * standard_error


def combined(grid, half_width):
    """Half width of an interval of about 95 %: grid uncertainty and statistical(), root of the sum of squares; they are independent.

    An unknown part is left out: the label of the number has to say so.
    """
    parts = [part for part in (grid, half_width) if math.isfinite(part)]
    return math.sqrt(sum(part**2 for part in parts)) if parts else math.nan
