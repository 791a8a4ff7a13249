"""What the friction of the mast does to the coefficients, and what its calibration is worth.

The paper does not print the friction of the mast. The same flows and snows are computed with several coefficients, and rules are
compared that give the mast a coefficient for each kind of snow. A rule with a free number is calibrated on one half of the points, by
its run-ups' RMSLE from the published equation, and judged on the other half.

Two tables can be given: a campaign with one coefficient for all snow, to be compared with the campaign with half of tan(phi'); and a
campaign that varies the coefficient at every point (`scan_tables`). `computed_heights` brings both into one form.
"""

from collections import namedtuple

import numpy as np
import pandas as pd

from mpmtools import equations
from mpmtools.errors import InputError
from mpmtools.scores import levels
from mpmtools.study.fits import height_samples, score_against_published
from mpmtools.study.regression import EQUATIONS, RUNUP, fit_heights
from mpmtools.study.runs import POINT, read_runs_or_refuse
from mpmtools.tables import number_text, numbers, read_table

CONSTANT, RATIO = 0.15, 0.5  # the two campaigns
STIFFEST = 2.2  # M': one row above it is in both campaigns
HALF, SMALLER = "half of tan phi'", "the smaller of {} and the half"

# A rule with a free number c: `coefficient(c, half)` of the mast, where half is tan(phi')/2 of the snow; `candidates` of c.
Family = namedtuple("Family", ["name", "coefficient", "candidates"])
CEILINGS = np.round(np.arange(0.0, 0.501, 0.01), 2)  # above 0.47 the smaller of both is the half for all but M' 2.3
SMALLER_OF_BOTH = Family("the smaller of c and the half", np.minimum, CEILINGS)
ONE_FOR_ALL = Family("c for all snow", lambda c, half: c + 0.0 * half, CEILINGS)


def half_friction(friction):
    """tan(phi') / 2."""
    return RATIO * np.tan(equations.friction_angle(friction))


def computed_heights(*campaigns):
    """Points with two or more frictions of the mast: a row for each run with its inputs, obstacle_friction, and both heights over H."""
    parts = []
    for runs in campaigns:
        keys = pd.DataFrame({name: levels(runs[name]).round(9) for name in POINT})
        parts.append(keys.join(runs[["effective_friction", "obstacle_friction", *(e.name for e in EQUATIONS)]]))
    rows = pd.concat(parts, ignore_index=True)
    return rows[rows.groupby(POINT).obstacle_friction.transform("nunique") > 1].reset_index(drop=True)


def with_friction(computed, coefficient):
    """A row for each point of `computed` with its heights for another coefficient of the mast.

    Between two coefficients that were computed the logarithm of the height is interpolated linearly; beyond them it is NaN.
    @param coefficient  of the mast, a function of tan(phi')/2 of the snow"""
    rows = []
    for point, of in computed.groupby(POINT, sort=False):
        of = of.sort_values("obstacle_friction")
        friction, known = coefficient(half_friction(of.effective_friction.iloc[0])), of.obstacle_friction.to_numpy()
        if np.isclose(friction, known[[0, -1]], rtol=1e-6, atol=1e-9).any():  # the same coefficient in other digits
            friction = np.clip(friction, known[0], known[-1])
        heights = {e.name: np.exp(np.interp(friction, known, np.log(of[e.name]), np.nan, np.nan)) for e in EQUATIONS}
        rows.append({**dict(zip(POINT, point)), "effective_friction": of.effective_friction.iloc[0], **heights})
    return pd.DataFrame(rows).assign(at_reference_width=True)


def rules_of(*constants):
    """{name: coefficient of the mast as a function of the half}: one for all snow, the half, and the smaller of both."""
    def constant(c):
        return lambda half: c

    def smaller(c):
        return lambda half: min(c, half)

    return {**{number_text(c): constant(c) for c in constants}, HALF: lambda half: half,
            **{SMALLER.format(number_text(c)): smaller(c) for c in constants if c > 0.0}}


def on_common_points(computed, rules):
    """{name: points with the rule's heights}, for the points that every rule can be computed at."""
    heights = {name: with_friction(computed, rule) for name, rule in rules.items()}
    common = np.logical_and.reduce([np.isfinite(of.runup) for of in heights.values()])
    if not common.any():
        raise InputError(f"no flow and snow was computed with every friction of these rules: {', '.join(rules)}")
    return {name: of[common].reset_index(drop=True) for name, of in heights.items()}


def with_and_without_the_stiffest(table):
    """[(which, rows)]: all rows, and, where there is snow that stiff, those without M' > 2.2."""
    kept = table[table.effective_friction < STIFFEST]
    return [("all", table)] + ([("without the stiffest", kept)] if len(kept) < len(table) else [])


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
    """{name: first half of the points}: every other material by rising M', and every other Froude number."""
    materials, froude = (np.sort(levels(points[name]).unique()) for name in ("effective_friction", "froude_number"))
    halves = [" and ".join(f"{number:g}" for number in part) for part in (froude[::2], froude[1::2])]
    return {"every other M'": levels(points.effective_friction).isin(materials[::2]),
            f"Fr {halves[0]}, Fr {halves[1]}": levels(points.froude_number).isin(froude[::2])}


def friction_calibration(computed, constant=CONSTANT, families=(SMALLER_OF_BOTH,)):
    """Rules with a free number c, calibrated on one half of the points and judged on the other: rule, points (all, or without M' > 2.2), split,
    calibrated_on (half), c, runs and RMSLE of the run-up on both halves. Only c whose coefficients lie between computed ones at every point are
    tried.

    `chosen` is the best on the first half of three rules without a free number: `constant`, the half, and the smaller of both; the last
    columns are what each of them scores on the half that judges."""
    return pd.concat([_calibrated(of, constant, families).assign(points=which) for which, of in with_and_without_the_stiffest(computed)],
                     ignore_index=True)


def _calibrated(computed, constant, families):
    plain = on_common_points(computed, rules_of(constant))
    points = next(iter(plain.values()))
    kept = computed.merge(points[POINT], on=POINT)
    rows = []
    for family in families:
        tried = {c: with_friction(kept, lambda half, c=c, family=family: family.coefficient(c, half)) for c in family.candidates}
        tried = {c: of for c, of in tried.items() if np.isfinite(of.runup).all()}
        for name, first in splits(points).items():
            for half, chosen in (("first", first.to_numpy()), ("second", ~first.to_numpy())):
                errors = {c: _rmsle(of[chosen]) for c, of in tried.items()}
                best = min(errors, key=errors.get)
                judged = tried[best][~chosen]
                scores = {rule: (_rmsle(of[chosen]), _rmsle(of[~chosen])) for rule, of in plain.items()}
                first_choice = min(scores, key=lambda rule: scores[rule][0])
                rows.append({"rule": family.name, "split": name, "calibrated_on": half, "c": best, "runs_calibrating": int(chosen.sum()),
                             "runs_judging": len(judged), "rmsle_calibrating": errors[best], "rmsle_judging": _rmsle(judged),
                             "fraction_25_judging": score_against_published(RUNUP, height_samples(RUNUP, judged)).fraction_25,
                             "chosen": first_choice, "chosen_rmsle_calibrating": scores[first_choice][0],
                             "chosen_rmsle_judging": scores[first_choice][1],
                             **{f"rmsle_judging_{short}": scores[rule][1] for short, rule in zip(("constant", "half", "smaller"), plain)}})
    return pd.DataFrame(rows)


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


def friction_tables(constant_file, ratio_runs, sensitivity_file=None):
    """{table name: table} of a campaign with CONSTANT for all snow against `ratio_runs`, those with half of tan(phi')."""
    computed = computed_heights(read_runs_or_refuse([constant_file]).runs, ratio_runs)
    if computed.empty:
        raise InputError(f"{constant_file}: no run has the inputs of a run of the campaign; the two must share flows and snows")
    tables = {"friction_rules": friction_rules(computed, rules_of(CONSTANT)), "friction_calibration": friction_calibration(computed)}
    if sensitivity_file:
        tables["friction_interpolation"] = interpolation_errors(computed, sensitivity_file)
    return tables


def scan_tables(scan_file):
    """{table name: table} of a campaign that varies the friction of the mast at every point: heights, rules, calibration."""
    computed = computed_heights(read_runs_or_refuse([scan_file]).runs)
    if computed.empty:
        raise InputError(f"{scan_file}: no flow and snow was computed with two frictions of the mast")
    constants = [c for c in (0.0, 0.05, 0.1, 0.15, 0.2, 0.3) if np.isclose(computed.obstacle_friction, c).any()]
    half = half_friction(computed.effective_friction)
    relative = computed.groupby(POINT, group_keys=False).apply(lambda of: _over_the_half(of, half[of.index]))
    heights = computed.assign(half=half, **relative[[f"{e.name}_over_half" for e in EQUATIONS]]).sort_values([*POINT, "obstacle_friction"])
    return {"friction_scan": heights, "friction_scan_rules": friction_rules(computed, rules_of(*constants)),
            "friction_scan_calibration": friction_calibration(computed, families=(SMALLER_OF_BOTH, ONE_FOR_ALL))}


def _over_the_half(of, half):
    """Heights of one point over those with the half; NaN where the half was not computed."""
    there = of[np.isclose(of.obstacle_friction, half)]
    return of.assign(**{f"{e.name}_over_half": of[e.name] / there[e.name].iloc[0] if len(there) else np.nan for e in EQUATIONS})
