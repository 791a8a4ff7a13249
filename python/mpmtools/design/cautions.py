"""What to know before the values of the page are used, and how accurate they are."""

import math

from mpmtools.design import comparison
from mpmtools.design.headlines import NOT_DETERMINED, TAKE, durations, finer_grid, longer
from mpmtools.design.results import is_oblique
from mpmtools.design.rounding import short, upward
from mpmtools.design.vibration import MOST
from mpmtools.design.what_decides import not_scaled, scenario_rows


def uncertainties(results):
    """[(quantity, grid uncertainty over the value, of heights above the bed, the largest of the snows; whether it may be greater)] of the main quantities;
    NaN: not known."""
    def share(key):
        base, entries = results.finest[0].base * key.endswith("mean_m"), [row[key] for row in results.table]
        return max((e.grid / abs(e.value - base) for e in entries if math.isfinite(e.value) and math.isfinite(e.grid)), default=math.nan)

    return [(label, share(key), results.ranges[key].at_least) for key, label in (
        ("force_mean_n", "mean force"), ("moment_mean_n_m", "mean moment"), ("runup_p99_mean_m", "run-up"), ("pressure_height_mean_m", "pressure height"))]


def accuracy(results):
    """The same in words."""
    return ", ".join(f"{label} {'at least ' if more else ''}{100.0 * share:.0f} %" if math.isfinite(share) else f"{label} not known" for label, share, more in uncertainties(results))


def advice_rows(ensemble, results):
    """What to know before the values are used: the advice of the program about the runs, and what the runs show. [(text, snows)]"""
    plan = ensemble.plan
    wanted = [2.0 * plan["duration_s"]] if any(loads.growth or loads.is_late or not loads.is_steady for loads in results.finest) else []
    longest = short(max(durations(plan) + wanted, default=0.0))
    rows = [(TAKE.sub(longest, advice["text"]), "" if len(advice["snows"]) == len(plan["snows"]) else ", ".join(advice["snows"]).replace("_", " "))
            for advice in plan.get("advice", [])]  # an older program wrote none
    if "arm" not in plan:
        rows.append(("The loads are those of the mast alone. What protrudes from it (cross-arm, ladder, cable) is pressed up to the height of the run-up: see 'Elements that "
                     "protrude', or give a cross-arm as [arm]", ""))
    drag, guideline = results.ranges["drag_coefficient"], comparison.guideline_loads(plan)
    if math.isfinite(drag.high) and (remark := comparison.drag_remark(plan, drag.lowest, drag.highest)):
        rows.append((remark, ""))
    shares = [(label, share) for label, share, _ in uncertainties(results)]
    arms = [("force on the arm", "arm_force"), ("lift on the arm", "arm_lift")]
    for label, load in [("design force", "force"), ("design moment", "moment")] + ("arm" in plan) * arms:
        key, _ = results.headline(load)
        if key is not None and results.ranges[key].highest > 0.0:
            entry = results.table[results.governing(key)][key]
            shares.append((label, entry.grid / entry.value))
    if coarse := [f"{label} {100.0 * share:.0f} %" for label, share in shares if share > NOT_DETERMINED]:
        remedy = finer_grid(plan)
        rows.append((f"The grids are too coarse: their uncertainty is more than a third of the value ({', '.join(coarse)}). "
                     f"{remedy[0].upper()}{remedy[1:]}", ""))
    (_, own_force), (_, own_moment) = results.headline("force"), results.headline("moment")
    of_arm = [max(values) for values in zip((0.0, 0.0), *((force, force * at) for force, at in results.arm_loads().values()))]
    greater = {}  # row: its loads that are
    for what, own, unit in (("force", own_force - of_arm[0], "kN"), ("moment", own_moment - of_arm[1], "kN m")):
        most = max(guideline, key=lambda row: getattr(row, what))
        if getattr(most, what) > own:
            greater.setdefault(most, []).append(f"a {what} of {short(getattr(most, what), 1e-3)} {unit} against {upward(own, 1e-3)} {unit}")
    for most, loads in greater.items():
        rows.append((f"A load of the guideline ({most.what}) is greater than the computed one{' without the arm' if 'arm' in plan else ''}: {' and '.join(loads)}. It reaches to {short(most.extent)} m; "
                     "which of the two applies is the designer's decision", ""))
    scenarios = scenario_rows(ensemble, results)[1:]
    if note := not_scaled(scenarios, plan):
        rows.append((note, ""))
    for name, _, force, moment, error, _ in scenarios:
        if force > own_force or moment > own_moment:
            rows.append((f"Scenario {name} gives more than the values above: {upward(force, 1e-3)} kN and {upward(moment, 1e-3)} kN m by scaling "
                         f"(± {100.0 * error:.0f} %); make it [flow], or a site file of its own, if it is to be designed for", ""))
    if is_oblique(plan):
        rows.append((f"The mast is turned by {plan['mast']['angle_deg']:g}° against the flow: lateral force and torsion are below, in the axes of the flow; "
                     "the modes act downstream only; the line load and the guideline's load are those downstream"
                     + ("; the arm is computed across the flow, not turned with the mast" if "arm" in plan else ""), ""))
    if plan["modes"] and plan["mast"]["height_m"] is None:
        rows.append(("The height of the mast is not given, so the vibration is an upper bound: give mast.height_m, and shape_at_load where you know it", ""))
    if len(plan["modes"]) > MOST:
        rows.append((f"Of the {len(plan['modes'])} modes of the site file only the {MOST} lowest are taken", ""))
    for snow, loads in enumerate(results.finest):
        begin = f"begins at {loads.time[loads.steady][0]:.3g} of {plan['duration_s']:g} s" if loads.is_steady else ""
        if not loads.is_steady:
            rows.append((f"The run ends after {plan['duration_s']:g} s, before the flow is steady: it has no means, and more than its peaks can follow: {longer(plan)}", ensemble.label(snow)))
        elif loads.growth:
            rises = ", ".join(f"{name} {100.0 * rise:.0f} %" for name, rise in loads.growth.items())
            rows.append((f"The snow before the mast still piles up when the run ends: the steady interval {begin}, and "
                         f"{'since the splash' if loads.is_late else 'within it'} these rise: {rises}. A longer run gives more, how much is not known: {longer(plan)}", ensemble.label(snow)))
        elif loads.is_late:
            rows.append((f"The steady interval is short: it {begin}. Snow may still pile up before the mast: {longer(plan)}", ensemble.label(snow)))
    top = plan["mast"]["height_m"] or math.inf
    for key, what in (("runup_p99_mean_m", "the steady mean of the run-up"), ("runup_mean_m", "the steady mean of the highest particle"),
                      ("runup_peak_m", "the highest particle at any time")):
        if over := [i for i, row in enumerate(results.table) if row[key].value >= top]:
            highest = max(results.table[i][key].value for i in over)
            rows.append((f"The mast is overtopped: {what} reaches {short(highest)} m, and the mast is {top} m high; heights are those of a mast "
                         "that ends there; leave out mast.height_m for the run-up on a taller one",
                         "" if len(over) == len(plan["snows"]) else ", ".join(ensemble.label(i) for i in over)))
    return rows
