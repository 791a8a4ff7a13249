"""Predicted against reference values, one plot for each kind of quantity, from the summary in results.json."""

import math

from reports.interactive import inline_svg
from mpmtools.figures.style import COLOURS, MARKERS, finish_axes, plain_ticks, plt

LABEL_COLOURS = {"verification": "#1f6fb4", "validation": "#b3262e"}
REFERENCES = {"verification": "exact solutions", "validation": "experiments, the paper"}


def summary_figures(summary, titles):
    """(title, SVG) of each quantity that has points, in the order of the table.

    titles: heading of each case by its name
    """
    cases = list(dict.fromkeys(point["case"] for point in summary["points"]))
    look = {case: (COLOURS[i % len(COLOURS)], MARKERS[(i + i // len(COLOURS)) % len(MARKERS)]) for i, case in enumerate(cases)}
    figures = []
    for quantity in dict.fromkeys(row["quantity"] for row in summary["rows"]):
        rows = [row for row in summary["rows"] if row["quantity"] == quantity]
        points = [p for p in summary["points"] if p["quantity"] == quantity and p["ratio"] is not None]
        if points:
            figures.append((quantity, _draw(rows, points, look, titles)))
    return figures


def _draw(rows, points, look, titles):
    cases = list(dict.fromkeys(p["case"] for p in points))
    lines = math.ceil(len(cases) / 2)
    figure = plt.figure(figsize=(4.6, 5.75 + 0.2 * lines), layout="constrained")
    grid = figure.add_gridspec(3, 1, height_ratios=(3.75, 1.35, 0.2 * lines))
    axes = figure.add_subplot(grid[0])
    ratios = figure.add_subplot(grid[1], sharex=axes)
    names = figure.add_subplot(grid[2])
    names.axis("off")
    axes.tick_params(labelbottom=False)
    quantity, unit = rows[0]["quantity"], rows[0]["unit"]
    values = [p[key] for p in points for key in ("predicted", "reference")]
    low, high = min(values), max(values)
    margin = max((high / low) ** 0.06, 1.3)
    low, high = low / margin, high * margin
    line = [low, high]

    uncertainty = max(row["reference_uncertainty"] for row in rows)
    if uncertainty > 0.0:
        band = math.exp(2.0 * uncertainty)
        axes.fill_between(line, [v / band for v in line], [v * band for v in line], color="#e9ecf0", linewidth=0, zorder=0)
        ratios.axhspan(1.0 / band, band, color="#e9ecf0", linewidth=0, zorder=0)
    axes.plot(line, line, color="black", linewidth=1.0, zorder=1)
    ratios.axhline(1.0, color="black", linewidth=1.0, zorder=1)
    for row in rows:
        if row["values"] < 2:
            continue
        colour, spread = LABEL_COLOURS[row["label"]], math.exp(2.0 * (row["model_spread"] or 0.0))
        for factor, style in ((1.0, "-"), (spread, "--"), (1.0 / spread, "--")):
            if factor == 1.0 and style == "--":
                continue
            axes.plot(line, [row["bias"] * factor * v for v in line], style, color=colour, linewidth=0.8, zorder=2)
            ratios.axhline(row["bias"] * factor, linestyle=style, color=colour, linewidth=0.8, zorder=2)

    texts = {}
    for i, p in enumerate(points):
        colour, marker = look[p["case"]]
        face = colour if p["label"] == "verification" else "white"
        known = f", known to ± {100 * p['reference_uncertainty']:.2g} %" if p["reference_uncertainty"] > 0 else ", exact"
        text = f"{titles[p['case']]}\n{p['name']}\n{p['text']}: ratio {p['ratio']:.4f}{known}"
        for panel, y in (("value", p["predicted"]), ("ratio", p["ratio"])):
            name = f"{panel}-{quantity.replace(' ', '-')}-{i}"
            (axes if panel == "value" else ratios).plot([p["reference"]], [y], marker, markersize=5.5, markerfacecolor=face, markeredgecolor=colour,
                                                        markeredgewidth=1.2, gid=name, zorder=3, clip_on=False)
            texts[name] = text

    axes.set(xscale="log", yscale="log", xlim=line, ylim=line, ylabel=f"predicted {quantity} [{unit}]")
    for axis in (axes.xaxis, axes.yaxis):
        plain_ticks(axis, line)
    reach = max(0.02, *(abs(p["ratio"] - 1.0) for p in points), *(abs(row["bias"] * math.exp(2.0 * (row["model_spread"] or 0.0)) - 1.0) for row in rows))
    ratios.set(ylim=(1.0 - 1.15 * reach, 1.0 + 1.15 * reach), ylabel="predicted /\nreference", xlabel=f"reference {quantity} [{unit}]")
    for panel in (axes, ratios):
        finish_axes(panel)
    axes.set_title(quantity[0].upper() + quantity[1:], fontsize=10.5, loc="left")
    handles = []
    for case in cases:
        colour, marker = look[case]
        kinds = {p["label"] for p in points if p["case"] == case}
        handles.append(plt.Line2D([], [], linestyle="", marker=marker, color=colour, markersize=5.5,
                                  markerfacecolor=colour if "verification" in kinds else "white", label=case))
    names.legend(handles=handles, loc="upper center", ncols=2, fontsize=8, frameon=False, handletextpad=0.2, columnspacing=1.0, borderaxespad=0.0)
    return inline_svg(figure, texts, f"Predicted against reference {quantity}")
