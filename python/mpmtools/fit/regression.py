"""The paper's two regressions (Sect. 4.1, Tables A1 and A2): coefficients of Eqs. 7 to 10 from the steady heights of many runs.

Nonlinear least squares with the Levenberg-Marquardt method of MINPACK, which curve_fit, the paper's choice, calls, too. The run-up
is fitted to log(h/H), the pressure height to h/H. All heights are over H, so that runs with different H weigh the same.
"""

from dataclasses import dataclass, field

import numpy as np
from scipy import optimize, stats

from mpmtools.equations import PUBLISHED_PRESSURE_HEIGHT, PUBLISHED_RUNUP, HeightCoefficients
from mpmtools.errors import ConfigError, MpmError
from mpmtools.tables import number_text
from mpmtools.wording import counted, verb

START_KAPPAS = (0.0, 1.0, 4.0)  # what the exponential can mean for M' of order 1: from no dissipation to no head left
PROFILE_STEPS = 20  # of the profile over Fr_sat, between two Froude numbers of the table


@dataclass(frozen=True)
class Equation:
    """One of the two equations, and what the paper found on its own data (NaN: not printed)."""

    name: str  # also the column of the heights
    title: str
    formula: str
    logarithmic: bool  # residuals of log(h/H), else of h/H
    parameters: tuple
    score: str  # the one by which the paper judges it
    published: HeightCoefficients
    published_estimates: dict  # parameter: (value, relative standard error, t)
    published_scores: dict

    @property
    def residuals(self):
        return "log(h/H)" if self.logarithmic else "h/H"

    @property
    def saturates(self):
        return "Fr_sat" in self.parameters


RUNUP = Equation(
    "runup", "Run-up height", "h_r/H = 1 + k_r M' + Fr^2/2 exp(-kappa_r M'), residuals of log(h_r)", True, ("k_r", "kappa_r"), "rmsle",
    PUBLISHED_RUNUP, {"k_r": (PUBLISHED_RUNUP.k, 0.0457, 21.888), "kappa_r": (PUBLISHED_RUNUP.kappa, 0.0188, 53.300)},
    {"r2": np.nan, "r2_log": 0.939, "nrmse": np.nan, "rmsle": 0.130, "bias": 0.981, "fraction_10": 0.663, "fraction_25": 0.929})
PRESSURE_HEIGHT = Equation(
    "pressure_height", "Pressure height", "h_p/H = 1 + k_p M' + min(Fr, Fr_sat)^2/2 exp(-kappa_p M'), residuals of h_p/H", False,
    ("k_p", "Fr_sat", "kappa_p"), "nrmse", PUBLISHED_PRESSURE_HEIGHT,
    {"k_p": (PUBLISHED_PRESSURE_HEIGHT.k, 0.0186, 53.893), "Fr_sat": (PUBLISHED_PRESSURE_HEIGHT.saturation_froude, 0.0370, 27.052),
     "kappa_p": (PUBLISHED_PRESSURE_HEIGHT.kappa, 0.0924, 10.819)},
    {"r2": 0.752, "r2_log": np.nan, "nrmse": 0.066, "rmsle": np.nan, "bias": 1.011, "fraction_10": 0.852, "fraction_25": 1.0})
EQUATIONS = (RUNUP, PRESSURE_HEIGHT)


@dataclass
class Estimate:
    """A fitted coefficient. The standard error is that of curve_fit: sqrt of the diagonal of (J^T J)^-1 S / (n - p), J the Jacobian of
    the residuals at the minimum, S the sum of their squares, n runs, p coefficients. It takes the equation to be right and the
    residuals to be independent and of one size."""

    value: float
    standard_error: float = np.nan
    degrees_of_freedom: int = 0

    @property
    def relative_error(self):
        return self.standard_error / abs(self.value)

    @property
    def t_statistic(self):
        with np.errstate(divide="ignore"):
            return np.divide(self.value, self.standard_error)

    @property
    def p_value(self):
        """Two-sided, of the hypothesis that the coefficient is 0."""
        return two_sided_p_value(self.t_statistic, self.degrees_of_freedom)

    @property
    def interval(self):
        """Of 95 %."""
        t = two_sided_quantile(0.05, self.degrees_of_freedom) if self.degrees_of_freedom else np.nan
        return self.value - t * self.standard_error, self.value + t * self.standard_error


@dataclass
class HeightFit:
    """One equation fitted to some runs."""

    equation: Equation
    coefficients: HeightCoefficients  # saturation_froude infinite: none, always so for the run-up
    estimates: dict  # parameter: Estimate
    runs: int
    degrees_of_freedom: int
    sum_of_squares: float  # of log(h/H) or h/H
    # Pressure height only: the Fr_sat at which profile <= S (1 + t^2 / (n - 3)), t the 97.5 % quantile of Student's t: an interval of
    # 95 % that needs no derivative by Fr_sat. Its upper end is infinite where runs without saturation are as credible.
    saturation_interval: tuple = (np.nan, np.nan)
    saturation_profile: list = field(default_factory=list)  # (Fr_sat, sum of squares with the other two fitted)
    cautions: list = field(default_factory=list)  # sentences on the limits of the standard errors

    def interval(self, parameter):
        return self.saturation_interval if parameter == "Fr_sat" else self.estimates[parameter].interval


def two_sided_p_value(t, degrees_of_freedom):
    """P(|T| >= |t|) of Student's t distribution."""
    return 2.0 * stats.t.sf(np.abs(t), degrees_of_freedom)


def two_sided_quantile(p, degrees_of_freedom):
    """t with two_sided_p_value(t, n) = p: 1.96 for p = 0.05 and many degrees of freedom."""
    return stats.t.isf(0.5 * p, degrees_of_freedom)


class Problem:
    """Residuals, prediction - observation, and their Jacobian by (k, kappa[, Fr_sat]).

    min(Fr, Fr_sat)^2 has a kink in Fr_sat at every Froude number of the table. The problem is smooth while one knows which runs are
    saturated: those with Fr > split have the head Fr_sat^2 / 2, and Fr_sat is fitted; or Fr_sat is held.
    """

    def __init__(self, equation, samples, split=None, held=np.inf):
        self.equation, self.fits_saturation = equation, split is not None
        self.friction, froude, self.height = (samples[c].to_numpy() for c in ("effective_friction", "froude_number", "relative_height"))
        self.saturated = froude > split if self.fits_saturation else None
        self.froude = np.minimum(froude, held)

    def _parts(self, x):
        froude = np.where(self.saturated, x[2], self.froude) if self.fits_saturation else self.froude
        damping = np.exp(-x[1] * self.friction)
        head = 0.5 * froude**2
        return head, damping, 1.0 + x[0] * self.friction + head * damping

    def residuals(self, x):
        with np.errstate(all="ignore"):  # a step to where there is no logarithm is NaN, and is refused by the method
            prediction = self._parts(x)[2]
            return np.log(prediction / self.height) if self.equation.logarithmic else prediction - self.height

    def jacobian(self, x):
        with np.errstate(all="ignore"):
            head, damping, prediction = self._parts(x)
            columns = [self.friction, -self.friction * head * damping]
            if self.fits_saturation:
                columns.append(np.where(self.saturated, x[2] * damping, 0.0))
            jacobian = np.column_stack(columns)
            return jacobian / prediction[:, None] if self.equation.logarithmic else jacobian

    def minimise(self, start):
        """(sum of squares, x), down to round-off: the default tolerance would leave five digits in the standard errors."""
        x = optimize.leastsq(self.residuals, start, Dfun=self.jacobian, xtol=1e-15, ftol=0.0, gtol=0.0, full_output=True)[0]
        total = float(np.sum(self.residuals(x) ** 2))
        return (total if np.isfinite(total) else np.inf), x

    def best_of_starts(self, start_froude=None):
        starts = [[1.0, kappa] + ([start_froude] if self.fits_saturation else []) for kappa in START_KAPPAS]
        return min((self.minimise(start) for start in starts), key=lambda found: found[0])


def fit_heights(equation, samples, with_profile=True):
    """Fits an equation to samples with the columns effective_friction, froude_number and relative_height (h/H).

    Pressure height: the sum of squares may have a minimum between each pair of Froude numbers of the table. Between two neighbours
    the problem is smooth: each such interval is searched on its own from several kappas, its ends are candidates with Fr_sat held
    there, and the best of all is the global minimum. Above the highest Froude number Fr_sat changes nothing: no saturation.
    """
    _require_samples(equation, samples)
    knots = np.unique(samples["froude_number"])
    total, x, saturation, split = _search_saturation(equation, samples, knots if equation.saturates else knots[:0])
    if not np.isfinite(total):
        raise MpmError("regression: no start led to a finite sum of squares")
    if np.isfinite(saturation):
        x, split = np.array([x[0], x[1], saturation]), saturation if split is None else split
    # On a Froude number of the table the derivative is that of the upper side, as forward differences would give it.
    jacobian, degrees = Problem(equation, samples, split).jacobian(x), len(samples) - len(x)
    errors = np.sqrt(np.diag(inverse_normal_matrix(jacobian)) * total / degrees)
    estimates = [Estimate(value, error, degrees) for value, error in zip(x, errors)]
    if equation.saturates:
        estimates = [estimates[0], estimates[2] if np.isfinite(saturation) else Estimate(np.inf), estimates[1]]
    fit = HeightFit(equation, HeightCoefficients(float(x[0]), float(x[1]), float(saturation)), dict(zip(equation.parameters, estimates)),
                    len(samples), degrees, total)
    if equation.saturates and with_profile:
        _profile_saturation(fit, samples, knots, x[:2])
        fit.cautions += _cautions_about_saturation(fit, knots)
    return fit


def _require_samples(equation, samples):
    count = len(equation.parameters)
    if len(samples) <= count:
        raise ConfigError(f"regression of {counted(count, 'coefficient')}: {counted(len(samples), 'run')} "
                          f"{verb(len(samples), 'is', 'are')} left; it needs {count + 1} or more")
    right = ((samples["effective_friction"] >= 0.0) & (samples["froude_number"] >= 0.0) & (samples["relative_height"] > 0.0)
             & np.isfinite(samples).all(axis=1))
    if not right.all():
        friction, froude, height = samples.loc[~right, ["effective_friction", "froude_number", "relative_height"]].iloc[0]
        raise ConfigError(f"regression: a run with M' = {friction:g}, Fr = {froude:g}, h/H = {height:g}: M' and Fr must be at least 0, "
                          "h/H greater than 0")


def _search_saturation(equation, samples, knots):
    """Global minimum over Fr_sat: (sum of squares, x, Fr_sat, split of the interval that it lies in). Without knots Fr_sat is infinite."""
    # From the right, where there is no saturation: of equal minima the one with the fewest coefficients is kept.
    best = (*Problem(equation, samples).best_of_starts(), np.inf, None)
    intervals = zip(np.concatenate([[0.0], knots[:-1]]), knots)
    for low, high in reversed([(low, high) for low, high in intervals if low < high]):
        candidates = [(*Problem(equation, samples, held=low).best_of_starts(), low, None)]
        total, x = Problem(equation, samples, split=low).best_of_starts(0.5 * (low + high))
        if low < abs(x[2]) < high:
            candidates.append((total, x, abs(x[2]), low))
        best = min([best, *candidates], key=lambda found: found[0])
    return best


def _profile_saturation(fit, samples, knots, start):
    """Profile of the sum of squares over Fr_sat, and the interval that it supports."""

    def held(froude):
        return Problem(fit.equation, samples, held=froude).minimise(start)[0]

    edges = np.unique(np.concatenate([[0.0], knots]))
    froude = np.concatenate([np.linspace(low, high, PROFILE_STEPS + 1) for low, high in zip(edges, edges[1:])])
    if np.isfinite(fit.coefficients.saturation_froude):
        froude = np.append(froude, fit.coefficients.saturation_froude)
    froude = np.unique(froude)
    sums = np.array([held(f) for f in froude])
    fit.saturation_profile = list(zip(froude.tolist(), sums.tolist()))
    freedom = len(samples) - 3
    # Round-off of exact data: their sum of squares is a few squares of epsilon.
    limit = fit.sum_of_squares * (1.0 + two_sided_quantile(0.05, freedom) ** 2 / freedom) + len(samples) * 1e-28
    credible = np.flatnonzero(sums <= limit)

    def crossing(a, b):
        return optimize.brentq(lambda f: held(f) - limit, froude[a], froude[b], xtol=1e-13, rtol=1e-13)

    first, last = credible[0], credible[-1]
    fit.saturation_interval = (crossing(first - 1, first) if first > 0 else 0.0,
                               crossing(last, last + 1) if last + 1 < len(froude) else np.inf)


def inverse_normal_matrix(jacobian):
    """(J^T J)^-1 with the columns of J at length 1, so that the units of the coefficients do not matter."""
    length = np.linalg.norm(jacobian, axis=0)
    scaled = jacobian / np.where(length > 0.0, length, 1.0)
    _, singular, directions = np.linalg.svd(scaled, full_matrices=False)
    if not singular[-1] > 1e-7 * singular[0]:  # the errors of the coefficients would exceed their residuals ten million times
        raise ConfigError("regression: the runs do not determine the coefficients; k needs runs with M' > 0, kappa runs with M' > 0 at two "
                          "or more Froude numbers, one of them well above 0")
    return (directions.T / singular**2) @ directions / np.outer(length, length)


def _cautions_about_saturation(fit, knots):
    froude = fit.coefficients.saturation_froude
    if not np.isfinite(froude):
        return ["no saturation: the best fit lets the pressure height grow up to the highest Froude number of the table"]
    if froude in knots:
        return [f"Fr_sat lies on {number_text(froude)}, a Froude number of the table, where the equation has a kink: the standard errors are "
                "those of its upper side only; take the interval instead"]
    below, above = max([0.0, *knots[knots < froude]]), min(knots[knots > froude])
    cautions = [f"Fr_sat lies between {number_text(below)} and {number_text(above)} of the table, with no run in between: the runs show the "
                "height of the plateau, and Fr_sat is where the velocity head would reach it, not an onset that was seen"]
    low, high = (froude + side * 2.0 * fit.estimates["Fr_sat"].standard_error for side in (-1.0, 1.0))
    if low < below or high > above:
        cautions.append(f"Fr_sat +- 2 standard errors, {low:.3f} to {high:.3f}, reaches over a Froude number of the table, where the equation "
                        "has a kink: its standard error, t and p are not trustworthy; take the interval instead")
    return cautions
