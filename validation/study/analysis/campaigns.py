"""Reproduction and prediction side by side: the same flows and snows with the numerics of the paper and with the accurate solver.

The heights of two runs of one set-up are divided run by run ("paired rows"), which needs no equation. Coefficients of the two campaigns
are compared on the sets that both have, because a coefficient depends on which runs there are.
"""

import numpy as np
import pandas as pd

from analysis.fits import point_keys, score_against_published
from mpmtools.scores import levels
from mpmtools.fit.fits import NARROW, WIDE, height_samples
from mpmtools.fit.regression import EQUATIONS, fit_heights
from mpmtools.fit.runs import POINT
from analysis.uncertainty import GROUPS, bootstrap, drawn_interval

FEWEST_FROUDE_NUMBERS, FEWEST_MATERIALS = 3, 4  # of snow with friction: fewer do not fix k, kappa and Fr_sat together, let alone their intervals
UNCERTAINTIES = ["runup_numerical_uncertainty", "pressure_height_numerical_uncertainty"]
ALIKE = ["obstacle_friction", "planned_duration_s"]  # inputs that are no part of a set-up: two runs with different ones are not compared
QUANTITIES = {"runup": "run-up", "pressure_height": "pressure height", "force_n": "force"}


def keyed(runs):
    """Runs at the reference width by their set-up; the first of several runs of one set-up."""
    at_width = runs[runs.at_reference_width].reset_index(drop=True)
    return at_width.assign(**point_keys(at_width)).drop_duplicates(POINT)


def alike_pairs(first, second, suffixes):
    """Both tables of keyed runs merged by set-up, in the order of the first, without the pairs that differ in an input of ALIKE which both
    tables name."""
    both = first.merge(second, on=POINT, suffixes=suffixes)
    differ = pd.Series(False, index=both.index)
    for name in ALIKE:
        differ |= abs(both.pop(name + suffixes[0]) - both.pop(name + suffixes[1])) > 1e-6  # not if one is NaN
    return both[~differ].reset_index(drop=True)


def paired_rows(reproduction, prediction):
    """A row for each set-up that both campaigns have, with the same friction of the mast and the same duration where both tables name them, in
    the order of the prediction: inputs, M', numerical uncertainties of the prediction's heights, each quantity (heights over H, force in N) of both, and
    prediction over reproduction."""
    ours = keyed(prediction)[[*POINT, "effective_friction", *ALIKE, *UNCERTAINTIES, *QUANTITIES]]
    both = alike_pairs(ours, keyed(reproduction)[[*POINT, *ALIKE, *QUANTITIES]], ("_prediction", "_reproduction"))
    ratios = {f"{name}_ratio": both[f"{name}_prediction"] / both[f"{name}_reproduction"] for name in QUANTITIES}
    return both.assign(**ratios)


def ratio_summary(ratio):
    """Of ratios that may lack: pairs, geometric mean, spread (standard deviation of the logarithm), lowest and highest; empty without any."""
    ratio = ratio.dropna()
    if ratio.empty:
        return {}
    logarithm = np.log(ratio)
    return {"pairs": len(ratio), "ratio": np.exp(logarithm.mean()), "spread": logarithm.std() if len(ratio) > 1 else np.nan,
            "lowest": ratio.min(), "highest": ratio.max()}


def paired_summary(rows):
    """ratio_summary() over all pairs and over those of one Froude number: a row for each group and quantity."""
    groups = [("all", rows), *((f"Fr {froude:g}", of) for froude, of in rows.groupby("froude_number"))]
    table = []
    for name, of in groups:
        for quantity, label in QUANTITIES.items():
            if summary := ratio_summary(of[f"{quantity}_ratio"]):
                table.append({"group": name, "quantity": label, **summary})
    return pd.DataFrame(table, columns=["group", "quantity", "pairs", "ratio", "spread", "lowest", "highest"])


def _at(runs, rows):
    """The runs whose set-up is among the pairs."""
    return keyed(runs).merge(rows[POINT], on=POINT)


def _intervals(fitting_set, runs):
    """Coefficients of one set with the intervals of the bootstrap; empty where the runs are too few."""
    members = runs[fitting_set.holds(runs)]
    table = []
    for equation in EQUATIONS:
        samples = height_samples(equation, members).reset_index(drop=True)
        frictional = samples[samples.effective_friction > 0.0]
        if levels(frictional.froude_number).nunique() < FEWEST_FROUDE_NUMBERS or levels(frictional.effective_friction).nunique() < FEWEST_MATERIALS:
            continue
        fit = fit_heights(equation, samples, with_profile=False)
        drawn = {name: bootstrap(equation, samples, column) for name, column in GROUPS.items()}
        for i, (name, estimate) in enumerate(fit.estimates.items()):
            row = {"parameter": name, "runs": len(samples), "materials": levels(samples.effective_friction).nunique(),
                   "froude_numbers": levels(samples.froude_number).nunique(), "value": estimate.value}
            for group, found in drawn.items():
                row[f"{group}_from"], row[f"{group}_to"] = drawn_interval(found[:, i])
            table.append(row)
    return pd.DataFrame(table, columns=["parameter", "runs", "materials", "froude_numbers", "value"] if not table else None)


def _parts(reproduction, prediction):
    """{name: runs} of both campaigns, and of each on the set-ups that both have."""
    rows = paired_rows(reproduction, prediction)
    return {"reproduction": reproduction, "reproduction, paired": _at(reproduction, rows), "prediction, paired": _at(prediction, rows),
            "prediction": prediction}


def side_by_side(reproduction, prediction, intervals):
    """Coefficients of the reproduction as a whole (`intervals`: its coefficient_intervals), of both campaigns on the sets that both have, and of the prediction as a whole, with
    the intervals of 90 % of the bootstrap; and the columns campaign and rows (runs with a steady run-up and w = H, whatever fitting set they
    belong to). Coefficients are NaN where the runs of a set hold too few Froude numbers or materials."""
    table = []
    for name, runs in _parts(reproduction, prediction).items():
        for fitting_set in (NARROW, WIDE):
            found = intervals[intervals.fitting_set == fitting_set.name] if runs is reproduction else _intervals(fitting_set, runs)
            for equation in EQUATIONS:
                for parameter in equation.parameters:
                    row = next((r for r in found.to_dict("records") if r["parameter"] == parameter), {"parameter": parameter})
                    table.append({**row, "campaign": name, "rows": int(runs.at_reference_width.sum()), "fitting_set": fitting_set.name,
                                  "published": equation.published_estimates[parameter][0]})
    columns = ["campaign", "rows", "fitting_set", "parameter", "runs", "materials", "froude_numbers", "value", "published", "material_from",
               "material_to", "froude_from", "froude_to"]
    return pd.DataFrame(table).reindex(columns=columns)


def campaign_scores(reproduction, prediction):
    """Scores of the published equations on each campaign, and on the set-ups that both have: a row for each fitting set and equation."""
    rows = []
    for name, runs in _parts(reproduction, prediction).items():
        for fitting_set in (NARROW, WIDE):
            for equation in EQUATIONS:
                samples = height_samples(equation, runs[fitting_set.holds(runs)])
                rows.append({"campaign": name, "fitting_set": fitting_set.name, "equation": equation.name, "runs": len(samples),
                             **score_against_published(equation, samples)})
    return pd.DataFrame(rows)


def campaign_tables(reproduction, prediction, intervals):
    """{name: table} of this module."""
    rows = paired_rows(reproduction, prediction)
    return {"side_by_side": side_by_side(reproduction, prediction, intervals), "campaign_scores": campaign_scores(reproduction, prediction),
            "paired_rows": rows, "paired_summary": paired_summary(rows)}
