"""design.html, design.json and the tables beside them."""

import datetime
import functools
import hashlib
import json
import math
import os
import re

import jinja2
import markupsafe
import numpy as np
import pandas as pd

from mpmtools import __version__
from mpmtools.design import comparison, figures, scaling
from mpmtools.design.ensemble import Ensemble
from mpmtools.design.factors import load_factors, outside, over_snows
from mpmtools.design.loads import all_modes, moving_mean
from mpmtools.design.results import LATERAL, LINE_LOADS, STATIC_FORCES, STATIC_MOMENTS, Results, is_oblique, quantities_of
from mpmtools.errors import InputError
from mpmtools.figures.style import STYLE, inline, use_style, write_page
from mpmtools.tables import write_text

LEVELS = {
    "quick": "quick: coarse grids, at most ten minutes on two cores. For orders of magnitude and for comparing variants.",
    "standard": "standard: at most an hour on two cores.",
}


def short(value, scale=1.0):
    """Three significant digits; a dash for what is not known."""
    if value is None or not math.isfinite(value):
        return "–"
    value *= scale
    digits = max(0, 2 - math.floor(math.log10(abs(value)))) if value else 0
    return f"{value:.{min(digits, 4)}f}" if digits else f"{round(value, 2 - math.floor(math.log10(abs(value))) if value else 0):.0f}"


def upward(value, scale=1.0):
    """Three significant digits, rounded up: a value to design with."""
    if not math.isfinite(value):
        return "–"
    value *= scale
    step = 10.0 ** (math.floor(math.log10(abs(value))) - 2) if value else 1.0
    return short(math.ceil(value / step - 1e-9) * step)


def value_and_error(value, uncertainty, scale=1.0):
    """Both with the digits that the uncertainty allows: two of its own, at most four of the value. Without one: three digits of the value."""
    if uncertainty is None or not math.isfinite(uncertainty) or not math.isfinite(value):
        return short(value, scale)
    value, uncertainty = value * scale, uncertainty * scale
    most = 3 - math.floor(math.log10(abs(value))) if value else 3
    digits = min(most, 1 - math.floor(math.log10(uncertainty)) if uncertainty > 0.0 else most)
    return " ± ".join(f"{round(number, digits):.{max(digits, 0)}f}" for number in (value, max(uncertainty, 10.0**-digits)))


def with_unit(text, unit):
    return f"{text} {unit}" if unit and text != "–" else text


NOT_DETERMINED = 1.0 / 3.0  # largest uncertainty over the value with which a height is stated
FINER = (5, 7, 11, 15, 21)  # cells that [plan] finest_cells takes


def finer_grid(plan):
    """(finest_cells to plan, times the work); None: this is the finest."""
    cells = plan["grids"][-1]["cells"]
    return next(((n, (n / cells) ** 4) for n in FINER if n > cells), None)


def longer(plan):
    """What to do where a run was too short."""
    return f"give [plan] duration_s = {short(2.0 * plan['duration_s'])}"


def still_growing(ensemble, results, name):
    """Why a quantity of Loads.growth is not final; empty: it is."""
    snows = [ensemble.label(snow) for snow, loads in enumerate(results.finest) if name in loads.growth]
    return f"The snow before the mast still piles up when the run ends ({', '.join(snows)}): {longer(ensemble.plan)}" if snows else ""


def pressure_heights(ensemble, results):
    """[(m, where it comes from)]: simulation, equations, guideline."""
    rows = comparison.equation_rows(ensemble.plan)
    return [(results.ranges["pressure_height_mean_m"].high, "simulation, upper value of the steady mean"),
            (max(row["pressure_height_m"] for row in rows), "the paper's equations, greatest of the snows"),
            (ensemble.base + 3.0 * ensemble.plan["flow"]["depth_m"], "3 H above the bed, conservative for all snows (Sect. 5)")]


def run_up_row(ensemble, results):
    """(value, why) of the greater of the steady run-up and the first splash."""
    splash, steady = results.ranges["runup_peak_m"], results.ranges["runup_p99_mean_m"]
    key = "runup_peak_m" if not steady.high > splash.high else "runup_p99_mean_m"
    entry = results.table[results.governing(key)][key]
    what = "highest particle of the first splash" if key == "runup_peak_m" else "height of 99 % of the snow before the mast, steady mean"
    mean = f"{short(steady.high)} m (Bernoulli’s bound H + v²/2g)" if steady.high == ensemble.bound else with_unit(upward(steady.high), "m")
    parts = (f"Steady mean: {mean}; "
             f"first splash: {short(splash.highest)} m on the finest grid, upper value {upward(splash.high)} m")
    growing = still_growing(ensemble, results, "run-up")
    finer = finer_grid(ensemble.plan)
    if growing:
        reason = growing
    elif math.isfinite(entry.total) and entry.total <= NOT_DETERMINED * entry.value:
        return upward(results.ranges[key].high) + " m", f"upper value of: {what}. {parts}"
    else:
        reason = (f"The uncertainty of the grid is more than a third of the value ({what}): the grids are too coarse for a statement; "
                  + (f"plan a finer grid: [plan] finest_cells = {finer[0]}, about {finer[1]:.0f} times the work" if finer else "no finer grid can be planned"))
    return (f"not determined ({'still growing, ' if growing else ''}{value_and_error(entry.value, entry.total)} m)",
            f"{reason}. Until then keep parts above {upward(max(results.ranges[key].high, ensemble.bound))} m. {parts}")


def why_amplified(plan, quasi_static, amplified):
    if not plan["modes"] or not math.isfinite(amplified):
        return ""
    if plan["mast"]["height_m"] is None:
        return " The height of the mast is not given: the load is taken to act where the mode has its unit of displacement, an upper bound; give mast.height_m."
    return f" Without vibration {quasi_static}."


def arm_remark(ensemble, results, key):
    """What belongs to the headline of the arm: its steady mean, where it acts, what else feels it."""
    name = key.split("_")[1]
    text = "" if "mean" in key else f" Steady mean: {with_unit(upward(results.ranges[f'arm_{name}_mean_n'].high, 1e-3), 'kN')}."
    if name == "lift":
        least = min(np.min(moving_mean(loads.arm.vertical, loads.rows)) for loads in results.finest)
        return text + (f" Downwards, as when snow falls on it: {with_unit(upward(-least, 1e-3), 'kN')} on the finest grid." if least < 0.0 else "")
    at = results.ranges["arm_height_m"]
    where = f" The mean acts at {comparison.span(at.lowest, at.highest, 3)} m." if math.isfinite(at.lowest) else ""
    return f"{text}{where} It is part of force and moment at the foundation" + (", and of the vibration: with the mode's shape at the arm's middle." if ensemble.plan["modes"] else ".")


def design_rows(ensemble, results):
    """The box at the top: what to design with. [(what, value, why)]"""
    plan = ensemble.plan
    by_key = {q.key: q for q in quantities_of(plan)}

    def value(key, number):
        return with_unit(upward(number, by_key[key].scale), by_key[key].unit)

    arm, rows = plan.get("arm"), []
    both = ", arm included" if arm else ""
    loads = [(f"force downstream, at the foundation{both}", "force", results.design_force, STATIC_FORCES),
             (f"overturning moment at the ground{both}", "moment", results.design_moment, STATIC_MOMENTS)]
    if arm:
        loads += [(f"arm ({arm['base_m']:.4g} to {arm['height_m']:.4g} m above the ground): force {axis}", "arm's force", functools.partial(results.arm_force, name=name), ())
                  for axis, name in (("downstream", "arm_force"), ("upwards", "arm_lift"))]
    for what, name, choose, statics in loads:
        chosen, number = choose()
        if chosen is None:
            rows.append((what, "–", "no run gives one"))
            continue
        snow, q = results.governing(chosen), by_key[chosen]
        entry = results.table[snow][chosen]
        why = f"upper value of: {q.label}, {with_unit(value_and_error(entry.value, entry.total, q.scale), q.unit)} ({ensemble.label(snow)})."
        if "vibration" in chosen:
            static, without = results.upper(statics)
            why += why_amplified(plan, value(static, without), number)
        steady, steady_number = choose(steady_only=True)
        if steady is not None and chosen != steady and steady_number < number:
            why += f" First impact of a vertical front (upper bound) included; while the flow is steady: {value(steady, steady_number)}."
        if name == "arm's force":
            why += arm_remark(ensemble, results, chosen)
        growing = still_growing(ensemble, results, name)
        rows.append((what, value(chosen, number) + (", still growing" if growing else ""), why + (f" {growing}." if growing else "")))
    heights = [h for h in pressure_heights(ensemble, results) if math.isfinite(h[0])]
    top, source = max(heights)
    growing = still_growing(ensemble, results, "pressure height") if source.startswith("simulation") else ""
    others = "; ".join(f"{where}: {upward(h)} m" for h, where in heights if where != source)
    rows.append(("height of the pressure, for a simplified load", f"{upward(top)} m{', still growing' if growing else ''}",
                 f"the greatest of three: {source}; the others: {others}. They differ because 3 H covers every snow and width of the paper, the equations hold for a "
                 "box as wide as the flow is deep, and the simulation is of this mast and these snows; the computed load over height is in the line load below, the guideline's load over 3 H in its table" + (f". {growing}" if growing else "")))
    rows.append(("run-up (keep parts that must not be struck above it)", *run_up_row(ensemble, results)))
    return rows


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
        cells = [f"{bottom:.2f} to {top:.2f}"]
        for q in loads.values():
            carried = np.interp([bottom, top], np.append(low, high[-1]), np.append(0.0, np.cumsum(q * step)))
            cells.append(f"{1e-3 * (carried[1] - carried[0]) / (top - bottom):.1f}")
        rows.append(cells)
    if arm:
        rows.append(["in addition on the arm"] + [f"{short(force, 1e-3)} kN at {at:.2f} m" for force, at in arms])
    rows.append(["force (kN)"] + [upward(q.sum() * step + force, 1e-3) for q, (force, _) in zip(loads.values(), arms)])
    rows.append(["moment (kN m)"] + [upward(q @ centre * step + force * at, 1e-3) for q, (force, at) in zip(loads.values(), arms)])
    return {"head": ["z (m), load in kN/m"] + [LINE_LOADS[name] for name in loads], "rows": rows}


def guideline_load_table(results, plan):
    """Loads of the guideline beside the computed ones."""
    of_mast = "mast_" if "arm" in plan else ""
    mean, moment = results.ranges[f"{of_mast}force_mean_n"], results.ranges[f"{of_mast}moment_mean_n_m"]
    rows = []
    for row in comparison.guideline_loads(plan):
        ratio = short(mean.high / row.force) if math.isfinite(mean.high) else "–"
        rows.append([row.what, short(row.extent), short(row.force, 1e-3), short(row.moment, 1e-3), ratio, row.source])
    drag = results.ranges["drag_coefficient"]
    rows.append([f"computed{', without the arm' if of_mast else ''}, steady mean, upper value (c_D over w H: {comparison.span(drag.lowest, drag.highest)}, upper {drag.high:.2g})",
                 upward(results.ranges["pressure_height_mean_m"].high), upward(mean.high, 1e-3), upward(moment.high, 1e-3), "1", "this page"])
    return {"head": ["load", "reaches to (m)", "force (kN)", "moment (kN m)", "computed / this", "source"], "rows": rows}


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
        factors = ", ".join(f"{amplification:.2f}" for _, amplification in found["modes"].values())
        rows.append(["vertical, ideal: upper bound" if depths == 0 else f"rises over {depths} H ({depths * plan['flow']['depth_m']:.3g} m, {time:.2g} s)",
                     factors, short(np.max(found["force"]), 1e-3), short(np.max(found["moment"]), 1e-3)])
    return {"head": ["front", "amplification of the modes' own part", "force (kN)", "moment (kN m)"], "rows": rows}


def sensitivity_rows(ensemble, results):
    """[(what changes, effect on the force, on the moment)] of the headline, greatest effect on the moment first; effects are (lower end, upper
    end) over the headline - 1. Depth, speed and density by scaling (scaling.py), without runs."""
    plan = ensemble.plan
    force, moment, _ = scaling.scaled_loads(results, plan, scaling.avalanche_of(plan))
    if not (math.isfinite(force) and math.isfinite(moment)):
        return []
    labels = {"velocity": "speed", "depth": "depth", "density": "density"}
    rows = []
    for name, ends in scaling.ranges_of(plan).items():
        scaled = [scaling.scaled_loads(results, plan, end) for end in ends]
        rows.append((f"{labels[name]} ± {100.0 * scaling.half_range(plan, name):.0f} %, scaling", *((low / whole - 1.0, high / whole - 1.0) for whole, low, high in (
            (force, scaled[0][0], scaled[1][0]), (moment, scaled[0][1], scaled[1][1])))))
    chosen = [choose()[0] for choose in (results.design_force, results.design_moment)]
    entries = [results.table[results.governing(key)][key] for key in chosen]
    shares = [np.nan_to_num(entry.grid) / entry.value for entry in entries]
    rows.append(("grid, in the headline at its upper end", *((-min(2.0 * share / (1.0 + share), 1.0), 0.0) for share in shares)))
    if len(plan["snows"]) > 1:
        upper = [results.snow_upper(number) for number in range(len(plan["snows"]))]
        rows.append(("snow: from the least to the greatest", *((min(values) / whole - 1.0, 0.0) for values, whole in zip(zip(*upper), (force, moment)))))
    steady = [results.design_force(steady_only=True)[1] / force - 1.0, results.design_moment(steady_only=True)[1] / moment - 1.0]
    if all(map(math.isfinite, steady)) and min(steady) < 0.0:
        rows.append(("front: without first impact", *((min(value, 0.0), 0.0) for value in steady)))
    return sorted(rows, key=lambda row: row[2][0] - row[2][1])


def sensitivity_table(rows):
    """The same in percent."""
    if not rows:
        return None
    return {"head": ["what changes", "design force", "design moment"],
            "rows": [[what, *(f"{100.0 * low:+.0f} to {100.0 * high:+.0f} %" for low, high in changes)] for what, *changes in rows]}


def ensemble_text(ensemble, results, rows):
    """All ranges at once, in a sentence; empty without a headline."""
    if not rows:
        return ""
    scaled = [scaling.scaled_loads(results, ensemble.plan, corner) for corner in scaling.corners_of(ensemble.plan)]
    independent = [math.sqrt(sum(row[which][1] ** 2 for row in rows if "scaling" in row[0])) for which in (1, 2)]
    forces, moments = [s[0] for s in scaled], [s[1] for s in scaled]
    return (f"All combinations of the ends and middles of depth, speed and density ({len(scaled)}): design force {short(min(forces), 1e-3)} to "
            f"{short(max(forces), 1e-3)} kN, moment {short(min(moments), 1e-3)} to {short(max(moments), 1e-3)} kN m. If the three are independent, the "
            f"upper ends add up as root of the sum of squares to {100.0 * independent[0]:+.0f} % of the force and {100.0 * independent[1]:+.0f} % of the moment.")


def scenario_rows(ensemble, results):
    """[(name, Avalanche, force, moment, error, (pressure height, run-up))] of [flow], as computed, and of each [[scenario]], scaled; SI."""
    plan, gravity = ensemble.plan, ensemble.plan["flow"]["gravity_m_s2"]
    computed = scaling.avalanche_of(plan)
    rows = []
    for name, other in [("[flow], computed", computed)] + [
            (s["name"], scaling.Avalanche(s["depth_m"], s["velocity_m_s"], s["density_kg_m3"])) for s in plan.get("scenarios", [])]:
        force, moment, error = scaling.scaled_loads(results, plan, other)
        scales = [scaling.factors(computed, other, snow["effective_friction"], gravity) for snow in plan["snows"]]
        bed = [results.ranges[key].high - ensemble.base for key in ("pressure_height_mean_m", "runup_p99_mean_m", "runup_peak_m")]
        heights = (ensemble.base + np.nanmax([bed[0] * max(s.pressure_height for s in scales), 3.0 * other.depth]),
                   ensemble.base + np.nanmax(bed[1:]) * max(s.runup for s in scales))
        rows.append((name, other, force, moment, error, heights))
    return rows


def scenario_table(ensemble, results):
    """None without scenarios."""
    if not ensemble.plan.get("scenarios"):
        return None
    gravity = ensemble.plan["flow"]["gravity_m_s2"]
    rows = []
    for name, other, force, moment, error, heights in scenario_rows(ensemble, results):
        rows.append([name, f"{other.depth:.3g}", f"{other.velocity:.3g}", f"{other.density:.3g}", f"{other.froude_number(gravity):.2f}",
                     upward(force, 1e-3), upward(moment, 1e-3), *(upward(h) for h in heights), f"± {100.0 * error:.0f} %" if error else "–"])
    return {"head": ["scenario", "H (m)", "v (m/s)", "ρ (kg/m³)", "Fr", "force (kN)", "moment (kN m)", "pressure height (m)", "run-up (m)", "scaling"],
            "rows": rows}


def reaction_table(ensemble, results):
    """What the foundation feels, over all snows on the finest grid."""
    units = {q.key: q.unit for q in quantities_of(ensemble.plan)}

    def cells(*keys):
        return [with_unit(upward(results.ranges[k].high, 1e-3), units[k]) if k in results.ranges else "–" for k in keys]

    def vertical(select):
        parts = [loads.vertical[where] for loads in results.finest if (where := select(loads)).any()]
        return f"{min(map(np.min, parts)) / 1e3:+.0f} to {max(map(np.max, parts)) / 1e3:+.0f} kN" if parts else "–"

    rows = []
    cases = [("steady mean", "mean", "", lambda l: l.steady), ("steady peak (0.1 s)", "steady_peak", "steady_peak", lambda l: l.steady),
             ("first impact (0.1 s)", "first_impact", "first_impact", lambda l: l.impact)]
    if ensemble.plan["modes"]:
        cases += [("with vibration, first impact included", "with_vibration", "", lambda l: l.impact),
                  ("with vibration, while steady", "with_vibration_steady", "", lambda l: l.steady)]
    for name, which, lateral, select in cases:
        row = [name, *cells(f"force_{which}_n", f"moment_{which}_n_m"), vertical(select)]
        rows.append(row + (cells(*(f"{key}_{lateral}" for key, _, _ in LATERAL)) if is_oblique(ensemble.plan) else []))
    return {"head": ["case", "force downstream", "overturning moment", "vertical force, upward positive"]
            + (["lateral force", "moment of the lateral force", "torsion"] if is_oblique(ensemble.plan) else []), "rows": rows}


FACTORS = {  # kind: heading, what its factors are
    "arm": ("Elements that protrude", "Pressure over the front of what protrudes, for the snow that gives most, scaled from runs with an arm three mast widths long and half a flow depth thick on a "
            "square mast as wide as the flow is deep. Drag is downstream, lift upwards; peaks are over 0.1 s. No grid study tells how uncertain they are"),
    "shape": ("Other cross-sections", "Over the value of a square that faces the flow, lowest to highest over the snows, uncertainty added"),
    "front": ("Other fronts", "Degrees of the front, and speed at the floor over the mean: peak over steady mean, lever arm of the mean force over H, lowest to highest over the snows, uncertainty added")}


def factor_tables(ensemble, factors=None):
    """[(heading, table, legend)] of the study's factors in the flow of the site, those of arms as pressures, unless the mast has an arm of its own; without
    rows where the flow is outside the table. @param factors  for tests; else the kept ones"""
    plan, factors = ensemble.plan, load_factors() if factors is None else factors
    flow, found = plan["flow"], []
    for kind, of in factors.groupby("kind", sort=False):
        if kind == "arm" and "arm" in plan:
            continue
        quantities, rows, known = list(of.quantity.unique()), [], False
        for name in of["name"].unique():
            values = [over_snows(of, kind, name, quantity, plan).values() for quantity in quantities]
            known = known or all(values)
            if kind == "arm":
                depths = float(name.removeprefix("base_"))
                row = f"{ensemble.base + depths * flow['depth_m']:.3g} m ({depths:g} H)"
                head = 0.5 * flow["density_kg_m3"] * flow["velocity_m_s"] ** 2
                cells = [(upward(head * max(v), 1e-3) if abs(head * max(v)) >= 10.0 else "0") if v else "outside the table" for v in values]
            else:
                row = name.replace("_", " ")
                cells = [comparison.span(min(v), max(v)) if v else "outside the table" for v in values]
            rows.append([row, *cells])
        labels = [quantity.replace("_", " ") + " (kPa)" * (kind == "arm") for quantity in quantities]
        heading, legend = FACTORS[kind]
        missing = outside(factors, kind, plan)
        note = f"{legend}." + (f" Attention: {missing}." if missing else "") if known else f"T{missing[1:]}."
        found.append((heading, {"head": ["height of the underside" if kind == "arm" else kind, *labels], "rows": rows if known else []}, note))
    return found


def advice_rows(ensemble, results):
    """What to know before the values are used: the advice of the program about the runs, and what the runs show. [(text, snows)]"""
    plan = ensemble.plan
    rows = [(advice["text"], "" if len(advice["snows"]) == len(plan["snows"]) else ", ".join(advice["snows"]).replace("_", " "))
            for advice in plan.get("advice", [])]  # an older program wrote none
    if "arm" not in plan:
        rows.append(("The loads are those of the mast alone. What protrudes from it (cross-arm, ladder, cable) is pressed up to the height of the run-up: see 'Elements that "
                     "protrude', or give a cross-arm as [arm]", ""))
    drag, guideline = results.ranges["drag_coefficient"], comparison.guideline_loads(plan)
    if math.isfinite(drag.high) and (remark := comparison.drag_remark(plan, drag.lowest, drag.highest)):
        rows.append((remark, ""))
    shares = uncertainties(results)
    arms = [("force on the arm", results.arm_force()), ("its lift", results.arm_force(name="arm_lift"))]
    for label, (key, _) in [("design force", results.design_force()), ("design moment", results.design_moment())] + ("arm" in plan) * arms:
        if key is not None and results.ranges[key].highest > 0.0:
            entry = results.table[results.governing(key)][key]
            shares.append((label, entry.grid / entry.value))
    coarse = [f"{label} {100.0 * share:.0f} %" for label, share in shares if share > NOT_DETERMINED]
    if coarse:
        finer = finer_grid(plan)
        rows.append((f"The grids are too coarse: their uncertainty is more than a third of the value ({', '.join(coarse)}). "
                     + (f"Plan a finer grid: [plan] finest_cells = {finer[0]}, about {finer[1]:.0f} times the work" if finer
                        else "No finer grid can be planned"), ""))
    (_, own_force), (_, own_moment) = results.design_force(), results.design_moment()
    of_arm = [max(values) for values in zip((0.0, 0.0), *((force, force * at) for force, at in results.arm_loads().values()))]
    greater = {}  # row: its loads that are
    for what, own, unit in (("force", own_force - of_arm[0], "kN"), ("moment", own_moment - of_arm[1], "kN m")):
        most = max(guideline, key=lambda row: getattr(row, what))
        if getattr(most, what) > own:
            greater.setdefault(most, []).append(f"a {what} of {upward(getattr(most, what), 1e-3)} {unit} against {upward(own, 1e-3)} {unit}")
    for most, loads in greater.items():
        rows.append((f"A load of the guideline ({most.what}) is greater than the computed one{' without the arm' if 'arm' in plan else ''}: {' and '.join(loads)}. It reaches to {short(most.extent)} m; "
                     "which of the two applies is the designer's decision", ""))
    for name, _, force, moment, error, _ in scenario_rows(ensemble, results)[1:]:
        if force > own_force or moment > own_moment:
            rows.append((f"Scenario {name} gives more than the values above: {upward(force, 1e-3)} kN and {upward(moment, 1e-3)} kN m by scaling "
                         f"(± {100.0 * error:.0f} %); make it [flow], or a site file of its own, if it is to be designed for", ""))
    if is_oblique(plan):
        rows.append((f"The mast is turned by {plan['mast']['angle_deg']:g}° against the flow: lateral force and torsion are below, in the axes of the flow; "
                     "the modes act downstream only; the line load and the guideline's load are those downstream"
                     + ("; the arm is computed across the flow, not turned with the mast" if "arm" in plan else ""), ""))
    if plan["modes"] and plan["mast"]["height_m"] is None:
        rows.append(("The height of the mast is not given, so the vibration is an upper bound: give mast.height_m, and shape_at_load where you know it", ""))
    for snow, loads in enumerate(results.finest):
        begin = f"begins at {loads.time[loads.steady][0]:.3g} of {plan['duration_s']:g} s" if loads.is_steady else ""
        if loads.growth:
            rises = ", ".join(f"{name} {100.0 * rise:.0f} %" for name, rise in loads.growth.items())
            rows.append((f"The snow before the mast still piles up when the run ends: the steady interval {begin}, and "
                         f"{'since the splash' if loads.is_late else 'within it'} these rise: {rises}. A longer run gives more, how much is not known: {longer(plan)}", ensemble.label(snow)))
        elif loads.is_late:
            rows.append((f"The steady interval is short: it {begin}. Snow may still pile up before the mast: {longer(plan)}", ensemble.label(snow)))
    top = plan["mast"]["height_m"]
    if top:
        for key, what in (("runup_p99_mean_m", "the steady mean of the run-up"), ("runup_mean_m", "the steady mean of the highest particle"),
                          ("runup_peak_m", "the highest particle of the first splash")):
            over = [i for i, row in enumerate(results.table) if math.isfinite(row[key].value) and row[key].value >= top]
            if over:
                highest = max(results.table[i][key].value for i in over)
                rows.append((f"The mast is overtopped: {what} reaches {short(highest)} m, and the mast is {top} m high; heights are those of a mast "
                             "that ends there; leave out mast.height_m for the run-up on a taller one",
                             "" if len(over) == len(plan["snows"]) else ", ".join(ensemble.label(i) for i in over)))
    return rows


def load_table(ensemble, results):
    plan = ensemble.plan
    head = ["quantity"] + [ensemble.label(i) for i in range(len(plan["snows"]))] + ["range with uncertainty"]
    rows = []
    for q in quantities_of(plan):
        cells = [q.label + (f" ({q.unit})" if q.unit else "")]
        for row in results.table:
            e = row[q.key]
            if not math.isfinite(e.value):
                cells.append("–")
                continue
            unknown = "" if math.isfinite(e.grid) else " *"
            cells.append(value_and_error(e.value, e.total, q.scale) + unknown)
        r = results.ranges[q.key]
        high = short if r.high == ensemble.bound else upward  # a bound is exact
        cells.append(f"{short(r.low, q.scale)} to {high(r.high, q.scale)}" if math.isfinite(r.high) else "–")
        rows.append(cells)
    return {"head": head, "rows": rows}


def grid_table(ensemble, results):
    """Values on the grids; how the uncertainty was found is in notes under the table, each once."""
    plan = ensemble.plan
    head = ["quantity and snow"] + [f"{g['cells']} cells, {g['cell_size_m']:.3g} m" for g in plan["grids"]] + ["order", "GCI", "known", "taken", "note"]
    rows, notes = [], []
    for q in quantities_of(plan):
        for snow, row in enumerate(results.table):
            e = row[q.key]
            if not math.isfinite(e.value) or e.value == 0.0:
                continue
            percent = [f"{100.0 * part / abs(e.value):.0f} %" if math.isfinite(part) else "–" for part in (e.gci, e.known, e.grid)]
            name = f"{q.label}, {ensemble.label(snow)}" + (f" ({q.unit})" if q.unit else "")
            if e.method not in notes:
                notes.append(e.method)
            rows.append([name, *(short(v, q.scale) for v in e.by_grid), f"{e.order:.1f}" if math.isfinite(e.order) else "–", *percent, f"{notes.index(e.method) + 1}"])
    return {"head": head, "rows": rows, "notes": notes}


def snow_table(plan):
    head = ["snow", "M", "β", "ξ", "M'", "source"]
    keys = ("critical_state_slope", "cohesion_beta", "hardening_xi", "effective_friction")
    rows, known = [], None
    for s in plan["snows"]:
        source = s["source"] or "given in the site file"
        rows.append([s["name"].replace("_", " "), *(f"{s[key]:.3g}" for key in keys), "as above" if source == known else source])
        known = source
    return {"head": head, "rows": rows}


def comparison_table(ensemble, results):
    """Simulated heights beside the paper's equations, for each snow."""
    rows = []
    for snow, equation in enumerate(comparison.equation_rows(ensemble.plan)):
        entries = results.table[snow]
        rows.append([ensemble.label(snow), short(entries["runup_mean_m"].value), short(equation["runup_m"]),
                     short(entries["pressure_height_mean_m"].value), short(equation["pressure_height_m"])])
    by = "by Eqs. 7 to 10, extrapolated" if comparison.equation_remarks(ensemble.plan) else "by Eqs. 7 to 10"
    return {"head": ["snow", "highest particle (m), computed", by, "pressure height (m), computed", by], "rows": rows}


def uncertainties(results):
    """[(quantity, grid uncertainty over the value, the largest of the snows)] of the main quantities; NaN: not known."""
    rows = []
    for key, label in (("force_mean_n", "mean force"), ("moment_mean_n_m", "mean moment"), ("runup_p99_mean_m", "run-up"),
                       ("pressure_height_mean_m", "pressure height")):
        shares = [row[key].grid / abs(row[key].value) for row in results.table if math.isfinite(row[key].value) and math.isfinite(row[key].grid)]
        rows.append((label, max(shares, default=math.nan)))
    return rows


def accuracy(results):
    """The same in words."""
    return ", ".join(f"{label} {100.0 * share:.0f} %" if math.isfinite(share) else f"{label} not known" for label, share in uncertainties(results))


def stamp(ensemble):
    """{name: text} for every printed sheet: date, author, project, hash of the input, version."""
    plan = ensemble.plan
    path = os.path.join(ensemble.folder, "site.toml")
    if not os.path.exists(path):
        path = os.path.join(ensemble.folder, "design_plan.json")
    with open(path, "rb") as file:
        digest = hashlib.sha256(file.read()).hexdigest()[:12]
    return {"date": datetime.date.today().isoformat(), "author": plan.get("author") or "author not given",
            "project": plan.get("project") or "project not given", "input": f"{os.path.basename(path)} {digest}", "version": f"mpm {plan['version']} ({plan['commit']})"}


def design_json(ensemble, results):
    plan = ensemble.plan

    def plain(value):
        return value if value is not None and math.isfinite(value) else None

    (chosen, force), (of_moment, moment) = results.design_force(), results.design_moment()
    quantities = {}
    for q in quantities_of(plan):
        r = results.ranges[q.key]
        quantities[q.key] = {
            "label": q.label,
            "range": {name: plain(getattr(r, name)) for name in r._fields},
            "snows": {plan["snows"][i]["name"]: {
                "value": plain(e.value), "by_grid": [plain(v) for v in e.by_grid], "grid_uncertainty": plain(e.grid), "gci": plain(e.gci), "order": plain(e.order),
                "known_uncertainty": plain(e.known), "standard_error": plain(e.standard_error), "uncertainty": plain(e.total), "note": e.note}
                      for i, e in enumerate(row[q.key] for row in results.table)}}
    return {"format_version": 1, "mpmtools": __version__, "plan": plan,
            "design_force_n": plain(force), "design_force_is": chosen, "design_moment_n_m": plain(moment), "design_moment_is": of_moment,
            **({"design_arm_force_n": plain(results.arm_force()[1]), "design_arm_lift_n": plain(results.arm_force(name="arm_lift")[1])} if "arm" in plan else {}),
            "pressure_heights": [{"value_m": plain(h), "source": source} for h, source in pressure_heights(ensemble, results)],
            "quantities": quantities, "guideline_loads": [row._asdict() for row in comparison.guideline_loads(plan)],
            "scenarios": [{"name": name, **other._asdict(), "force_n": plain(force), "moment_n_m": plain(moment), "scaling_error": error,
                           "pressure_height_m": plain(heights[0]), "runup_m": plain(heights[1])}
                          for name, other, force, moment, error, heights in scenario_rows(ensemble, results)],
            "sensitivity": [{"what": what, "force": force_change, "moment": moment_change}
                            for what, force_change, moment_change in sensitivity_rows(ensemble, results)],
            "guideline": [{"what": what, "value_m": value, "source": source} for what, value, source in comparison.guideline_rows(plan)],
            "equations": comparison.equation_rows(plan), "equation_remarks": comparison.equation_remarks(plan),
            "advice": [{"text": text, "snows": snows} for text, snows in advice_rows(ensemble, results)],
            "known_uncertainty_is_of": comparison.known_uncertainty_remark(plan) or None}


def write_tables(ensemble, results, spectrum):
    """design.csv, line_load.csv, arm_load.csv of a mast with an arm, pressure_over_height.csv, loads_over_time.csv, shock_spectrum.csv.
    @return their names"""
    folder, plan = ensemble.folder, ensemble.plan
    rows = [{"quantity": q.key, "snow": plan["snows"][i]["name"], "value": e.value, "grid_uncertainty": e.grid, "gci": e.gci,
             "known_uncertainty": e.known, "standard_error": e.standard_error, "uncertainty": e.total}
            for q in quantities_of(plan) for i, e in enumerate(row[q.key] for row in results.table)]
    tables = {"design.csv": pd.DataFrame(rows), "pressure_over_height.csv": pd.DataFrame(results.profile_table(ensemble))}
    low, high, lines, arm = results.line_loads(plan)
    tables["line_load.csv"] = pd.DataFrame({"z_from_m": low, "z_to_m": high, **{f"{name}_kn_m": 1e-3 * q for name, q in lines.items()}})
    if arm:
        upper = {f"upper_{axis}_kn": [1e-3 * results.ranges[f"{of}_{name}_n"].high if f"{of}_{name}_n" in results.ranges else math.nan for name in arm]
                 for axis, of in (("downstream", "arm_force"), ("upwards", "arm_lift"))}
        tables["arm_load.csv"] = pd.DataFrame({"with_line_load": list(arm), "downstream_kn": [1e-3 * force for force, _ in arm.values()],
                                               "height_m": [at for _, at in arm.values()], **upper})
    times = []
    for snow, loads in enumerate(results.finest):
        of_arm = {"arm_force_x_n": loads.arm.force, "arm_force_z_n": loads.arm.vertical} if loads.has_arm else {}
        times.append(pd.DataFrame({"snow": plan["snows"][snow]["name"], "time_s": loads.time, "force_x_n": loads.force,
                                   "force_x_smooth_n": loads.smooth_force, "overturning_moment_n_m": loads.moment,
                                   "overturning_moment_smooth_n_m": loads.smooth_moment, "runup_p99_m": loads.runup, "runup_m": loads.highest,
                                   "pressure_height_m": loads.pressure_height, **of_arm}))
    tables["loads_over_time.csv"] = pd.concat(times)
    spectra = {"frequency_hz": figures.FREQUENCIES}
    spectra.update({f"{snow['name']}_n": row for snow, row in zip(plan["snows"], spectrum)})
    tables["shock_spectrum.csv"] = pd.DataFrame(spectra)
    for name, table in tables.items():
        write_text(os.path.join(folder, name), table.to_csv(index=False, float_format="%.6g"))
    return list(tables)


def make_page(folder):
    """Writes everything into the folder. @return (path of the page, [line for the user])"""
    use_style()
    ensemble = Ensemble(folder)
    plan, results = ensemble.plan, Results(ensemble)
    middle = results.finest[ensemble.middle]
    spectrum = figures.spectra(ensemble, results.finest)
    sensitivity = sensitivity_rows(ensemble, results)
    design, advice, uncertain = design_rows(ensemble, results), advice_rows(ensemble, results), accuracy(results)
    pictures = [figures.side_view(ensemble, middle), figures.view_3d(ensemble, middle), figures.pressure_over_height(ensemble, results.finest), figures.line_load(results, plan),
                figures.over_time(ensemble, results.finest, "force"), figures.over_time(ensemble, results.finest, "moment"),
                figures.shock_spectrum(ensemble, results.finest, spectrum), figures.runup_over_time(ensemble, results.finest),
                figures.grid_convergence(ensemble, results.table)]
    try:
        files = write_tables(ensemble, results, spectrum)
        write_text(os.path.join(folder, "design.json"), json.dumps(design_json(ensemble, results), indent=2))
        environment = jinja2.Environment(loader=jinja2.FileSystemLoader(os.path.dirname(__file__)), autoescape=True, trim_blocks=True)
        environment.filters["inline"] = inline
        environment.filters["css"] = lambda text: markupsafe.Markup(json.dumps(re.sub(r"[\\<>\n]", " ", str(text)), ensure_ascii=False))
        page = environment.get_template("design_page.html.j2").render(
            style=markupsafe.Markup(STYLE), plan=plan, title=plan["title"] or "Avalanche on a mast", design=design, advice=advice,
            stamp=stamp(ensemble), line_load=line_load_table(results, plan), guideline_loads=guideline_load_table(results, plan),
            factors=factor_tables(ensemble), fronts=front_table(ensemble, results), reactions=reaction_table(ensemble, results), sensitivity=sensitivity_table(sensitivity),
            ensemble_text=ensemble_text(ensemble, results, sensitivity), tornado=figures.tornado(sensitivity), oblique=is_oblique(plan),
            scenarios=scenario_table(ensemble, results), base=ensemble.base,
            sources={"head": ["shape and regime", "c_D", "source", "what was read of it"], "rows": comparison.drag_sources(plan)},
            scaling_errors="; ".join(f"{100.0 * error:.0f} % up to {most:g} times the Froude number" if math.isfinite(most) else f"{100.0 * error:.0f} % beyond"
                                     for most, error in scaling.ERRORS),
            moment_per_metre=upward(results.design_force()[1], 1e-3), higher_modes=[m["frequency_hz"] for m in all_modes(plan)[len(plan["modes"]):]],
            known_is_of=comparison.known_uncertainty_remark(plan),
            loads=load_table(ensemble, results), grids=grid_table(ensemble, results), snows=snow_table(plan), shape=plan["mast"]["shape"],
            comparison=comparison_table(ensemble, results), remarks=comparison.equation_remarks(plan),
            guideline=[(what, short(value), source) for what, value, source in comparison.guideline_rows(plan)],
            pictures=[p for p in pictures if p is not None], level=LEVELS[plan["level"]], accuracy=uncertain,
            not_steady=[os.path.basename(path) for path in results.not_steady], files=files, axis=short(middle.axis),
            cosine=math.cos(math.radians(plan["flow"]["slope_deg"])), sine=math.sin(math.radians(plan["flow"]["slope_deg"])), duration=short(plan["duration_s"]), wall=sum(run.number("wall_time_s") or 0.0 for row in ensemble.runs for run in row) / 60.0,
            threads=middle.run.number("threads"), middle=ensemble.label(ensemble.middle),
            three_grids=len(plan["grids"]) > 2)
        path = os.path.join(folder, "design.html")
        write_page(path, page)
    except OSError as problem:
        raise InputError(f"cannot write to '{folder}': {problem.strerror}") from None
    lines = [f"{what}: {value} ({why})" for what, value, why in design]
    lines += [f"warning: snow {snows}: {text}" if snows else f"warning: {text}" for text, snows in advice]
    lines.append(f"largest grid uncertainties: {uncertain}")
    return path, lines


def run_command(options):
    path, lines = make_page(options.directory)
    print("\n".join(lines))
    print(f"wrote {path}")
