"""The tables of this study that its texts quote (tables/*.csv), made from its rows. The first column, `key`, names a row.

Every function returns a DataFrame. Heights are over H, ratios plain numbers, intervals those of 90 % of a bootstrap over kinds of snow.
"""

import functools
import subprocess

import numpy as np
import pandas as pd

from analysis import grids, jams, loads, rheology, sensitivity, yardstick
from analysis.campaigns import paired_rows, paired_summary
from analysis.fits import score_against_published
from analysis.refinement import refinement_tables
from analysis.study import CAMPAIGNS, ROWS, STUDY, rows, runs_of
from analysis.uncertainty import bootstrap, drawn_interval
from mpmtools import equations
from mpmtools.fit.fits import NARROW, WIDE, height_samples
from mpmtools.fit.regression import EQUATIONS, RUNUP, fit_heights
from mpmtools.fit.runs import POINT, read_runs_or_refuse, read_study_table
from mpmtools.scores import compute_scores, same_input
from mpmtools.tables import numbers, read_table

SETS = {"": lambda runs: runs[NARROW.holds(runs) & (runs.effective_friction > 0.0)], "_fluid": lambda runs: runs[NARROW.holds(runs)],
        "_wide": lambda runs: runs[WIDE.holds(runs) & (runs.effective_friction > 0.0)]}
SHORT = {"runup": "r", "pressure_height": "p"}


@functools.cache
def coefficients():
    """Both equations fitted to each campaign: narrow set without the fluid (key `reproduction`), with it (`_fluid`), wide without it (`_wide`).
    Coefficients, intervals, relative difference from the paper's (`_off`); scores of the own fit, and of the published equation (`_published`)."""
    paper = {"key": "paper", "runs": np.nan}
    for e in EQUATIONS:
        paper |= {name: value for name, (value, *_) in e.published_estimates.items()}
        paper |= {f"{name}_{SHORT[e.name]}": e.published_scores[source] for name, source in _scores(e)}
    found = [paper]
    for campaign in CAMPAIGNS:
        runs = runs_of(campaign)
        found += [{"key": campaign + suffix, **_fitted(chosen(runs))} for suffix, chosen in SETS.items()]
    return pd.DataFrame(found)


def _scores(equation):
    return (("error", equation.score), ("bias", "bias"), ("within_10", "fraction_10"), ("within_25", "fraction_25"))


def _fitted(runs):
    row = {"runs": len(runs)}
    for e in EQUATIONS:
        samples = height_samples(e, runs).reset_index(drop=True)
        fit = fit_heights(e, samples, with_profile=False)
        drawn = bootstrap(e, samples, "effective_friction")
        for i, (name, estimate) in enumerate(fit.estimates.items()):
            low, high = drawn_interval(drawn[:, i])
            row |= {name: estimate.value, f"{name}_from": low, f"{name}_to": high, f"{name}_off": estimate.value / e.published_estimates[name][0] - 1.0}
        own = compute_scores(samples.relative_height, equations.relative_height(samples.effective_friction, samples.froude_number, fit.coefficients))
        theirs = score_against_published(e, samples)
        row |= {f"{name}_{SHORT[e.name]}": own[source] for name, source in _scores(e)}
        row |= {f"{name}_{SHORT[e.name]}_published": theirs[source] for name, source in _scores(e)}
    return row


def aims():
    """The aims of the reproduction (narrow set within 10 %, wide within 15 %, both without the fluid; RMSLE of the own fit within 2 points of the
    paper's; NRMSE at most the paper's): what each campaign has, and 1 where it is met."""
    table, found = coefficients().set_index("key"), []
    for name in (name for e in EQUATIONS for name in e.parameters):
        for suffix, limit in (("", 0.10), ("_wide", 0.15)):
            found.append({"key": name + suffix, "limit": limit, **_aim(table, suffix, f"{name}_off", lambda v, limit=limit: abs(v) <= limit)})
    found.append({"key": "rmsle", "limit": 0.02, **_aim(table, "", "error_r", lambda v: abs(v - RUNUP.published_scores["rmsle"]) <= 0.02)})
    found.append({"key": "nrmse", "limit": 0.066, **_aim(table, "", "error_p", lambda v: v <= 0.066)})
    return pd.DataFrame(found)


def _aim(table, suffix, column, met):
    values = {campaign: table.loc[campaign + suffix, column] for campaign in ("reproduction", "prediction")}
    return {key: of for campaign, value in values.items() for key, of in ((campaign, value), (f"{campaign}_met", int(met(value))))}


def campaigns():
    """Rows of each campaign: sets, those without a steady mean, commits that computed them (and how many rows each), jams by rule."""
    found = []
    for name, campaign in CAMPAIGNS.items():
        table = read_study_table(campaign.files)
        unsteady = sum(number for reason, number in table.left_out.items() if "steady" in reason)
        jammed = jams.jam_indices(table.runs)
        found.append({"key": name, "sets": len(table.runs) + unsteady, "unsteady": unsteady,
                      "jams": int(jammed.jammed.sum()), "jams_stiffest": int((jammed.jammed & (jammed.effective_friction > 2.2)).sum()),
                      "highest_runup_peak": table.runs.runup_peak.max(), "highest_pressure_height": table.runs.pressure_height.max()})
    return pd.DataFrame(found)


def provenance():
    """Files of rows: number of rows, and the commits of the program that computed them, newest last."""
    found = []
    for path in sorted(ROWS.glob("*.csv")):
        table = read_table(str(path))
        if "commit" in table:
            counts = table.commit.value_counts()
            order = sorted(counts.index, key=_commit_time)
            found.append({"key": path.stem, "rows": len(table), "commits": ", ".join(f"{commit} ({counts[commit]})" for commit in order)})
    return pd.DataFrame(found)


def _commit_time(commit):
    found = subprocess.run(["git", "-C", STUDY, "log", "-1", "--format=%ct", commit], capture_output=True, text=True, check=False).stdout.strip()
    return int(found or 0)


def friction():
    """The yardstick on the rows that there are."""
    summary = yardstick.friction_tables(read_runs_or_refuse(CAMPAIGNS["reproduction"].compared["friction_files"]).runs)["yardstick"]
    return summary.rename(columns={"rule": "key"})


def friction_reuse():
    """Height with 0.2 or 0.3 over that with half of tan(phi') for slow loose snow: the rows that stand for any rule (yardstick.LOOSE, SLOW)."""
    scan = yardstick.friction_scan(read_runs_or_refuse(rows("friction_scan", "reproduction")).runs)
    at_half = scan[np.isclose(scan.obstacle_friction, scan.half, atol=1e-4)].set_index(POINT).pressure_height
    scan = scan.join(at_half.rename("pressure_at_half"), on=POINT)
    scan = scan[(scan.froude_number <= 1.0) & (scan.effective_friction <= yardstick.LOOSE) & scan.obstacle_friction.round(3).isin([0.2, 0.3])]
    found = []
    for key, of in (("frictional", scan[scan.effective_friction > 0.0]), ("fluid", scan[scan.effective_friction == 0.0])):
        ratios = {"runup": of.runup_over_half, "pressure_height": of.pressure_height / of.pressure_at_half}
        found.append({"key": key, "pairs": len(of), **{f"{q}_{end}": getattr(r, end)() for q, r in ratios.items() for end in ("min", "max")}})
    return pd.DataFrame(found)


CHOICES = {  # label: (file, column of the choice, its value)
    "slope_30": ("sensitivity", "numerics.slope_deg", "30"),
    "walls_slip": ("sensitivity", "conveyor.sidewall_contact", "slip"),
    "cells_w7": ("sensitivity", "cell_size_m", "0.25"),
    "particles_27": ("sensitivity", "numerics.particles_per_cell", "27"), "cfl_02": ("sensitivity", "numerics.cfl", "0.2"),
    "window_long": ("sensitivity", "conveyor.upstream_length_m, conveyor.downstream_length_m", "12.6, 5.6"),
    **{f"friction_{key}": ("sensitivity", "obstacle_friction", key) for key in ("0", "0.3", "0.5")}}


def choices():
    """One choice at a time, over the base at the same points: geometric mean, lowest and highest of each quantity, and the RMSLE of the run-up from
    the published equation with that of the base."""
    summaries = {name: sensitivity.sensitivities(str(ROWS / f"{name}.csv")).summaries for name in ("sensitivity",)}
    found = []
    for key, (file, column, value) in CHOICES.items():
        of = summaries[file]
        found.append({"key": key, **of[(of.choice == column) & (of["value"].astype(str) == value)].iloc[0].drop(["choice", "value"])})
    transfer, time_step = (read_table(str(ROWS / f"{name}.csv")) for name in ("transfer", "time_step"))
    transfer = transfer[transfer["numerics.precision"] == "single"]
    found += [_over(transfer, key, *pair) for key, pair in {
        "flip": ({"numerics.transfer": "flip"}, {"numerics.transfer": "apic", "conveyor.lattice": "staggered"}),
        "aflip": ({"numerics.transfer": "aflip"}, {"numerics.transfer": "apic", "conveyor.lattice": "staggered"}),
        "aligned": ({"conveyor.lattice": "aligned"}, {"numerics.transfer": "apic", "conveyor.lattice": "staggered"})}.items()]
    found += [_over(time_step, f"cfl_08_{name}", {"campaign": name, "numerics.cfl": "0.8"}, {"campaign": name, "numerics.cfl": "0.4"})
              for name in ("reproduction", "prediction")]
    default = pd.concat([read_table(str(ROWS / f"{name}.csv")).assign(cfl=cfl) for name, cfl in (("prediction_w5", 1), ("time_step_08", 0.8))])
    found.append(_over(default, "cfl_1_prediction", {"cfl": 1}, {"cfl": 0.8}))
    return pd.DataFrame(found)


def _over(table, key, changed, base):
    """Geometric mean, lowest and highest of the rows of a table that are `changed`, over those of the same point that are `base`."""
    def chosen(conditions):
        of = table[np.logical_and.reduce([table[column] == value for column, value in conditions.items()])]
        of = of.assign(**{point: numbers(of, point).round(9) for point in POINT})
        return of.drop_duplicates(POINT).set_index(POINT)

    a, b = chosen(changed), chosen(base)
    both = a.join(b, rsuffix="_base", how="inner")
    row, columns = {"key": key, "points": len(both)}, {"runup": "runup_mean_m", "pressure_height": "pressure_height_mean_m", "force": "force_mean_n.x"}
    for quantity, column in columns.items():
        ratio = (numbers(both, column) / numbers(both, column + "_base")).dropna()
        row |= {quantity: np.exp(np.log(ratio).mean()), f"{quantity}_low": ratio.min(), f"{quantity}_high": ratio.max()}
    for which, suffix in (("runup_rmsle", ""), ("base_runup_rmsle", "_base")):
        log = np.log(numbers(both, "runup_mean_m" + suffix) / numbers(both, "predicted_runup_m"))
        row[which] = np.sqrt(np.mean(log.dropna()**2))
    return row


def numerics():
    """Prediction over reproduction at w/5, same friction and duration, by Froude number and over all."""
    return _wide_ratios(paired_summary(paired_rows(runs_of("reproduction_w5"), runs_of("prediction"))), "group")


def _wide_ratios(summary, *by):
    """A row for each group with the columns of all quantities."""
    found = []
    for key, of in summary.groupby(by[0] if len(by) == 1 else list(by), sort=False):
        row = {"key": ", ".join(map(str, key)) if isinstance(key, tuple) else str(key), "pairs": int(of.pairs.max())}
        for r in of.itertuples():
            short = r.quantity.replace("run-up", "runup").replace(" ", "_")
            row |= {short: r.ratio, f"{short}_low": r.lowest, f"{short}_high": r.highest}
        found.append(row)
    return pd.DataFrame(found)


def grid():
    """A finer grid over a coarser one: with an earlier solver 0.25 m over w/5 by kind of snow (and how many run-ups lie within the uncertainty
    that w/5 states); with today's the points on three grids."""
    table = read_study_table(rows("earlier_grids"), finest=True)
    kinds = refinement_tables(pd.concat([table.runs, table.coarser], ignore_index=True))["refined_kinds"]
    found = _wide_ratios(kinds, "kind", "speeds")
    of_runup = kinds[kinds.quantity == "run-up"]
    found["covered"] = of_runup.covered.to_numpy()
    summary = grids.grid_tables(rows("grids"))["grids_summary"].set_index("quantity")
    three = {"key": "w/5 over w/10", "pairs": int(summary.points.max())}
    for quantity, r in summary.iterrows():
        short = quantity.replace("run-up", "runup").replace(" ", "_")
        three |= {short: r.coarse_mean, f"{short}_low": r.coarse_lowest, f"{short}_high": r.coarse_highest}
    return pd.concat([found, pd.DataFrame([three])], ignore_index=True)


def pile_up():
    """(h/H - 1)/M' at Fr 0.1 and xi = 5, which the equations take to be one number k: a row for each height and campaign, a column for each M'."""
    found = []
    for name in ("reproduction", "prediction"):
        runs = runs_of(name)
        slow = runs[same_input(0.1, runs.froude_number) & same_input(5.0, runs.hardening_xi) & (runs.effective_friction > 0.0)].sort_values("effective_friction")
        for e in EQUATIONS:
            found.append({"key": f"{name}_{SHORT[e.name]}", **{f"{m:.2f}": k for m, k in zip(slow.effective_friction, (slow[e.name] - 1.0) / slow.effective_friction)}})
    return pd.DataFrame(found)


def windows():
    """M' = 2.3, xi = 5 in windows of one, two and four times the length, w/5: force over that of the longest, heights; and a strip at Fr 1."""
    table = pd.read_csv(ROWS / "window_means.csv", comment="#")
    table = table[(table.conveyor_width_m == 21) & (table.sidewall_contact == "no_slip") & table.feed.str.startswith("window")]
    lengths = {"window, 8.4 m + 4.2 m": "1", "window, 16.8 m + 8.4 m": "2", "window, 33.6 m + 16.8 m": "4"}
    found = []
    for (friction, froude), of in table.groupby(["effective_friction", "froude_number"]):
        of = of.assign(length=of.feed.map(lengths)).set_index("length")
        row = {"key": f"{friction:.2f} {froude:g}"}
        for length in of.index:
            row |= {f"force_{length}": of.force_n[length] / of.force_n["4"], f"runup_{length}": of.runup[length], f"pressure_height_{length}": of.pressure_height[length]}
        found.append(row)
    return pd.DataFrame(found)


def strips():
    """The paper's strip over a window of four times the usual length, over the same time: Fr 1 (155 m) and 0.3 (71 m); M' 1.2 to 2.3."""
    table = pd.read_csv(ROWS / "strip_means.csv", comment="#")
    found = []
    for froude, of in table.groupby("froude_number"):
        strip = of[of.feed.str.startswith("strip")].sort_values("feed").drop_duplicates("effective_friction", keep="last").set_index("effective_friction")
        window = of[of.feed.str.startswith("window, 33.6")].set_index("effective_friction")
        both = strip.join(window, rsuffix="_window", how="inner")
        row = {"key": f"{froude:g}", "kinds": len(both)}
        for name, column in (("runup", "runup"), ("force", "force_n")):
            ratio = both[column] / both[f"{column}_window"]
            row |= {f"{name}_low": ratio.min(), f"{name}_high": ratio.max()}
        found.append(row)
    return pd.DataFrame(found)


def compaction():
    """Fast compressible snow: what is left of the head of the least compressible snow, what a compaction shock leaves, and the rms difference."""
    table = rheology.compaction_summary(rheology.compaction_losses(runs_of("reproduction")))
    keys = [f"{'cohesive' if r.cohesive else 'loose'} {'all' if np.isnan(r.hardening_xi) else f'{r.hardening_xi:g}'}" for r in table.itertuples()]
    return table.assign(key=keys)[["key", *table.columns.drop("cohesive")]]


def fluid():
    """The least compressible fluid (beta = 0, xi = 5) over 1 + Fr^2/2 at each Froude number, and its RMSLE over all."""
    found = []
    for name in CAMPAIGNS:
        runs = runs_of(name)
        of = runs[(runs.effective_friction == 0.0) & same_input(0.0, runs.cohesion_beta) & same_input(5.0, runs.hardening_xi)]
        ratio = of.runup / equations.bernoulli_height(of.froude_number)
        found.append({"key": name, "rmsle": np.sqrt(np.mean(np.log(ratio)**2)), **{f"{froude:g}": r for froude, r in sorted(zip(of.froude_number, ratio))}})
    return pd.DataFrame(found)


def parts():
    """The run-up coefficients of parts of the reproduction, narrow set without the fluid: loose and stiff snow, without M' = 2.3."""
    runs = SETS[""](runs_of("reproduction"))
    chosen = {"loose": runs.effective_friction < 0.9, "stiff": runs.effective_friction > 0.9, "without 2.3": runs.effective_friction < 2.2,
              "converged": ~np.any([holds(runs) for holds in grids.UNCONVERGED.values()], axis=0)}
    return pd.DataFrame([{"key": key, **_fitted(runs[of])} for key, of in chosen.items()])


def mast_heights():
    """Masts of other heights: force over that on the tallest, for each Froude number."""
    table = pd.read_csv(ROWS / "height.csv", comment="#")
    found = []
    for height, of in table.groupby("obstacle.height_m"):
        row = {"key": f"{height / 1.75:.1f}"}
        for r in of.to_dict("records"):
            tallest = table[table.froude_number == r["froude_number"]].sort_values("obstacle.height_m").iloc[-1]
            row[f"{r['froude_number']:g}"] = r["force_mean_n.x"] / tallest["force_mean_n.x"]
        found.append(row)
    return pd.DataFrame(found)


def first_impact():
    """The filtered peak of the first impact over the mean force, and the part of the force above the pressure height, on the tallest mast."""
    table = pd.read_csv(ROWS / "height.csv", comment="#")
    found = []
    for froude, of in table.groupby("froude_number"):
        r = of.sort_values("obstacle.height_m").iloc[-1]
        found.append({"key": f"{froude:g}", "peak": r["force_filtered_peak_to_mean"], "above": r["force_above_pressure_height_n"] / r["force_mean_n.x"],
                      "resultant": r["force_resultant_height_m"] / 1.75})
    return pd.DataFrame(found)


def widths():
    """Heights at masts of other widths over those at w = H, lowest and highest over Fr 1 to 5, and the guideline's factor."""
    from analysis.width import width_factors

    table = width_factors(read_study_table(rows("width")).runs)
    found = []
    for (slope, width), of in table[~same_input(table.relative_width, 1.0)].groupby(["critical_state_slope", "relative_width"]):
        row = {"key": f"{slope:g} {width:g}", "guideline": of.guideline.iloc[0]}
        for name in ("runup", "pressure_height"):
            row |= {f"{name}_low": of[f"{name}_factor"].min(), f"{name}_high": of[f"{name}_factor"].max()}
        found.append(row)
    return pd.DataFrame(found)


def costs():
    """Core hours that the program expects of the plans that are to be computed."""
    return pd.read_csv(ROWS / "costs.csv", comment="#")


TABLES = {f.__name__: f for f in (coefficients, aims, campaigns, provenance, friction, friction_reuse, choices, numerics, grid, pile_up, windows, strips,
                                  compaction, fluid, parts, mast_heights, first_impact, widths, costs, loads.load_factors)}
TABLES["load_factors_over_snow"] = lambda: loads.over_snow(loads.load_factors())
