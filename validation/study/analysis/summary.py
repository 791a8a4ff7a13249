"""The first screen of the study's page: what was fitted, beside the paper's.

`studies`: every function takes a list of Study (page.py). Every number comes from the tables of the studies. Intervals are of 90 %, by a
bootstrap over materials if nothing else is said.
"""

from typing import NamedTuple

import numpy as np

from analysis.axes import number, per_cent
from analysis.jams import LIMIT

NAMES = {"k_r": "k_r", "kappa_r": "κ_r", "k_p": "k_p", "Fr_sat": "Fr_sat", "kappa_p": "κ_p"}
SETS = ("narrow", "wide")
SCORES = {"runup": "rmsle", "pressure_height": "nrmse"}


def interval(low, high):
    if not np.isfinite(low):
        return "not determined"
    return f"{number(low, 2)} to {number(high, 2)}" if np.isfinite(high) else f"above {number(low, 2)}"


class Column(NamedTuple):
    """What was fitted to one fitting set of a campaign."""

    campaign: str
    fitting_set: str  # one of SETS, or "both sets"
    runs: int
    materials: int
    found: dict  # {coefficient: (value, from, to)}
    scores: dict  # {equation: scores of the published equation}

    @property
    def name(self):
        return f"{self.campaign}, {self.fitting_set}"


def headline_columns(studies):
    """[Column]: both fitting sets of every study, and of the prediction where a study was evaluated with it and the prediction is no study of
    its own: none of this name, and none with the same values."""
    columns = []
    of_its_own = any(study.name == "prediction" for study in studies)
    for study in studies:
        intervals = study.table("coefficient_intervals")
        for name in SETS:
            of_set = intervals[intervals.fitting_set == name] if len(intervals) else intervals
            if len(of_set):
                scores = {e: r["scores_of_published"] for e in SCORES if (r := study.regression(e, name)) and "scores_of_published" in r}
                columns.append(_column(study.name, name, of_set, scores))
        prediction, scores = _predicted(study), _predicted(study, "campaign_scores")
        for name in SETS if len(prediction) and not of_its_own else ():
            of_set = prediction[prediction.fitting_set == name]
            if np.isfinite(of_set.value).any():
                of_scores = {r["equation"]: r for r in scores[scores.fitting_set == name].to_dict("records")} if len(scores) else {}
                columns.append(_column("prediction", name, of_set, of_scores))
    fitted = [c.found for c in columns if c.campaign != "prediction"]
    return [c for c in columns if c.campaign != "prediction" or not any(_same_values(c.found, found) for found in fitted)]


def _column(campaign, fitting_set, rows, scores):
    found = {c.parameter: (c.value, c.material_from, c.material_to) for c in rows.itertuples()}
    return Column(campaign, fitting_set, int(rows.iloc[0].runs), int(rows.iloc[0].materials), found, scores)


def _same_values(a, b):
    """Whether two columns hold the same coefficients: the prediction may be a study of its own on the page."""
    return set(a) == set(b) and all(np.isclose(a[p][0], b[p][0], rtol=1e-9) for p in a)


def _predicted(study, name="side_by_side"):
    """Rows of a table of both campaigns that are of the prediction as a whole; empty without them."""
    table = study.table(name)
    return table[table.campaign == "prediction"] if len(table) else table


def _without_repeats(columns):
    """One column in place of two where both fitting sets of a campaign hold the same runs."""
    kept = []
    for column in columns:
        if kept and kept[-1]._replace(fitting_set=column.fitting_set) == column:
            kept[-1] = column._replace(fitting_set="both sets")
        else:
            kept.append(column)
    return kept


def _published(studies):
    return {c.parameter: c.published for c in studies[0].table("coefficient_intervals").itertuples()}


def _scores_of_paper(studies):
    return {e: studies[0].regression(e)["published_scores_on_its_own_data"] for e in SCORES}


def matrix(studies):
    """The table that heads the page: what was fitted, beside the paper's."""
    columns = _without_repeats(headline_columns(studies))
    if not columns:
        return None
    published = _published(studies)

    def row(name, runs, coefficients, scored):
        return [name, runs, *coefficients,
                *(f"{per_cent(s[score])}, {per_cent(s['fraction_25'])}" if (s := scored.get(e)) else "–" for e, score in SCORES.items())]

    rows = [row("paper", "", [number(value) for value in published.values()], _scores_of_paper(studies))]
    for c in columns:
        found = [c.found[p] for p in published]
        rows.append(row(c.name, str(c.runs), [f"{number(f[0])} ({interval(*f[1:])})" if np.isfinite(f[0]) else "–" for f in found], c.scores))
    return {"head": ["", "runs", *(NAMES[p] for p in published), "run-up: RMSLE, within 25 %", "pressure height: NRMSE, within 25 %"],
            "rows": rows}


HEADLINE = ["campaign and fitting set", "coefficient", "value", "90 %, materials drawn anew", "90 %, Froude numbers drawn anew", "without jams",
            "paper", "paper inside (materials)"]


def headline(studies):
    """Both fitting sets of every study: coefficient, with both intervals, and the paper's; None if nothing was fitted."""
    rows = []
    for study in studies:
        intervals, jams = study.table("coefficient_intervals"), study.table("coefficients_without_jams")
        for fitting_set, of_set in intervals.groupby("fitting_set", sort=False) if len(intervals) and len(jams) else ():
            kept = jams[(jams.fitting_set == fitting_set) & np.isclose(jams.limit, LIMIT)].iloc[0]
            rows += [[f"{study.name}, {fitting_set} ({c.runs} runs, {c.materials} M')", c.parameter, number(c.value),
                      interval(c.material_from, c.material_to), interval(c.froude_from, c.froude_to), number(kept[c.parameter]),
                      number(c.published), "yes" if c.material_from <= c.published <= c.material_to else "no"] for c in of_set.itertuples()]
    return {"head": HEADLINE, "rows": rows} if rows else None
