"""How far the coefficients depend on which runs there are.

The standard errors of a fit take its residuals to be independent. They are not: all runs of one M' err together, because one equation
describes many rheologies, and so do all runs of one Froude number. Whole materials (values of M') and whole Froude numbers are
therefore drawn anew or left out, and not single rows.
"""

import numpy as np
import pandas as pd
from scipy import optimize

from analysis.fits import LINEAR_RUNUP
from mpmtools import equations
from mpmtools.errors import ConfigError
from mpmtools.scores import levels
from mpmtools.fit.fits import NARROW, WIDE, height_samples
from mpmtools.fit.regression import EQUATIONS, RUNUP, Problem, fit_heights, two_sided_quantile
from analysis.resampling import Cells, best_for_kappa, fit_pressure_height, refit

SEED, RESAMPLES = 19, 1000  # of each bootstrap
TAILS = (0.05, 0.95)  # all intervals here are of 90 %
GROUPS = {"material": "effective_friction", "froude": "froude_number"}
SETS = (NARROW, WIDE)
LOOSE, STIFF = "M' < 0.9", "M' > 0.9"
PARTS = {"all": (RUNUP, lambda runs: runs.froude_number > 0.0), LOOSE: (RUNUP, lambda runs: runs.effective_friction < 0.9),
         STIFF: (RUNUP, lambda runs: runs.effective_friction > 0.9), "Fr < 0.5": (RUNUP, lambda runs: runs.froude_number < 0.5),
         "Fr > 0.5": (RUNUP, lambda runs: runs.froude_number > 0.5), "all, residuals of h/H": (LINEAR_RUNUP, lambda runs: runs.froude_number > 0.0)}


def each_fit(runs):
    """(fit, fitting set, samples) of all that can be fitted."""
    for fitting_set in SETS:
        members = runs[fitting_set.holds(runs)]
        for equation in EQUATIONS:
            samples = height_samples(equation, members).reset_index(drop=True)
            try:
                fit = fit_heights(equation, samples, with_profile=False)
            except ConfigError:  # too few runs, or runs that do not determine the coefficients
                continue
            yield fit, fitting_set, samples


def coefficient_intervals(runs):
    """One row a coefficient: value, published, and intervals of 90 % by its standard error, by the profile of the sum of squares, and by
    bootstrap over materials and over Froude numbers; standard error by the jackknife over materials; lowest and highest value if one
    material is left out, and which (M')."""
    rows = []
    for fit, fitting_set, samples in each_fit(runs):
        equation = fit.equation
        drawn = {name: bootstrap(equation, samples, column) for name, column in GROUPS.items()}
        materials, without = leave_out(equation, samples, "effective_friction")
        profiles = profile_intervals(fit, samples)
        for i, (name, estimate) in enumerate(fit.estimates.items()):
            half = two_sided_quantile(1.0 - (TAILS[1] - TAILS[0]), fit.degrees_of_freedom) * estimate.standard_error
            row = {"equation": equation.name, "fitting_set": fitting_set.name, "parameter": name, "runs": len(samples),
                   "materials": samples.effective_friction.nunique(), "froude_numbers": samples.froude_number.nunique(),
                   "value": estimate.value, "published": equation.published_estimates[name][0],
                   "standard_error_from": estimate.value - half, "standard_error_to": estimate.value + half,
                   "profile_from": profiles[name][0], "profile_to": profiles[name][1]}
            for group, found in drawn.items():
                row[f"{group}_from"], row[f"{group}_to"] = drawn_interval(found[:, i])
                row[f"{group}_undetermined"] = int(np.isnan(found[:, i]).sum())
            values = without[:, i]
            row["jackknife_error"] = jackknife_error(values)
            for which, at in (("lowest", np.argmin(values)), ("highest", np.argmax(values))):
                row[f"{which}_without_one"], row[f"{which}_without_material"] = values[at], materials[at]
            rows.append(row)
    return pd.DataFrame(rows)


def bootstrap(equation, samples, column, resamples=None, seed=SEED):
    """Coefficients of as many draws (RESAMPLES if not given) with replacement of whole groups of runs, those with one value of `column`. NaN where a draw does not
    determine them."""
    groups = levels(samples[column])
    code = groups.astype("category").cat.codes.to_numpy()
    count = code.max() + 1
    weights = np.random.default_rng(seed).multinomial(count, np.full(count, 1.0 / count), size=resamples or RESAMPLES)[:, code]
    found = refit(equation, samples, weights)
    if equation.saturates:
        found[~below_saturation(samples, weights, found[:, 1])] = np.nan
    return found


def drawn_interval(values):
    """Ends of the interval that holds 90 % of the draws that determine a coefficient."""
    known = values[~np.isnan(values)]
    return np.quantile(known, TAILS, method="nearest") if len(known) else (np.nan, np.nan)


def below_saturation(samples, weights, saturation):
    """Which weightings hold snow with M' > 0 slower than Fr_sat. Where all of it is saturated, k and kappa differ by the shape of
    their curves over M' alone."""
    frictional = np.where((weights > 0) & (samples.effective_friction.to_numpy() > 0.0), samples.froude_number.to_numpy(), np.inf)
    return frictional.min(axis=1) < saturation


def leave_out(equation, samples, column):
    """(values of `column`, coefficients without the runs of each)."""
    groups = levels(samples[column]).to_numpy()
    values = np.unique(groups)
    return values, refit(equation, samples, (groups != values[:, None]).astype(float))


def jackknife_error(values):
    """Standard error from the estimates that leave out one group each (Efron and Tibshirani 1993, Eq. 11.5)."""
    count = len(values)
    return float(np.sqrt((count - 1) / count * np.sum((values - np.mean(values)) ** 2)))


def leave_one_out(runs):
    """Coefficients without each material and each Froude number: equation, fitting_set, left_out, at, runs (left), coefficients."""
    tables = []
    for fit, fitting_set, samples in each_fit(runs):
        equation = fit.equation
        for name, column in GROUPS.items():
            values, found = leave_out(equation, samples, column)
            groups = levels(samples[column])
            table = pd.DataFrame({"equation": equation.name, "fitting_set": fitting_set.name, "left_out": name, "at": values,
                                  "runs": [int((groups != value).sum()) for value in values]})
            tables.append(table.join(pd.DataFrame(found, columns=[p.split("_")[0] if p != "Fr_sat" else p for p in equation.parameters])))
    columns = ["equation", "fitting_set", "left_out", "at", "runs", "k", "Fr_sat", "kappa"]
    return pd.concat(tables, ignore_index=True).reindex(columns=columns) if tables else pd.DataFrame(columns=columns)


def runup_parts(runs):
    """The run-up equation fitted to parts of each set, because one k_r need not hold for all, and to all with residuals of h/H instead of its
    logarithm: part, fitting_set, runs, k_r, kappa_r and their standard errors. Slow runs alone do not fix kappa_r, as its standard
    error shows. Left out are parts with one or two kinds of snow, and those that do not determine both coefficients."""
    rows = []
    for fitting_set in SETS:
        samples = height_samples(RUNUP, runs[fitting_set.holds(runs)]).reset_index(drop=True)
        for part, (equation, holds) in PARTS.items():
            of = samples[holds(samples)].reset_index(drop=True)
            if of.effective_friction.nunique() <= len(RUNUP.parameters):
                continue
            row = {"part": part, "fitting_set": fitting_set.name, "runs": len(of)}
            try:
                fit = fit_heights(equation, of, with_profile=False)
            except ConfigError:  # the part does not determine the coefficients
                continue
            for name, estimate in fit.estimates.items():
                row.update({name: estimate.value, f"{name}_standard_error": estimate.standard_error})
            rows.append(row)
    return pd.DataFrame(rows)


def influence(runs):
    """What each run does to the coefficients of the narrow set: its inputs, the residual of the fit (log h/H or h/H, simulation less
    equation), and by how many standard errors each coefficient would change without it. Sorted by what it does to kappa."""
    tables = []
    for fit, fitting_set, samples in each_fit(runs):
        if fitting_set is not NARROW:
            continue
        equation = fit.equation
        without = refit(equation, samples, 1.0 - np.eye(len(samples)))
        fitted = equations.relative_height(samples.effective_friction, samples.froude_number, fit.coefficients)
        residual = np.log(samples.relative_height / fitted) if equation.logarithmic else samples.relative_height - fitted
        table = samples.assign(equation=equation.name, residual=residual)
        for i, (name, estimate) in enumerate(fit.estimates.items()):
            column = name if name == "Fr_sat" else name.split("_")[0]
            table[f"{column}_without"] = without[:, i]
            table[f"{column}_change"] = (without[:, i] - estimate.value) / estimate.standard_error
        tables.append(table.sort_values("kappa_change", key=np.abs, ascending=False))
    columns = ["equation", "froude_number", "effective_friction", "hardening_xi", "relative_height", "residual", "k_without", "k_change",
               "Fr_sat_without", "Fr_sat_change", "kappa_without", "kappa_change"]
    return pd.concat(tables, ignore_index=True).reindex(columns=columns) if tables else pd.DataFrame(columns=columns)


# ---- Profile of the sum of squares ----------------------------------------------------------------------------------------------------


def profile_intervals(fit, samples):
    """{coefficient: interval of 90 %}: where the sum of squares, least over the other coefficients, is at most S (1 + t^2 / (n - p))."""
    limit = fit.sum_of_squares * (1.0 + two_sided_quantile(1.0 - (TAILS[1] - TAILS[0]), fit.degrees_of_freedom)**2 / fit.degrees_of_freedom)
    profiles = _pressure_height_profiles(fit, samples) if fit.equation.saturates else _runup_profiles(fit, samples)
    return {name: (_crossing(profiles[name], estimate, limit, -1.0), _crossing(profiles[name], estimate, limit, 1.0))
            for name, estimate in fit.estimates.items()}


def _crossing(profile, estimate, limit, side):
    """Where the profile passes the limit on one side of its minimum; infinite where it does not within 127 standard errors.
    Beyond it the profile is not searched for another valley. NaN where the minimum is not on the profile: the search of the other
    coefficients has bounds (resampling.py), and runs that do not fix them may lie beyond."""
    if not np.isfinite(estimate.value) or not estimate.standard_error > 0.0 or profile(estimate.value) > limit:
        return np.nan
    inside, step = estimate.value, estimate.standard_error
    for _ in range(7):
        outside = inside + side * step
        if profile(outside) > limit:
            return float(optimize.brentq(lambda x: profile(x) - limit, *sorted((inside, outside)), xtol=1e-6 * estimate.standard_error))
        inside, step = outside, 2.0 * step
    return side * np.inf


def _runup_profiles(fit, samples):
    problem, best = Problem(fit.equation, samples), np.array([fit.coefficients.k, fit.coefficients.kappa])

    def held(index):
        def profile(value):
            def residuals(other):
                return problem.residuals(np.array([value, other[0]]) if index == 0 else np.array([other[0], value]))
            return float(np.sum(optimize.leastsq(residuals, [best[1 - index]], full_output=True)[2]["fvec"] ** 2))
        return profile

    return dict(zip(fit.equation.parameters, (held(0), held(1))))


def _pressure_height_profiles(fit, samples):
    cells = Cells(fit.equation, samples, np.ones((1, len(samples))))

    def at_saturation(froude):
        if froude <= 0.0:
            return np.inf
        problem = Problem(fit.equation, samples, held=froude)
        return problem.minimise([fit.coefficients.k, fit.coefficients.kappa])[0]

    return {"k_p": lambda k: float(fit_pressure_height(cells, k)[1][0]), "Fr_sat": at_saturation,
            "kappa_p": lambda kappa: float(best_for_kappa(cells, np.array([kappa]))[0][0])}
