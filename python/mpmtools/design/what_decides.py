"""How much the headlines depend on the avalanche, the snow, the grid and the front; scenarios. By scaling (scaling.py), without runs."""

import math

import numpy as np

from mpmtools.design import scaling
from mpmtools.design.headlines import is_run_up_determined, marked
from mpmtools.design.rounding import UNKNOWN, downward, number, percent, upward


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
        scaled = zip((force, moment), *(scaling.scaled_loads(results, plan, end) for end in ends))
        rows.append((f"{labels[name]} ± {100.0 * scaling.half_range(plan, name):.0f} %, scaling", *((low / whole - 1.0, high / whole - 1.0) for whole, low, high in scaled)))
    rows = [row for row in rows if all(math.isfinite(end) for change in row[1:] for end in change)]  # else a snow is beyond the fit
    entries = [results.table[results.governing(key)][key] for key, _ in (results.headline("force"), results.headline("moment"))]
    shares = [np.nan_to_num(entry.grid) / entry.value for entry in entries]
    rows.append(("grid, in the headline at its upper end", *((-min(2.0 * share / (1.0 + share), 1.0), 0.0) for share in shares)))
    values, steady = ([results.snow_upper(number, "value", steady_only) for number in range(len(plan["snows"]))] for steady_only in (False, True))
    if len(plan["snows"]) > 1:
        rows.append(("snow: from the least to the greatest value", *((min(of) / max(of) - 1.0, 0.0) for of in zip(*values))))
    steady = [max(of) / max(whole) - 1.0 for of, whole in zip(zip(*steady), zip(*values))]
    if all(map(math.isfinite, steady)) and min(steady) < 0.0:
        rows.append(("front: only while the flow is steady", *((min(value, 0.0), 0.0) for value in steady)))
    return sorted(rows, key=lambda row: row[2][0] - row[2][1])


def sensitivity_table(rows):
    """The same in percent."""
    return {"head": ["what changes", "design force", "design moment"],
            "rows": [[what, *(f"{number(100.0 * low, '+.0f')} to {percent(high, '+.0f')}" for low, high in changes)] for what, *changes in rows]}


def ensemble_text(ensemble, results, rows):
    """All ranges at once, in a sentence; empty without a headline."""
    if not rows:
        return ""
    if unknown := scaling.unknown_snows(ensemble.plan):
        return f"Depth and speed are not scaled: {beyond_fit(unknown)}."
    corners, gravity = scaling.corners_of(ensemble.plan), ensemble.plan["flow"]["gravity_m_s2"]
    scaled = [scaling.scaled_loads(results, ensemble.plan, corner) for corner in corners]
    flows = [corner.froude_number(gravity) for corner in corners]
    beyond = "" if all(map(scaling.is_fitted, flows)) else (
        f" Attention: these are flows of Fr {min(flows):.2g} to {max(flows):.2g}, and the scaling was fitted to Fr {scaling.FROUDE[0]:g} to {scaling.FROUDE[1]:g}: "
        "its error beyond is not known.")
    independent = [math.sqrt(sum(row[which][1] ** 2 for row in rows if "scaling" in row[0])) for which in (1, 2)]
    forces, moments = [s[0] for s in scaled], [s[1] for s in scaled]
    return (f"All combinations of the ends and middles of depth, speed and density ({len(scaled)}): design force {downward(min(forces), 1e-3)} to "
            f"{upward(max(forces), 1e-3)} kN, moment {downward(min(moments), 1e-3)} to {upward(max(moments), 1e-3)} kN m. If the three are independent, the "
            f"upper ends add up as root of the sum of squares to {percent(independent[0], '+.0f')} of the force and {percent(independent[1], '+.0f')} of the moment.{beyond}")


def beyond_fit(unknown):
    """@param unknown  scaling.unknown_snows()"""
    low, high = scaling.FITTED
    return f"{unknown} is beyond the fit (M' {low:g} to {high:g}, continued to {scaling.CONTINUED * high:.2f}); compute it with a site file of its own"


def scenario_rows(ensemble, results):
    """[(name, Avalanche, force, moment, error, (pressure height, run-up))] of [flow], as computed, and of each [[scenario]], scaled; SI. NaN
    beyond the flows to which the scaling was fitted."""
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
        rows.append((name, other, *((force, moment, error, heights) if math.isfinite(error) else (*[math.nan] * 3, (math.nan, math.nan)))))
    return rows


def not_scaled(rows, plan):
    """Why scenarios have no loads, in words; empty: all have. @param rows  scenario_rows()"""
    names = [name for name, _, _, _, error, _ in rows if math.isnan(error)]
    if not names:
        return ""
    if unknown := scaling.unknown_snows(plan):
        return f"Scenario {', '.join(names)}: not scaled: {beyond_fit(unknown)}"
    return (f"Scenario {', '.join(names)}: no loads, since from or to {'its Froude number' if len(names) == 1 else 'their Froude numbers'} nothing can be scaled: the scaling "
            f"was fitted to Fr {scaling.FROUDE[0]:g} to {scaling.FROUDE[1]:g}; compute it with a site file of its own")


def scenario_table(ensemble, results):
    """None without scenarios."""
    if not ensemble.plan.get("scenarios"):
        return None
    gravity = ensemble.plan["flow"]["gravity_m_s2"]
    rows, scenarios, determined = [], scenario_rows(ensemble, results), is_run_up_determined(ensemble, results)
    for name, other, force, moment, error, heights in scenarios:
        rows.append([name, f"{other.depth:.3g}", f"{other.velocity:.3g}", f"{other.density:.3g}", f"{other.froude_number(gravity):.2f}",
                     marked(ensemble, results, upward(force, 1e-3), "force"), marked(ensemble, results, upward(moment, 1e-3), "moment"), upward(heights[0]),
                     upward(heights[1]) if determined or math.isnan(heights[1]) else "not determined", UNKNOWN if math.isnan(error) else f"± {percent(error)}" if error else "none"])
    return {"head": ["scenario", "H (m)", "v (m/s)", "ρ (kg/m³)", "Fr", "force (kN)", "moment (kN m)", "pressure height (m)", "run-up (m)", "error of force and moment by scaling"],
            "rows": rows, "note": not_scaled(scenarios, ensemble.plan)}
