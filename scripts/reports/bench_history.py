"""The record of the speed comparisons (benchmarks/history.csv): ratios of times with their intervals and verdicts."""

import io
import math

import numpy as np
import pandas as pd
from matplotlib.ticker import FuncFormatter, MaxNLocator

from mpmtools.figures.style import finish_axes, plt
from mpmtools.files import read_text, save_figure

VERDICT_COLOURS = {"faster": "#1c7a43", "slower": "#b3262e", "no change": "#5a6675"}
SHOWN = 12  # comparisons, the latest
SMALLEST_RANGE = 6.0  # per cent, either side of the baseline on every axis: a change of 5 % is seen


def draw_history(history, target, machine, threshold):
    """Draws the rows of `machine` in the table `history` into the file `target`; returns False if there are none."""
    rows = pd.read_csv(io.StringIO(read_text(history)), dtype={"commit": str, "baseline": str})  # 005551511e13 is a commit, not a number
    rows = rows[rows.machine == machine]
    if rows.empty:
        return False
    figure = history_figure(rows, threshold)
    save_figure(figure, target, dpi=130)
    return True


def history_figure(rows, threshold):
    """One panel a kernel, one point a comparison: change of the time against the baseline, with the interval and the verdict.

    A cross is the change of the number of instructions, which has no noise. The grey band holds the changes below `threshold`, which
    are not called.
    """
    comparisons = list(dict.fromkeys(zip(rows.date, rows.commit, rows.baseline)))[-SHOWN:]
    place = {comparison: i for i, comparison in enumerate(comparisons)}
    rows = rows.assign(place=[place.get(key, np.nan) for key in zip(rows.date, rows.commit, rows.baseline)]).dropna(subset="place")
    kernels = list(dict.fromkeys(rows.kernel))
    lines = math.ceil(len(kernels) / 2)
    figure, axes = plt.subplots(lines, 2, squeeze=False, sharex=True, layout="constrained", figsize=(11.0, 1.2 + 2.0 * lines))
    for axis, kernel in zip(axes.flat, kernels):
        _draw_kernel(axis, kernel, rows[rows.kernel == kernel], threshold)
    for axis in axes.flat[len(kernels):]:
        axis.axis("off")
    labels = [f"{commit[:12]}\nagainst {baseline[:12]}\n{date[:10]}" for date, commit, baseline in comparisons]
    for axis in axes[-1]:
        axis.set_xlim(-0.6, len(comparisons) - 0.4)
        axis.set_xticks(range(len(comparisons)), labels, rotation=90 if len(comparisons) > 4 else 0, fontsize=7)
    handles = [plt.Line2D([], [], color=colour, marker="o", linestyle="", label=verdict) for verdict, colour in VERDICT_COLOURS.items()]
    handles.append(plt.Line2D([], [], color="black", marker="x", linestyle="", label="instructions"))
    axes[0, -1].legend(handles=handles, loc="lower right", bbox_to_anchor=(1.0, 1.08), ncols=4, fontsize=9, frameon=False)
    figure.suptitle(f"Change of the time against the baseline, one thread; bars: 99 % interval; band: ±{100 * threshold:.0f} %"
                    f"\n{rows.machine.iat[0]}", fontsize=10, x=0.01, ha="left")
    return figure


def _draw_kernel(axis, kernel, rows, threshold):
    """In per cent off the baseline."""
    off = {name: 100.0 * (rows[name] - 1.0) for name in ("ratio", "ratio_low", "ratio_high", "instruction_ratio")}
    axis.axhspan(-100.0 * threshold, 100.0 * threshold, color="#e8ebef", zorder=0)
    axis.axhline(0.0, color="black", linewidth=0.8, zorder=1)
    axis.plot(rows.place, off["instruction_ratio"], "x", color="black", markersize=5, zorder=2)
    for verdict, colour in VERDICT_COLOURS.items():
        mine = rows.verdict == verdict
        ratio, low, high = (off[name][mine] for name in ("ratio", "ratio_low", "ratio_high"))
        axis.errorbar(rows.place[mine], ratio, yerr=[ratio - low, high - ratio], fmt="o", capsize=4, markersize=5, color=colour, zorder=3)
        for place, value in zip(rows.place[mine], ratio) if verdict != "no change" else ():
            axis.annotate(f"{verdict}, {value:+.1f} %", (place, value), xytext=(7, 0), textcoords="offset points", fontsize=7.5, va="center",
                          color=colour)
    reach = 1.15 * max(SMALLEST_RANGE, *(np.nanmax(np.abs(values)) for values in off.values() if values.notna().any()))
    axis.set_ylim(-reach, reach)
    axis.yaxis.set_major_locator(MaxNLocator(6, steps=[1, 2, 5, 10]))
    axis.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:+g} %" if abs(value) > 1e-9 else "0"))
    axis.set_title(kernel, fontsize=9.5, loc="left")
    finish_axes(axis)
