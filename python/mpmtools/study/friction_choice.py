"""What the friction of the mast does to the coefficients, and what its calibration is worth.

The paper does not print the friction of the mast. Two campaigns of the same flows and snows are compared, one with a coefficient for
all snow and one with half of tan phi', and rules that lie between them. A rule is calibrated on one half of the runs, by its run-ups'
RMSLE from the published equation, and judged on the other half.
"""

import numpy as np
import pandas as pd

from mpmtools import equations
from mpmtools.errors import InputError
from mpmtools.scores import levels
from mpmtools.study.fits import height_samples, score_against_published
from mpmtools.study.regression import EQUATIONS, RUNUP, fit_heights
from mpmtools.study.runs import read_runs_or_refuse
from mpmtools.tables import numbers, read_table

CONSTANT, RATIO = 0.15, 0.5  # the two campaigns
CEILINGS = np.round(np.arange(0.15, 0.501, 0.01), 2)  # of the rule min(ceiling, tan(phi')/2); above 0.47 it is the half for all but M' 2.3
POINT = ["froude_number", "critical_state_slope", "cohesion_beta", "hardening_xi"]
STIFFEST = 2.2  # M': one row above it is in both campaigns


def half_friction(friction):
    """tan(phi') / 2."""
    return RATIO * np.tan(equations.friction_angle(friction))


def paired(constant_runs, ratio_runs):
    """The points that both campaigns have: inputs, friction of the half, and each height with both frictions."""
    tables = []
    for runs in (constant_runs, ratio_runs):
        keys = pd.DataFrame({name: levels(runs[name]).round(9) for name in POINT})
        tables.append(keys.join(runs[["effective_friction", *(e.name for e in EQUATIONS)]]))
    both = tables[0].merge(tables[1].drop(columns="effective_friction"), on=POINT, suffixes=("_constant", "_half"))
    return both.assign(half=half_friction(both.effective_friction))


def with_rule(points, ceiling):
    """Heights with the friction min(ceiling, tan(phi')/2), ceiling >= 0.15: where it lies between the two that were computed, the
    logarithm of the height is interpolated linearly. A ceiling of 0.15 needs no interpolation, an infinite one neither."""
    if ceiling < CONSTANT:
        raise InputError(f"a ceiling of {ceiling:g} lies below {CONSTANT:g}, the lowest friction that was computed for stiff snow")
    share = np.clip((np.minimum(ceiling, points.half) - CONSTANT) / (points.half - CONSTANT), 0.0, 1.0).where(points.half > CONSTANT, 1.0)
    heights = {e.name: points[f"{e.name}_constant"] ** (1.0 - share) * points[f"{e.name}_half"] ** share for e in EQUATIONS}
    return points[[*POINT, "effective_friction"]].assign(**heights, at_reference_width=True)


def with_constant(points):
    heights = {e.name: points[f"{e.name}_constant"] for e in EQUATIONS}
    return points[[*POINT, "effective_friction"]].assign(**heights, at_reference_width=True)


def rules_of(points):
    """{name: the points with its heights}"""
    return {"0.15": with_constant(points), "half of tan phi'": with_rule(points, np.inf),
            "the smaller of 0.15 and the half": with_rule(points, CONSTANT)}


def friction_rules(points):
    """Coefficients and scores against the published equations on the same points: rule, points (all, or without M' > 2.2), runs."""
    rows = []
    for name, runs in rules_of(points).items():
        for which, chosen in (("all", runs), ("without the stiffest", runs[runs.effective_friction < STIFFEST])):
            row = {"rule": name, "points": which, "runs": len(chosen)}
            for equation in EQUATIONS:
                samples = height_samples(equation, chosen)
                fit = fit_heights(equation, samples, with_profile=False)
                row.update({key: estimate.value for key, estimate in fit.estimates.items()})
                scores = score_against_published(equation, samples)
                row.update({f"{equation.name}_{score}": scores[score] for score in (equation.score, "fraction_25")})
            rows.append(row)
    return pd.DataFrame(rows)


def splits(points):
    """{name: first half of the points}: every other material by rising M', and Froude numbers 1 and 3 against 2 and 5."""
    materials = np.sort(levels(points.effective_friction).unique())
    return {"every other M'": levels(points.effective_friction).isin(materials[::2]),
            "Fr 1 and 3, Fr 2 and 5": np.isclose(points.froude_number, 1.0) | np.isclose(points.froude_number, 3.0)}


def friction_calibration(points):
    """The rule min(ceiling, tan(phi')/2) with its ceiling calibrated on one half and judged on the other: split, calibrated_on (half),
    ceiling, runs and RMSLE of the run-up on both halves. `chosen` is the best of the three rules that need no interpolation; the last
    columns are what each of them scores on the half that judges."""
    rows = []
    for name, first in splits(points).items():
        for half, chosen in (("first", first), ("second", ~first)):
            errors = [_rmsle(with_rule(points[chosen], ceiling)) for ceiling in CEILINGS]
            ceiling = CEILINGS[int(np.argmin(errors))]
            judged = points[~chosen]
            plain = {rule: (_rmsle(on_chosen), _rmsle(rules_of(judged)[rule])) for rule, on_chosen in rules_of(points[chosen]).items()}
            best = min(plain, key=lambda rule: plain[rule][0])
            rows.append({"split": name, "calibrated_on": half, "ceiling": ceiling, "runs_calibrating": int(chosen.sum()),
                         "runs_judging": len(judged), "rmsle_calibrating": min(errors), "rmsle_judging": _rmsle(with_rule(judged, ceiling)),
                         "fraction_25_judging": score_against_published(RUNUP, height_samples(RUNUP, with_rule(judged, ceiling))).fraction_25,
                         "chosen": best, "chosen_rmsle_calibrating": plain[best][0], "chosen_rmsle_judging": plain[best][1],
                         **{f"rmsle_judging_{short}": plain[rule][1] for short, rule in zip(("constant", "half", "smaller"), plain)}})
    return pd.DataFrame(rows)


def _rmsle(runs):
    return float(score_against_published(RUNUP, height_samples(RUNUP, runs)).rmsle)


def interpolation_errors(points, sensitivity_file):
    """Interpolated run-up over the computed one, at the points of the sensitivities with a friction between the two campaigns': inputs,
    friction, interpolated, computed (both over H), ratio."""
    table = read_table(sensitivity_file)
    names = [*POINT, "obstacle_friction", "flow_height_m", "runup_mean_m", "cell_size_m"]
    runs = pd.DataFrame({name: numbers(table, name) for name in names})
    plain = table["name"].str.contains("_mu0")  # friction alone was changed
    rows = []
    for run in runs[plain & np.isfinite(runs.runup_mean_m)].itertuples():
        same = points[np.logical_and.reduce([np.isclose(points[name], getattr(run, name)) for name in POINT])]
        for point in same[(same.half > run.obstacle_friction) & (run.obstacle_friction > CONSTANT + 1e-9)].index:
            computed = run.runup_mean_m / run.flow_height_m
            interpolated = float(with_rule(points.loc[[point]], run.obstacle_friction).runup.iloc[0])
            rows.append({**{name: getattr(run, name) for name in POINT}, "obstacle_friction": run.obstacle_friction,
                         "interpolated": interpolated, "computed": computed, "ratio": interpolated / computed})
    return pd.DataFrame(rows, columns=[*POINT, "obstacle_friction", "interpolated", "computed", "ratio"])


def friction_tables(constant_file, ratio_runs, sensitivity_file=None):
    """{table name: table} of all of the above."""
    points = paired(read_runs_or_refuse([constant_file]).runs, ratio_runs)
    if points.empty:
        raise InputError(f"{constant_file}: no run has the inputs of a run of the campaign; the two must share flows and snows")
    tables = {"friction_rules": friction_rules(points), "friction_calibration": friction_calibration(points)}
    if sensitivity_file:
        tables["friction_interpolation"] = interpolation_errors(points, sensitivity_file)
    return tables
