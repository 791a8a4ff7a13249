"""Figures beyond the paper, from a folder of tables: results.csv of plans of extensions/.

Each function takes the folder and returns what its section of the page shows.
"""

import os
from typing import NamedTuple

from analysis.axes import Drawn, froude_colour, number
from mpmtools.figures.axes import new_axes, picture
from mpmtools.figures.style import COLOURS, MARKERS, plain_ticks
from mpmtools.scores import levels
from mpmtools.tables import read_series


class Quantity(NamedTuple):
    name: str
    unit: str
    scale: float  # from the unit of the column to the one shown
    digits: int
    column: str
    error: str | None  # column of the standard error


FORCE = Quantity("mean force", "kN", 1e-3, 0, "force_mean_n.x", "force_standard_error_n.x")
PEAK = Quantity("filtered peak of the force", "kN", 1e-3, 0, "force_filtered_peak_n", None)
RUNUP = Quantity("mean run-up", "m", 1.0, 2, "runup_mean_m", "runup_standard_error_m")
PRESSURE_HEIGHT = Quantity("mean pressure height", "m", 1.0, 2, "pressure_height_mean_m", "pressure_height_standard_error_m")
RESULTANT = Quantity("height of the resultant force", "m", 1.0, 2, "force_resultant_height_m", None)


def finished_runs(folder, name):
    """The rows of a campaign's table whose status is done; None without the table."""
    path = os.path.join(folder, f"{name}.csv")
    if not os.path.exists(path):
        return None
    table = read_series(path)
    return table[table.status == "done"].assign(froude_number=levels(table.froude_number))


def no_table(name):
    return Drawn([], [f"no table rows/{name}.csv"])


def two_errors(table, quantity, scale):
    return None if quantity.error is None else 2.0 * scale * table[quantity.error]


def caption(quantity):
    return "Bars: two standard errors." if quantity.error else ""


def figure_mast_height(folder):
    table = finished_runs(folder, "height")
    if table is None:
        return no_table("height")
    ratio, peak, above = new_axes(), new_axes(), new_axes()
    for i, (froude, rows) in enumerate(table.sort_values("obstacle.height_m").groupby("froude_number")):
        height, force = rows["obstacle.height_m"] / rows.flow_height_m, rows[FORCE.column]
        tallest = force.iat[-1]
        style = {"color": froude_colour(froude), "marker": MARKERS[i], "markersize": 5, "linewidth": 1.4, "label": f"Fr = {froude:g}"}
        ratio.errorbar(height, force / tallest, yerr=two_errors(rows, FORCE, 1.0 / tallest), capsize=2, **style)
        peak.plot(height, rows[PEAK.column] / tallest, **style)
        above.plot(height, 100.0 * rows.force_above_pressure_height_n / force, **style)
    for axes in (ratio, peak, above):
        axes.set_xscale("log")
        plain_ticks(axes.xaxis, [0.5, 8.1])
    ratio.axvline(3.0, color="0.5", linestyle="--", linewidth=1.0, label="three flow heights (Hauksson et al. 2007)")
    axis, over = "height of the mast over the flow height", "over the mean force on the tallest mast"
    return Drawn([
        picture(ratio, "(a) mean force, stream-wise", axis, over, "Stream-wise; bars: two standard errors."),
        picture(peak, "(b) filtered peak of the force", axis, over, "Highest force of the first impact, filtered over 0.1 s."),
        picture(above, "(c) force above the pressure height", axis, "part of the mean force [%]",
                "What protrudes above the pressure height takes this part."),
    ])


def figure_shapes(folder):
    table = finished_runs(folder, "shapes")
    if table is None:
        return no_table("shapes")
    names = [name.rsplit("_fr", 1)[0].replace("_", " ") for name in table.name]
    pictures = []
    for letter, colour, q in zip("abcd", COLOURS, (FORCE, PEAK, RUNUP, PRESSURE_HEIGHT)):
        values = q.scale * table[q.column]
        axes = new_axes(height=3.2)
        bars = axes.barh(range(len(names)), values, xerr=two_errors(table, q, q.scale), color=colour, height=0.6, capsize=3)
        axes.bar_label(bars, [number(v, q.digits) for v in values], padding=6, fontsize=9)
        axes.set_yticks(range(len(names)), names)
        axes.invert_yaxis()
        axes.set_xlim(0, 1.18 * values.max())
        title = f"({letter}) {q.name}, Fr = {table.froude_number.iat[0]:g}"
        pictures.append(picture(axes, title, f"{q.name} [{q.unit}]", "", caption(q)))
    return Drawn(pictures)


def figure_shear(folder):
    table = finished_runs(folder, "inflow")
    if table is None:
        return no_table("inflow")
    table = table.assign(slip=table["conveyor.inflow_slip_ratio"].fillna(1.0)).sort_values("slip")  # no value: a plug
    pictures = []
    for letter, q in zip("abcd", (RUNUP, PRESSURE_HEIGHT, FORCE, RESULTANT)):
        axes = new_axes(height=3.8)
        for marker, (froude, rows) in zip(MARKERS, table.groupby("froude_number")):
            plug = rows[q.column].iat[-1]
            axes.errorbar(rows.slip, rows[q.column] / plug, yerr=two_errors(rows, q, 1.0 / plug), color=froude_colour(froude), marker=marker,
                          markersize=5, linewidth=1.4, capsize=2, label=f"Fr = {froude:g}: plug {number(q.scale * plug, q.digits)} {q.unit}")
        axes.axhline(1.0, color="black", linewidth=0.8)
        pictures.append(picture(axes, f"({letter}) {q.name}", "speed at the floor over the mean speed (1: plug)", "over that of plug inflow",
                                caption(q)))
    return Drawn(pictures)


SECTIONS = [
    ("mast-height", "Beyond the paper: force against the height of the mast", figure_mast_height,
     "A mast lower than the run-up lets snow jump over it. Hauksson and others measured in chutes that the force no longer grows above "
     "some three flow heights. Loose snow, M = 0.4, β = 0, ξ = 5, dx = w/5."),
    ("shapes", "Beyond the paper: cross-sections", figure_shapes,
     "Box, cylinder, wedge of 30° half angle and square on its edge, of one width across the flow, 1.75 m; the same snow, dx = w/7."),
    ("shear", "Beyond the paper: sheared inflow", figure_shear,
     "The discharge of a plug, with a speed that grows linearly from the floor to the surface: at the floor 40 % of the mean, or nothing. "
     "The inlet, 5.25 m upstream, holds the profile. dx = w/5."),
]
