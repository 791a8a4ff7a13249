"""Tables of the page: {"head": [...], "rows": [[...]]} of text."""

import math

import numpy as np

from mpmtools.design import comparison
from mpmtools.design.factors import CONDITIONS, load_factors, outside, over_snows
from mpmtools.design.results import LATER, LATERAL, LINE_LOADS, STATIC_FORCES, is_oblique, quantities_of
from mpmtools.design.rounding import UNKNOWN, downward, number, outward, percent, short, upward, value_and_error, with_unit


STAR = " *"  # behind an uncertainty that may be greater: Entry.at_least


def with_unit_of(quantity, text):
    return f"{text} ({quantity.unit})" if quantity.unit else text


def load_table(ensemble, results):
    plan = ensemble.plan
    head = ["quantity"] + [ensemble.label(i) for i in range(len(plan["snows"]))] + ["range with uncertainty"]
    rows = []
    for q in results.shown(plan):
        r = results.ranges[q.key]
        high = short if r.high == ensemble.bound else upward  # a bound is exact
        rows.append([with_unit_of(q, q.label), *(value_and_error(e.value, e.total, q.scale) + STAR * e.at_least for e in (row[q.key] for row in results.table)),
                     f"{downward(r.low, q.scale)} to {high(r.high, q.scale)}{STAR * r.at_least}" if math.isfinite(r.high) else UNKNOWN])
    return {"head": head, "rows": rows}


def line_load_table(results, plan, blocks=10):
    """Mean load in blocks of equal height, kN/m, and force and moment of the whole."""
    low, high, loads, arm = results.line_loads(plan)
    if not loads:
        return {"head": ["z (m)"], "rows": []}
    arms = [arm.get(name, (0.0, 0.0)) for name in loads]
    step = high[0] - low[0]
    centre = 0.5 * (low + high)
    most = max(np.max(np.cumsum(np.abs(q))) for q in loads.values())
    loaded = [np.flatnonzero(np.abs(q) > 1e-4 * most)[-1] for name, q in loads.items() if name != "with_vibration"]
    static_top = high[max(loaded)]
    edges = list(np.linspace(0.0, static_top, blocks + 1))
    if "with_vibration" in loads and plan["mast"]["height_m"] and plan["mast"]["height_m"] > static_top:
        edges += list(np.linspace(static_top, plan["mast"]["height_m"], 4))[1:]
    rows = []
    for bottom, top in zip(edges[:-1], edges[1:]):
        carried = [np.diff(np.interp([bottom, top], np.append(low, high[-1]), np.append(0.0, np.cumsum(q * step))))[0] for q in loads.values()]
        rows.append([f"{bottom:.2f} to {top:.2f}", *(number(1e-3 * of / (top - bottom), ".1f") for of in carried)])
    if arm:
        rows.append(["in addition on the arm"] + [f"{short(force, 1e-3)} kN at {number(at, '.2f')} m" for force, at in arms])
    stars = [STAR * results.is_at_least((f"force_{name}_n", f"moment_{name}_n_m")) for name in loads]
    rows.append(["force (kN)"] + [upward(q.sum() * step + force, 1e-3) + star for q, (force, _), star in zip(loads.values(), arms, stars)])
    rows.append(["moment (kN m)"] + [upward(q @ centre * step + force * at, 1e-3) + star for q, (force, at), star in zip(loads.values(), arms, stars)])
    return {"head": ["z (m), load in kN/m"] + [LINE_LOADS[name] for name in loads], "rows": rows}


def reaction_table(ensemble, results):
    """What the foundation feels, over all snows on the finest grid."""
    units = {q.key: q.unit for q in quantities_of(ensemble.plan)}

    def cells(*keys):
        return [with_unit(upward(results.ranges[k].high, 1e-3), units[k]) + STAR * results.ranges[k].at_least if k in results.ranges else UNKNOWN for k in keys]

    def vertical(select):
        parts = [loads.vertical[where] for loads in results.finest if (where := select(loads)).any()]
        return f"{outward(min(map(np.min, parts)), max(map(np.max, parts)), 1e-3)} kN" if parts else UNKNOWN

    rows = []
    cases = [("steady mean", "mean", "", lambda l: l.steady), ("steady peak (0.1 s)", "steady_peak", "steady_peak", lambda l: l.steady),
             ("first impact (0.1 s)", "first_impact", "first_impact", lambda l: l.impact)]
    if "later_peak" in results.peaks:
        cases.append((f"{LATER} (0.1 s)", "later_peak", "later_peak", lambda l: ~l.impact))
    if ensemble.plan["modes"]:
        cases += [("with vibration, first impact included", "with_vibration", "", lambda l: l.time > 0.0),
                  ("with vibration, while steady", "with_vibration_steady", "", lambda l: l.steady)]
    for name, which, lateral, select in cases:
        row = [name, *cells(f"force_{which}_n", f"moment_{which}_n_m"), vertical(select)]
        rows.append(row + (cells(*(f"{key}_{lateral}" for key, _, _ in LATERAL)) if is_oblique(ensemble.plan) else []))
    return {"head": ["case", "force downstream", "overturning moment", "vertical force, upward positive"]
            + (["lateral force", "moment of the lateral force", "torsion"] if is_oblique(ensemble.plan) else []), "rows": rows}


def front_table(ensemble, results):
    """Force and moment at the foundation for fronts that rise to full depth over some depths; values of the governing snow."""
    plan = ensemble.plan
    if not plan["modes"]:
        return None
    loads = results.finest[results.governing("moment_with_vibration_n_m")]
    rows = []
    for depths in (0, 1, 2, 5):
        time = depths * plan["flow"]["depth_m"] / plan["flow"]["velocity_m_s"]
        found = loads.with_vibration(plan, front=max(1, round(time / loads.interval)))
        factors = ", ".join(number(amplification, ".2f") for _, amplification in found["modes"].values())
        rows.append(["vertical, ideal: upper bound" if depths == 0 else f"rises over {depths} H ({depths * plan['flow']['depth_m']:.3g} m, {time:.2g} s)",
                     factors, short(np.max(found["force"]), 1e-3), short(np.max(found["moment"]), 1e-3)])
    return {"head": ["front", "amplification of the modes' own part", "force (kN)", "moment (kN m)"], "rows": rows}


def guideline_load_table(results, plan):
    """Loads of the guideline beside the computed ones."""
    of_mast = "mast_" if "arm" in plan else ""
    mean, moment = results.ranges[f"{of_mast}force_mean_n"], results.ranges[f"{of_mast}moment_mean_n_m"]
    rows = [[row.what, short(row.extent), short(row.force, 1e-3), short(row.moment, 1e-3), short(mean.high / row.force), row.source]
            for row in comparison.guideline_loads(plan)]
    drag = results.ranges["drag_coefficient"]
    rows.append([f"computed{', without the arm' if of_mast else ''}, steady mean, upper value (c_D over w H: {comparison.span(drag.lowest, drag.highest)}, upper {number(drag.high, '.2g')})",
                 *(upward(r.high, scale) + STAR * r.at_least for r, scale in ((results.ranges["pressure_height_mean_m"], 1.0), (mean, 1e-3), (moment, 1e-3))), "1" if math.isfinite(mean.high) else UNKNOWN, "this page"])
    return {"head": ["load", "reaches to (m)", "force (kN)", "moment (kN m)", "computed / this", "source"], "rows": rows}


def comparison_table(ensemble, results):
    """Simulated heights beside the paper's equations, for each snow."""
    rows = [[ensemble.label(snow), short(entries["runup_mean_m"].value), short(equation["runup_m"]),
             short(entries["pressure_height_mean_m"].value), short(equation["pressure_height_m"])]
            for snow, (entries, equation) in enumerate(zip(results.table, comparison.equation_rows(ensemble.plan)))]
    by = "by Eqs. 7 to 10, extrapolated" if comparison.equation_remarks(ensemble.plan) else "by Eqs. 7 to 10"
    return {"head": ["snow", "highest particle (m), computed", by, "pressure height (m), computed", by], "rows": rows}


def snow_table(plan):
    head = ["snow", "M", "β", "ξ", "M'", "source"]
    keys = ("critical_state_slope", "cohesion_beta", "hardening_xi", "effective_friction")
    rows, known = [], None
    for s in plan["snows"]:
        source = s["source"] or "given in the site file"
        rows.append([s["name"].replace("_", " "), *(f"{s[key]:.3g}" for key in keys), "as above" if source == known else source])
        known = source
    return {"head": head, "rows": rows}


def grid_table(ensemble, results):
    """Values on the grids; how the uncertainty was found is in notes under the table, each once."""
    plan = ensemble.plan
    head = ["quantity and snow"] + [f"{g['cells']} cells, {g['cell_size_m']:.3g} m" for g in plan["grids"]] + ["order", "GCI", "known", "taken", "note"]
    rows, notes = [], []
    for q in results.shown(plan):
        for snow, row in enumerate(results.table):
            e = row[q.key]
            if not math.isfinite(e.value) or e.value == 0.0:
                continue
            shares = [percent(part / abs(e.value)) for part in (e.gci, e.known, e.grid)]
            if e.method not in notes:
                notes.append(e.method)
            rows.append([with_unit_of(q, f"{q.label}, {ensemble.label(snow)}"), *(short(v, q.scale) for v in e.by_grid), number(e.order, ".1f"), *shares,
                         f"{notes.index(e.method) + 1}"])
    return {"head": head, "rows": rows, "notes": notes}


FACTORS = {  # kind: heading, column of each quantity, what its factors are
    "arm": ("Elements that protrude", {"drag": "drag (kPa)", "peak_drag": "peak drag (kPa)", "lift": "lift (kPa)", "peak_lift": "peak lift (kPa)"},
            "Pressure over the front of what protrudes, for the snow that gives most, scaled from runs with an arm three mast widths long and half a flow depth thick on a "
            "square mast as wide as the flow is deep. Drag is downstream, lift upwards; peaks are over 0.1 s. No grid study tells how uncertain they are"),
    "shape": ("Other cross-sections", {"force": "force", "moment": "moment", "runup": "run-up", "pressure_height": "pressure height"},
              "Over the value of a square that faces the flow, of the same width across it; lowest to highest over the snows, uncertainty added. Degrees: of a square against "
              "the flow, of a wedge half the angle of its edge"),
    "front": ("Other fronts and sheared flow", {"peak_force": "peak over mean force", "lever_arm": "lever arm over H", "moment_over_plug": "moment over plug's",
                                                "runup_over_plug": "run-up over plug's"},
              "Degrees of the front, and slip, the speed at the floor over the mean: 1 is a plug, as on this page. Peaks are over 0.1 s; lever arm, and moment and run-up over "
              "those of a plug behind the same front, are of steady means: they hold for no first impact. Lowest to highest over the snows, uncertainty added; – is not known")}


def factor_name(kind, name, ensemble):
    """Of a row, for the page."""
    parts = name.split("_")
    if kind == "arm":
        depths = float(parts[1])
        return f"{ensemble.base + depths * ensemble.plan['flow']['depth_m']:.3g} m ({depths:g} H)"
    return f"{parts[1]}°, slip {parts[3]}" if kind == "front" else ", ".join(parts) + "°" * (len(parts) > 1)


def own_front(ensemble, results):
    """The row of this page beside the factors of fronts: its values, lowest to highest over the snows, without their uncertainty."""
    rows = [row for row in results.table if row["force_mean_n"].value > 0.0]
    peaks = [np.nanmax([row[key].value for key in STATIC_FORCES]) / row["force_mean_n"].value for row in rows]
    arms = [(row["resultant_height_m"].value - ensemble.base) / ensemble.plan["flow"]["depth_m"] for row in rows]
    cells = [comparison.span(min(of), max(of), 3) if rows else UNKNOWN for of in (peaks, arms)]
    return ["this page: 90°, slip 1", *cells, *["1"] * (len(FACTORS["front"][1]) - len(cells))]


def factor_tables(ensemble, factors=None, results=None):
    """[(heading, table, legend)] of the study's factors in the flow of the site, those of arms as pressures, unless the mast has an arm of its own; without
    rows where the flow is outside the table. @param factors  for tests; else the kept ones @param results  whose own values stand beside those of fronts"""
    plan, factors = ensemble.plan, load_factors() if factors is None else factors
    head, found = 0.5 * plan["flow"]["density_kg_m3"] * plan["flow"]["velocity_m_s"] ** 2, []

    def cell(kind, values):
        if not values:
            return UNKNOWN
        if kind == "arm":
            return upward(head * max(values), 1e-3) if abs(head * max(values)) >= 10.0 else "0"
        return comparison.span(min(values), max(values), 3)

    for kind, of in factors.groupby("kind", sort=False):
        if kind == "arm" and "arm" in plan:
            continue
        heading, labels, legend = FACTORS[kind]
        quantities = [quantity for quantity in labels if (of.quantity == quantity).any()]
        rows = {name: [over_snows(of, kind, name, quantity, plan).values() for quantity in quantities] for name in of["name"].unique()}
        known = any(map(all, rows.values()))
        missing = outside(factors, kind, plan)
        runs = f"The runs have ξ = {CONDITIONS['hardening_xi']:g} and w = H = {CONDITIONS['flow_height_m']:g} m, w across the flow; other snow and other masts differ"
        note = f"{legend}. {runs}." + (f" Attention: {missing}." if missing else "") if known else f"T{missing[1:]}."
        cells = [[factor_name(kind, name, ensemble), *(cell(kind, v) for v in values)] for name, values in rows.items()] if known else []
        if kind == "front" and known and results is not None:
            cells.append(own_front(ensemble, results))
            note += " The row of this page has values, without their uncertainty."
        head_of = "height of the underside" if kind == "arm" else kind
        found.append((heading, {"head": [head_of, *(labels[quantity] for quantity in quantities)], "rows": cells}, note))
    return found
