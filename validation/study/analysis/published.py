"""What the printed statistics of the paper say about the runs and the fit behind them.

A fit's standard errors follow from its design (the inputs of the runs), its coefficients and the size of its residuals. The paper prints the
errors, the coefficients and scores that give the size; so each design that it may have can be tried, and each kind of residual.
"""

from itertools import product

import numpy as np
import pandas as pd

from analysis.fits import LINEAR_RUNUP
from mpmtools import equations
from mpmtools.fit.regression import EQUATIONS, Problem, inverse_normal_matrix

SLOPES, COHESIONS, FROUDE_NUMBERS = (0.0, 0.4, 0.8, 1.2), (0.0, 0.15, 0.3, 0.45), (0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 7.0)
# Pairs of M and beta for each xi, at every Froude number (Sect. 2.2). For 1.5 and 0.15 the paper does not print them: those of our plans.
PAIRS = {5.0: [*product(SLOPES, COHESIONS)], 0.5: [*product(SLOPES, COHESIONS)], 1.5: [(0.4, 0.15), (0.8, 0.3), (1.2, 0.45)],
         0.15: [(0.4, 0.15), (0.8, 0.3)]}
XIS = {"narrow": (5.0, 0.5, 1.5), "wide": (5.0, 0.5, 1.5, 0.15)}  # note b of Table 1; Sect. 4.1
WITHOUT_FLUID = " without the fluid"


def paper_designs():
    """{name: inputs of the runs}: both sets that the paper may have fitted, with the fluid (M = 0, four values of beta) and without it."""
    designs = {}
    for name, xis in XIS.items():
        rows = [(*pair, froude, xi) for xi in xis for pair in PAIRS[xi] for froude in FROUDE_NUMBERS]
        whole = pd.DataFrame(rows, columns=["critical_state_slope", "cohesion_beta", "froude_number", "hardening_xi"])
        whole["effective_friction"] = equations.effective_friction(whole.critical_state_slope, whole.cohesion_beta)
        designs |= {name: whole, name + WITHOUT_FLUID: whole[whole.effective_friction > 0.0].reset_index(drop=True)}
    return designs


def published_errors():
    """Printed relative standard errors of the coefficients, beside those of a fit of each design: equation, design, runs, parameter, residuals
    (log(h/H) or h/H), published_score (of these residuals, NaN: not printed), relative_standard_error (that follows from this score),
    published_relative_standard_error, needed_residual (root mean square of the residuals that would give the printed error). A design and a
    kind of residual are credible where all coefficients of an equation need the same residual."""
    rows = []
    for design, samples in paper_designs().items():
        for equation in (*EQUATIONS, LINEAR_RUNUP):
            heights, residual = _heights_and_residual(equation, samples)
            errors = _design_errors(equation, samples.assign(relative_height=heights))
            for name, error in zip(equation.parameters, errors):
                published = equation.published_estimates[name][1]
                rows.append({"equation": equation.name, "design": design, "runs": len(samples), "parameter": name,
                             "residuals": equation.residuals, "published_score": equation.published_scores[equation.score],
                             "relative_standard_error": error * residual, "published_relative_standard_error": published,
                             "needed_residual": published / error})
    return pd.DataFrame(rows)


def _heights_and_residual(equation, samples):
    """Heights by the published equation, and the root mean square of the residuals that the printed score gives."""
    heights = equations.relative_height(samples.effective_friction, samples.froude_number, equation.published)
    return heights, equation.published_scores[equation.score] * (1.0 if equation.logarithmic else float(np.mean(heights)))


def _design_errors(equation, samples):
    """Relative standard errors, in the order of the parameters, for residuals of root mean square 1."""
    c, n, p = equation.published, len(samples), len(equation.parameters)
    x = [c.k, c.kappa] + ([c.saturation_froude] if equation.saturates else [])
    jacobian = Problem(equation, samples, split=c.saturation_froude if equation.saturates else None).jacobian(x)
    errors = np.sqrt(n / (n - p) * np.diag(inverse_normal_matrix(jacobian))) / np.array(x)
    return errors[[0, 2, 1]] if equation.saturates else errors


def published_variances():
    """Variance of the heights that follows from two printed scores, R^2 and the size of the residuals, beside that of each design: equation,
    design, runs, residuals, published_variance, design_variance (of the published equation, and of residuals of the printed size)."""
    rows = []
    for design, samples in paper_designs().items():
        for equation in EQUATIONS:
            heights, residual = _heights_and_residual(equation, samples)
            rows.append({"equation": equation.name, "design": design, "runs": len(samples), "residuals": equation.residuals,
                         "published_variance": residual**2 / (1.0 - equation.published_scores["r2_log" if equation.logarithmic else "r2"]),
                         "design_variance": np.var(np.log(heights) if equation.logarithmic else heights) + residual**2})
    return pd.DataFrame(rows)


def possible_runs(most, least=1):
    """Numbers of runs of which whole numbers of runs are the printed fractions within 10 and 25 %, rounded to a tenth of a percent."""
    fractions = [equation.published_scores[name] for equation in EQUATIONS for name in ("fraction_10", "fraction_25")]
    return [n for n in range(least, most + 1) if all(any(round(k / n, 3) == fraction for k in range(n + 1)) for fraction in fractions)]
