"""What the figures of the study share: what a section of the page shows, colours by Froude number, numbers as text."""

from typing import NamedTuple

import numpy as np

from mpmtools.figures.style import MARKERS, plain_ticks, plt

FROUDE_NUMBERS = (0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 7.0)


class Drawn(NamedTuple):
    """What a section of the page shows."""

    pictures: list
    missing: list = []  # sentences on what could not be drawn
    tables: list = []  # dicts of title, head and rows


def froude_colour(froude):
    """From blue (slow) over green to yellow (fast), by rank in the paper's list."""
    rank = int(np.argmin([abs(froude - f) for f in FROUDE_NUMBERS]))
    return plt.get_cmap("viridis")(0.88 * rank / (len(FROUDE_NUMBERS) - 1))


def xi_marker(xi):
    return dict(zip((5.0, 0.5, 0.05, 1.5, 0.15, 15.0), MARKERS)).get(xi, "x")


def per_cent(value, digits=1):
    return "–" if value is None or not np.isfinite(value) else f"{100 * value:z.{digits}f} %"


def number(value, digits=3):
    return "–" if value is None or not np.isfinite(value) else f"{value:z.{digits}f}"


def decades(axes, which, values):
    """A logarithmic axis with plain numbers where it spans less than two decades."""
    values = [float(v) for v in values if np.isfinite(v) and v > 0]
    if not values:
        return
    (axes.set_xscale if which == "x" else axes.set_yscale)("log")
    plain_ticks(axes.xaxis if which == "x" else axes.yaxis, values)


def scatter_runs(axes, points, x, y):
    """Runs coloured by Fr, with a symbol for xi; @return handles for a legend of both."""
    for xi, rows in points.groupby("hardening_xi"):
        axes.scatter(rows[x], rows[y], c=rows.froude_number.map(froude_colour), marker=xi_marker(xi), s=22, linewidths=0.4, edgecolors="white",
                     zorder=3)

    def handle(label, **style):
        return plt.Line2D([], [], linestyle="", markersize=5, label=label, **style)

    froude, xis = np.sort(points.froude_number.unique()), np.sort(points.hardening_xi.unique())
    return ([handle(f"Fr = {f:g}", color=froude_colour(f), marker="o") for f in froude]
            + [handle(rf"$\xi$ = {xi:g}", color="#5a6675", marker=xi_marker(xi)) for xi in xis])
