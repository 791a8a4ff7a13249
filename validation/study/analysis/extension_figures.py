"""Figures beyond the paper, from the folder of rows: masts of other heights, fronts, cross-sections.

Each function of SECTIONS takes the folder and returns what its section of the page shows. The others draw one panel, for figures.py too.
"""

import os

from analysis import loads
from analysis.axes import Drawn, froude_colour
from mpmtools.figures.style import COLOURS, MARKERS, new_axes, picture, plain_ticks
from mpmtools.scores import levels
from mpmtools.tables import read_series

FORCE = "force_mean_n.x"


def no_table(name):
    return Drawn([], [f"no table rows/{name}.csv"])


def mast_heights(axes, table, column=FORCE):
    """A column over the mean force on the tallest mast, over the height of the mast, for each Froude number."""
    for marker, (froude, of) in zip(MARKERS, table.sort_values("obstacle.height_m").groupby("froude_number")):
        height, tallest = of["obstacle.height_m"] / of.flow_height_m, of[FORCE].iat[-1]
        errors = 2.0 * of["force_standard_error_n.x"] / tallest if column == FORCE else None
        axes.errorbar(height, of[column] / tallest, yerr=errors, color=froude_colour(froude), marker=marker, markersize=5, linewidth=1.4, capsize=2,
                      label=f"Fr {froude:g}")
    axes.set_xscale("log")
    plain_ticks(axes.xaxis, [0.5, 8.1])


def mean_and_range(axes, factors, by, shift=1.0, **style):
    """Factors over a column: mean over M' with bars from the lowest to the highest. @param shift  of the points, as a factor"""
    spread = factors.groupby(by).factor.agg(["mean", "min", "max"])
    axes.errorbar(shift * spread.index, spread["mean"], yerr=[spread["mean"] - spread["min"], spread["max"] - spread["mean"]], markersize=5, capsize=2, **style)


def over_friction(axes, factors, by, quantity, style="-", name=""):
    """Factors over a column for each Froude number."""
    for marker, (froude, of) in zip(MARKERS, factors[factors.quantity == quantity].groupby("froude_number")):
        mean_and_range(axes, of, by, linestyle=style, color=froude_colour(froude), marker=marker, linewidth=1.4, label=f"{name}Fr {froude:g}")


def shapes(axes, factors, quantity):
    """Factors over the Froude number for each cross-section, side by side."""
    for i, (name, of) in enumerate(factors[(factors.quantity == quantity) & (factors["name"] != "square")].groupby("name", sort=False)):
        mean_and_range(axes, of, "froude_number", 1.03 ** (i - 3), color=COLOURS[i % len(COLOURS)], marker=MARKERS[i % len(MARKERS)], linewidth=1.2,
                       label=name.replace("_", " "))
    axes.axhline(1.0, color="black", linewidth=0.8)
    axes.set_xscale("log")
    plain_ticks(axes.xaxis, levels(factors.froude_number))


def of_fronts(factors):
    """With angle and slip as columns."""
    parts = factors["name"].str.split("_", expand=True)
    return factors.assign(front=parts[1].astype(float), slip=parts[3].astype(float))


def figure_mast_height(folder):
    path = os.path.join(folder, "height.csv")
    if not os.path.exists(path):
        return no_table("height")
    table = read_series(path)
    table = table[table.status == "done"].assign(froude_number=levels(table.froude_number))
    pictures = []
    for title, column, caption in (("(a) mean force", FORCE, "Stream-wise; bars: two standard errors."),
                                   ("(b) filtered peak of the force", "force_filtered_peak_n", "Highest force of the first impact, filtered over 0.1 s."),
                                   ("(c) force above the pressure height", "force_above_pressure_height_n",
                                    "What protrudes above the pressure height takes this part.")):
        axes = new_axes()
        mast_heights(axes, table, column)
        if column == FORCE:
            axes.axvline(3.0, color="0.5", linestyle="--", linewidth=1.0, label="three flow heights (Hauksson et al. 2007)")
        pictures.append(picture(axes, title, "height of the mast over the flow height", "over the mean force on the tallest mast", caption))
    return Drawn(pictures)


def factors_of(kind, folder):
    """The factors of a kind of load from a folder of rows; None without its table."""
    path = os.path.join(folder, f"{loads.FILES[kind]}.csv")
    return loads.MAKERS[kind](loads.read_rows(path)) if os.path.exists(path) else None


def figure_shapes(folder):
    factors = factors_of("shape", folder)
    if factors is None:
        return no_table("shapes")
    pictures = []
    for letter, (quantity, name) in zip("abcd", (("force", "mean force"), ("moment", "overturning moment"), ("runup", "run-up"), ("pressure_height", "pressure height"))):
        axes = new_axes()
        shapes(axes, factors, quantity)
        pictures.append(picture(axes, f"({letter}) {name}", "Froude number", "over the square that faces the flow",
                                "Mean over M', bars from the lowest to the highest.", ncols=2))
    return Drawn(pictures)


def figure_fronts(folder):
    factors = factors_of("front", folder)
    if factors is None:
        return no_table("fronts")
    factors = of_fronts(factors)
    vertical, plug = factors[factors.front == factors.front.max()], factors[factors.slip == factors.slip.max()]
    pictures = []
    for letter, (of, by, quantity, title, y) in zip("abcd", (
            (plug, "front", "peak_force", "filtered peak of the force, plug", "over the steady mean"),
            (vertical, "slip", "runup_over_plug", "run-up, sheared inflow", "over that of a plug"),
            (vertical, "slip", "moment_over_plug", "overturning moment, sheared inflow", "over that of a plug"),
            (vertical, "slip", "lever_arm", "arm of the mean force, sheared inflow", "over the flow height"))):
        axes = new_axes(height=3.8)
        over_friction(axes, of, by, quantity)
        pictures.append(picture(axes, f"({letter}) {title}", "angle of the front, degrees" if by == "front" else "speed at the floor over the mean speed (1: plug)",
                                y, "Mean over M', bars from the lowest to the highest."))
    return Drawn(pictures)


SECTIONS = [
    ("mast-height", "Beyond the paper: force against the height of the mast", figure_mast_height,
     "A mast lower than the run-up lets snow jump over it. Hauksson and others measured in chutes that the force no longer grows above "
     "some three flow heights. Loose snow, M = 0.4, β = 0, ξ = 5, dx = w/5."),
    ("shapes", "Beyond the paper: cross-sections", figure_shapes,
     "Squares turned against the flow, cylinder and wedges (half the angle of the edge), of one width across the flow, 1.75 m; M' 0.4 to 1.42, ξ = 5, dx = w/7."),
    ("fronts", "Beyond the paper: inclined fronts and sheared inflow", figure_fronts,
     "The discharge of a plug, with a speed that grows linearly from the floor to the surface, behind a front of 90, 45 or 20 degrees. "
     "The inlet, 5.25 m upstream, holds the profile. M' 0.4 to 1.2, ξ = 5, dx = w/7."),
]
