#!/usr/bin/env python3
"""Draws the figures of the extensions from their tables. Every number is read; nothing is fitted here.

Usage: draw.py  (in this folder; reads height.csv, shapes.csv, inflow.csv, surge.csv where they exist, writes .svg beside them)
A table is results.csv of `mpm campaign run <plan>.toml`, the plan of the same name; surge.csv is a series.
"""

import csv
import pathlib

import matplotlib

matplotlib.use("svg")
import matplotlib.pyplot as plt  # noqa: E402  (after the backend is chosen)

HERE = pathlib.Path(__file__).resolve().parent
COLOURS = ["#1f6fb4", "#d1601f", "#2e8b57", "#8b4fa8", "#b3262e"]
MARKERS = ["o", "s", "^", "D", "v"]


def table(name):
    """Rows of a table with numbers where there are any; none without the file. Runs that are not done are left out."""
    path = HERE / f"{name}.csv"
    if not path.exists():
        return []
    with open(path, encoding="utf-8", newline="") as file:
        rows = [dict(row) for row in csv.DictReader(file)]
    for row in rows:
        for key, cell in row.items():
            try:
                row[key] = float(cell)
            except (TypeError, ValueError):
                pass
    return [row for row in rows if row["status"] == "done"]


def save(figure, name):
    figure.savefig(HERE / f"{name}.svg", metadata={"Date": None})
    plt.close(figure)
    print(f"wrote {name}.svg")


def draw_height(rows):
    """Mean and peak stream-wise force against the height of the mast, over the force on the tallest one at that Froude number."""
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.4), layout="constrained")
    for n, froude in enumerate(sorted({row["froude_number"] for row in rows})):
        group = sorted((row for row in rows if row["froude_number"] == froude), key=lambda row: row["obstacle.height_m"])
        h = [row["obstacle.height_m"] / row["flow_height_m"] for row in group]
        style = {"color": COLOURS[n], "marker": MARKERS[n], "markersize": 5, "label": f"Fr = {froude:g}"}
        left.errorbar(h, [row["force_mean_n.x"] / group[-1]["force_mean_n.x"] for row in group],
                      yerr=[2.0 * row["force_standard_error_n.x"] / group[-1]["force_mean_n.x"] for row in group], capsize=2, **style)
        right.plot(h, [1e-3 * row["force_filtered_peak_n"] for row in group], **style)
        right.plot(h, [1e-3 * row["force_mean_n.x"] for row in group], color=COLOURS[n], linestyle=":")
    left.axvline(3.0, color="0.6", linestyle="--", linewidth=1, label="three flow heights (Hauksson et al. 2007)")
    left.set(xlabel="mast height over flow height (-)", ylabel="mean force over that on the tallest mast (-)", ylim=(0, None))
    right.set(xlabel="mast height over flow height (-)", ylabel="stream-wise force (kN)", yscale="log",
              title="first impact (filtered peak), and mean (dotted)")
    left.legend(fontsize="small")
    for axes in (left, right):
        axes.grid(alpha=0.3, which="both")
    save(figure, "height")


def draw_groups(rows, name, group_of, title):
    """Bars of force, run-up and peak for each group of runs, one colour a Froude number."""
    quantities = [("force_mean_n.x", 1e-3, "mean force (kN)"), ("runup_mean_m", 1.0, "mean run-up (m)"),
                  ("pressure_height_mean_m", 1.0, "pressure height (m)"), ("force_filtered_peak_n", 1e-3, "filtered peak force (kN)")]
    groups = list(dict.fromkeys(group_of(row) for row in rows))
    froudes = sorted({row["froude_number"] for row in rows})
    figure, axes = plt.subplots(1, len(quantities), figsize=(3.1 * len(quantities), 4.2), layout="constrained")
    for a, (key, factor, label) in zip(axes, quantities):
        for n, froude in enumerate(froudes):
            for row in rows:
                if row["froude_number"] != froude or not isinstance(row.get(key), float):
                    continue
                place = groups.index(group_of(row)) + 0.8 * ((n + 0.5) / len(froudes) - 0.5)
                first = row is next(r for r in rows if r["froude_number"] == froude)
                a.bar(place, factor * row[key], width=0.75 / len(froudes), color=COLOURS[n], label=f"Fr = {froude:g}" if first else None)
        a.set_xticks(range(len(groups)), groups, rotation=35, ha="right", fontsize="small")
        a.set_ylabel(label)
        a.grid(alpha=0.3, axis="y")
    axes[0].legend(fontsize="small")
    figure.suptitle(title)
    save(figure, name)


def draw_surge(path):
    """Force, run-up and pressure height over time while the inflow changes; series.csv of examples/avalanche_surge.toml at w/4."""
    with open(path, encoding="utf-8", newline="") as file:
        rows = list(csv.DictReader(file))
    t = [float(row["time_s"]) for row in rows]
    figure, (top, bottom) = plt.subplots(2, 1, figsize=(8.0, 5.4), sharex=True, layout="constrained")
    top.plot(t, [1e-3 * float(row["force_x_n"]) for row in rows], color=COLOURS[0], linewidth=1)
    top.set_ylabel("stream-wise force (kN)")
    for key, label, colour in (("runup_m", "run-up", COLOURS[1]), ("pressure_height_m", "pressure height", COLOURS[2])):
        bottom.plot(t, [float(row[key]) for row in rows], color=colour, linewidth=1, label=label)
    bottom.set(xlabel="time since the front reached the obstacle (s)", ylabel="height (m)")
    bottom.legend(fontsize="small")
    for axes in (top, bottom):
        axes.grid(alpha=0.3)
        for instant, what in ((0.0, "front: 12 m/s, 1 m"), (2.0, "10 m/s, 2 m"), (4.0, "5 % denser"), (7.0, "3 m/s, 1.25 m")):
            axes.axvline(instant, color="0.6", linestyle="--", linewidth=1)
            if axes is top:
                axes.annotate(what, (instant, 0.97), xycoords=("data", "axes fraction"), fontsize="x-small", rotation=90, va="top", ha="right")
    figure.suptitle("A surge: what enters at the inlet, 8 m upstream, at the dashed instants")
    save(figure, "surge")


def main():
    if rows := table("height"):
        draw_height(rows)
    if rows := table("shapes"):
        draw_groups(rows, "shapes", lambda row: row["name"].rsplit("_fr", 1)[0].replace("_", " "), "Cross-sections of one width, 1.75 m")
    if rows := table("inflow"):
        draw_groups(rows, "inflow", lambda row: row["name"].rsplit("_fr", 1)[0].replace("_", " "), "Plug and sheared inflow of one discharge")
    if (HERE / "surge.csv").exists():
        draw_surge(HERE / "surge.csv")


if __name__ == "__main__":
    main()
