"""How far a rule for the friction of the mast is from the paper: from its eight printed scores, and from what its Appendix A3 says about the
errors of its equations over Fr, xi and M'. choices.md states the criteria and when they were fixed.

The paper's scores and sentences are about its own data and its own fit. So the equations are fitted to the runs of a rule (narrow set, without
the fluid), and the errors of this fit are judged. The coefficients themselves are not: to choose a friction by them would be circular.
"""

from dataclasses import dataclass
from typing import Callable

import numpy as np
import pandas as pd

from analysis.fits import point_keys
from mpmtools import equations
from mpmtools.errors import ConfigError
from mpmtools.scores import compute_scores, levels, same_input
from mpmtools.fit.fits import NARROW, height_samples
from mpmtools.fit.regression import PRESSURE_HEIGHT, RUNUP, fit_heights
from mpmtools.fit.runs import POINT

PAPER_RUNS = 189  # of the narrow set without the fluid
STANDARD_ERRORS = 3.0  # that make one unit of a score: more than one, because the runs of one kind of snow err together
DOZEN = 12  # kinds of snow with friction at one Froude number
LOOSE, SLOW = 0.8, 1.0  # M' and Fr up to which a row with half of tan(phi') stands for any rule: heights change by less than 1.5 %
FLUID_WITHIN = 0.10  # 'closely follows'


def tan_friction(friction):
    return np.tan(equations.friction_angle(friction))


@dataclass(frozen=True)
class Rule:
    """coefficient of the mast as a function of M'."""

    name: str
    coefficient: Callable


CONSTANTS = (0.2, 0.25, 0.3)  # those that are judged


def rules(*constants):
    """One coefficient for all snow, and the smaller of it and the snow's own tan(phi'), for each constant; then half of tan(phi')."""
    found = []
    for c in constants:
        found += [Rule(f"{c:g}", lambda friction, c=c: np.full_like(friction, c)),
                  Rule(f"the smaller of {c:g} and tan phi'", lambda friction, c=c: np.minimum(c, tan_friction(friction)))]
    return [*found, Rule("half of tan phi'", lambda friction: 0.5 * tan_friction(friction))]


def rows_of(rule, runs):
    """The run of each set whose mast has the friction of the rule; of slow loose snow that with the half where there is no other."""
    wanted = rule.coefficient(runs.effective_friction.to_numpy())
    own = np.isclose(runs.obstacle_friction, wanted, rtol=0.0, atol=1e-4)
    half = np.isclose(runs.obstacle_friction, 0.5 * tan_friction(runs.effective_friction), rtol=0.0, atol=1e-4)
    reused = half & (runs.froude_number <= SLOW + 1e-6) & (runs.effective_friction <= LOOSE + 0.005)
    chosen = pd.concat([runs[own], runs[reused & ~own]])
    chosen = chosen[NARROW.holds(chosen) & chosen.at_reference_width]
    return chosen.assign(**point_keys(chosen)).drop_duplicates(POINT).reset_index(drop=True)


# ---- The paper's numbers and sentences --------------------------------------------------------------------------------------------------


def _score_unit(equation, name):
    """STANDARD_ERRORS of this score over PAPER_RUNS independent runs of the printed scatter; of a fraction of 100 % the rule of three."""
    printed = equation.published_scores
    if name.startswith("fraction"):
        p = printed[name]
        return max(STANDARD_ERRORS * np.sqrt(p * (1.0 - p) / PAPER_RUNS), 3.0 / PAPER_RUNS)
    return STANDARD_ERRORS * printed[equation.score] / np.sqrt(PAPER_RUNS if name == "bias" else 2.0 * PAPER_RUNS)


# The ten of Tables A1 and A2 without R^2, which follows from the scatter and the variance of the heights, and so from the list of sets.
SCORES = [(equation, name) for equation in (RUNUP, PRESSURE_HEIGHT) for name in (equation.score, "bias", "fraction_10", "fraction_25")]


@dataclass(frozen=True)
class Sentence:
    """One statement of the paper: errors (RMSLE or NRMSE) of groups of runs, and the band that it gives them."""

    part: str  # Fr, xi or M'
    where: str
    text: str
    equation: object
    groups: Callable  # errors of the groups, from Errors
    band: tuple
    spared: int = 0  # groups that may be outside: 'mostly'


class Errors:
    """RMSLE or NRMSE of one equation's own fit, by group."""

    def __init__(self, equation, samples, coefficients):
        self.equation, self.samples = equation, samples
        self.predicted = equations.relative_height(samples.effective_friction, samples.froude_number, coefficients)

    def of(self, chosen):
        return compute_scores(self.samples.relative_height[chosen], self.predicted[chosen])[self.equation.score]

    def over(self, name, chosen):
        """One error for each value of an input among the chosen samples."""
        of = levels(self.samples[name])
        return [self.of(chosen & (of == value)) for value in sorted(of[chosen].unique())]

    def by_froude(self, xi, low, high):
        s = self.samples
        return self.over("froude_number", same_input(xi, s.hardening_xi) & (s.froude_number > low) & (s.froude_number < high))

    def by_friction(self, low, high):
        return self.over("effective_friction", (self.samples.effective_friction > low) & (self.samples.effective_friction < high))

    def excess(self, chosen):
        """Error of the chosen samples less that of the others: [one number]."""
        return [self.of(chosen) - self.of(~chosen)] if chosen.any() and not chosen.all() else []

    def of_xi(self):
        both = same_input(0.5, self.samples.hardening_xi) | same_input(5.0, self.samples.hardening_xi)
        only = Errors.__new__(Errors)
        only.equation, only.samples, only.predicted = self.equation, self.samples[both], self.predicted[both]
        return only.excess(same_input(5.0, only.samples.hardening_xi))


def intermediate(samples):
    return (samples.effective_friction > 0.395) & (samples.effective_friction < 1.5)


SENTENCES = [
    Sentence("Fr", "A3.2", "For chi = 100.7 %, RMSLE remains mostly below 10 % for Fr < 3", RUNUP, lambda e: e.by_froude(5.0, 0.0, 2.9), (0.0, 0.10), 1),
    Sentence("Fr", "A3.2", "rising to 10 % to 15 % for 3 <= Fr <= 7", RUNUP, lambda e: e.by_froude(5.0, 2.9, 7.1), (0.10, 0.15)),
    Sentence("Fr", "A3.2", "For chi = 107.5 %, 7 % to 15 % for Fr < 3", RUNUP, lambda e: e.by_froude(0.5, 0.0, 2.9), (0.07, 0.15)),
    Sentence("Fr", "A3.2", "and 14 % to 23 % for 3 <= Fr <= 7", RUNUP, lambda e: e.by_froude(0.5, 2.9, 7.1), (0.14, 0.23)),
    Sentence("Fr", "A3.3", "For chi = 100.7 %, NRMSE remains between 4 % to 8 % across the full Fr range", PRESSURE_HEIGHT,
             lambda e: e.by_froude(5.0, 0.0, 7.1), (0.04, 0.08)),
    Sentence("Fr", "A3.3", "For chi = 107.5 %, reaching up to 14 % at high Fr", PRESSURE_HEIGHT, lambda e: e.by_froude(0.5, 0.0, 7.1), (0.0, 0.14)),
    Sentence("xi", "A3.2", "For chi = 107.5 %, errors are slightly larger", RUNUP, Errors.of_xi, (-np.inf, 0.0)),
    Sentence("xi", "A3.3", "For chi = 107.5 %, errors are slightly larger", PRESSURE_HEIGHT, Errors.of_xi, (-np.inf, 0.0)),
    Sentence("M'", "A3.2", "M' = 0.4 to 1.5, where RMSLE remains at or below 10 %", RUNUP, lambda e: e.by_friction(0.395, 1.5), (0.0, 0.10)),
    Sentence("M'", "A3.2", "accuracy is best for intermediate effective internal friction", RUNUP, lambda e: e.excess(intermediate(e.samples)),
             (-np.inf, 0.0)),
    Sentence("M'", "A3.3", "for M' >= 0.4, NRMSE remains below 10 %", PRESSURE_HEIGHT, lambda e: e.by_friction(0.395, 9.0), (0.0, 0.10)),
]
PARTS = ("scores", "Fr", "xi", "M'")


def sentence_unit(equation):
    """One standard error of a root mean square over a dozen runs of the printed scatter."""
    return equation.published_scores[equation.score] / np.sqrt(2.0 * DOZEN)


def deviation(errors, band, unit, spared=0):
    """Root mean square of how far the groups are outside the band, in units; the worst `spared` of them are left out."""
    outside = np.array([max(band[0] - e, e - band[1], 0.0) for e in errors])
    kept = np.sort(outside)[:max(len(outside) - spared, 0)]
    return float(np.sqrt(np.mean(kept**2)) / unit) if len(kept) else 0.0


# ---- The distance -----------------------------------------------------------------------------------------------------------------------


def judge(runs):
    """(summary, rows) of the runs of one rule: {part: deviation, distance, fluid, agrees, and the coefficients}, and a row for each score and sentence."""
    rows, found = [], {"runs": int((runs.effective_friction > 0.0).sum())}
    errors = {}
    for equation in (RUNUP, PRESSURE_HEIGHT):
        samples = height_samples(equation, runs[runs.effective_friction > 0.0]).reset_index(drop=True)
        fit = fit_heights(equation, samples, with_profile=False)
        found.update({name: estimate.value for name, estimate in fit.estimates.items()})
        errors[equation.name] = Errors(equation, samples, fit.coefficients)
    for equation, name in SCORES:
        of = errors[equation.name]
        value = compute_scores(of.samples.relative_height, of.predicted)[name]
        rows.append({"part": "scores", "where": "Table A1" if equation is RUNUP else "Table A2", "equation": equation.name, "statement": name,
                     "from": equation.published_scores[name], "to": equation.published_scores[name], "lowest": value, "highest": value,
                     "deviation": abs(value - equation.published_scores[name]) / _score_unit(equation, name)})
    for s in SENTENCES:
        values = s.groups(errors[s.equation.name])
        rows.append({"part": s.part, "where": s.where, "equation": s.equation.name, "statement": s.text, "from": s.band[0], "to": s.band[1],
                     "lowest": min(values, default=np.nan), "highest": max(values, default=np.nan),
                     "deviation": deviation(values, s.band, sentence_unit(s.equation), s.spared)})
    table = pd.DataFrame(rows)
    parts = {part: float(np.sqrt(np.mean(table.deviation[table.part == part]**2))) for part in PARTS}
    found |= parts | {"distance": float(np.sqrt(np.mean(np.square([*parts.values()]))))}
    found["fluid_rmsle"] = fluid_error(runs)
    found["agrees"] = int(max(parts.values()) <= 1.0 and found["fluid_rmsle"] <= FLUID_WITHIN)  # not without runs of the fluid
    return found, table


def fluid_error(runs):
    """RMSLE of the least compressible fluid from 1 + Fr^2/2, which no coefficient enters; NaN without such runs."""
    fluid = runs[(runs.effective_friction == 0.0) & same_input(5.0, runs.hardening_xi)]
    return compute_scores(fluid.runup, equations.bernoulli_height(fluid.froude_number)).rmsle if len(fluid) else np.nan


def on_common_sets(candidates, runs):
    """{rule name: its rows}, of the sets that all rules have with steady means of both heights."""
    found = {rule.name: rows_of(rule, runs) for rule in candidates}
    found = {name: of[np.isfinite(of.runup) & np.isfinite(of.pressure_height)] for name, of in found.items()}
    keys = [set(map(tuple, of[POINT].to_numpy())) for of in found.values()]
    common = set.intersection(*keys)
    if not common:
        raise ConfigError("no set was computed with every rule for the friction of the mast")
    return {name: of[[point in common for point in map(tuple, of[POINT].to_numpy())]].reset_index(drop=True) for name, of in found.items()}


def yardstick(candidates, runs):
    """(a row a rule by rising distance, with the jackknife error over kinds of snow of its distance less that of the nearest; a row a rule and
    statement)."""
    chosen = on_common_sets(candidates, runs)
    judged = {name: judge(of) for name, of in chosen.items()}
    summary = pd.DataFrame([{"rule": name, **found} for name, (found, _) in judged.items()]).sort_values("distance", ignore_index=True)
    nearest = chosen[summary.rule[0]]
    summary["behind"] = summary.distance - summary.distance[0]
    summary["behind_error"] = [_behind_error(chosen[name], nearest) for name in summary.rule]
    statements = pd.concat([table.assign(rule=name) for name, (_, table) in judged.items()], ignore_index=True)
    return summary, statements[["rule", *statements.columns[:-1]]]


def _behind_error(runs, nearest):
    kinds = sorted(levels(runs.effective_friction[runs.effective_friction > 0.0]).unique())
    without = [judge(runs[~same_input(kind, runs.effective_friction)])[0]["distance"]
               - judge(nearest[~same_input(kind, nearest.effective_friction)])[0]["distance"] for kind in kinds]
    return float(np.sqrt((len(without) - 1) / len(without) * np.sum((without - np.mean(without))**2)))


def friction_scan(runs):
    """Runs of the points that were run with several frictions of the mast: both heights, and the run-up over that with half of tan(phi')."""
    runs = runs[runs.at_reference_width].assign(**point_keys(runs), half=0.5 * tan_friction(runs.effective_friction))
    runs = runs.assign(friction=levels(runs.obstacle_friction).round(6)).drop_duplicates([*POINT, "friction"])
    at_half = runs[np.isclose(runs.obstacle_friction, runs.half, rtol=0.0, atol=1e-4)].set_index(POINT).runup
    several = runs[runs.groupby(POINT).friction.transform("nunique") > 1]
    scan = several[[*POINT, "effective_friction", "half", "obstacle_friction", "runup", "pressure_height"]].join(at_half.rename("at_half"), on=POINT)
    scan["runup_over_half"] = scan.runup / scan.pop("at_half")
    return scan.sort_values([*POINT, "obstacle_friction"], ignore_index=True)


def friction_tables(runs):
    """{name: table}: friction_scan(), and the yardstick for the constants that were computed."""
    tables = {"friction_scan": friction_scan(runs)}
    if constants := [c for c in CONSTANTS if np.isclose(runs.obstacle_friction, c, rtol=0.0, atol=1e-4).any()]:
        tables["yardstick"], tables["yardstick_statements"] = yardstick(rules(*constants), runs)
    return tables
