"""Fits and runs as the tables of the study compare them."""

from dataclasses import replace

import numpy as np
import pandas as pd

from mpmtools.equations import relative_height
from mpmtools.errors import ConfigError
from mpmtools.fit.fits import NARROW, height_samples
from mpmtools.fit.regression import EQUATIONS, RUNUP, fit_heights
from mpmtools.fit.runs import POINT
from mpmtools.scores import SCORES, compute_scores, levels
from mpmtools.tables import number_text

# Not what the paper says of its fit, but what its standard errors look like (published.py).
LINEAR_RUNUP = replace(RUNUP, formula=RUNUP.formula.replace("log(h_r)", "h_r/H"), logarithmic=False, score="nrmse")


def score_against_published(equation, samples):
    """Scores of the published equation on samples, those of height_samples(); NaN without any."""
    if samples.empty:
        return pd.Series(np.nan, index=SCORES)
    return compute_scores(samples.relative_height, relative_height(samples.effective_friction, samples.froude_number, equation.published))


def coefficients_and_scores(runs, fitting_set):
    """{coefficient or score: value} of both equations on one set: its own coefficients (NaN where the runs do not determine them), and the
    scores of the published equations, as `runup_rmsle`."""
    row = {}
    for equation in EQUATIONS:
        samples = height_samples(equation, runs[fitting_set.holds(runs)])
        try:
            row.update({name: e.value for name, e in fit_heights(equation, samples, with_profile=False).estimates.items()})
        except ConfigError:  # too few runs, or too much alike
            row.update(dict.fromkeys(equation.parameters, np.nan))
        scores = score_against_published(equation, samples)
        row.update({f"{equation.name}_{score}": scores[score] for score in (equation.score, "fraction_25")})
    return row


def own_coefficients(fits):
    """{equation name: coefficients} of the narrow set, which the study takes for its own; None where it could not be fitted."""
    return {s.equation.name: s.fit.coefficients if s.fit else None for s in fits if s.fitting_set is NARROW}


def point_keys(runs):
    """Flow and snow of each run, equal inputs equal to the bit."""
    return pd.DataFrame({name: levels(runs[name]).round(9) for name in POINT})


def inputs_text(froude, slope, beta, xi):
    return f"Fr = {number_text(froude)}, M = {number_text(slope)}, beta = {number_text(beta)}, xi = {number_text(xi)}"
