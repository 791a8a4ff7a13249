"""The two figures of the texts, as files: our heights against the published equations, and the runs beyond the paper."""

import os

import numpy as np
import pandas as pd

from analysis.axes import decades, froude_colour, scatter_runs
from analysis.facts import SETS
from analysis.study import ROWS, runs_of
from mpmtools import equations
from mpmtools.figures.style import COLOURS, MARKERS, finish_axes, plain_ticks, plt, use_style
from mpmtools.fit.regression import EQUATIONS

LABELS = {"runup": "run-up over H", "pressure_height": "pressure height over H"}


def draw(folder):
    os.makedirs(folder, exist_ok=True)
    use_style()
    for name, make in (("heights", heights), ("extensions", extensions)):
        figure = make()
        figure.savefig(os.path.join(folder, f"{name}.png"), dpi=90, metadata={"Software": None})
        plt.close(figure)


def heights():
    """Simulated heights of the reproduction over those of the published equations."""
    runs = SETS["_fluid"](runs_of("reproduction"))
    figure, panels = plt.subplots(1, 2, figsize=(11.5, 4.9), layout="constrained")
    for axes, equation in zip(panels, EQUATIONS):
        of = runs[np.isfinite(runs[equation.name])].assign(
            published=lambda t, e=equation: equations.relative_height(t.effective_friction, t.froude_number, e.published))
        handles = scatter_runs(axes, of, "published", equation.name)
        line = np.array([0.9, 1.1 * max(of.published.max(), of[equation.name].max())])
        axes.plot(line, line, color="black", linewidth=1.2)
        for factor in (0.75, 1.25):
            axes.plot(line, factor * line, "--", color="#808890", linewidth=1.0)
        if equation.logarithmic:
            for which, values in (("x", of.published), ("y", of[equation.name])):
                decades(axes, which, values)
        finish_axes(axes)
        axes.set(xlabel=f"{LABELS[equation.name]}, published equation", ylabel=f"{LABELS[equation.name]}, our run")
        axes.legend(handles=handles, fontsize=8, ncols=2, loc="upper left")
    return figure


def extensions():
    """Force over the height of the mast, sheared inflow, cross-sections."""
    figure, (mast, shear, shape) = plt.subplots(1, 3, figsize=(14.5, 4.4), layout="constrained")
    table = pd.read_csv(ROWS / "height.csv", comment="#").sort_values("obstacle.height_m")
    for marker, (froude, of) in zip(MARKERS, table.groupby("froude_number")):
        force = of["force_mean_n.x"]
        mast.plot(of["obstacle.height_m"] / of.flow_height_m, force / force.iat[-1], marker=marker, color=froude_colour(froude), label=f"Fr {froude:g}")
    mast.set_xscale("log")
    plain_ticks(mast.xaxis, [0.5, 8.1])
    mast.set(xlabel="height of the mast over H", ylabel="force over that on the tallest mast", title="mast height")
    table = pd.read_csv(ROWS / "inflow.csv", comment="#")
    table = table.assign(slip=table["conveyor.inflow_slip_ratio"].fillna(1.0)).sort_values("slip")
    for style, column, name in (("-", "moment_mean_n_m.y", "moment"), ("--", "runup_mean_m", "run-up")):
        for marker, (froude, of) in zip(MARKERS, table.groupby("froude_number")):
            shear.plot(of.slip, of[column] / of[column].iat[-1], style, marker=marker, color=froude_colour(froude), label=f"{name}, Fr {froude:g}")
    shear.set(xlabel="speed at the floor over the mean speed", ylabel="over that of a plug", title="sheared inflow")
    table = pd.read_csv(ROWS / "shapes.csv", comment="#")
    for i, (column, name) in enumerate((("force_mean_n.x", "force"), ("runup_mean_m", "run-up"), ("pressure_height_mean_m", "pressure height"))):
        shape.bar(np.arange(len(table)) + 0.27 * (i - 1), table[column] / table[column].iat[0], 0.25, color=COLOURS[i], label=name)
    shape.set_xticks(range(len(table)), [name.rsplit("_fr", 1)[0].replace("_", " ") for name in table.name])
    shape.set(ylabel="over that of the box", title="cross-section, Fr 3", ylim=(0.0, 1.35))
    for axes in (mast, shear, shape):
        finish_axes(axes)
        axes.legend(fontsize=8, ncols=2 if axes is shear else 1, loc="upper right" if axes is not mast else "lower right")
    return figure
