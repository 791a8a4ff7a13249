"""Both regressions on both fitting sets of the paper, and their scores by every input."""

import json
import os
import subprocess
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

import mpmtools
from mpmtools.equations import relative_height
from mpmtools.errors import ConfigError
from mpmtools.files import plain
from mpmtools.scores import SCORES, compute_scores, levels, same_input, scores_by_group
from mpmtools.fit.regression import EQUATIONS, HeightFit, fit_heights
from mpmtools.tables import csv_text

INPUTS = ("froude_number", "effective_friction")  # by which the scores are broken down


@dataclass(frozen=True)
class FittingSet:
    """Which runs are fitted."""

    name: str
    description: str
    xi: tuple
    only: bool  # True: only runs with one of these xi; False: all others

    def holds(self, runs):
        named = np.any([same_input(xi, runs["hardening_xi"]) for xi in self.xi], axis=0)
        return named == self.only


NARROW = FittingSet("narrow", "xi in {0.5, 1.5, 5} (note of Table 1)", (0.5, 1.5, 5.0), True)
WIDE = FittingSet("wide", "everything but xi = 0.05 (Sect. 4.1)", (0.05,), False)


@dataclass
class SetFit:
    """One equation fitted to one set. `scores` has the columns coefficients (fitted or published), hardening_xi (NaN: the whole
    set), group (input that the runs share, or empty), at (its value), runs, and the scores."""

    equation: object
    fitting_set: FittingSet
    runs: int
    without_height: int  # runs of the set that were left out: without a steady height,
    other_width: int  # and with a mast of another width than H
    fit: HeightFit | None = None
    why_not: str = ""
    scores: pd.DataFrame = field(default_factory=pd.DataFrame)

    def whole(self, coefficients):
        """Scores of the whole set against the `fitted` or `published` coefficients; None without them."""
        if self.scores.empty:
            return None
        rows = self.scores[(self.scores.coefficients == coefficients) & self.scores.hardening_xi.isna() & (self.scores.group == "")]
        return rows.iloc[0] if len(rows) else None


def height_samples(equation, runs):
    """What an equation is fitted to: the runs that have its height, and w = H."""
    used = runs[runs.at_reference_width & np.isfinite(runs[equation.name])]
    return used[["effective_friction", "froude_number", "hardening_xi"]].assign(relative_height=used[equation.name])


def fit_set(equation, fitting_set, runs):
    members = runs[fitting_set.holds(runs)]
    at_width = members[members.at_reference_width]
    samples = height_samples(equation, members)
    result = SetFit(equation, fitting_set, len(samples), len(at_width) - len(samples), len(members) - len(at_width))
    try:
        result.fit = fit_heights(equation, samples)
    except ConfigError as error:
        result.why_not = str(error)
    tables, everything = [], height_samples(equation, runs)  # also of the xi outside the set
    for source, coefficients in {**({"fitted": result.fit.coefficients} if result.fit else {}), "published": equation.published}.items():
        tables.append(score_samples(samples, coefficients, [*INPUTS, "hardening_xi"]).assign(coefficients=source, hardening_xi=np.nan))
        for xi, of_xi in everything.groupby(levels(everything.hardening_xi)):
            tables.append(score_samples(of_xi, coefficients, INPUTS).assign(coefficients=source, hardening_xi=xi))
    result.scores = pd.concat(tables, ignore_index=True)
    return result


def score_samples(samples, coefficients, inputs):
    """Scores of all samples, then by each input."""
    if samples.empty:
        return pd.DataFrame()
    predicted = relative_height(samples.effective_friction, samples.froude_number, coefficients)
    whole = pd.DataFrame([{"group": "", "at": np.nan, "runs": len(samples), **compute_scores(samples.relative_height, predicted)}])
    groups = [scores_by_group(samples[name], samples.relative_height, predicted).assign(group=name) for name in inputs]
    return pd.concat([whole, *groups], ignore_index=True)


def fit_paper_sets(runs):
    """Both equations, each on both sets of the paper."""
    return [fit_set(equation, fitting_set, runs) for fitting_set in (NARROW, WIDE) for equation in EQUATIONS]


def coefficients_table(fits):
    """Tables A1 and A2: one row a coefficient, ours beside the paper's."""
    rows = []
    for s in fits:
        for name, estimate in (s.fit.estimates if s.fit else {}).items():
            low, high = s.fit.interval(name)
            published, published_error, published_t = s.equation.published_estimates[name]
            rows.append({"equation": s.equation.name, "fitting_set": s.fitting_set.name, "parameter": name, "value": estimate.value,
                         "standard_error": estimate.standard_error, "relative_standard_error": estimate.relative_error,
                         "t_statistic": estimate.t_statistic, "p_value": estimate.p_value, "interval_from": low, "interval_to": high,
                         "published": published, "published_relative_standard_error": published_error,
                         "published_t_statistic": published_t, "relative_difference": estimate.value / published - 1.0})
    return pd.DataFrame(rows)


def scores_table(fits):
    """Scores of all fits by all inputs (Appendix A3.1, Figs. A3 and A5)."""
    columns = ["equation", "fitting_set", "coefficients", "hardening_xi", "group", "at", "runs", *SCORES]
    tables = [s.scores.assign(equation=s.equation.name, fitting_set=s.fitting_set.name) for s in fits if len(s.scores)]
    return pd.concat(tables, ignore_index=True)[columns] if tables else pd.DataFrame(columns=columns)


def coefficients_csv(fits):
    return csv_text(coefficients_table(fits), nothing="")


def scores_csv(fits):
    return csv_text(scores_table(fits), nothing="")


def evaluated_by():
    """Version of this package; its commit where it lies in a clone."""
    here = os.path.dirname(os.path.abspath(__file__))
    try:
        commit = subprocess.run(["git", "-C", here, "describe", "--always", "--abbrev=12", "--exclude=*", "--dirty"], check=True,
                                capture_output=True, text=True).stdout.strip()
    except (OSError, subprocess.CalledProcessError):
        commit = ""
    return f"mpmtools {mpmtools.__version__}" + (f", commit {commit}" if commit else "")


def fits_json(fits, table):
    """Everything of the fits, the published values, and what the table left out, as JSON. What is unknown or infinite is
    null."""
    return json.dumps(plain({
        "evaluated_by": evaluated_by(), "files": table.files, "rows": table.rows, "runs": len(table.runs),
        "left_out": [{"reason": reason, "rows": rows} for reason, rows in table.left_out.items()],
        "cautions": table.cautions, "provenance": table.provenance, "fits": [_fit_dict(s) for s in fits],
    }), indent=1, allow_nan=False) + "\n"


def _fit_dict(s):
    rows = coefficients_table([s]).drop(columns=["equation", "fitting_set"], errors="ignore").to_dict("records")
    for row in rows:
        row["interval"] = [row.pop("interval_from"), row.pop("interval_to")]
    return {"equation": s.equation.name, "fitting_set": s.fitting_set.name, "fitting_set_description": s.fitting_set.description,
            "runs": s.runs, "without_height": s.without_height, "other_width": s.other_width, "why_not": s.why_not,
            "coefficients": rows, "cautions": s.fit.cautions if s.fit else [], "published_scores_on_its_own_data": s.equation.published_scores,
            **{f"scores_of_{source}": whole[list(SCORES)].to_dict() for source in ("fitted", "published") if (whole := s.whole(source)) is not None},
            **({"saturation_profile": s.fit.saturation_profile} if s.fit else {})}
