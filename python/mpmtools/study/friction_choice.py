"""What the friction of the mast does to the coefficients, and what its calibration is worth.

The paper does not print the friction of the mast. The same flows and snows are computed with several coefficients, and rules are
compared that give the mast a coefficient for each kind of snow. A rule with a free number is calibrated on one half of the points, by
its run-ups' RMSLE from the published equation, and judged on the other half.

Two kinds of tables can be given: a campaign with one coefficient for all snow, to be compared with the campaign with half of tan(phi'); and
tables of runs that vary the coefficient at every point (`scan_tables`). `computed_heights` brings both into one form.
"""

import re
from collections import namedtuple
from functools import partial

import numpy as np
import pandas as pd

from mpmtools import equations
from mpmtools.errors import InputError
from mpmtools.scores import levels
from mpmtools.study.fits import height_samples, score_against_published
from mpmtools.study.regression import EQUATIONS, RUNUP, fit_heights
from mpmtools.study.runs import POINT, point_keys, read_runs_or_refuse
from mpmtools.tables import number_text, numbers, read_table

CONSTANT, RATIO = 0.15, 0.5  # the two campaigns
MOST_POINTS = 0.9  # of all, as a run without a steady mean leaves a gap
STIFFEST = 2.2  # M': one row above it is in both campaigns
HALF, SMALLER = "half of tan phi'", "the smaller of {} and the half"
EVERY_FRICTION, ALL = "every friction", "all"  # points of a scan

# A rule with a free number c: `coefficient(c, half)` of the mast, where half is tan(phi')/2 of the snow; `candidates` of c.
Family = namedtuple("Family", ["name", "coefficient", "candidates"])
CEILINGS = np.round(np.arange(0.0, 0.501, 0.01), 2)  # above 0.47 the smaller of both is the half for all but M' 2.3
SMALLER_OF_BOTH = Family("the smaller of c and the half", np.minimum, CEILINGS)
ONE_FOR_ALL = Family("c for all snow", lambda c, half: c, CEILINGS)
SHARE = Family("c times tan phi'", lambda c, half: c / RATIO * half, CEILINGS)
FAMILIES = (SMALLER_OF_BOTH, ONE_FOR_ALL, SHARE)


def half_friction(friction):
    """tan(phi') / 2."""
    return RATIO * np.tan(equations.friction_angle(friction))


def has_half(computed):
    """For each row, whether its mast has half of tan(phi')."""
    return np.isclose(computed.obstacle_friction, half_friction(computed.effective_friction))


def coefficients_of(computed):
    """The coefficient of the mast of each row; those that are meant to be equal have equal digits."""
    return levels(computed.obstacle_friction).round(9)


def computed_heights(*campaigns):
    """Points with two or more frictions of the mast: a row for each friction with its inputs, obstacle_friction, and both heights over H. Of
    several runs with one friction the first counts."""
    columns = ["effective_friction", "obstacle_friction", *(e.name for e in EQUATIONS)]
    rows = pd.concat([point_keys(runs).join(runs[columns]) for runs in campaigns], ignore_index=True)
    rows = rows[~rows.assign(friction=coefficients_of(rows)).duplicated([*POINT, "friction"])]
    return rows[rows.groupby(POINT).obstacle_friction.transform("nunique") > 1].reset_index(drop=True)


def with_friction(computed, coefficient):
    """A row for each point of `computed` with its heights for another coefficient of the mast.

    Between two coefficients that were computed the logarithm of the height is interpolated linearly; beyond them it is NaN.
    @param coefficient  of the mast, a function of tan(phi')/2 of the snow"""
    return with_frictions(computed, {"": coefficient})[""]


def with_frictions(computed, rules):
    """{name: with_friction() of this rule}. @param rules  {name: coefficient of the mast as a function of tan(phi')/2}"""
    points, heights = [], []
    for point, of in computed.groupby(POINT, sort=False):
        of = of.sort_values("obstacle_friction")
        half, known = half_friction(of.effective_friction.iloc[0]), of.obstacle_friction.to_numpy()
        friction = np.array([coefficient(half) for coefficient in rules.values()], float)
        at_end = np.isclose(friction[:, None], known[[0, -1]], rtol=1e-6, atol=1e-9).any(axis=1)  # the same coefficient in other digits
        friction = np.where(at_end, np.clip(friction, known[0], known[-1]), friction)
        points.append({**dict(zip(POINT, point)), "effective_friction": of.effective_friction.iloc[0]})
        heights.append([np.exp(np.interp(friction, known, np.log(of[e.name]), np.nan, np.nan)) for e in EQUATIONS])
    points, heights = pd.DataFrame(points), np.array(heights)  # heights: point, equation, rule
    return {name: points.assign(**{e.name: heights[:, i, k] for i, e in enumerate(EQUATIONS)}, at_reference_width=True)
            for k, name in enumerate(rules)}


def rules_of(*constants):
    """{name: coefficient of the mast as a function of the half}: one for all snow, the half, and the smaller of both."""
    return {**{number_text(c): partial(ONE_FOR_ALL.coefficient, c) for c in constants}, HALF: lambda half: half,
            **{SMALLER.format(number_text(c)): partial(SMALLER_OF_BOTH.coefficient, c) for c in constants if c > 0.0}}


def best_rules(computed, rules, families):
    """{name: coefficient of the mast as a function of the half}: of each family the one whose run-ups have the least RMSLE from the published
    equation at the points that all `rules` can be computed at."""
    points = on_common_points(computed, rules)[HALF]
    best = {}
    for family in families:
        errors = {c: _rmsle(of) for c, of in _rows_of(_tried(computed, points, family), points).items()}
        c = min(errors, key=errors.get)
        best["best: " + re.sub(r"\bc\b", number_text(c), family.name)] = partial(family.coefficient, c)
    return best


def _tried(computed, points, family):
    """{c: heights of these points} for every candidate of a family."""
    kept = computed.merge(points[POINT], on=POINT)
    return with_frictions(kept, {c: partial(family.coefficient, c) for c in family.candidates})


def on_common_points(computed, rules):
    """{name: points with the rule's heights}, for the points that every rule can be computed at."""
    heights = with_frictions(computed, rules)
    common = np.logical_and.reduce([np.isfinite(of.runup) for of in heights.values()])
    if not common.any():
        raise InputError(f"no flow and snow was computed with every friction of these rules: {', '.join(rules)}")
    return {name: of[common].reset_index(drop=True) for name, of in heights.items()}


def with_and_without_the_stiffest(table):
    """[(which, rows)]: all rows, and, where there is snow that stiff, those without M' > 2.2."""
    kept = table[table.effective_friction < STIFFEST]
    return [(ALL, table)] + ([("without the stiffest", kept)] if len(kept) < len(table) else [])


def friction_rules(computed, rules):
    """Coefficients and scores against the published equations on the same points: rule, points (all, or without M' > 2.2), runs."""
    rows = []
    for name, runs in on_common_points(computed, rules).items():
        for which, chosen in with_and_without_the_stiffest(runs):
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
    """{name: first half of the points}: every other material by rising M', every other Froude number, and, where several were computed, every
    other xi."""
    def every_other(name):
        found = np.sort(levels(points[name]).unique())
        return levels(points[name]).isin(found[::2]), [" and ".join(f"{number:g}" for number in part) for part in (found[::2], found[1::2])]

    (materials, _), (froude, numbers), (by_xi, xi) = (every_other(name) for name in ("effective_friction", "froude_number", "hardening_xi"))
    halves = {"every other M'": materials, f"Fr {numbers[0]}, Fr {numbers[1]}": froude}
    if not by_xi.all():
        halves[f"xi {xi[0]}, xi {xi[1]}"] = by_xi
    return halves


def friction_calibration(computed, constant=CONSTANT, families=(SMALLER_OF_BOTH,)):
    """Rules with a free number c, calibrated on one half of the points and judged on the other: rule, points (all, or without M' > 2.2), split,
    calibrated_on (half), c, at_edge (1: the lowest or highest c that was tried), runs and RMSLE of the run-up on both halves, `constant`. Only c
    whose coefficients lie between computed ones at every point of both halves are tried.

    `chosen` is the best on the first half of three rules without a free number: `constant`, the half, and the smaller of both; the last
    columns are what each of them scores on the half that judges."""
    plain = on_common_points(computed, rules_of(constant))
    points = plain[HALF]
    rows = []
    for family in families:
        tried = _tried(computed, points, family)
        for which, chosen in with_and_without_the_stiffest(points):
            rows += [{"rule": family.name, **row, "constant": constant, "points": which}
                     for row in _judged_on_halves(_rows_of(tried, chosen), _rows_of(plain, chosen), splits(chosen))]
    return pd.DataFrame(rows)


def _rows_of(heights, points):
    """{name or c: its rows of these points}, where it has a height at each of them."""
    chosen = {key: of.loc[points.index] for key, of in heights.items()}
    return {key: of for key, of in chosen.items() if np.isfinite(of.runup).all()}


def _judged_on_halves(tried, plain, halves):
    """Rows of friction_calibration(). @param tried, plain  {c: heights}, {rule: heights} at the same points"""
    for name, first in halves.items():
        for half, chosen in (("first", first), ("second", ~first)):
            errors = {c: _rmsle(of[chosen]) for c, of in tried.items()}
            best = min(errors, key=errors.get)
            judged = tried[best][~chosen]
            scores = {rule: (_rmsle(of[chosen]), _rmsle(of[~chosen])) for rule, of in plain.items()}
            first_choice = min(scores, key=lambda rule: scores[rule][0])
            yield {"split": name, "calibrated_on": half, "c": best, "at_edge": int(best in (min(errors), max(errors))),
                   "runs_calibrating": int(chosen.sum()), "runs_judging": len(judged), "rmsle_calibrating": errors[best], "rmsle_judging": _rmsle(judged),
                   "fraction_25_judging": score_against_published(RUNUP, height_samples(RUNUP, judged)).fraction_25,
                   "chosen": first_choice, "chosen_rmsle_calibrating": scores[first_choice][0], "chosen_rmsle_judging": scores[first_choice][1],
                   **{f"rmsle_judging_{short}": scores[rule][1] for short, rule in zip(("constant", "half", "smaller"), plain)}}


def _rmsle(runs):
    return float(score_against_published(RUNUP, height_samples(RUNUP, runs)).rmsle)


def interpolation_errors(computed, sensitivity_file):
    """Interpolated run-up over the computed one, at the points of the sensitivities with a friction between two of `computed`: inputs,
    friction, interpolated, computed (both over H), ratio."""
    table = read_table(sensitivity_file)
    names = [*POINT, "obstacle_friction", "flow_height_m", "runup_mean_m", "cell_size_m"]
    runs = pd.DataFrame({name: numbers(table, name) for name in names})
    plain = table["name"].str.contains("_mu0")  # friction alone was changed
    rows = []
    for run in runs[plain & np.isfinite(runs.runup_mean_m)].itertuples():
        same = computed[np.logical_and.reduce([np.isclose(computed[name], getattr(run, name)) for name in POINT])]
        if same.empty or np.isclose(same.obstacle_friction, run.obstacle_friction).any():
            continue  # nothing to interpolate
        interpolated = float(with_friction(same, lambda half, friction=run.obstacle_friction: friction).runup.iloc[0])
        if np.isfinite(interpolated):
            there = run.runup_mean_m / run.flow_height_m
            rows.append({**{name: getattr(run, name) for name in POINT}, "obstacle_friction": run.obstacle_friction,
                         "interpolated": interpolated, "computed": there, "ratio": interpolated / there})
    return pd.DataFrame(rows, columns=[*POINT, "obstacle_friction", "interpolated", "computed", "ratio"])


def friction_tables(constant_file, ratio_runs, sensitivity_files=()):
    """{table name: table} of a campaign with CONSTANT for all snow against `ratio_runs`, those with half of tan(phi')."""
    computed = computed_heights(read_runs_or_refuse([constant_file]).runs, ratio_runs)
    if computed.empty:
        raise InputError(f"{constant_file}: no run has the inputs of a run of the campaign; the two must share flows and snows")
    tables = {"friction_rules": friction_rules(computed, rules_of(CONSTANT)), "friction_calibration": friction_calibration(computed)}
    if sensitivity_files:
        tables["friction_interpolation"] = pd.concat([interpolation_errors(computed, path) for path in sensitivity_files], ignore_index=True)
    return tables


def scan_tables(scan_files):
    """{table name: table} of runs that vary the friction of the mast at every point: heights, rules (those whose friction was computed, and the
    best of each family), calibration.

    If only some points were computed with every friction, rules and calibrations are given for these first and then for all, where fewer
    coefficients can be compared; the column `points` tells them apart."""
    names, computed = ", ".join(map(str, scan_files)), computed_heights(read_runs_or_refuse(scan_files).runs)
    if computed.empty:
        raise InputError(f"{names}: no flow and snow was computed with two frictions of the mast")
    at_half = computed[has_half(computed)].drop_duplicates(POINT)[[*POINT, *(e.name for e in EQUATIONS)]]
    heights = computed.assign(half=half_friction(computed.effective_friction)).merge(at_half, on=POINT, how="left", suffixes=("", "_at_half"))
    for name in (e.name for e in EQUATIONS):
        heights[f"{name}_over_half"] = heights[name] / heights.pop(f"{name}_at_half")  # NaN where the half was not computed
    rules, calibrations = [], []
    for points, of in _parts_of(computed).items():
        constants = computed_nearly_everywhere(of)
        if not (constants > 0.0).any():
            raise InputError(f"{names}: no friction above 0 was computed at nine in ten of the points, to compare rules with")
        constant = CONSTANT if np.isclose(constants, CONSTANT).any() else min(constants[constants > 0.0])
        fixed = rules_of(*constants)
        rules.append(friction_rules(of, fixed | best_rules(of, fixed, FAMILIES)).replace({"points": {ALL: points}}))
        calibrations.append(friction_calibration(of, constant, FAMILIES).replace({"points": {ALL: points}}))
    return {"friction_scan": heights.sort_values([*POINT, "obstacle_friction"], ignore_index=True),
            "friction_scan_rules": pd.concat(rules, ignore_index=True),
            "friction_scan_calibration": pd.concat(calibrations, ignore_index=True)}


def _parts_of(computed):
    """{points: their rows}: all, and first, unless nearly all are such, the points with every coefficient of the table but at most one (a run
    without a steady mean leaves a gap)."""
    coefficient = coefficients_of(computed)
    constants = coefficient[~has_half(computed)].unique()
    found = coefficient.isin(constants).groupby([computed[name] for name in POINT]).transform("sum")
    full = computed[found >= len(constants) - 1]
    share = full.groupby(POINT).ngroups / computed.groupby(POINT).ngroups
    return ({EVERY_FRICTION: full} if 0.0 < share < MOST_POINTS else {}) | {ALL: computed}


def computed_nearly_everywhere(computed):
    """The coefficients, rising, that were computed at MOST_POINTS of the points or more."""
    share = computed.groupby(coefficients_of(computed)).size() / computed.groupby(POINT).ngroups
    return share.index[share >= MOST_POINTS]
