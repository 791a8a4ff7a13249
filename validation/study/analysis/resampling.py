"""Refits of an equation to many weightings of the same runs at once: what bootstrap, jackknife and influence need thousands of.

The minimum is the one of regression.fit_heights(), found another way. Runs of one M' and Fr enter a sum of squares only through their
number, sum and sum of squares, so that they are put together as cells; then

- pressure height: with kappa held, h/H - 1 = k M' + min(Fr, Fr_sat)^2/2 exp(-kappa M') is linear in k and Fr_sat^2/2, the latter within
  the interval between two Froude numbers of the table. Each interval is solved exactly, and kappa is searched (variable projection,
  Golub and Pereyra 1973, SIAM J. Numer. Anal. 10, 413).
- run-up: k and kappa by Levenberg-Marquardt, for all weightings side by side.
"""

import numpy as np

from mpmtools.scores import levels

KAPPAS = np.linspace(-1.0, 6.0, 71)  # from dissipation that adds energy to no head left; the search is refined between neighbours
REFINEMENTS = 32  # of a golden section: 0.2 of kappa to 4e-8
MAX_STEPS, ENOUGH = 100, 1e-12  # of Levenberg-Marquardt, and the relative change of the coefficients that ends it


class Cells:
    """Weighted runs put together by (M', Fr). Arrays are (weightings, cells); `height` is h/H - 1 or log(h/H)."""

    def __init__(self, equation, samples, weights):
        friction, froude = levels(samples.effective_friction).to_numpy(), levels(samples.froude_number).to_numpy()
        corners, cell = np.unique(np.column_stack([friction, froude]), axis=0, return_inverse=True)
        member = np.zeros((len(samples), len(corners)))
        member[np.arange(len(samples)), cell.ravel()] = 1.0
        height = samples.relative_height.to_numpy()
        height = np.log(height) if equation.logarithmic else height - 1.0
        weights = np.atleast_2d(np.asarray(weights, float))
        self.friction, self.froude = corners.T
        self.count, self.sum = weights @ member, (weights * height) @ member
        self.squares = weights @ height**2


def refit(equation, samples, weights):
    """Coefficients, in the order of equation.parameters, for each row of weights (one weight a run; 0 leaves it out).

    Fr_sat is infinite where no saturation fits best. A weighting that does not determine the coefficients gives NaN: it must hold snow
    with M' > 0 at two Froude numbers.
    """
    cells = Cells(equation, samples, weights)
    found = _fit_runup(cells) if equation.logarithmic else fit_pressure_height(cells)[0]
    found[~determined(cells)] = np.nan
    return found


def determined(cells):
    """Which weightings hold snow with M' > 0 at two or more Froude numbers."""
    frictional = (cells.friction > 0.0) & (cells.count > 0.0)
    return np.array([len(np.unique(cells.froude[row])) >= 2 for row in frictional])


def _fit_runup(cells):
    """Levenberg-Marquardt on (k, kappa); a weighting whose sum of squares would rise keeps its place and takes a shorter step."""
    m, head = cells.friction, 0.5 * cells.froude**2
    count, total = cells.count, cells.sum

    def parts(x):
        damping = np.exp(-x[:, 1:] * m)
        prediction = 1.0 + x[:, :1] * m + head * damping
        with np.errstate(invalid="ignore", divide="ignore"):
            logarithm = np.log(prediction)
            squares = np.sum(count * logarithm**2 - 2.0 * total * logarithm, axis=1)
        return damping, prediction, logarithm, np.where(np.isfinite(squares), squares, np.inf)

    x = np.tile([1.0, 1.0], (len(count), 1))
    lift = np.full(len(count), 1e-3)
    damping, prediction, logarithm, squares = parts(x)
    for _ in range(MAX_STEPS):
        by_k, by_kappa = m / prediction, -m * head * damping / prediction
        residual = count * logarithm - total
        a, b, c = np.sum(count * by_k**2, 1), np.sum(count * by_k * by_kappa, 1), np.sum(count * by_kappa**2, 1)
        g, h = np.sum(by_k * residual, 1), np.sum(by_kappa * residual, 1)
        a, c = a * (1.0 + lift), c * (1.0 + lift)
        with np.errstate(invalid="ignore", divide="ignore"):
            step = np.column_stack([b * h - c * g, b * g - a * h]) / (a * c - b * b)[:, None]
        step = np.where(np.isfinite(step), step, 0.0)
        tried = parts(x + step)
        better = tried[3] <= squares
        x = x + np.where(better[:, None], step, 0.0)
        damping, prediction, logarithm, squares = (np.where(better[:, None] if new.ndim == 2 else better, new, old)
                                                   for new, old in zip(tried, (damping, prediction, logarithm, squares)))
        lift = np.where(better, 0.2 * lift, 5.0 * lift)
        if np.all(np.abs(step) <= ENOUGH * np.maximum(1.0, np.abs(x))):
            break
    return x


def fit_pressure_height(cells, k=None):
    """((k, Fr_sat, kappa) for each weighting, their sums of squares); k may be held."""
    weightings = len(cells.count)

    def squares(kappa):
        return best_for_kappa(cells, kappa, k)[0]

    scan = np.array([squares(np.full(weightings, kappa)) for kappa in KAPPAS])
    lowest = np.clip(np.argmin(scan, axis=0), 1, len(KAPPAS) - 2)
    kappa = _golden_section(squares, KAPPAS[lowest - 1], KAPPAS[lowest + 1])
    total, found_k, froude = best_for_kappa(cells, kappa, k)
    return np.column_stack([found_k, froude, kappa]), total


def _golden_section(function, low, high):
    """Lowest point of many functions of one variable at once."""
    ratio = 0.5 * (np.sqrt(5.0) - 1.0)
    left, right = high - ratio * (high - low), low + ratio * (high - low)
    at_left, at_right = function(left), function(right)
    for _ in range(REFINEMENTS):
        to_left = at_left < at_right
        low, high = np.where(to_left, low, left), np.where(to_left, right, high)
        kept, at_kept = np.where(to_left, left, right), np.where(to_left, at_left, at_right)
        new = np.where(to_left, high - ratio * (high - low), low + ratio * (high - low))
        at_new = function(new)
        left, right = np.where(to_left, new, kept), np.where(to_left, kept, new)
        at_left, at_right = np.where(to_left, at_new, at_kept), np.where(to_left, at_kept, at_new)
    return 0.5 * (low + high)


def best_for_kappa(cells, kappa, k=None):
    """(sum of squares, k, Fr_sat) of the best fit of the pressure height with kappa, and perhaps k, held: exact."""
    m, knots = cells.friction, np.unique(cells.froude)
    damping = np.exp(-kappa[:, None] * m)
    at_level = (cells.froude[:, None] == knots).astype(float)
    cross, damped = (cells.count * m * damping) @ at_level, (cells.count * damping**2) @ at_level  # by Froude number
    heights = (damping * cells.sum) @ at_level
    a_kk, b_k_all = np.sum(cells.count * m**2, 1), np.sum(m * cells.sum, 1)
    head = 0.5 * knots**2
    best = (np.full(len(kappa), np.inf), np.full(len(kappa), np.nan), np.full(len(kappa), np.nan))
    for low, high in zip(np.concatenate([[0.0], knots[:-1]]), knots):
        free = knots <= low  # not saturated
        b_k = b_k_all - cross[:, free] @ head[free]
        constant = cells.squares - 2.0 * heights[:, free] @ head[free] + damped[:, free] @ head[free]**2
        a_ks, a_ss, b_s = cross[:, ~free].sum(1), damped[:, ~free].sum(1), heights[:, ~free].sum(1)
        with np.errstate(invalid="ignore", divide="ignore"):
            s = (b_s - a_ks * k) / a_ss if k is not None else (a_kk * b_s - a_ks * b_k) / (a_kk * a_ss - a_ks**2)
            s = np.clip(np.where(np.isfinite(s), s, 0.5 * high**2), 0.5 * low**2, 0.5 * high**2)
            own_k = np.full(len(kappa), k) if k is not None else (b_k - a_ks * s) / a_kk
        total = constant - 2.0 * own_k * b_k - 2.0 * s * b_s + own_k**2 * a_kk + 2.0 * own_k * s * a_ks + s**2 * a_ss
        froude = np.where(s >= (1.0 - 1e-7) * 0.5 * knots[-1]**2, np.inf, np.sqrt(2.0 * s))  # up to the round-off of a flat minimum
        better = total < best[0]
        best = tuple(np.where(better, new, old) for new, old in zip((total, own_k, froude), best))
    return best
