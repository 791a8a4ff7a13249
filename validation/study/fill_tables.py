#!/usr/bin/python3
"""Fills the generated tables of the study's texts (README.md and others, see TEXTS) from the tables in results/.

usage: fill_tables.py [--check]    --check changes nothing and fails where a text is out of date
"""

import pathlib
import sys

import numpy as np
import pandas as pd

STUDY = pathlib.Path(__file__).resolve().parent
SOURCE = STUDY.parent.parent
sys.path[:0] = [str(SOURCE / "python"), str(SOURCE / "docs")]

from generate import filled, table  # noqa: E402
from mpmtools.equations import PUBLISHED_RUNUP, relative_height  # noqa: E402
from mpmtools.figures.study_summary import NAMES as SYMBOLS  # noqa: E402
from mpmtools.study.friction_choice import ALL, EVERY_FRICTION, FAMILIES, HALF, coefficients_of, has_half  # noqa: E402
from mpmtools.study.fits import STRICTER_AIMS  # noqa: E402
from mpmtools.study.jams import LIMIT  # noqa: E402
from mpmtools.study.regression import EQUATIONS  # noqa: E402
from mpmtools.tables import number_text, read_series, read_table  # noqa: E402

CAMPAIGNS = {"reproduction_w7": "reproduction at 0.25 m", "reproduction_w5": "reproduction at w/5",
             "calibrated_prediction": "calibrated prediction", "prediction": "prediction, {refined} sets at 0.25 m"}
FIRST = {"first_w5": "first reproduction, w/5", "first_w7": "first reproduction, 0.25 m"}
MAST_FRICTION = {"reproduction_w7": "half", "reproduction_w5": "at most 0.2", "calibrated_prediction": "at most 0.2", "prediction": "half",
                 "first_w5": "half", "first_w7": "half"}
QUANTITIES = ("run-up", "pressure height", "force")
PUBLISHED = {name: value for equation in EQUATIONS for name, (value, *_) in equation.published_estimates.items()}
HOLDS = {(True, True): "in both", (True, False): "kinds of snow", (False, True): "Froude numbers", (False, False): "–"}


def results(campaign, name):
    return read_series(STUDY / "results" / campaign / f"{name}.csv")


def label(campaign, template):
    """With the number of set-ups that have a row at 0.25 m."""
    fine = STUDY / "results" / campaign / "w7.csv"
    return template.format(refined=len(read_table(fine)) if fine.exists() else 0)


def percent(fraction):
    return f"{100 * fraction:.1f} %"


def published():
    return [f"{PUBLISHED[name]:.3f}" for name in SYMBOLS]


def paper_scores():
    """Those that the paper prints, on its own data."""
    return [f"{percent(e.published_scores[e.score])}, {percent(e.published_scores['fraction_25'])}" for e in EQUATIONS]


def published_scores(campaign, fitting_set):
    """Cells of the scores of the published equations on one set of a campaign."""
    scores = results(campaign, "scores")
    whole = scores[(scores.fitting_set == fitting_set) & (scores.coefficients == "published") & scores.hardening_xi.isna() & scores.group.isna()]
    whole = whole.set_index("equation")
    return [f"{percent(whole.loc[e.name, e.score])}, {percent(whole.loc[e.name, 'fraction_25'])}" for e in EQUATIONS]


def with_interval(row):
    return f"{row.value:.3f} ({row.material_from:.3f} to {row.material_to:.3f})"


def headline(campaigns):
    """A row for each campaign and fitting set: coefficients with intervals, scores of the published equations."""
    rows = [("**paper**", "not known", "one fit", *published(), *paper_scores())]
    for campaign, name in campaigns.items():
        intervals = results(campaign, "coefficient_intervals")
        sets = intervals.groupby("fitting_set", sort=False).runs.first()
        for fitting_set in sets.index[:1] if sets.nunique() == 1 else sets.index:  # equal numbers: no run is in the wide set alone
            of = intervals[intervals.fitting_set == fitting_set].set_index("parameter")
            first = (label(campaign, name), MAST_FRICTION[campaign]) if fitting_set == "narrow" else ("", "")
            rows.append((*first, f"{fitting_set}, {int(of.runs.iloc[0])} runs", *(with_interval(of.loc[symbol]) for symbol in SYMBOLS), *published_scores(campaign, fitting_set)))
    return table(("", "friction of the mast", "set", *SYMBOLS.values(), "run-up: RMSLE, within 25 %", "pressure height: NRMSE, within 25 %"), rows)


def stricter_aims(campaign):
    """The stricter aims of the reproduction on both sets, and on the narrow one without the fluid: value, and whether it is met."""
    left_out = results(campaign, "coefficients_without_unconverged").fillna({"without": ""})
    sets = {"narrow": ("", "narrow"), "wide": ("", "wide"), "narrow, without the fluid": ("fluid", "narrow")}
    found = [left_out[(left_out.without == kind) & (left_out.fitting_set == fitting_set)].iloc[0] for kind, fitting_set in sets.values()]

    def cell(value, met, signed=False):
        return f"{100 * value:{'+' if signed else ''}.1f} %".replace("-", "−") + (", met" if met else ", **missed**")

    rows, limits = [], STRICTER_AIMS
    for symbol, name in SYMBOLS.items():
        differences = [of[symbol] / PUBLISHED[symbol] - 1.0 for of in found]
        rows.append((f"{name}, from the paper's: at most {' or '.join(f'{100 * limit:.0f}' for limit in limits.coefficients.values())} % (wide)",
                     *(cell(d, abs(d) <= limits.coefficients[of.fitting_set], True) for d, of in zip(differences, found))))
    for equation, height in zip(EQUATIONS, QUANTITIES):
        score, fraction = f"{equation.name}_{equation.score}", f"{equation.name}_fraction_25"
        limit = limits.scores[equation.score]
        rows.append((f"{equation.score.upper()} of the {height}: at most {percent(limit)}", *(cell(of[score], of[score] <= limit) for of in found)))
        rows.append((f"{height}s within 25 %: at least {percent(limits.fraction_25)}", *(cell(of[fraction], of[fraction] >= limits.fraction_25) for of in found)))
    return table(("aim", *sets), rows)


def intervals_hold(campaigns):
    """Which of the two kinds of intervals hold the published coefficients, for each campaign and set."""
    rows = []
    for campaign, name in campaigns.items():
        for fitting_set, of in results(campaign, "coefficient_intervals").groupby("fitting_set", sort=False):
            of = of.set_index("parameter")
            inside = {symbol: (of.material_from[symbol] <= of.published[symbol] <= of.material_to[symbol],
                               of.froude_from[symbol] <= of.published[symbol] <= of.froude_to[symbol]) for symbol in SYMBOLS}
            rows.append((label(campaign, name), fitting_set, *(HOLDS[inside[symbol]] for symbol in SYMBOLS)))
    return table(("", "set", *SYMBOLS.values()), rows)


def ratio_cells(of):
    """Geometric mean, lowest and highest ratio of each quantity; `of` has a row for each."""
    return [f"{r.ratio:.2f} ({r.lowest:.2f} to {r.highest:.2f})" for r in (of.loc[q] for q in QUANTITIES)]


def ratios(campaign, name):
    """Geometric mean of the pairs, lowest and highest, by Froude number and over all."""
    summary = results(campaign, name)
    rows = []
    for group in [*(g for g in summary.group.unique() if g != "all"), "all"]:
        of = summary[summary.group == group].set_index("quantity")
        rows.append((group, str(int(of.pairs.max())), *ratio_cells(of)))
    return table(("", "pairs", *QUANTITIES), rows)


def kinds(campaign):
    """What the finer grid changes, by kind of snow: sets that have it, pairs, ratios, and the pairs of which the coarse runs said so."""
    rows = []
    for (kind, speeds), of in results(campaign, "refined_kinds").groupby(["kind", "speeds"], sort=False):
        of = of.set_index("quantity")
        one = of.loc[QUANTITIES[0]]
        rows.append((f"{kind}, {speeds}".replace("xi", "ξ").replace("<=", "≤"), f"{one.fine:.0f} of {one.sets:.0f}", str(int(of.pairs.max())),
                     *ratio_cells(of), ", ".join(f"{of.covered[q]:.0f}" for q in QUANTITIES[:2])))
    return table(("kind of snow", "sets at 0.25 m", "pairs", *QUANTITIES, "within"), rows)


def numerics_alone(campaign):
    """Coefficients of a reproduction and of the accurate solver on the set-ups that both have."""
    both = results(campaign, "side_by_side")
    both = both[both.fitting_set == "narrow"].set_index(["campaign", "parameter"])
    rows = [("paper", "", *published())]
    for campaign, name in (("reproduction, paired", CAMPAIGNS[campaign]), ("prediction, paired", "accurate solver")):
        of = both.loc[campaign]
        rows.append((name, str(int(of.runs.iloc[0])), *(with_interval(of.loc[symbol]) for symbol in SYMBOLS)))
    return table(("", "runs", *SYMBOLS.values()), rows)


def with_coarser(campaign):
    """Coefficients and scores without and with the coarser rows of the set-ups that are not steady on the finest grid."""
    rows = [(r["rows"] if r["fitting_set"] == "narrow" else "", f"{r['fitting_set']}, {r['runs']:.0f} runs", *(f"{r[symbol]:.3f}" for symbol in SYMBOLS),
             f"{percent(r['runup_rmsle'])}, {percent(r['runup_fraction_25'])}", percent(r["pressure_height_nrmse"]))
            for r in results(campaign, "coefficients_with_coarser").to_dict("records")]
    return table(("rows", "set", *SYMBOLS.values(), "run-up: RMSLE, within 25 %", "NRMSE"), rows)


def on_both_grids(campaign):
    """Coefficients and scores of the set-ups that were computed on two grids, narrow set."""
    of = results(campaign, "refined_coefficients")
    of = of[of.fitting_set == "narrow"].set_index("grid")
    sizes = results(campaign, "refined_rows")
    rows = [("paper", "", *published(), "", "")]
    for grid in ("coarse", "fine"):
        row = of.loc[grid]
        (size,) = sizes[f"cell_size_m_{grid}"].unique()
        rows.append((f"{size:.2f} m", str(int(row.runs)), *("–" if np.isnan(row[name]) else f"{row[name]:.3f}" for name in SYMBOLS),
                     *(percent(row[f"{e.name}_{e.score}"]) for e in EQUATIONS)))
    return table(("cell size", "runs", *SYMBOLS.values(), "RMSLE", "NRMSE"), rows)


def compaction(campaigns):
    """What is left of the run-up of compressible snow, and what a compaction shock leaves: a row a campaign, with cohesion or not, and xi."""
    rows = []
    for campaign, name in campaigns.items():
        for r in results(campaign, "compaction_summary").itertuples():
            rows.append((name, "with" if r.cohesive else "without", "all" if np.isnan(r.hardening_xi) else number_text(r.hardening_xi), str(r.runs),
                         *(f"{value:.2f}" for value in (r.mean_head, r.mean_behind_shock, r.rms, r.rms_without_loss))))
    return table(("", "cohesion", "ξ", "runs", "kept", "left", "rms of kept − left", "rms of kept − 1"), rows)


def pile_up(campaigns, froude=0.1, xi=5.0):
    """(h/H - 1)/M' of the slowest runs, which the equations take to be one number k: for both heights a row a campaign, a column for each kind of
    snow with friction."""
    tables = {name: results(campaign, "points") for campaign, name in campaigns.items()}
    slow = {name: of[np.isclose(of.froude_number, froude) & np.isclose(of.hardening_xi, xi) & (of.effective_friction > 0.0)]
            for name, of in tables.items()}
    found = {f"{height}, {name}": dict(zip(of.effective_friction.round(2), (of[equation.name] - 1.0) / of.effective_friction))
             for equation, height in zip(EQUATIONS, QUANTITIES) for name, of in slow.items()}
    frictions = sorted(set().union(*found.values()))
    cells = [[f"{of[friction]:.2f}" if friction in of else "–" for friction in frictions] for of in found.values()]
    return table(("M'", *(f"{friction:.2f}" for friction in frictions)), [(name, *row) for name, row in zip(found, cells)])


def without_jams(campaigns):
    """Coefficients and scores of the campaigns that have jammed runs, without these."""
    rows = []
    for campaign, name in campaigns.items():
        scan = results(campaign, "coefficients_without_jams")
        kept = scan[np.isclose(scan.limit, LIMIT) & (scan.left_out > 0)]
        for row in kept.drop_duplicates(list(SYMBOLS)).itertuples():  # twice the same: no run is in the wide set alone
            rows.append((f"{label(campaign, name)}, {row.fitting_set}", *(f"{getattr(row, symbol):.3f}" for symbol in SYMBOLS), percent(row.runup_rmsle),
                         percent(row.pressure_height_nrmse)))
    return table(("", *SYMBOLS.values(), "RMSLE", "NRMSE"), rows)


def friction_design(campaign):
    """Run-up over the published equation at the points that have more than half of the frictions: a row for each Froude number and M'."""
    scan = results(campaign, "friction_scan")
    scan["ratio"] = scan.runup / relative_height(scan.effective_friction, scan.froude_number, PUBLISHED_RUNUP)
    scan["column"] = np.where(has_half(scan), HALF, coefficients_of(scan).map(number_text))
    frictions = sorted(set(scan.column) - {HALF}, key=float)
    fluid = scan[(scan.column == HALF) & np.isclose(scan.half, 0.0)]
    scan = pd.concat([scan, fluid.assign(column="0")])  # half of nothing is no friction, too
    rows = []
    for (froude, friction, _), of in scan.groupby(["froude_number", "effective_friction", "hardening_xi"]):
        found = dict(zip(of.column, of.ratio))
        if 2 * len(found) > len(frictions) + 1:  # not those of three frictions
            rows.append((f"{froude:g}", f"{friction:.2f}", *(f"{found[c]:.2f}" if c in found else "–" for c in (*frictions, HALF))))
    return table(("Fr", "M'", *frictions, "half (tan φ'/2)"), rows)


def friction_rules(campaign, points):
    """Coefficients and scores with each rule for the friction of the mast, on the same points."""
    rules = results(campaign, "friction_scan_rules")
    rules = rules[rules.points == points]
    rows = [(r.rule.replace("phi", "φ"), *(f"{getattr(r, symbol):.3f}" for symbol in SYMBOLS), f"{percent(r.runup_rmsle)}, {percent(r.runup_fraction_25)}",
             percent(r.pressure_height_nrmse)) for r in rules.itertuples()]
    return table((f"friction of the mast ({rules.runs.iloc[0]:.0f} points)", *SYMBOLS.values(), "run-up: RMSLE, within 25 %", "NRMSE"), rows)


def friction_halves(campaign, points):
    """What is calibrated on one half of the points, and its RMSLE there and on the other half, beside that of the half of tan phi'."""
    calibration = results(campaign, "friction_scan_calibration")
    of = calibration[calibration.points == points].set_index(["split", "calibrated_on", "rule"])
    rows = []
    for split, half in dict.fromkeys((split, half) for split, half, _ in of.index):
        of_rules = [of.loc[split, half, family.name] for family in FAMILIES]
        there, other = of.loc[split, "second" if half == "first" else "first", FAMILIES[0].name].rmsle_judging_half, of_rules[0].rmsle_judging_half
        rows.append((f"{split}: {half} half ({of_rules[0].runs_calibrating:.0f} points)", *(f"{r.c:.2f}{'*' * r.at_edge}: {percent(r.rmsle_calibrating)}, "
                     f"{percent(r.rmsle_judging)}" for r in of_rules), f"{percent(there)}, {percent(other)}"))
    return table(("calibrated on", *(family.name.replace("phi", "φ") for family in FAMILIES), "half of tan φ'"), rows)


TEXTS = {
    "README.md": {"coefficients": lambda: headline(CAMPAIGNS), "stricter aims": lambda: stricter_aims("reproduction_w7"),
                  "intervals": lambda: intervals_hold(CAMPAIGNS), "numerics": lambda: ratios("reproduction_w5", "paired_summary"),
                  "numerics alone": lambda: numerics_alone("reproduction_w5"),
                  "numerics at 0.25 m": lambda: ratios("reproduction_w7", "paired_summary"),
                  "numerics at 0.25 m alone": lambda: numerics_alone("reproduction_w7"), "with coarser rows": lambda: with_coarser("prediction"),
                  "grids": lambda: ratios("reproduction_w7", "refined_summary"),
                  "grids alone": lambda: on_both_grids("reproduction_w7"), "grids of the prediction": lambda: kinds("prediction"),
                  "pile-up": lambda: pile_up({"reproduction_w7": "reproduction at 0.25 m", "reproduction_w5": "reproduction at w/5",
                                              "prediction": "prediction"})},
    "first_reproduction.md": {"coefficients": lambda: headline(FIRST)},
    "friction.md": {"design": lambda: friction_design("reproduction_w7"), "rules": lambda: friction_rules("reproduction_w7", EVERY_FRICTION),
                    "halves": lambda: friction_halves("reproduction_w7", EVERY_FRICTION), "rules of all": lambda: friction_rules("reproduction_w7", ALL),
                    "halves of all": lambda: friction_halves("reproduction_w7", ALL), "design at w/5": lambda: friction_design("reproduction_w5"),
                    "rules at w/5": lambda: friction_rules("reproduction_w5", ALL),
                    "halves at w/5": lambda: friction_halves("reproduction_w5", ALL)},
    "compressible_snow.md": {"compaction": lambda: compaction({"reproduction_w7": "reproduction at 0.25 m", "reproduction_w5": "reproduction at w/5",
                                                               "prediction": "prediction"})},
    "jams.md": {"without jams": lambda: without_jams({**FIRST, **CAMPAIGNS})},
}


def main():
    if sys.argv[1:] not in ([], ["--check"]):
        sys.exit(__doc__)
    stale = []
    for name, sections in TEXTS.items():
        path = STUDY / name
        before = path.read_text(encoding="utf-8")
        after = filled(path.relative_to(SOURCE), before, {marker: make() for marker, make in sections.items()})
        if after != before:
            stale.append(str(path.relative_to(SOURCE)))
            if not sys.argv[1:]:
                path.write_text(after, encoding="utf-8")
    if sys.argv[1:] and stale:
        sys.exit(f"{', '.join(stale)}: out of date; run validation/study/fill_tables.py")


if __name__ == "__main__":
    main()
