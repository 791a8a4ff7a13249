"""Figures beyond the paper, from the tables in extensions/: results.csv of `mpm campaign run extensions/<plan>.toml`, and a run's series.

Each function returns (pictures, what is missing), as those of study_page.py.
"""

import os
from collections import namedtuple

import numpy as np
from page_tools import distinct, done, froude_colour, new_axes, number, read_columns, rows_where, select
from report_style import COLOURS, MARKERS, plain_ticks

HERE = os.path.join(os.path.dirname(os.path.abspath(__file__)), "extensions")
# scale: from the column's unit to the one shown; error: column of the standard error
Quantity = namedtuple("Quantity", "name unit scale digits column error")
FORCE = Quantity("mean force", "kN", 1e-3, 0, "force_mean_n.x", "force_standard_error_n.x")
PEAK = Quantity("filtered peak of the force", "kN", 1e-3, 0, "force_filtered_peak_n", None)
RUNUP = Quantity("mean run-up", "m", 1.0, 2, "runup_mean_m", "runup_standard_error_m")
PRESSURE_HEIGHT = Quantity("mean pressure height", "m", 1.0, 2, "pressure_height_mean_m", "pressure_height_standard_error_m")
RESULTANT = Quantity("height of the resultant force", "m", 1.0, 2, "force_resultant_height_m", None)


def finished(name):
    table = read_columns(os.path.join(HERE, name + ".csv"))
    return select(table, table["status"] == "done") if table else {}


def no_table(name):
    return [], [f"no table of `mpm campaign run validation/study/extensions/{name}.toml`"]


def two_errors(table, quantity, scale):
    return None if quantity.error is None else 2.0 * scale * table[quantity.error]


def caption(quantity):
    return "Bars: two standard errors." if quantity.error else ""


def figure_mast_height():
    table = finished("height")
    if not table:
        return no_table("height")
    panels = {"ratio": new_axes(), "peak": new_axes(), "above": new_axes()}
    for i, froude in enumerate(distinct(table["froude_number"])):
        rows = select(table, rows_where(table, froude_number=froude))
        rows = select(rows, np.argsort(rows["obstacle.height_m"]))
        h, force = rows["obstacle.height_m"] / rows["flow_height_m"], rows[FORCE.column]
        style = {"color": froude_colour(froude), "marker": MARKERS[i], "markersize": 5, "linewidth": 1.4, "label": f"Fr = {froude:g}"}
        panels["ratio"][1].errorbar(h, force / force[-1], yerr=two_errors(rows, FORCE, 1.0 / force[-1]), capsize=2, **style)
        panels["peak"][1].plot(h, rows[PEAK.column] / force[-1], **style)
        panels["above"][1].plot(h, 100.0 * rows["force_above_pressure_height_n"] / force, **style)
    for _, axes in panels.values():
        axes.set_xscale("log")
        plain_ticks(axes.xaxis, [0.5, 8.1])
    panels["ratio"][1].axvline(3.0, color="0.5", linestyle="--", linewidth=1.0, label="three flow heights (Hauksson et al. 2007)")
    axis = "height of the mast over the flow height"
    over = "over the mean force on the tallest mast"
    return [("(a) mean force", "Stream-wise; bars: two standard errors.", done(panels["ratio"][1], "(a) mean force, stream-wise", axis, over)),
            ("(b) first impact", "Highest force of the first impact, filtered over 0.1 s.", done(panels["peak"][1], "(b) filtered peak of the force", axis, over)),
            ("(c) above the pressure height", "What protrudes above the pressure height takes this share.",
             done(panels["above"][1], "(c) force above the pressure height", axis, "share of the mean force [%]"))], []


def figure_shapes():
    table = finished("shapes")
    if not table:
        return no_table("shapes")
    names = [str(name).rsplit("_fr", 1)[0].replace("_", " ") for name in table["name"]]
    pictures = []
    for letter, colour, q in zip("abcd", COLOURS, (FORCE, PEAK, RUNUP, PRESSURE_HEIGHT)):
        values = q.scale * table[q.column]
        _, axes = new_axes(height=3.2)
        bars = axes.barh(range(len(names)), values, xerr=two_errors(table, q, q.scale), color=colour, height=0.6, capsize=3)
        axes.bar_label(bars, [number(v, q.digits) for v in values], padding=6, fontsize=9)
        axes.set_yticks(range(len(names)), names)
        axes.invert_yaxis()
        axes.set_xlim(0, 1.18 * np.max(values))
        title = f"({letter}) {q.name}, Fr = {table['froude_number'][0]:g}"
        pictures.append((title, caption(q), done(axes, title, f"{q.name} [{q.unit}]", "")))
    return pictures, []


def figure_shear():
    table = finished("inflow")
    if not table:
        return no_table("inflow")
    table["conveyor.inflow_slip_ratio"] = np.nan_to_num(table["conveyor.inflow_slip_ratio"], nan=1.0)  # no value: a plug
    pictures = []
    for letter, q in zip("abcd", (RUNUP, PRESSURE_HEIGHT, FORCE, RESULTANT)):
        _, axes = new_axes(height=3.8)
        for marker, froude in zip(MARKERS, distinct(table["froude_number"])):
            rows = select(table, rows_where(table, froude_number=froude))
            rows = select(rows, np.argsort(rows["conveyor.inflow_slip_ratio"]))
            plug = rows[q.column][-1]
            axes.errorbar(rows["conveyor.inflow_slip_ratio"], rows[q.column] / plug, yerr=two_errors(rows, q, 1.0 / plug), color=froude_colour(froude), marker=marker,
                          markersize=5, linewidth=1.4, capsize=2, label=f"Fr = {froude:g}: plug {number(q.scale * plug, q.digits)} {q.unit}")
        axes.axhline(1.0, color="black", linewidth=0.8)
        title = f"({letter}) {q.name}"
        pictures.append((title, caption(q), done(axes, title, "speed at the floor over the mean speed (1: plug)", "over that of plug inflow")))
    return pictures, []


def figure_surge():
    series = read_columns(os.path.join(HERE, "surge.csv"))
    if not series:
        return [], ["no series of the run of `mpm campaign run validation/study/extensions/surge.toml`"]
    instants = ((0.0, "front, 12 m/s, 1 m"), (2.0, "10 m/s, 2 m"), (4.0, "5 % denser"), (7.0, "3 m/s, 1.25 m"))
    panels = []
    for title, label, lines in (("(a) stream-wise force", "force on the mast [kN]", (("force_x_n", 1e-3, "mean of 20 ms", COLOURS[0]),)),
                                ("(b) heights", "height [m]", (("runup_m", 1.0, "run-up", COLOURS[1]), ("pressure_height_m", 1.0, "pressure height", COLOURS[2])))):
        _, axes = new_axes()
        for column, scale, name, colour in lines:
            axes.plot(series["time_s"], scale * series[column], color=colour, linewidth=1.1, label=name)
        for instant, what in instants:
            axes.axvline(instant, color="0.6", linestyle="--", linewidth=0.9)
            axes.annotate(what, (instant, 0.97), xytext=(-3, 0), xycoords=("data", "axes fraction"), textcoords="offset points", fontsize=7.5, rotation=90, va="top", ha="right",
                          color="#5a6675")
        axes.set_ylim(bottom=0)
        panels.append((title, "Dashed: what enters at the inlet, 8.4 m upstream, from then on.", done(axes, title, "time since the front reached the mast [s]", label, loc="upper right")))
    return panels, []


SECTIONS = [
    ("mast-height", "Beyond the paper: force against the height of the mast", figure_mast_height,
     "A mast lower than the run-up lets snow jump over it. Hauksson and others measured in chutes that the force no longer grows above some three flow heights. Loose snow, M = 0.4, β = 0, ξ = 5, dx = w/5."),
    ("shapes", "Beyond the paper: cross-sections", figure_shapes,
     "Box, cylinder, wedge of 30° half angle and square on its edge, of one width across the flow, 1.75 m; the same snow, dx = w/7."),
    ("shear", "Beyond the paper: sheared inflow", figure_shear,
     "The discharge of a plug, with a speed that grows linearly from the floor to the surface: at the floor 40 % of the mean, or nothing. The inlet, 5.25 m upstream, holds the profile. dx = w/5."),
    ("surge", "Beyond the paper: a surge, whose height, speed and density vary", figure_surge,
     "A thin fast front, then a surge of twice its height, then a slow tail that was compacted on its way. There is no steady span; the table of such a run says so. dx = w/5."),
]
