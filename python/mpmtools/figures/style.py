"""What the pages of this project share: style sheet, colours, axes, and pictures as data addresses.

A page holds its images and needs no other file.
"""

import base64
import html
import io
import math
import pathlib
import re
from typing import NamedTuple

import markupsafe
import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402  (after the backend is chosen)
from matplotlib.ticker import FixedLocator, FuncFormatter, MaxNLocator, NullFormatter  # noqa: E402

# Distinct in hue and in lightness, so that they survive colour blindness and a grey printer.
COLOURS = ["#1f6fb4", "#d1601f", "#2e8b57", "#8b4fa8", "#b3262e", "#6b6b00", "#008b9a", "#9c5b3b"]
MARKERS = ["o", "s", "^", "D", "v", "P", "X", "*"]

STYLE = pathlib.Path(__file__).with_name("style.css").read_text(encoding="utf-8")


def inline(text):
    """The little Markdown that a paragraph uses: `code`, *emphasis*, [text](address)."""
    text = html.escape(text, quote=False)
    text = re.sub(r"`([^`]+)`", r"<code>\1</code>", text)
    text = re.sub(r"(?<![\w*])\*\*?([^*\s][^*]*)\*\*?(?!\w)", r"<em>\1</em>", text)
    text = re.sub(r"\[([^\]]+)\]\([^)]*\)", r"\1", text)
    return markupsafe.Markup(text)


def verdict_class(verdict):
    """Style of a verdict: "ok", "not met" (of a check), "ok, 3 not met" (of a case) or "FAILED"."""
    return "known" if verdict.endswith("not met") else {"ok": "ok"}.get(verdict, "failed")


def breakable(name):
    """A name that may break after an underscore."""
    return markupsafe.Markup("_<wbr>").join(markupsafe.escape(part) for part in name.split("_"))


def short(value):
    return "" if value is None else f"{value + 0.0:.4g}"  # + 0.0: a negative zero is 0


def finish_axes(axes):
    axes.grid(True, which="major", color="#e3e7ec", linewidth=0.8)
    axes.set_axisbelow(True)
    for side in ("top", "right"):
        axes.spines[side].set_visible(False)


def new_axes(width=6.2, height=4.3):
    return plt.subplots(figsize=(width, height), layout="constrained")[1]


class Picture(NamedTuple):
    title: str
    caption: str
    data: str  # data address


def picture(axes, title, x, y, caption="", legend=True, **arguments):
    """Finishes axes and makes a picture of their figure; further arguments go to the legend."""
    axes.set_title(title, fontsize=10.5, loc="left")
    axes.set(xlabel=x, ylabel=y)
    finish_axes(axes)
    if legend and (arguments.get("handles") or axes.get_legend_handles_labels()[0]):
        axes.legend(**{"fontsize": 8.5, "frameon": True, "framealpha": 0.9, "edgecolor": "none", **arguments})
    return Picture(title, caption, _data_address(axes.figure, "svg+xml", format="svg", metadata={"Date": None}))


def png_data(figure):
    return _data_address(figure, "png", format="png", dpi=130, metadata={"Software": None})


def _data_address(figure, kind, **options):
    """The image of a figure, which is closed. @param options  of savefig"""
    stream = io.BytesIO()
    figure.savefig(stream, **options)
    plt.close(figure)
    return f"data:image/{kind};base64," + base64.b64encode(stream.getvalue()).decode()


def nice_ticks(low, high):
    """Round numbers from low to high, at most six: 1, 2, 5 of each decade, or equal steps where fewer than three of those are inside."""
    decades = range(math.floor(math.log10(low)), math.ceil(math.log10(high)) + 1)
    for leading in ((1,), (1, 3), (1, 2, 5)):
        ticks = [float(f"{digit}e{power}") for power in decades for digit in leading if low <= float(f"{digit}e{power}") <= high]
        if 3 <= len(ticks) <= 6:
            return ticks
    for intervals in range(4, 10):
        ticks = [float(t) for t in MaxNLocator(nbins=intervals, steps=[1, 2, 5, 10]).tick_values(low, high) if low <= t <= high]
        if len(ticks) >= 2:
            break
    return ticks


def tick_label(value):
    """A number as a tick shows it: 0.002, 6·10⁻⁵."""
    if value == 0.0 or 1e-3 <= abs(value) < 1e5:
        return f"{value + 0.0:.5g}"
    digits, power = f"{value:.3e}".split("e")
    return rf"${float(digits):g}\cdot10^{{{int(power)}}}$"


def plain_ticks(axis, values):
    """A few round ticks on a logarithmic axis that spans less than two decades."""
    values = [v for v in values if math.isfinite(v) and v > 0]
    if values and max(values) / min(values) < 100:
        margin = (max(values) / min(values)) ** 0.04  # a little less than that of the axes
        axis.set_major_locator(FixedLocator(nice_ticks(min(values) / margin, max(values) * margin)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: tick_label(value)))
        axis.set_minor_formatter(NullFormatter())


def use_style():
    """Sets what all figures have in common."""
    matplotlib.rcParams.update({"font.size": 10, "svg.hashsalt": "libmpm", "axes.edgecolor": "#5a6675"})
