"""Axes in the style of the report, and pictures of them for a page."""

from typing import NamedTuple

from mpmtools.figures.style import finish_axes, plt, svg_data


class Picture(NamedTuple):
    title: str
    caption: str
    data: str  # data address


def new_axes(width=6.2, height=4.3):
    return plt.subplots(figsize=(width, height), layout="constrained")[1]


def picture(axes, title, x, y, caption="", legend=True, **arguments):
    """Finishes axes and makes a picture of their figure; further arguments go to the legend."""
    axes.set_title(title, fontsize=10.5, loc="left")
    axes.set(xlabel=x, ylabel=y)
    finish_axes(axes)
    if legend and (arguments.get("handles") or axes.get_legend_handles_labels()[0]):
        axes.legend(**{"fontsize": 8.5, "frameon": True, "framealpha": 0.9, "edgecolor": "none", **arguments})
    return Picture(title, caption, svg_data(axes.figure))
