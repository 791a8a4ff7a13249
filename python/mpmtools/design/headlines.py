"""The values at the top of the page: what to design with, and why."""

import math
import re

import numpy as np

from mpmtools.design import comparison
from mpmtools.design.loads import moving_mean
from mpmtools.design.results import HEADLINES, STATIC_FORCES, STATIC_MOMENTS, quantities_of
from mpmtools.design.rounding import UNKNOWN, short, upward, value_and_error, with_unit

NOT_DETERMINED = 1.0 / 3.0  # largest uncertainty over the value above the bed with which a height is stated
FINER = (5, 7, 11, 15, 21)  # cells that [plan] finest_cells takes


def finer_grid(plan):
    """What to do where the grids are too coarse."""
    cells = plan["grids"][-1]["cells"]
    if (finer := next((n for n in FINER if n > cells), None)) is None:
        return "no finer grid can be planned"
    return f"plan a finer grid: [plan] finest_cells = {finer}, about {(finer / cells) ** 4:.0f} times the work"


TAKE = re.compile(r"(?<=take plan\.duration_s = )[0-9.e+]+")  # of the program's advice


def durations(plan):
    """Those that the advice of the program names, s."""
    return [float(number) for advice in plan.get("advice", []) for number in TAKE.findall(advice["text"])]


def longer(plan):
    """What to do where a run was too short: at least twice as long, and as the program advises."""
    return f"give [plan] duration_s = {short(max(2.0 * plan['duration_s'], *durations(plan), 0.0))}"


ONE_GRID = "Fewer than two grids, or not the finest one, have a steady value, so that the uncertainty of the grid may be greater"


def at_least(results, keys):
    """Before an upper value that may be greater: ONE_GRID."""
    return "at least " if results.is_at_least(keys) else ""


def still_growing(ensemble, results, load):
    """(mark of a load of HEADLINES, or another quantity of Loads.growth, that is not final, why it is not); empty: it is."""
    name = "arm's force" if load.startswith("arm") else load
    for mark, text, condition in (("not steady", "The run ends before the flow is steady", lambda loads: not loads.is_steady),
                                  ("still growing", "The snow before the mast still piles up when the run ends", lambda loads: name in loads.growth)):
        if snows := [ensemble.label(snow) for snow, loads in enumerate(results.finest) if condition(loads)]:
            return mark, f"{text} ({', '.join(snows)}): {longer(ensemble.plan)}"
    return "", ""


def marked(ensemble, results, text, load):
    """A load in words with the marks of its headline. @param load  of HEADLINES"""
    mark, _ = still_growing(ensemble, results, load)
    return text if text == UNKNOWN else at_least(results, HEADLINES[load][1]) + text + (f", {mark}" if mark else "")


def pressure_heights(ensemble, results):
    """[(m, where it comes from)]: simulation, equations, guideline."""
    rows = comparison.equation_rows(ensemble.plan)
    return [(results.ranges["pressure_height_mean_m"].high, "simulation, upper value of the steady mean"),
            (max(row["pressure_height_m"] for row in rows), "the paper's equations, greatest of the snows"),
            (ensemble.base + 3.0 * ensemble.plan["flow"]["depth_m"], "3 H above the bed, conservative for all snows (Sect. 5)")]


def governing_run_up(results):
    """(quantity of the greater of steady run-up and highest particle at any time, its Entry)"""
    key = "runup_p99_mean_m" if results.ranges["runup_p99_mean_m"].high > results.ranges["runup_peak_m"].high else "runup_peak_m"
    return key, results.table[results.governing(key)][key]


def is_run_up_determined(ensemble, results):
    """Whether the page states it."""
    _, entry = governing_run_up(results)
    return not still_growing(ensemble, results, "run-up")[0] and math.isfinite(entry.total) and entry.total <= NOT_DETERMINED * (entry.value - ensemble.base)


def run_up_row(ensemble, results):
    """(value, why) of the greater of the steady run-up and the highest particle at any time, that of the first splash or of a pile that grows."""
    splash, steady = results.ranges["runup_peak_m"], results.ranges["runup_p99_mean_m"]
    key, entry = governing_run_up(results)
    what = "highest particle at any time" if key == "runup_peak_m" else "height of 99 % of the snow before the mast, steady mean"
    mean = f"{short(steady.high)} m (Bernoulli’s bound H + v²/2g)" if steady.high == ensemble.bound else with_unit(upward(steady.high), "m")
    parts = (f"Steady mean: {mean}; "
             f"highest particle at any time: {short(splash.highest)} m on the finest grid, upper value {upward(splash.high)} m")
    mark, growing = still_growing(ensemble, results, "run-up")
    until = f"Until then keep parts above {upward(max(results.ranges[key].high, ensemble.bound))} m"
    if growing:
        reason, until = growing, f"{until} at least: the pile can become higher, how much is not known"
    elif is_run_up_determined(ensemble, results):
        keys = ("runup_peak_m", "runup_p99_mean_m")
        return f"{at_least(results, keys)}{upward(results.ranges[key].high)} m", (f"{ONE_GRID}; " if results.is_at_least(keys) else "") + f"upper value of: {what}. {parts}"
    else:
        reason = (f"The uncertainty of the grid is more than a third of the value{' above the bed' if ensemble.base else ''} ({what}): the grids are too coarse for a statement; "
                  f"{finer_grid(ensemble.plan)}")
    return (f"not determined ({f'{mark}, ' if mark else ''}{value_and_error(entry.value, entry.total)} m)",
            f"{reason}. {until}. {parts}")


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
    loads = [(f"force downstream, at the foundation{both}", "force", STATIC_FORCES), (f"overturning moment at the ground{both}", "moment", STATIC_MOMENTS)]
    if arm:
        loads += [(f"arm ({arm['base_m']:.4g} to {arm['height_m']:.4g} m above the ground): force {axis}", load, ())
                  for axis, load in (("downstream", "arm_force"), ("upwards", "arm_lift"))]
    for what, load, statics in loads:
        chosen, number = results.headline(load)
        if chosen is None:
            rows.append((what, UNKNOWN, "no run gives one"))
            continue
        snow, q = results.governing(chosen), by_key[chosen]
        entry = results.table[snow][chosen]
        why = f"upper value of: {q.label}, {with_unit(value_and_error(entry.value, entry.total, q.scale), q.unit)} ({ensemble.label(snow)})."
        if "vibration" in chosen:
            why += (" The height of the mast is not given: the load is taken to act where the mode has its unit of displacement, an upper bound; "
                    "give mast.height_m." if plan["mast"]["height_m"] is None else f" Without vibration {value(*results.upper(statics))}.")
        steady, steady_number = results.headline(load, steady_only=True)
        if steady is not None and chosen != steady and steady_number < number:
            why += f" What comes before the flow is steady included, such as the first impact of a vertical front (upper bound); while the flow is steady: {value(steady, steady_number)}."
        if load.startswith("arm"):
            why += arm_remark(ensemble, results, chosen)
        _, growing = still_growing(ensemble, results, load)
        rows.append((what, marked(ensemble, results, value(chosen, number), load),
                     why + (f" {growing}." if growing else "") + (f" {ONE_GRID}." if results.is_at_least(HEADLINES[load][1]) else "")))
    heights = [h for h in pressure_heights(ensemble, results) if math.isfinite(h[0])]
    top, source = max(heights)
    mark, growing = still_growing(ensemble, results, "pressure height")
    least = {where: at_least(results, ["pressure_height_mean_m"]) if where.startswith("simulation") else "" for _, where in heights}
    marks = {where: f", {mark}" if mark and where.startswith("simulation") else "" for _, where in heights}
    others = "; ".join(f"{where}: {least[where]}{upward(h)} m{marks[where]}" for h, where in heights if where != source)
    rows.append(("height of the pressure, for a simplified load", f"{least[source]}{upward(top)} m{marks[source]}",
                 f"the greatest of three: {source}; the others: {others}. They differ because 3 H covers every snow and width of the paper, the equations hold for a "
                 "box as wide as the flow is deep, and the simulation is of this mast and these snows; the computed load over height is in the line load below, the guideline's load over 3 H in its table" + (f". {growing}" if marks[source] else "")))
    rows.append(("run-up (keep parts that must not be struck above it)", *run_up_row(ensemble, results)))
    return rows
