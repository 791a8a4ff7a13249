"""The first screen of the study's page: what was fitted beside the paper's, and in sentences what is confirmed, what differs, and why.

`studies`: every function takes a list of Study (study_page.py). The first is the one that the sentences are about. Every number comes from
the tables of the studies. Intervals are of 90 %, by a bootstrap over materials if nothing else is said.
"""

from typing import NamedTuple

import numpy as np

from mpmtools.figures.axes import number, per_cent
from mpmtools.study.friction_choice import HALF, SHARE, SMALLER_OF_BOTH
from mpmtools.study.grids import ALL_UNCONVERGED
from mpmtools.study.jams import LIMIT
from mpmtools.study.uncertainty import LOOSE, STIFF

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


def in_short(studies):
    """Three lists of sentences for somebody who has read the paper: confirmed, differs, why; None if nothing was fitted."""
    columns = [c for c in headline_columns(studies) if c.scores]
    if not columns:
        return None
    published = _published(studies)
    spread = {p: _inside_and_outside(columns, p, value) for p, value in published.items()}
    saturation = [c.found["Fr_sat"][0] for c in columns]
    confirmed = [_form(columns, _scores_of_paper(studies)),
                 "Slow snow piles up because of its friction, fast snow loses head to it; the pressure height stops growing "
                 f"at Fr {number(np.nanmin(saturation), 1)} to {number(np.nanmax(saturation), 1)} (paper {number(published['Fr_sat'], 1)})."]
    confirmed += [f"{NAMES[p]}: the published {number(value)} lies in the interval of every campaign, the widest {_widest(columns, p)}."
                  for p, value in published.items() if spread[p][0] and not spread[p][1]]
    differs = [f"{NAMES[p]} (published {number(value)}) is outside the interval of the {_listed(spread[p][1])}"
               + (f"; inside that of the {_listed(spread[p][0])}" if spread[p][0] else "") + "." for p, value in published.items() if spread[p][1]]
    compared = next((s for s in studies if len(s.table("paired_summary"))), studies[0])
    return {"confirmed": confirmed, "differs": [*differs, _accurate_solver(compared)], "why": _why(studies[0])}


def _form(columns, paper):
    """How well the published equations fit the runs of the first campaign."""
    first = [c for c in columns if c.campaign == columns[0].campaign]

    def scored(score):
        return " and ".join(f"{per_cent(score(c.scores))} ({c.fitting_set})" for c in first)

    runup, pressure = paper["runup"], paper["pressure_height"]
    return (f"The published equations describe our heights ({first[0].campaign}): RMSLE of the run-up "
            f"{scored(lambda s: s['runup']['rmsle'])}, paper {per_cent(runup['rmsle'])} on its own; within 25 % "
            f"{scored(lambda s: s['runup']['fraction_25'])}, paper {per_cent(runup['fraction_25'])}; NRMSE of the pressure height "
            f"{scored(lambda s: s['pressure_height']['nrmse'])}, paper {per_cent(pressure['nrmse'])}.")


def _widest(columns, parameter):
    found = [c.found[parameter][1:] for c in columns]
    return interval(*max((ends for ends in found if np.isfinite(ends[0])), key=lambda ends: ends[1] - ends[0]))


def _inside_and_outside(columns, parameter, published):
    """Two lists of texts: the campaigns, with their value, whose interval holds the published one, and the others."""
    verdicts = {}
    for c in columns:
        value, low, high = c.found[parameter]
        if np.isfinite(value):
            verdicts.setdefault((c.campaign, not low <= published <= high), []).append((c.fitting_set, value))
    lists = ([], [])
    for (campaign, outside), found in verdicts.items():
        only = f", {found[0][0]} set" if (campaign, not outside) in verdicts else ""
        lists[outside].append(f"{campaign}{only} ({number(found[0][1])})")
    return lists


def _listed(texts):
    return " and the ".join([", the ".join(texts[:-1]), texts[-1]] if len(texts) > 1 else texts)


def _accurate_solver(study):
    summary, prediction = study.table("paired_summary"), _predicted(study)
    if summary.empty or prediction.empty:
        return "No run of the prediction (accurate solver) was compared."
    of_all = summary[summary.group == "all"].set_index("quantity")
    ratios = ", ".join(f"{q} {number(r.ratio, 2)} ({number(r.lowest, 2)} to {number(r.highest, 2)})" for q, r in of_all.iterrows())
    text = f"The accurate solver over the contact on nodes ({study.name}), {of_all.pairs.max():.0f} pairs of runs: {ratios}."
    fitted = np.isfinite(prediction.value).any()
    return text if fitted else text + f" Its {prediction.rows.iloc[0]:.0f} rows are too few for coefficients."


def _why(study):
    """One sentence for each table that explains a difference."""
    return [sentence for explain in (_friction, _calibration, _pile_up, _fluid, _unconverged, _jams, _compaction) if (sentence := explain(study))]


def _pile_up(study):
    k_of = {r.part: r.k_r for r in study.table("runup_parts").itertuples() if r.fitting_set == SETS[0]}
    if not {LOOSE, STIFF} <= k_of.keys():
        return None
    return (f"The pile-up is not proportional to M', so that k_r depends on the snow that is fitted: with the runs of {LOOSE} alone k_r is "
            f"{number(k_of[LOOSE], 2)}, with those above {number(k_of[STIFF], 2)}.")


def _fluid(study):
    """What the paper's printed errors say of its runs, and what that does to ours."""
    row = _fit_without(study, "fluid")
    if row is None or study.table("published_errors").empty:
        return None
    found = ", ".join(f"{NAMES[p]} {number(row[p])}" for p in ("k_p", "Fr_sat", "kappa_p"))
    return (f"The paper's printed standard errors point to a fit without the fluid (M = 0). Ours then has {found}, and an NRMSE of "
            f"{per_cent(row.pressure_height_nrmse)}.")


def _fit_without(study, kind):
    """Coefficients and scores of the narrow set without a kind of snow; None without this table."""
    left_out = study.table("coefficients_without_unconverged")
    of = left_out[(left_out.without == kind) & (left_out.fitting_set == SETS[0])] if len(left_out) else left_out
    return None if of.empty else of.iloc[0]


def _unconverged(study):
    row, published = _fit_without(study, ALL_UNCONVERGED), _published([study])
    if row is None or row[list(NAMES)].isna().any():
        return None
    found = ", ".join(f"{NAMES[p]} {number(row[p])} ({100.0 * (row[p] / value - 1.0):+.0f} %)" for p, value in published.items())
    return (f"Without the snow whose heights are not converged at w/5 (fluids, M' above 1.5, cohesive snow of ξ up to 0.5) the {study.name} has "
            f"{found}, an RMSLE of {per_cent(row.runup_rmsle)} and an NRMSE of {per_cent(row.pressure_height_nrmse)}.")


def _friction(study):
    rules = next((table for name in ("friction_scan_rules", "friction_rules") if len(table := study.table(name))), ())
    if not len(rules):
        return None
    k = _first_points(rules).set_index("rule")
    best = k.nsmallest(4, "runup_rmsle")
    return ("k_r follows the friction of the mast, which the paper does not print. The four of our rules that fit the run-ups best: "
            + ", ".join(f"{number(r.k_r, 2)} with {rule.replace('phi', 'φ').removeprefix('best: ')}" for rule, r in best.iterrows())
            + (f"; {number(k.k_r[HALF], 2)} with half of tan φ'" if HALF in k.index and HALF not in best.index else "")
            + (f"; {number(k.k_r['0'], 2)} without friction" if "0" in k.index else "") + f", on the same {k.runs.iloc[0]:.0f} rows.")


def _calibration(study):
    """What each family of rules with one number c finds on one half of the points, and its score on the other."""
    calibration = study.table("friction_scan_calibration")
    if calibration.empty:
        return None
    whole, calibration = calibration, _first_points(calibration)
    families = {family.name: of for family in (SMALLER_OF_BOTH, SHARE) if len(of := calibration[calibration.rule == family.name])}
    first = next(iter(families.values()))
    points = first.runs_calibrating.iloc[0] + first.runs_judging.iloc[0]

    def rmsle(column):
        return f"{per_cent(column.min())} to {per_cent(column.max())}"

    found = [f"{name.replace('phi', 'φ')}: c = {number(of.c.min(), 2)} to {number(of.c.max(), 2)}, RMSLE {rmsle(of.rmsle_judging)}"
             for name, of in families.items()]
    return (f"Friction of the mast, calibrated on one half of {points:.0f} points and judged on the other, {len(first)} halves: "
            + "; ".join(found) + f"; half of tan φ' without calibration: RMSLE {rmsle(first.rmsle_judging_half)}." + _losses_on_the_other_half(whole))


def _losses_on_the_other_half(calibration):
    """How much worse the calibrated rules are on the points that they have not seen, where the table has more points than the first."""
    more = calibration[(calibration.points != calibration.points.iloc[0]) & calibration.rule.isin([SMALLER_OF_BOTH.name, SHARE.name])]
    if more.empty:
        return ""
    points = more.runs_calibrating.iloc[0] + more.runs_judging.iloc[0]
    worse = 100.0 * (more.rmsle_judging - more.rmsle_calibrating).max()
    return f" On all {points:.0f} points they are up to {number(worse, 1)} percentage points worse on the half that they have not seen."


def _first_points(table):
    """The rows of the points that the table has first: those with most frictions of the mast."""
    return table[table.points == table.points.iloc[0]]


def _jams(study):
    jams = study.table("coefficients_without_jams")
    if jams.empty:
        return None
    both = [jams[(jams.fitting_set == name) & (jams.limit == limit)].iloc[0] for name in SETS for limit in (np.inf, LIMIT)]
    if both[1].left_out > 0:
        found = (f"{both[1].left_out:.0f} runs of stiff snow jam between inlet and mast. Without them κ_p goes from {number(both[0].kappa_p, 2)} to "
                 f"{number(both[1].kappa_p, 2)} (narrow) and from {number(both[2].kappa_p, 2)} to {number(both[3].kappa_p, 2)} (wide). ")
    else:
        found = f"No run of the {study.name} jams by the rule of this page. "
    return found + _without_one_material(study.table("coefficient_intervals"))


def _without_one_material(intervals):
    """How far k_p and κ_p depend on one kind of snow."""
    rows = intervals[intervals.fitting_set == SETS[0]].set_index("parameter")
    ranges = [f"{NAMES[p]} is {number(c.lowest_without_one, 2)} (without M' {number(c.lowest_without_material, 2)}) to "
              f"{number(c.highest_without_one, 2)} (without M' {number(c.highest_without_material, 2)})"
              for p, c in rows.loc[["k_p", "kappa_p"]].iterrows()]
    return "With one material left out " + ", ".join(ranges) + " on the narrow set."


def _compaction(study):
    compaction = study.table("compaction_summary")
    whole = compaction[compaction.hardening_xi.isna()] if len(compaction) else compaction
    if len(whole) < 2:  # one of the two kinds of snow is missing
        return None
    loose, sticky = (whole[whole.cohesive == c].iloc[0] for c in (0, 1))
    helped = [number(s.hardening_xi, 2) for s in compaction[compaction.cohesive == 1].itertuples() if s.rms < s.rms_without_loss and s.hardening_xi > 0]
    return ("Compressible fast snow climbs less. Without cohesion it keeps "
            f"{number(loose.mean_head, 2)} of its head, and a compaction shock leaves {number(loose.mean_behind_shock, 2)} (rms difference "
            f"{number(loose.rms, 2)}; from no loss {number(loose.rms_without_loss, 2)}). With cohesion the shock comes closer than no loss "
            + (f"for ξ = {' and '.join(helped)} only" if helped else "for no ξ") + f" (rms difference {number(sticky.rms, 2)} over all).")


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
