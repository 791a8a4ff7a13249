#!/usr/bin/python3
"""Draws the figures of the theory pages into docs/images/theory: draw.py [OUT]. The same input gives the same bytes."""

import pathlib
import sys

import matplotlib
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parents[1] / "python"))
matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402  (after the backend is chosen)
from matplotlib.patches import FancyArrowPatch, Polygon, Rectangle  # noqa: E402

from mpmtools import equations  # noqa: E402  (after its path)

BLUE, ORANGE, GREEN, RED, GREY = "#1f5fa8", "#d9641e", "#2f8f4e", "#b3262e", "#5a6675"


def weight(s):
    s = np.abs(s)
    return np.where(s <= 0.5, 0.75 - s**2, np.where(s <= 1.5, 0.5 * (1.5 - s) ** 2, 0.0))


def arrow(axes, start, end, colour, width=1.4):
    axes.add_patch(FancyArrowPatch(start, end, arrowstyle="-|>", mutation_scale=10, color=colour, linewidth=width, shrinkA=0, shrinkB=0))


def nodes(axes, columns, rows, colour=GREY):
    for x in range(columns + 1):
        axes.plot([x, x], [0, rows], color="0.85", linewidth=0.8, zorder=0)
    for y in range(rows + 1):
        axes.plot([0, columns], [y, y], color="0.85", linewidth=0.8, zorder=0)
    x, y = np.meshgrid(range(columns + 1), range(rows + 1))
    axes.plot(x.ravel(), y.ravel(), ".", color=colour, markersize=4)


def bare(axes, left, right, bottom, top):
    axes.set(xlim=(left, right), ylim=(bottom, top))
    axes.set_aspect("equal")
    axes.axis("off")


def step():
    figure, parts = plt.subplots(1, 3, figsize=(10, 3.6), layout="constrained")
    random = np.random.default_rng(3)
    cloud = np.array([(i + 0.25 + 0.5 * a, j + 0.25 + 0.5 * b) for i in (1, 2) for j in (1, 2) for a in (0, 1) for b in (0, 1)])
    cloud = cloud + 0.12 * random.standard_normal(cloud.shape)
    particle, moved = np.array([2.3, 2.35]), np.array([2.75, 2.6])
    around = np.array([(x, y) for x in (1, 2, 3) for y in (1, 2, 3)])
    titles = ("1. Particles give mass\nand momentum to nodes", "2. Nodes are moved by forces;\nwalls act on them", "3. Particles take their velocity\nfrom nodes and move")
    for number, (axes, title) in enumerate(zip(parts, titles)):
        nodes(axes, 4, 4)
        axes.scatter(*cloud.T, s=22, color=BLUE, alpha=0.35, linewidths=0)
        axes.set_title(title, fontsize=10)
        bare(axes, -0.3, 4.6, -0.3, 4.3)
        if number == 1:
            for x, y in around:
                arrow(axes, (x, y), (x + 0.62, y + 0.26), ORANGE)
            axes.scatter(*around.T, s=26, color=ORANGE, zorder=3)
            continue
        place = particle
        for node in around:
            start, end = (place, node) if number == 0 else (node, place)
            w = float(weight(node[0] - place[0]) * weight(node[1] - place[1]))
            arrow(axes, start + 0.12 * (end - start), start + 0.88 * (end - start), GREEN if number == 0 else ORANGE, 0.6 + 4.0 * w)
        axes.scatter(*place, s=70, color=BLUE, zorder=4)
        if number == 2:
            axes.scatter(*moved, s=70, facecolors="none", edgecolors=BLUE, linewidths=1.6, zorder=4)
            arrow(axes, place, moved, BLUE, 1.8)
    return figure


def bspline():
    figure, axes = plt.subplots(figsize=(7, 3), layout="constrained")
    s = np.linspace(-2.5, 2.5, 501)
    for centre, colour in ((-1, "0.7"), (1, "0.7"), (0, BLUE)):
        axes.plot(s, weight(s - centre), color=colour, linewidth=2.2 if centre == 0 else 1.4)
    axes.plot(s, sum(weight(s - k) for k in range(-5, 6)), color=GREEN, linestyle="--", label="sum over all nodes")
    axes.set(xlabel=r"$(x_p - x_i)\,/\,\Delta x$", ylabel="weight $N$", ylim=(0, 1.1))
    axes.set_xticks(range(-2, 3))
    axes.grid(alpha=0.3)
    axes.legend(loc="upper right", fontsize="small")
    return figure


def yield_surface():
    figure, axes = plt.subplots(figsize=(7, 3.8), layout="constrained")
    slope = 0.8
    for beta, colour in ((0.0, GREEN), (0.15, BLUE), (0.3, ORANGE)):
        p = np.linspace(-beta, 1.0, 800)
        q = slope * np.sqrt(np.maximum(0.0, -(p + beta) * (p - 1.0)) / (1.0 + 2.0 * beta))
        axes.plot(p, q, color=colour, linewidth=2, label=rf"$\beta$ = {beta:g}, $M'$ = {float(equations.effective_friction(slope, beta)):.2f}")
        critical = 0.5 * (1.0 - beta)
        top = float(equations.effective_friction(slope, beta)) * critical
        axes.plot([0, critical], [0, top], color=colour, linestyle=":", linewidth=1.3)
        axes.plot([critical], [top], "o", color=colour)
    axes.annotate("critical state", (0.5, 0.4), (0.62, 0.47), arrowprops={"arrowstyle": "->", "color": GREY}, color=GREY)
    axes.annotate("compacts, hardens", (0.86, 0.28), (0.90, 0.36), arrowprops={"arrowstyle": "->", "color": GREY}, color=GREY)
    axes.annotate("dilates, softens", (0.06, 0.25), (-0.3, 0.40), arrowprops={"arrowstyle": "->", "color": GREY}, color=GREY)
    axes.axhline(0, color="0.3", linewidth=0.8)
    axes.axvline(0, color="0.3", linewidth=0.8)
    axes.set(xlabel="$p\\,/\\,p_c$", ylabel="$q\\,/\\,p_c$", xlim=(-0.42, 1.2), ylim=(0, 0.52), title=f"M = {slope:g}")
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small", loc="lower center")
    return figure


def hardening():
    figure, axes = plt.subplots(figsize=(7, 3.6), layout="constrained")
    bulk, first = 1.0e6 / (3.0 * 0.8), 1.0e4  # E = 1 MPa, nu = 0.1; p_c0
    for xi, colour in ((0.05, ORANGE), (0.5, GREEN), (5.0, BLUE)):
        pressure = np.linspace(0.0, 6.0e4, 600)
        begin = np.arcsinh(first / bulk) / xi
        compaction = np.maximum(0.0, np.arcsinh(pressure / bulk) / xi - begin)  # X - X0
        axes.plot(100.0 * (1.0 - np.exp(-(pressure / bulk + compaction))), 1e-3 * pressure, color=colour, linewidth=2, label=rf"$\xi$ = {xi:g}")
    axes.axhline(10.0, color=GREY, linestyle=":", label=r"$p_{c0}$ = 10 kPa: yield begins")
    axes.set(xlabel="loss of volume (%)", ylabel="pressure $p$ (kPa)", ylim=(0, 60), xlim=(0, 60))
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small")
    return figure


def folded_wall():
    figure, parts = plt.subplots(1, 2, figsize=(9, 3.4), layout="constrained", sharey=True)
    wall, nodes_x = 0.35, np.arange(-1, 5)
    flow = -1.0 + 0.0 * nodes_x
    for axes, title in zip(parts, ("node by node", "folded at the wall")):
        axes.axvspan(-1.6, wall, color="0.9")
        axes.axvline(wall, color="0.3", linewidth=2)
        axes.axhline(0, color="0.6", linewidth=0.8)
        before = np.where(nodes_x > wall, flow, np.nan)
        axes.plot(nodes_x, before, "o", color="0.75", label="before contact")
        if title == "node by node":
            after = np.where(nodes_x <= wall, 0.0, flow)
        else:
            master = nodes_x[nodes_x >= wall + 0.5][0]
            value = -0.45
            after = np.where(nodes_x <= master, value * (nodes_x - wall) / (master - wall), flow)
            after[nodes_x == -1] = np.nan
            axes.annotate("master", (master, value), (master + 0.5, value + 0.28), arrowprops={"arrowstyle": "->", "color": GREY}, color=GREY)
            zero = np.array([-0.4, 1.4])
            axes.plot(zero, value * (zero - wall) / (master - wall), color=BLUE, linewidth=1.0, linestyle="--")
        axes.plot(nodes_x, after, "o", color=BLUE, label="after contact")
        axes.set(title=title, xlabel=r"$x/\Delta x$, wall at 0.35", xlim=(-1.6, 4.4), ylim=(-1.25, 0.6))
        axes.text(-1.5, -1.15, "wall", color=GREY)
    parts[0].set_ylabel("velocity normal to the wall / $v$")
    parts[0].legend(fontsize="small", loc="upper right")
    return figure


def contact_points():
    figure, axes = plt.subplots(figsize=(6.4, 4.6), layout="constrained")
    nodes(axes, 9, 7)
    left, right, low, high = 3.3, 7.3, 1.45, 5.45
    axes.add_patch(Polygon([(left, low), (right, low), (right, high), (left, high)], facecolor="0.86", edgecolor="0.25", linewidth=1.6))
    along, margins = [0.2 + 0.9 * (i + 0.5) for i in range(4)], [0.1, 3.9]
    spots = [(left, low + s) for s in along]
    axes.scatter(*zip(*spots), s=46, color=RED, zorder=4)
    others = [(left + s, y) for s in along for y in (low, high)] + [(right, low + s) for s in along]
    axes.scatter(*zip(*others), s=22, color=RED, alpha=0.6, zorder=4)
    at_edges = [(x, low + s) for s in margins for x in (left, right)] + [(left + s, y) for s in margins for y in (low, high)]
    axes.scatter(*zip(*at_edges), s=22, facecolors="white", edgecolors=RED, zorder=4)
    for (x, y), length in zip(spots, (0.35, 1.0, 1.0, 0.35)):
        arrow(axes, (x, y), (x - length, y), RED)
    x, y = spots[1]
    near = [(i, j) for i in range(2, 5) for j in range(2, 5)]
    axes.scatter(*zip(*near), s=30, facecolors="none", edgecolors=BLUE, linewidths=1.4, zorder=5)
    axes.annotate("nodes through which\nthis point acts", (2.02, 3.98), (0.1, 5.7), arrowprops={"arrowstyle": "->", "color": BLUE}, color=BLUE, fontsize=9)
    axes.annotate("less at the edges;\nopen points: only with material at rest round the edge", (2.95, low + 0.65), (0.1, 0.1), arrowprops={"arrowstyle": "->", "color": RED}, color=RED, fontsize=9)
    for j in (2.2, 3.4, 4.6):
        arrow(axes, (-1.2, j), (-0.3, j), GREY)
    axes.text(-1.2, 5.0, "flow", color=GREY)
    bare(axes, -1.4, 9.2, -0.3, 7.3)
    return figure


def conveyor():
    figure, axes = plt.subplots(figsize=(9, 3.4), layout="constrained")
    axes.add_patch(Polygon([(-8, 0), (-8, 1.75), (-2.6, 1.75), (-1.2, 2.1), (-0.45, 3.2), (-0.25, 5.6), (0, 5.9), (0, 0)], facecolor="#c9ddf0", edgecolor=BLUE))
    axes.add_patch(Polygon([(1.75, 0), (1.75, 0.9), (2.6, 1.5), (4, 1.6), (4, 0)], facecolor="#c9ddf0", edgecolor=BLUE))
    axes.add_patch(Rectangle((0, 0), 1.75, 8.2, facecolor="0.82", edgecolor="0.25", hatch="///"))
    axes.plot([-8, 4], [0, 0], color="0.2", linewidth=2)
    for z in (0.35, 0.9, 1.45):
        arrow(axes, (-9.3, z), (-8.1, z), BLUE)
    arrow(axes, (4.05, 0.8), (5.2, 0.8), BLUE)
    axes.text(-9.4, 2.0, "fresh snow enters\nwith speed $v$", color=BLUE, fontsize=9)
    axes.text(4.2, 1.4, "leaves", color=BLUE, fontsize=9)
    for x, top, text, side in ((-5.2, 1.75, "$H$", 0.15), (-1.9, 5.9, "run-up $h_r$", -2.35), (3.0, 3.1, "pressure height $h_p$", 0.15)):
        axes.annotate("", (x, 0), (x, top), arrowprops={"arrowstyle": "<->", "color": "0.25"})
        axes.text(x + side, 0.55 * top if x > -3 else 0.75, text, fontsize=9, color="0.2")
    axes.plot([-0.25, -2.1], [5.9, 5.9], color="0.5", linestyle=":", linewidth=1)
    z = np.linspace(0, 3.1, 60)
    axes.plot(1.75 + 1.0 * (1 - z / 3.1) ** 1.3, z, color=ORANGE, linewidth=1.8)
    axes.plot([1.75, 3.2], [3.1, 3.1], color="0.5", linestyle=":", linewidth=1)
    axes.text(2.0, 3.4, "pressure on the mast", color=ORANGE, fontsize=9)
    axes.text(-7.6, -0.75, "frictionless bed; side walls move with the flow", color=GREY, fontsize=9)
    bare(axes, -9.8, 6.4, -1.0, 8.4)
    return figure


def equation_curves():
    figure, parts = plt.subplots(1, 2, figsize=(9, 3.6), layout="constrained")
    froude = np.linspace(0.0, 6.0, 300)
    for axes, coefficients, title in ((parts[0], equations.PUBLISHED_RUNUP, "run-up"), (parts[1], equations.PUBLISHED_PRESSURE_HEIGHT, "pressure height")):
        for friction, colour in ((0.0, BLUE), (0.4, GREEN), (0.8, ORANGE), (1.5, RED)):
            axes.plot(froude, equations.relative_height(friction, froude, coefficients), color=colour, label=f"$M'$ = {friction:g}")
        axes.set(title=title, xlabel="Froude number", ylabel="height / $H$", xlim=(0, 6), ylim=(0, None))
        axes.grid(alpha=0.3)
    parts[0].plot(froude, equations.bernoulli_height(froude), color=GREY, linestyle=":", label="Bernoulli")
    parts[0].set_ylim(0, 20)
    parts[0].legend(fontsize="small")
    return figure


FIGURES = {"step": step, "bspline": bspline, "yield": yield_surface, "hardening": hardening, "folded_wall": folded_wall,
           "contact_points": contact_points, "conveyor": conveyor, "equations": equation_curves}


def main():
    out = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else HERE.parent / "images" / "theory"
    out.mkdir(parents=True, exist_ok=True)
    matplotlib.rcParams.update({"svg.hashsalt": "libmpm", "font.size": 10, "axes.edgecolor": GREY})
    for name, draw in FIGURES.items():
        figure = draw()
        figure.savefig(out / f"{name}.svg", metadata={"Date": None, "Creator": None})
        plt.close(figure)


if __name__ == "__main__":
    main()
