"""How far the study's coefficients can be trusted: both campaigns side by side, intervals, what decides them, jams, and the friction of the mast.

Every function takes a Study (page.py), and draws tables that tables.py calls evidence. Intervals are of 90 %.
"""

import numpy as np

from analysis.axes import Drawn, decades, froude_colour, number, per_cent, scatter_runs
from mpmtools.figures.style import COLOURS, MARKERS, new_axes, picture
from analysis.summary import NAMES, interval
from analysis.jams import LEAST_STATIC, LIMIT
from mpmtools.fit.regression import EQUATIONS

SYMBOLS = {"k_r": "$k_r$", "kappa_r": r"$\kappa_r$", "k_p": "$k_p$", "Fr_sat": r"$Fr_{sat}$", "kappa_p": r"$\kappa_p$"}
KINDS = (("standard_error", "its standard error"), ("profile", "profile of the sum of squares"), ("material", "bootstrap over materials"),
         ("froude", "bootstrap over Froude numbers"))
FITTED_AND_SCORED = [*NAMES.values(), "RMSLE of h_r", "within 25 %", "NRMSE of h_p"]  # head of the cells of _fitted_and_scored
TITLES = {equation.name: equation.title.lower() for equation in EQUATIONS}
NONE = ["no tables of evidence: `./run study` makes them from a table of runs"]


def _fitted_and_scored(row):
    """Cells of what coefficients_and_scores() gives: the five coefficients, and scores of the published equations."""
    return [*(number(row[name]) for name in SYMBOLS), per_cent(row["runup_rmsle"]), per_cent(row["runup_fraction_25"]),
            per_cent(row["pressure_height_nrmse"])]


def figure_campaigns(study):
    """Both campaigns on the same set-ups: heights with the numerical uncertainty as a band, and ratios."""
    rows, summary, coefficients = (study.table(name) for name in ("paired_rows", "paired_summary", "side_by_side"))
    if rows.empty:
        return Drawn([], ["no table of the prediction (--prediction)"])
    pictures = []
    for xi, of_xi in sorted(rows.groupby("hardening_xi"), reverse=True):
        for key, name, symbol in (("runup", "Run-up", "$h_r/H$"), ("pressure_height", "Pressure height", "$h_p/H$")):
            axes = new_axes(height=4.6)
            for froude, of in of_xi.sort_values("effective_friction").groupby("froude_number"):
                colour, x, y, band = froude_colour(froude), of.effective_friction, of[f"{key}_prediction"], of[f"{key}_numerical_uncertainty"]
                axes.fill_between(x, y - band, y + band, color=colour, alpha=0.2, linewidth=0)
                axes.plot(x, y, "o-", color=colour, markersize=4, linewidth=1.0, label=f"Fr = {froude:g}")
                axes.plot(x, of[f"{key}_reproduction"], "s", markerfacecolor="none", markeredgecolor=colour, markersize=5)
            if key == "runup":
                decades(axes, "y", of_xi[[f"{key}_prediction", f"{key}_reproduction"]].to_numpy().ravel())
            caption = ("Discs: prediction, with the numerical uncertainty of grid and time step that its runs state as a band. Squares: "
                       "reproduction of the same set-up on the same grid.")
            drawn = picture(axes, f"{name}, both campaigns, $\\xi$ = {xi:g}", "effective internal friction $M'$", symbol, caption, ncols=2,
                            fontsize=8)
            pictures.append(drawn._replace(title=f"{name}, both campaigns, ξ = {xi:g}"))
    ratios = [[r.group, r.quantity, f"{r.pairs:.0f}", number(r.ratio), per_cent(r.spread), number(r.lowest), number(r.highest)]
              for r in summary.itertuples()]
    sets = [[f"{name}, {fitting_set} ({_fitted_rows(of)})", *(_coefficient(of, p) for p in NAMES)]
            for (name, fitting_set), of in coefficients.groupby(["campaign", "fitting_set"], sort=False)]
    published = coefficients.groupby("parameter").published.first()
    sets.insert(0, ["published", *(number(published[p]) for p in NAMES)])
    return Drawn(pictures, [], [
        {"title": "Coefficients side by side, with 90 % of a bootstrap over materials", "head": ["campaign and fitting set", *NAMES.values()],
         "rows": sets},
        {"title": f"Paired rows: prediction over reproduction, {len(rows)} set-ups", "rows": ratios,
         "head": ["rows", "quantity", "pairs", "ratio (geometric mean)", "spread (standard deviation of the logarithm)", "lowest", "highest"]}])


def figure_grids(study):
    """The same runs on three grids, over their values on the finest."""
    table, summary = study.table("grids"), study.table("grids_summary")
    if table.empty:
        return Drawn([], ["no table of runs on three grids (--grids)"])
    pictures = []
    for quantity, rows in table.groupby("quantity", sort=False):
        axes = new_axes()
        for i, r in enumerate(rows.itertuples()):
            label = f"Fr {r.froude_number:g}, $M$ {r.critical_state_slope:g}, $\\beta$ {r.cohesion_beta:g}, $\\xi$ {r.hardening_xi:g}"
            axes.errorbar([r.cell_size_m_coarse, r.cell_size_m_middle, r.cell_size_m_fine], [r.coarse_over_fine, r.middle_over_fine, 1.0],
                          yerr=[r.ratio_standard_error, 0.0, 0.0], color=froude_colour(r.froude_number), capsize=2.5, linewidth=1.1,
                          marker=MARKERS[i % len(MARKERS)], markersize=4.5, label=label)
        axes.axhline(1.0, color="black", linewidth=0.9)
        axes.set_xlim(left=0.0)
        pictures.append(picture(axes, f"{quantity} on three grids", "cell size [m]", f"{quantity} over that of the finest grid",
                                "Bars: one standard error of the ratio of the coarsest to the finest.", fontsize=6.5, ncols=2))
    rows = [[r.quantity, f"{r.points:.0f}", f"{number(r.coarse_mean)} ({number(r.coarse_lowest, 2)} to {number(r.coarse_highest, 2)})",
             f"{number(r.middle_mean)} ({number(r.middle_lowest, 2)} to {number(r.middle_highest, 2)})", f"{r.with_order:.0f}", f"{r.covered:.0f}"]
            for r in summary.itertuples()]
    head = ["quantity", "points", "coarsest over finest grid (lowest to highest)", "middle over finest", "with an order of 0.5 to 1.5",
            "finest value within the uncertainty that the coarsest run states"]
    return Drawn(pictures, [], [{"title": "Over all points", "head": head, "rows": rows}])


def figure_refinement(study):
    """The set-ups that are there on two grids: the finest over the coarsest, over M' and by kind of snow."""
    rows, kinds = study.table("refined_rows"), study.table("refined_kinds")
    if rows.empty or kinds.empty:
        return Drawn([], ["no set-up on two grids (--finest, --coarser)"])
    fine, coarse = rows.cell_size_m_fine.unique(), rows.cell_size_m_coarse.unique()
    sizes = f"{fine[0]:g} m over {coarse[0]:g} m" if len(fine) == len(coarse) == 1 else "finest over coarsest grid"
    pictures = []
    for name, label in (("runup", "run-up"), ("pressure_height", "pressure height")):
        axes = new_axes()
        handles = scatter_runs(axes, rows.dropna(subset=[f"{name}_ratio"]), "effective_friction", f"{name}_ratio")
        axes.axhline(1.0, color="black", linewidth=0.9)
        pictures.append(picture(axes, f"{study.name}: {label} on a finer grid", "effective internal friction $M'$", f"{label}, {sizes}",
                                "Set-ups that have a steady mean, the same friction of the mast and the same duration on both grids.", handles=handles, ncols=2,
                                fontsize=7.5))
    table = [[r.kind, r.speeds, f"{r.fine:.0f} of {r.sets:.0f}", r.quantity, f"{r.pairs:.0f}",
              f"{number(r.ratio, 2)} ({number(r.lowest, 2)} to {number(r.highest, 2)})", "–" if np.isnan(r.covered) else f"{r.covered:.0f}"]
             for r in kinds.replace({"kind": {"xi <=": "ξ ≤"}}, regex=True).itertuples()]
    head = ["kind of snow", "speeds", "set-ups on the finer grid", "quantity", "pairs", "ratio (lowest to highest)",
            "pairs within the uncertainty that the coarser run states"]
    return Drawn(pictures, [], [{"title": f"{study.name}: {sizes}, by kind of snow", "head": head, "rows": table}])


def _without_unconverged(study):
    rows = [[r["without"] or "–", r["fitting_set"], f"{r['left_out']:.0f}", *_fitted_and_scored(r)]
            for r in study.table("coefficients_without_unconverged").fillna({"without": ""}).to_dict("records")]
    head = ["left out", "set", "runs left out", *FITTED_AND_SCORED]
    title = "Coefficients without some of the runs, and scores against the published equations"
    return {"title": title, "head": head, "rows": rows}


def _with_coarser(study):
    rows = [[r["rows"], r["fitting_set"], f"{r['runs']:.0f}", *_fitted_and_scored(r)] for r in study.table("coefficients_with_coarser").to_dict("records")]
    title = "Coefficients and scores with the coarser run of each set-up whose run on the finest grid has no steady mean"
    return {"title": title, "head": ["rows", "set", "runs", *FITTED_AND_SCORED], "rows": rows}


def _fitted_rows(rows):
    runs, of = rows.runs.max(), f"{rows.rows.iloc[0]:.0f} rows"
    return f"{runs:.0f} of {of}" if np.isfinite(runs) else of


def _coefficient(rows, parameter):
    row = rows[rows.parameter == parameter].iloc[0]
    return f"{number(row.value)} ({interval(row.material_from, row.material_to)})" if np.isfinite(row.value) else "too few rows"


def figure_intervals(study):
    table = study.table("coefficient_intervals")
    if table.empty:
        return Drawn([], NONE)
    pictures = []
    for fitting_set, rows in table.groupby("fitting_set", sort=False):
        axes = new_axes(height=4.6)
        for i, (kind, label) in enumerate(KINDS):
            at = np.arange(len(rows)) + 0.17 * (i - 1.5)
            low, high = (rows[f"{kind}_{end}"] / rows.published for end in ("from", "to"))
            value = rows.value / rows.published
            axes.errorbar(value, at, xerr=[(value - low).clip(lower=0), (high - value).clip(lower=0)], fmt=MARKERS[i], color=COLOURS[i],
                          markersize=4, capsize=2.5, linewidth=1.3, label=label)
        axes.axvline(1.0, color="black", linewidth=1.1)
        axes.set_yticks(range(len(rows)), [SYMBOLS[p] for p in rows.parameter])
        axes.set_ylim(len(rows) - 0.5, -0.5)
        runs = rows.runs.iloc[0]
        pictures.append(picture(axes, f"set '{fitting_set}', {runs} runs", "over the published value", "",
                                "Bars: 90 %. Line: the published value.", fontsize=8, loc="upper left", bbox_to_anchor=(0.0, -0.14), ncols=2))
    rows = [[c.fitting_set, c.parameter, number(c.value), interval(c.standard_error_from, c.standard_error_to),
             interval(c.profile_from, c.profile_to), interval(c.material_from, c.material_to), interval(c.froude_from, c.froude_to),
             number(c.jackknife_error), f"{number(c.lowest_without_one)} (without M' {number(c.lowest_without_material, 2)})",
             f"{number(c.highest_without_one)} (without M' {number(c.highest_without_material, 2)})", number(c.published)]
            for c in table.itertuples()]
    head = ["set", "coefficient", "value", "standard error", "profile", "materials", "Froude numbers", "jackknife error (materials)",
            "lowest without one material", "highest", "paper"]
    intervals = {"title": "Intervals of 90 %, and leaving one material out", "head": head, "rows": rows}
    return Drawn(pictures, [], [intervals, *_published_errors(study)])


def _published_errors(study):
    """For each design that the paper's fit may have, the residuals that its printed standard errors need: credible where they agree."""
    table = study.table("published_errors")
    if "needed_residual" not in table:
        return []
    rows = []
    for (equation, residuals, design), of in table.groupby(["equation", "residuals", "design"]):
        needed = of.needed_residual
        rows.append([TITLES[equation], residuals, f"{design} ({of.runs.iloc[0]:.0f} runs)",
                     ", ".join(f"{NAMES[p]} {number(value)}" for p, value in zip(of.parameter, needed)), number(needed.max() / needed.min(), 2)])
    head = ["equation", "residuals of", "design", "root mean square of the residuals that each printed error needs", "highest over lowest"]
    return [{"title": "The paper's own standard errors", "head": head, "rows": rows}]


def figure_influence(study):
    table, left = study.table("influence"), study.table("leave_one_out")
    if table.empty:
        return Drawn([], NONE)
    pictures = []
    chosen = left[(left.equation == "pressure_height") & (left.fitting_set == "narrow") & (left.left_out == "material")]
    for key, published in (("k", 0.5277), ("kappa", 1.3072)):
        axes = new_axes(height=3.6)
        axes.plot(chosen["at"], chosen[key], "o-", color=COLOURS[0], linewidth=1.2, label="one material left out")
        axes.axhline(published, color="black", linestyle="--", linewidth=1.1, label="published")
        pictures.append(picture(axes, f"{SYMBOLS[key + '_p']} without one material", "material left out, $M'$", SYMBOLS[key + "_p"]))
    rows = [[name.replace("_", " "), f"Fr {r.froude_number:g}, M' {number(r.effective_friction, 2)}, ξ {r.hardening_xi:g}",
             number(r.relative_height, 2), number(r.residual, 2), number(r.k_without), number(r.k_change, 2), number(r.kappa_without),
             number(r.kappa_change, 2)]
            for name, of in table.groupby("equation", sort=False) for r in of.head(6).itertuples()]
    head = ["equation", "run left out", "height over H", "residual", "k", "in standard errors", "κ", "in standard errors"]
    parts = [[r.part, r.fitting_set, f"{r.runs:.0f}", f"{number(r.k_r)} ± {number(r.k_r_standard_error)}",
              f"{number(r.kappa_r)} ± {number(r.kappa_r_standard_error)}"] for r in study.table("runup_parts").itertuples()]
    tables = [{"title": "The six runs that move κ most, narrow set", "head": head, "rows": rows},
              {"title": "The run-up equation fitted to parts of the runs, with standard errors", "rows": parts,
               "head": ["part", "set", "runs", NAMES["k_r"], NAMES["kappa_r"]]}, _without_unconverged(study), _with_coarser(study)]
    return Drawn(pictures, [], [table for table in tables if table["rows"]])


def figure_jams(study):
    table, scan = study.table("jams"), study.table("coefficients_without_jams")
    if table.empty:
        return Drawn([], NONE)
    axes = new_axes()
    for froude, of in table.groupby("froude_number"):
        axes.scatter(of.effective_friction, of.static_force, s=20, color=froude_colour(froude), label=f"Fr = {froude:g}", zorder=3)
    jammed = table[table.jammed == 1]
    axes.scatter(jammed.effective_friction, jammed.static_force, s=90, facecolors="none", edgecolors="#b3262e", linewidths=1.4, label="jammed",
                 zorder=4)
    drawn = [picture(axes, "Static force on the mast", "effective internal friction $M'$", "hydrostatic forces of the flow height",
                     f"Force less ρv²Hw. Rings: more than {LIMIT:g} times the least of the same snow at Fr ≥ 5.", ncols=2, fontsize=8, loc="upper left")]
    judged = table[np.isfinite(table.jam_index)].head(8)
    rows = [[f"Fr {r.froude_number:g}, M' {number(r.effective_friction, 2)}, ξ {r.hardening_xi:g}", number(r.force_over_hydrostatic, 0),
             number(r.static_force, 0), number(r.fast_static_force, 0), number(r.jam_index, 2), "left out" if r.jammed else "kept"]
            for r in judged.itertuples()]
    head = ["run", "force, hydrostatic", "static part", "of the same snow at Fr ≥ 5", "jam index", "by the rule"]
    scanned = [["none" if np.isinf(r["limit"]) else f"{r['limit']:g}", r["fitting_set"], f"{r['left_out']:.0f}", *_fitted_and_scored(r)]
               for r in scan.to_dict("records")]
    scan_head = ["limit of the jam index", "set", "runs left out", *FITTED_AND_SCORED]
    return Drawn(drawn, [], [{"title": "The eight highest jam indices", "head": head, "rows": rows},
                             {"title": "Coefficients with other limits, scores against the published equations", "head": scan_head,
                              "rows": scanned}])


def figure_friction(study):
    rules, scan = study.table("yardstick"), study.table("friction_scan")
    if scan.empty:
        return Drawn([], ["no table of runs with several frictions of the mast"])
    tables = []
    if len(rules):
        rows = [[r["rule"].replace("phi", "φ"), f"{r['runs']:.0f}", *(number(r[part], 2) for part in ("scores", "Fr", "xi", "M'", "distance")),
                 f"{number(r['behind'], 2)} ± {number(r['behind_error'], 2)}", per_cent(r["fluid_rmsle"]), "yes" if r["agrees"] else "no",
                 *(number(r[name]) for name in NAMES)] for r in rules.to_dict("records")]
        head = ["friction of the mast", "runs", "scores", "Fr", "ξ", "M'", "distance", "behind the nearest", "fluid off 1 + Fr²/2", "agrees", *NAMES.values()]
        tables.append({"title": "Distance of each rule to the paper, on the sets that all have", "head": head, "rows": rows})
        statements = study.table("yardstick_statements")
        rows = [[of.iloc[0]["where"], of.iloc[0]["equation"].replace("_", " "), text.replace("<=", "≤").replace(">=", "≥"), *(number(d, 2) for d in of.deviation)]
                for (_, _, text), of in statements.groupby(["part", "equation", "statement"], sort=False)]
        tables.append({"title": "Deviation from each score and sentence", "rows": rows,
                       "head": ["where", "equation", "score or sentence", *(rule.replace("phi", "φ") for rule in dict.fromkeys(statements.rule))]})
    return Drawn(_scan_pictures(scan), [], tables)


def _scan_pictures(scan):
    """Run-up over friction of the mast, for the weakest, a middle and the stiffest snow that has friction."""
    materials = sorted(m for m in scan.effective_friction.round(6).unique() if m > 0.0)
    pictures = []
    for friction in dict.fromkeys((materials[0], materials[len(materials) // 2], materials[-1])):
        axes = new_axes()
        of_snow = scan[np.isclose(scan.effective_friction, friction, atol=1e-6)]
        styles = dict(zip(sorted(of_snow.hardening_xi.unique(), reverse=True), ("-", "--", ":", "-.")))
        for (froude, xi), of in of_snow.sort_values("obstacle_friction").groupby(["froude_number", "hardening_xi"]):
            axes.plot(of.obstacle_friction, of.runup_over_half, styles[xi], marker="o", ms=4, color=froude_colour(froude),
                      label=f"Fr = {froude:g}" + (f", $\\xi$ = {xi:g}" if len(styles) > 1 else ""))
        half = of_snow.half.iloc[0]
        axes.axvline(half, color="0.6", lw=0.8, ls="--", label="half of tan φ'")
        axes.axhline(1.0, color="0.6", lw=0.8)
        low, high = axes.get_ylim()
        axes.set_ylim(low, high + 0.3 * (high - low))  # room for the legend
        pictures.append(picture(axes, f"Run-up and friction of the mast, M' = {friction:.2f}", "friction of the mast",
                                "run-up over that with half of tan φ'", "Runs without a steady mean are left out.", ncols=2, fontsize=8, handlelength=3.5))
    return pictures


OF_EACH_STUDY = [
    ("refinement", "What a finer grid changes, by kind of snow", figure_refinement,
     "The same set-ups on two grids. A set-up is of the first kind that holds it: fluids, stiff snow (M' > 1.5), cohesive snow with ξ ≤ 0.5, and "
     "all other snow. The last column counts the pairs where the uncertainty that the run on the coarser grid states, and two standard errors "
     "of the difference, cover the value on the finer grid."),
]
SECTIONS = [
    ("campaigns", "Reproduction and prediction side by side", figure_campaigns,
     "*Reproduction*: contact on nodes, as in the algorithm that the paper follows, and APIC; the paper does not name its transfer. "
     "*Prediction*: contact at the true position of the wall, and AFLIP. Snow, flow, mast and grid are the same, so that only the numerics differ. "
     "A coefficient depends on which runs are fitted: the rows marked *paired* hold the sets that both campaigns have with the same friction "
     "of the mast and the same duration. Coefficients are given from three Froude numbers and four materials on."),
    ("grids", "Prediction on three grids", figure_grids,
     "Points over the regimes, computed with the accurate solver on three grids. Points without a steady mean on one of them are left out. "
     "The run-up of cohesive snow with ξ = 0.5 is about a fifth lower on the coarsest grid than on the finest. A run on one grid states an "
     "uncertainty that comes from grid studies; the last column counts the points where the value on the finest grid lies within it (and two "
     "standard errors of the difference). These uncertainties are from versions that did not yet know stiff snow; most did not depend on the kind of snow."),
    ("intervals", "How well the coefficients are known", figure_intervals,
     "The standard errors of a fit take its residuals to be independent. All runs of one material (one M') err together, and so do all runs "
     "of one Froude number: therefore whole materials and whole Froude numbers are drawn anew (bootstrap) and left out (jackknife). The last "
     "table asks which design and which kind of residual the paper's printed standard errors belong to: those for which every coefficient of an "
     "equation needs the same residual. That is probably a fit without the fluid, and, for the run-up, to h/H, though the paper says that it was to its logarithm."),
    ("influence", "Which runs decide", figure_influence,
     "Each run and each material is left out in turn. k_p and κ_p compensate each other; the first table tells which runs move κ most. "
     "The second asks whether one k_r holds for loose and stiff, for slow and fast snow. The third leaves out whole kinds of snow."),
    ("jams", "Runs that jam, and what they do to the coefficients", figure_jams,
     f"A run below Fr 5 counts as jammed if its static force is more than {LIMIT:g} times the least of the same snow at Fr ≥ 5, and more than "
     f"{LIMIT:g} × {LEAST_STATIC:g} hydrostatic forces: layers that enter at the inlet then push the snow against the mast, and the result "
     "depends on the length of the window. The rule and its limit were chosen on the first reproduction, after its heights had been seen. Headlines show the coefficients "
     "with and without such runs. The stiffest snow, M' = 2.3, has a window of twice the length, because it jams in the usual one."),
    ("mast-friction", "Friction of the mast: how far each rule is from the paper", figure_friction,
     "The paper does not print the friction of its mast. Each rule for it is judged by the scatter of its runs about their own fit, against the paper's "
     "eight scores and the sentences of its Appendix A3 (validation/study/choices.md): a deviation of 1 is one unit, zero is inside. The pictures show "
     "what the friction does to the run-up."),
]
