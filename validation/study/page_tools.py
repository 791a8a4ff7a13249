"""What the study's figures share: tables by column, axes in the style of the report, colours by Froude number.

Imported before report_style, whose folder it puts on the path.
"""

import csv
import os
import sys

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "../../scripts"))

import numpy as np  # noqa: E402  (after the path to the shared style)
from report_style import finish_axes, plain_ticks, plt, svg_data  # noqa: E402

FROUDE_NUMBERS = (0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 7.0)


def froude_colour(froude):
    """From blue (slow) over green to red (fast), by rank in the paper's list."""
    rank = int(np.argmin([abs(froude - f) for f in FROUDE_NUMBERS]))
    return plt.get_cmap("viridis")(0.88 * rank / (len(FROUDE_NUMBERS) - 1))


def per_cent(value, digits=1):
    return "–" if value is None or not np.isfinite(value) else f"{100 * value:.{digits}f} %"


def number(value, digits=3):
    return "–" if value is None or not np.isfinite(value) else f"{value:.{digits}f}"


def read_columns(path):
    """A table's columns by name, as numbers (nothing: nan) or text; none of them without the file."""
    if not os.path.exists(path):
        return {}
    with open(path, newline="", encoding="utf-8") as file:
        rows = list(csv.reader(line for line in file if not line.startswith("#")))
    columns = {}
    for i, column in enumerate(rows[0]):
        cells = [row[i] for row in rows[1:]]
        try:
            columns[column] = np.array([float(cell) if cell else np.nan for cell in cells])
        except ValueError:
            columns[column] = np.array(cells)
    return columns


def rows_where(table, **conditions):
    """Mask of the rows whose columns have these values."""
    length = len(next(iter(table.values()))) if table else 0
    mask = np.ones(length, bool)
    for column, value in conditions.items():
        mask &= (table[column] == value) if isinstance(value, str) else np.isclose(table[column], value, rtol=1e-6, atol=1e-9)
    return mask


def select(table, mask):
    return {column: values[mask] for column, values in table.items()}


def distinct(values):
    return sorted({round(float(v), 9) for v in values})


def new_axes(width=6.2, height=4.3):
    return plt.subplots(figsize=(width, height), layout="constrained")


def done(axes, title, x, y, legend=True, **arguments):
    axes.set_title(title, fontsize=10.5, loc="left")
    axes.set(xlabel=x, ylabel=y)
    finish_axes(axes)
    if legend and (arguments.get("handles") or axes.get_legend_handles_labels()[0]):
        axes.legend(**{"fontsize": 8.5, "frameon": True, "framealpha": 0.9, "edgecolor": "none", **arguments})
    return svg_data(axes.figure)


def decades(axes, which, values):
    """A logarithmic axis with plain numbers where it spans less than two decades."""
    values = [float(v) for v in values if np.isfinite(v) and v > 0]
    if not values:
        return
    (axes.set_xscale if which == "x" else axes.set_yscale)("log")
    plain_ticks(axes.xaxis if which == "x" else axes.yaxis, values)
