"""The two figures of the texts, as files: our heights against the published equations, and the runs beyond the paper."""

import os

import numpy as np
import pandas as pd

from analysis import extension_figures as panels
from analysis.axes import decades, scatter_runs
from analysis.facts import SETS
from analysis.study import ROWS, runs_of
from mpmtools import equations
from mpmtools.figures.style import finish_axes, plt, use_style
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
    table = pd.read_csv(ROWS / "height.csv", comment="#")
    panels.mast_heights(mast, table)
    mast.set(xlabel="height of the mast over H", ylabel="force over that on the tallest mast", title="mast height")
    fronts = panels.of_fronts(panels.factors_of("front", ROWS))
    for style, quantity, name in (("-", "moment_over_plug", "moment, "), ("--", "runup_over_plug", "run-up, ")):
        panels.over_friction(shear, fronts[fronts.front == 90.0], "slip", quantity, style, name)
    shear.set(xlabel="speed at the floor over the mean speed", ylabel="over that of a plug", title="sheared inflow")
    panels.shapes(shape, panels.factors_of("shape", ROWS), "force")
    shape.set(xlabel="Froude number", ylabel="force over that on the square that faces the flow", title="cross-section")
    for axes in (mast, shear, shape):
        finish_axes(axes)
        axes.legend(fontsize=8, ncols=1 if axes is mast else 2, loc="lower right" if axes is mast else "best")
    return figure
