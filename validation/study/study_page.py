#!/usr/bin/python3
"""Draws the page of the study: the paper's figures from our runs, with its fitted curves beside ours.

Every number was computed by `mpm study`; this script formats and draws, and decides nothing. The page holds its images and needs no other
file. A figure whose data are missing says what is missing.

usage: study_page.py PAGE.html MAIN_FOLDER [OTHER_FOLDER...]

The folders are what `mpm study --out` wrote. All figures are drawn from MAIN_FOLDER; the others stand beside it in the tables.
"""

import csv
import json
import os
import sys

import extension_figures
import jinja2
import markupsafe
import numpy as np
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.patches import Rectangle
from page_tools import decades, distinct, done, froude_colour, new_axes, number, per_cent, read_columns, rows_where, select
from report_style import COLOURS, MARKERS, STYLE, finish_axes, inline, plt, png_data, use_style, write_page

COMPRESSIBILITY = {0.05: 205.3, 0.15: 127.1, 0.5: 107.5, 1.5: 102.4, 5.0: 100.7, 15.0: 100.2}  # chi(25 kPa) in per cent, Table 1
THREE_XI = (5.0, 0.5, 0.05)  # of Figs. A2 to A5
ENVELOPE_COLOURS = {0.1: COLOURS[0], 1.0: COLOURS[2], 5.0: COLOURS[1]}
PUBLISHED_RANGES = ((0.45, 0.65, "dry, loose"), (1.0, 1.5, "dense"))
# As in plot_run.py: almost white for nothing, over blue and yellow to dark red for strong compression.
STRESS_COLOURS = LinearSegmentedColormap.from_list(
    "stress", [(0.45, 0.04, 0.14), (0.89, 0.36, 0.20), (0.98, 0.82, 0.40), (0.42, 0.66, 0.88), (0.78, 0.86, 0.93)])
HEIGHTS = {"runup": ("Run-up height", "$h_r/H$"), "pressure_height": ("Pressure height", "$h_p/H$")}


def xi_marker(xi):
    return dict(zip((5.0, 0.5, 0.05, 1.5, 0.15, 15.0), MARKERS)).get(xi, "x")


def xi_label(xi):
    chi = COMPRESSIBILITY.get(round(xi, 3))
    return rf"$\xi$ = {xi:g}" + (rf", $\chi$ = {chi} %" if chi else "")


class Study:
    """What one folder of `mpm study` holds: fit.json, and its tables by name as columns of numbers or text."""

    def __init__(self, folder):
        self.folder = folder
        self.name = os.path.basename(os.path.normpath(folder))
        with open(os.path.join(folder, "fit.json"), encoding="utf-8") as file:
            self.fit = json.load(file)

    def table(self, name):
        return read_columns(os.path.join(self.folder, name + ".csv"))

    def text(self, name, column):
        """A column as it is written, also where all its cells are numbers."""
        with open(os.path.join(self.folder, name + ".csv"), newline="", encoding="utf-8") as file:
            return [row[column] for row in csv.DictReader(file)]

    def regression(self, equation, fitting_set):
        for fit in self.fit["fits"]:
            if fit["equation"] == equation and fit["fitting_set"] == fitting_set:
                return fit
        return None

    def is_fitted(self, equation):
        fit = self.regression(equation, "narrow")
        return bool(fit and fit["coefficients"])


def shade_guideline(axes):
    for low, high, name in PUBLISHED_RANGES:
        axes.axvspan(low, high, color="#e8ebef", zorder=0)
        axes.annotate(name, (0.5 * (low + high), 0.985), xycoords=("data", "axes fraction"), ha="center", va="top", fontsize=8, color="#5a6675")


# ---- Figures: each returns (pictures, what is missing). A picture is (title, caption, data address). ---------------------------------------


def figure_1(study):
    table = study.table("effective_friction")
    pictures = []
    for column, title, label in (("effective_friction", "(a) effective internal friction", "$M'$"),
                                 ("friction_angle_deg", "(b) effective friction angle", r"$\varphi'$ [°]")):
        figure, axes = new_axes(height=3.8)
        for k, slope in enumerate(distinct(table["critical_state_slope"])):
            rows = select(table, rows_where(table, critical_state_slope=slope))
            axes.plot(rows["cohesion_beta"], rows[column], color=COLOURS[k], linewidth=1.6, label=f"M = {slope:g}")
            axes.plot(rows["cohesion_beta"][::30], rows[column][::30], MARKERS[k], color=COLOURS[k], markersize=5)
        pictures.append((title, "Symbols: the rheologies of the study.", done(axes, title, r"cohesion $\beta$", label)))
    return pictures, []


def figure_3(study):
    table, spread = study.table("envelopes"), study.table("spreads")
    missing = [f"Fr = {f:g}: no time histories of runs" for f in ENVELOPE_COLOURS if not rows_where(table, froude_number=f).any()]
    pictures = []
    for key, title in (("runup", "(a) run-up height"), ("pressure_height", "(b) pressure height")):
        if len(missing) == len(ENVELOPE_COLOURS):
            break
        figure, axes = new_axes()
        for froude, colour in ENVELOPE_COLOURS.items():
            rows = select(table, rows_where(table, froude_number=froude))
            if not len(rows["time_s"]):
                continue
            keep = (rows["runs"] == rows["all_runs"]) & (rows["time_s"] > 0.1)
            if not keep.any():
                continue
            t, low, high = rows["time_s"][keep], rows[f"{key}_low"][keep], rows[f"{key}_high"][keep]
            axes.fill_between(t, low, high, color=colour, alpha=0.22, linewidth=0)
            axes.plot(t, low, color=colour, linewidth=1.2)
            axes.plot(t, high, color=colour, linewidth=1.2, label=f"Fr = {froude:g}, {rows['all_runs'][0]:.0f} runs")
        decades(axes, "x", [0.1, 100])
        if key == "runup":
            decades(axes, "y", [0.5, 40])
        data = done(axes, title, "time since the front reached the mast [s]", HEIGHTS[key][1])
        pictures.append((title, "Lowest and highest of all rheologies at each time, as far as every run reaches. The axis of time is logarithmic, because slow flow takes "
                                "ten times as long.", data))
    rows = [[f"Fr = {f:g}", f"{n:.0f}", f"{number(a, 2)} to {number(b, 2)}", number(c, 1), f"{number(d, 2)} to {number(e, 2)}", number(g, 1)]
            for f, n, a, b, c, d, e, g in zip(*(spread[k] for k in spread))]
    tables = [{"title": "Spread of the steady means over all rheologies", "head": ["flow", "runs", "h_r/H", "factor of h_r", "h_p/H", "factor of h_p"], "rows": rows}] if rows else []
    return pictures, missing, tables


def figure_4(study):
    table = study.table("decomposition")
    names = ["fluid: M = β = 0, ξ = 5", "+ friction", "+ cohesion", "+ compressibility"]
    pictures, missing = [], []
    links = distinct(table["link"]) if table else []
    for link in links:
        rows = select(table, rows_where(table, link=link))
        without = [f"{f:g}" for f, h in zip(rows["froude_number"], rows["runup"]) if not np.isfinite(h)]
        if without:
            missing.append(f"M = {rows['critical_state_slope'][0]:g}, β = {rows['cohesion_beta'][0]:g}, ξ = {rows['hardening_xi'][0]:g}: no steady run at Fr {', '.join(without)}")
    for key, title in (("runup", "(a) run-up height"), ("pressure_height", "(b) pressure height")):
        if not links or not np.isfinite(table[key]).any():
            continue
        figure, axes = new_axes()
        for link in links:
            rows = select(table, rows_where(table, link=link))
            ok = np.isfinite(rows[key])
            name = names[int(link)]
            if link == 1:
                name += f" M = {rows['critical_state_slope'][0]:g}"
            if link == 2:
                name += f" β = {rows['cohesion_beta'][0]:g}"
            if link == 3:
                name += f" ξ = {rows['hardening_xi'][0]:g}"
            axes.plot(rows["froude_number"][ok], rows[key][ok], marker=MARKERS[int(link)], color=COLOURS[int(link)], linewidth=1.5, markersize=5, label=name, zorder=3)
        rows = select(table, rows_where(table, link=links[0]))
        if key == "runup":
            axes.plot(rows["froude_number"], rows["bernoulli"], "--", color="black", linewidth=1.2, label="$H$ + velocity head", zorder=2)
            decades(axes, "y", np.concatenate([rows["bernoulli"], table[key]]))
        else:
            slow = rows["froude_number"] <= 2.0
            axes.plot(rows["froude_number"][slow], rows["bernoulli"][slow], "--", color="black", linewidth=1.2, label="$H$ + velocity head", zorder=2)
        pictures.append((title, "One property of the snow is added at a time.", done(axes, title, "Froude number Fr", HEIGHTS[key][1])))
    return pictures, missing


def figure_5(study):
    sections = study.table("sections")
    pictures, missing = [], []
    for name, froude, title in (("slow", 0.1, "(a) gravity-driven, Fr = 0.1"), ("fast", 5.0, "(b) inertia-driven, Fr = 5")):
        rows = select(sections, rows_where(sections, froude_number=froude)) if sections else {}
        particles, profile = study.table(f"section_{name}"), study.table(f"section_profile_{name}")
        if not rows or not len(rows["froude_number"]) or not particles or not profile:
            missing.append(f"Fr = {froude:g}: no run with M = 0.8, β = 0.3, ξ = 0.5 that kept its last state (final.h5) and its mean profile")
            continue
        pictures.append((title, "Left: particles near the plane of symmetry in the last state, coloured by the stream-wise stress. Right: mean pressure on the mast over the steady "
                                "span, on the same axis of height.", draw_section(title, particles, profile, rows)))
    return pictures, missing


def draw_section(title, particles, profile, rows):
    height = float(rows["flow_height_m"][0])
    x, z = particles["x_m"] / height, particles["z_m"] / height
    top = max(1.05 * float(z.max()), 2.2)
    left, right = max(float(x.min()), -4.0), 1.3
    # Placed in inches, so that a flow height is as long in both directions and the profile shares the section's axis of height.
    profile_width, before, between, after, below = 1.75, 0.65, 0.2, 0.15, 1.3
    section_width = min((right - left) * 3.9 / top, 6.2 - profile_width - before - between - after)
    scale = section_width / (right - left)  # inches a flow height
    page_width, page_height = before + section_width + between + profile_width + after, below + scale * top + 0.4
    figure = plt.figure(figsize=(page_width, page_height))
    axes = figure.add_axes((before / page_width, below / page_height, section_width / page_width, scale * top / page_height))
    beside = figure.add_axes(((before + section_width + between) / page_width, below / page_height, profile_width / page_width, scale * top / page_height), sharey=axes)
    shown = (x >= left) & (x <= right)
    stress = 1e-3 * particles["stress_xx_pa"]
    low = min(float(np.percentile(stress[shown], 0.5)), -0.1)
    size = (0.9 * scale * 72.0 * float(rows["particle_spacing_m"][0]) / height) ** 2
    points = axes.scatter(x[shown], z[shown], c=stress[shown], s=max(size, 0.8), marker="s", cmap=STRESS_COLOURS, vmin=low, vmax=0.0, linewidths=0, rasterized=True)
    axes.add_patch(Rectangle((0.0, 0.0), 1.0, 2 * top, facecolor="#c9ced5", edgecolor="#3a424d", hatch="///", linewidth=1.0, zorder=0))
    axes.axhline(0.0, color="#3a424d", linewidth=1.2)
    axes.set(xlim=(left, right), ylim=(-0.02 * top, top), xlabel="$x/H$", ylabel="$z/H$")
    beside.step(1e-3 * profile["pressure_pa"], profile["z_m"] / height, where="mid", color="0.65", linewidth=1.0, label="mean")
    beside.plot(1e-3 * profile["smoothed_pressure_pa"], profile["z_m"] / height, color=COLOURS[0], linewidth=1.7, label="smoothed")
    for value, colour, label in ((rows["runup"][0], COLOURS[1], "$h_r$"), (rows["pressure_height"][0], COLOURS[2], "$h_p$")):
        if np.isfinite(value):
            beside.axhline(value, color=colour, linestyle="--", linewidth=1.3, label=f"{label} = {value:.2f} $H$")
    beside.set_xlabel("pressure [kPa]")
    beside.tick_params(labelleft=False)
    beside.set_xlim(left=0.0)
    finish_axes(axes)
    finish_axes(beside)
    axes.grid(False)
    beside.legend(fontsize=8, frameon=True, framealpha=0.9, edgecolor="none", loc="upper right")
    strip = figure.add_axes((before / page_width, 0.5 / page_height, section_width / page_width, 0.13 / page_height))
    bar = figure.colorbar(points, cax=strip, orientation="horizontal", extend="both")
    bar.set_label(r"$\sigma_{xx}$ [kPa], compression negative", fontsize=9)
    bar.outline.set_visible(False)
    figure.text(before / page_width, 1.0 - 0.1 / page_height, title, fontsize=10.5, ha="left", va="top")
    return png_data(figure)


def scatter_runs(axes, points, x, y):
    """Runs coloured by Fr, with a symbol for xi; two legends' worth of handles."""
    for xi in distinct(points["hardening_xi"]):
        rows = select(points, rows_where(points, hardening_xi=xi))
        axes.scatter(rows[x], rows[y], c=[froude_colour(f) for f in rows["froude_number"]], marker=xi_marker(xi), s=22, linewidths=0.4, edgecolors="white", zorder=3)
    handles = [plt.Line2D([], [], color=froude_colour(f), marker="o", linestyle="", markersize=5, label=f"Fr = {f:g}") for f in distinct(points["froude_number"])]
    handles += [plt.Line2D([], [], color="#5a6675", marker=xi_marker(xi), linestyle="", markersize=5, label=rf"$\xi$ = {xi:g}") for xi in distinct(points["hardening_xi"])]
    return handles


def reference_points(study):
    points = study.table("points")
    return select(points, rows_where(points, relative_width=1.0) & np.isfinite(points["runup"])) if points else {}


def figure_6(study):
    points = reference_points(study)
    points = select(points, np.isfinite(points["pressure_height"])) if points else {}
    if not points or not len(points["runup"]):
        return [], ["no run with both a steady run-up and a steady pressure height"]
    figure, axes = new_axes(height=4.8)
    handles = scatter_runs(axes, points, "runup", "pressure_height")
    limit = [0.9, 1.05 * float(points["pressure_height"].max())]
    axes.plot(limit, limit, "--", color="black", linewidth=1.1)
    handles.append(plt.Line2D([], [], color="black", linestyle="--", linewidth=1.1, label="$h_p = h_r$"))
    decades(axes, "x", points["runup"])
    return [("Pressure height over run-up height", "", done(axes, "Pressure height over run-up height", "$h_r/H$", "$h_p/H$", handles=handles, ncols=2, fontsize=8))], []


def figure_7(study):
    points = reference_points(study)
    points = select(points, points["hardening_xi"] > 0.051) if points else {}
    if not points or not len(points["runup"]):
        return [], ["no runs with w = H and ξ > 0.05"]
    pictures = []
    for key, panel in (("runup", "a"), ("pressure_height", "b")):
        for source, whose in (("published", "published coefficients"), ("fitted", "our fit")):
            rows = select(points, np.isfinite(points[key]) & np.isfinite(points[f"{key}_{source}"]))
            if not len(rows[key]):
                continue
            figure, axes = new_axes(height=4.8)
            handles = scatter_runs(axes, rows, key, f"{key}_{source}")
            both = np.concatenate([rows[key], rows[f"{key}_{source}"]])
            line = np.array([0.9 * both.min(), 1.08 * both.max()])
            axes.plot(line, line, color="black", linewidth=1.2)
            for factor in (1 - 0.25, 1 + 0.25):  # |y - f| <= 0.25 y, as the score counts it
                axes.plot(line, factor * line, "--", color="#808890", linewidth=1.0)
            if key == "runup":
                decades(axes, "x", rows[key])
                decades(axes, "y", rows[key])
            title = f"({panel}) {HEIGHTS[key][0].lower()}: {whose}"
            pictures.append((title, "Dashed: 25 % of the simulated value.", done(axes, title, f"{HEIGHTS[key][1]}, simulation", f"{HEIGHTS[key][1]}, equation", handles=handles, ncols=2,
                                                                                fontsize=8, loc="upper left")))
    missing = [f"our fit of the {HEIGHTS[key][0].lower()}: {why(study, key)}" for key in HEIGHTS if not study.is_fitted(key)]
    return pictures, missing


def why(study, equation):
    fit = study.regression(equation, "narrow")
    return fit["why_not"] if fit and fit["why_not"] else "not fitted"


def figure_8(study):
    table = study.table("factor_curves")
    pictures = []
    for quantity, title, label in (("zeta", "(a) magnification factor", r"$\zeta = k\,M'$"), ("lambda", "(b) dissipation factor", r"$\lambda = \exp(\kappa\,M')$")):
        figure, axes = new_axes()
        shade_guideline(axes)
        for k, (letter, name) in enumerate((("r", "run-up"), ("p", "pressure height"))):
            for source, style, whose in (("fitted", "-", "our fit"), ("published", "--", "published")):
                values = table[f"{quantity}_{letter}_{source}"]
                if np.isfinite(values).any():
                    axes.plot(table["effective_friction"], values, style, color=COLOURS[k], linewidth=1.6, label=f"{name}, {whose}")
        axes.set_xlim(0, 2.4)
        if quantity == "lambda":
            decades(axes, "y", [1, 40])
        pictures.append((title, "Grey: the ranges of M' that the paper assigns to the guideline's avalanche types.", done(axes, title, "effective internal friction $M'$", label, loc="lower right")))
    return pictures, [f"our fit of the {HEIGHTS[key][0].lower()}: {why(study, key)}" for key in HEIGHTS if not study.is_fitted(key)]


def figure_9(study):
    table, minima = study.table("guideline"), study.table("guideline_minima")
    if not table or not len(table["lambda"]):
        return [], ["no ξ with three or more values of M' that have a run at every Froude number from 3 to 7"]
    pictures = []
    for key, title, label in (("normalised", "RMSLE, normalised to 0–1", "normalised RMSLE"), ("rmsle", "RMSLE itself", "RMSLE")):
        figure, axes = new_axes()
        shade_guideline(axes)
        xis = [xi for xi in distinct(table["hardening_xi"])[::-1] if xi in (5.0, 0.5)] or distinct(table["hardening_xi"])[::-1]
        for k, lam in enumerate(distinct(table["lambda"])):
            for j, xi in enumerate(xis):
                rows = select(table, rows_where(table, hardening_xi=xi, **{"lambda": lam}))
                axes.plot(rows["effective_friction"], rows[key], ("-", "--", ":", "-.")[j % 4], marker=MARKERS[j], markersize=4, color=COLOURS[k], linewidth=1.4,
                          label=rf"$\lambda$ = {lam:g}, $\xi$ = {xi:g}")
        axes.set_ylim(0, 1.35 * axes.get_ylim()[1])  # room for the legend
        pictures.append((title, "Grey: the paper's minima, 0.45–0.65 for λ = 1.5 (dry, loose) and 1.0–1.5 for λ = 3 (dense).",
                         done(axes, title, "effective internal friction $M'$", label, ncols=2, loc="upper right", bbox_to_anchor=(1.0, 0.95), fontsize=8)))
    rows = [[f"{lam:g}", f"{xi:g}", number(at, 3), f"{number(below, 2)} to {number(above, 2)}", number(vertex, 3), number(error, 3), f"{low:g} to {high:g}",
             "no minimum: an end of the curve" if not np.isfinite(vertex) else "yes" if inside else "no"]
            for lam, xi, at, below, above, vertex, error, low, high, inside in zip(*(minima[k] for k in minima))]
    tables = [{"title": "Where the curves are lowest", "head": ["λ", "ξ", "lowest M' of the table", "between its neighbours", "vertex of the parabola", "RMSLE", "published M'", "inside"], "rows": rows}]
    return pictures, [], tables


def figure_10(study):
    table = study.table("width_factors")
    if not table or not len(table["relative_width"]):
        return [], ["no table of the width study: runs with w/H other than 1 and their reference with w = H"]
    pictures = []
    for key, letter in (("runup", "a"), ("pressure_height", "b")):
        for j, slope in enumerate(distinct(table["critical_state_slope"])):
            rows = select(table, rows_where(table, critical_state_slope=slope))
            figure, axes = new_axes()
            for froude in distinct(rows["froude_number"]):
                of = select(rows, rows_where(rows, froude_number=froude))
                order = np.argsort(of["relative_width"])
                axes.errorbar(of["relative_width"][order], of[f"{key}_factor"][order], yerr=of[f"{key}_standard_error"][order], marker="o", markersize=4.5, capsize=3, linewidth=1.4,
                              color=froude_colour(froude), label=f"Fr = {froude:g}")
            width = np.unique(np.round(rows["relative_width"], 9))
            axes.plot(width, [rows["guideline"][np.argmin(abs(rows["relative_width"] - w))] for w in width], "--", color="black", linewidth=1.3, label="guideline (Eq. 6, 1 at $w = H$)")
            title = f"({letter}.{j + 1}) {HEIGHTS[key][0].lower()}, M = {slope:g}, β = {rows['cohesion_beta'][0]:g}, ξ = {rows['hardening_xi'][0]:g}"
            pictures.append((title, "", done(axes, title, "$w/H$", "$f_r$" if key == "runup" else "$f_p$")))
    return pictures, []


CHOICES = {"obstacle_friction": "mast friction μ", "obstacle_friction_ratio": "μ / tan φ'", "cell_size_m": "cell size [m]", "numerics.slope_deg": "slope [°]",
           "conveyor.sidewall_contact": "side walls", "conveyor.sidewall_contact, conveyor.sidewall_friction": "side walls", "numerics.transfer": "transfer",
           "numerics.particles_per_cell": "particles a cell", "conveyor.lattice": "feed's lattice", "conveyor.upstream_length_m, conveyor.downstream_length_m": "window up-, downstream [m]",
           "numerics.cfl": "CFL number"}


def choice_label(choice, value):
    return "base" if not choice else f"{CHOICES.get(choice, choice)} {value.replace('_', '-')}"


def figure_s1(study):
    table, summary = study.table("sensitivity"), study.table("sensitivity_summary")
    if not table or not len(table["runup_to_base"]):
        return [], ["no table of runs that change one choice at a time"]
    labels = [choice_label(c, v) for c, v in zip(study.text("sensitivity_summary", "choice"), study.text("sensitivity_summary", "value"))]
    of_run = [choice_label(c, v) for c, v in zip(study.text("sensitivity", "choice"), study.text("sensitivity", "value"))]
    shown = [label for label in labels if label != "base"]
    pictures = []
    for key, title in (("runup", "(a) run-up height, one choice changed"), ("pressure_height", "(b) pressure height, one choice changed"),
                       ("force", "(c) mean force on the mast, one choice changed")):
        figure, axes = new_axes(height=1.2 + 0.21 * len(shown))
        for i, froude in enumerate(distinct(table["froude_number"])):
            mask = np.isclose(table["froude_number"], froude) & np.array([label != "base" for label in of_run])
            rows = [shown.index(label) + 0.16 * (i - 1) for label, m in zip(of_run, mask) if m]
            axes.errorbar(table[f"{key}_to_base"][mask], rows, xerr=table[f"{key}_standard_error"][mask], fmt=MARKERS[i], color=froude_colour(froude), markersize=4, linewidth=0.9,
                          label=f"Fr = {froude:g}")
        axes.axvline(1.0, color="black", linewidth=1.1)
        axes.set_yticks(range(len(shown)), shown, fontsize=8)
        axes.set_ylim(len(shown) - 0.5, -0.5)
        pictures.append((title, "Bars: standard errors of both runs' means. Line: the base.", done(axes, title, "over that of the base", "", loc="best", fontsize=8)))
    rows = [[label, f"{n:.0f}", *(f"{number(summary[key][i], 2)} ({number(summary[key + '_low'][i], 2)} to {number(summary[key + '_high'][i], 2)})" for key in ("runup", "pressure_height", "force")),
             per_cent(summary["runup_rmsle"][i]), per_cent(summary["base_runup_rmsle"][i])] for i, (label, n) in enumerate(zip(labels, summary["points"]))]
    tables = [{"title": "Over the base: geometric mean of the points (lowest to highest)",
               "head": ["what differs", "points", "h_r", "h_p", "force", "RMSLE of h_r from the published equation", "the base's at the same points"], "rows": rows}]
    return pictures, [], tables


def height_choice_table(study):
    table = study.table("height_choices")
    if not table or not len(table["runs"]):
        return [], ["no time histories of runs"]
    rows = [[name, f"{n:.0f}", *(number(table[k][i]) for k in ("k_r", "kappa_r")), *(per_cent(table[k][i]) for k in ("runup_rmsle_published", "runup_fraction_25_published")),
             *(number(table[k][i]) for k in ("k_p", "Fr_sat", "kappa_p")), *(per_cent(table[k][i]) for k in ("pressure_height_nrmse_published", "pressure_height_fraction_25_published"))]
            for i, (name, n) in enumerate(zip(table["height"], table["runs"]))]
    return [], [], [{"title": "Coefficients of the narrow set, and scores against the published equations",
                     "head": ["height of a run", "runs", "k_r", "κ_r", "RMSLE", "within 25 %", "k_p", "Fr_sat", "κ_p", "NRMSE", "within 25 %"], "rows": rows}]


def figure_compaction(study):
    table, curve, summary = study.table("compaction"), study.table("compaction_curve"), study.table("compaction_summary")
    if not table or not len(table["head"]):
        return [], ["no runs of compressible and hardly compressible snow at one flow that tell their density at the mast"]
    pictures = []
    cohesive = table["critical_state_slope"] * table["cohesion_beta"] > 0
    for mask, title in ((~cohesive, "(a) snow without cohesion, and the fluid"), (cohesive, "(b) cohesive snow")):
        rows = select(table, mask & (table["froude_number"] > 2.99))
        if not len(rows["head"]):
            continue
        _, axes = new_axes()
        handles = scatter_runs(axes, rows, "compaction", "share")
        axes.errorbar(rows["compaction"], rows["share"], yerr=2.0 * rows["share_standard_error"], fmt="none", ecolor="#5a6675", linewidth=0.8, zorder=2)
        axes.plot(curve["compaction"], curve["share"], "--", color="black", linewidth=1.2, zorder=2)
        axes.set(xlim=(0.9, 1.08 * np.max(rows["compaction"])), ylim=(0, None))
        handles.append(plt.Line2D([], [], color="black", linestyle="--", linewidth=1.2, label=r"behind the shock, $(2\chi-1)/\chi^2$"))
        pictures.append((title, "Run-up above H over that of the least compressible snow at the same flow and strength (times what the shock leaves of that one's head). Bars: two standard errors.",
                         done(axes, title, r"density at the mast over the initial density, $\chi$", "share of the velocity head", handles=handles, fontsize=8, ncols=2)))
    rows = [["with" if c else "without", f"{n:.0f}", number(head, 2), number(shock, 2), number(rms, 2)] for c, n, head, shock, rms in zip(*(summary[k] for k in summary))]
    tables = [{"title": "Fr ≥ 3", "head": ["cohesion", "runs", "run-up above H over the least compressible snow's, mean", "behind the shock, mean", "rms difference"], "rows": rows}]
    return pictures, [], tables


def heights_over_friction(study, key):
    points, curves = reference_points(study), study.table("height_curves")
    pictures, missing = [], []
    for xi in THREE_XI:
        rows = select(points, rows_where(points, hardening_xi=xi) & np.isfinite(points[key])) if points else {}
        if not rows or not len(rows[key]):
            missing.append(f"ξ = {xi:g}: no steady run")
            continue
        figure, axes = new_axes(height=4.6)
        for froude in distinct(rows["froude_number"]):
            of = select(rows, rows_where(rows, froude_number=froude))
            line = select(curves, rows_where(curves, froude_number=froude))
            colour = froude_colour(froude)
            axes.plot(of["effective_friction"], of[key], MARKERS[0], color=colour, markersize=4.5, label=f"Fr = {froude:g}", zorder=3)
            axes.plot(line["effective_friction"], line[f"{key}_fitted"], "-", color=colour, linewidth=1.2)
            axes.plot(line["effective_friction"], line[f"{key}_published"], "--", color=colour, linewidth=0.9)
        if key == "runup":
            decades(axes, "y", [0.9, 30])
        title = f"{HEIGHTS[key][0]}, {xi_label(xi)}"
        pictures.append((f"{HEIGHTS[key][0]}, ξ = {xi:g}", "Symbols: simulations. Full lines: our fit. Dashed: the published equation." + (" Outside the range of the fits." if xi < 0.1 else ""),
                         done(axes, title, "effective internal friction $M'$", HEIGHTS[key][1], ncols=2, fontsize=8)))
    return pictures, missing


def error_breakdown(study, key):
    table = study.table("scores")
    score, label = ("rmsle", "RMSLE [%]") if key == "runup" else ("nrmse", "NRMSE [%]")
    pictures, missing = [], []
    for group, axis, title in (("froude_number", "Froude number Fr", "over all M', by Froude number"), ("effective_friction", "effective internal friction $M'$", "over all Fr, by M'")):
        figure, axes = new_axes()
        drawn = 0
        for j, xi in enumerate(THREE_XI):
            for source, style in (("fitted", "-"), ("published", "--")):
                mask = rows_where(table, equation=key, fitting_set="narrow", coefficients=source, group=group) if table else np.zeros(0, bool)
                rows = select(table, mask & np.isclose(table["hardening_xi"], xi)) if mask.any() else {}
                if rows and len(rows["at"]):
                    axes.plot(rows["at"], 100 * rows[score], style, marker=MARKERS[j], markersize=4.5, color=COLOURS[j], linewidth=1.4, label=f"{xi_label(xi)}, {'our fit' if source == 'fitted' else 'published'}")
                    drawn += 1
        if not drawn:
            missing.append(f"no scores by {axis}")
            plt.close(figure)
            continue
        axes.set_ylim(bottom=0)
        name = f"{label.split()[0]} {title}"
        pictures.append((name, "", done(axes, name, axis, label, fontsize=8)))
    return pictures, missing


# ---- Tables -------------------------------------------------------------------------------------------------------------------------------


def coefficient_table(studies, equation):
    """Layout of Tables A1 and A2, ours beside the paper's."""
    rows = []
    for study in studies:
        for fitting_set in ("narrow", "wide"):
            fit = study.regression(equation, fitting_set)
            label = f"{study.name}, {fitting_set}" if len(studies) > 1 else fitting_set
            if not fit or not fit["coefficients"]:
                rows.append([label, "", fit["why_not"] if fit else "no such set", "", "", "", "", "", "", ""])
                continue
            for c in fit["coefficients"]:
                interval = c["interval"]
                rows.append([f"{label} ({fit['runs']} runs)", c["parameter"], number(c["value"], 4), number(c["relative_standard_error"], 4), number(c["t_statistic"], 2),
                             "–" if c["p_value"] is None else f"{c['p_value']:.1e}", f"{number(interval[0])} – {number(interval[1])}", number(c["published"], 4),
                             number(c["published_relative_standard_error"], 4), per_cent(c["relative_difference"])])
    return {"head": ["fitting set", "parameter", "value", "rel. std. error", "t", "p", "95 % interval", "paper", "paper's rel. std. error", "difference"], "rows": rows}


def score_table(studies, equation):
    rows = []
    published = None
    for study in studies:
        for fitting_set in ("narrow", "wide"):
            fit = study.regression(equation, fitting_set)
            if not fit:
                continue
            published = fit["published_scores_on_its_own_data"]
            label = f"{study.name}, {fitting_set}" if len(studies) > 1 else fitting_set
            for whose, key in (("our fit", "scores_of_fitted"), ("published equation", "scores_of_published")):
                if key in fit:
                    rows.append([f"{label}: our data, {whose}", *score_cells(fit[key])])
    if published:
        rows.append(["paper: its data, its fit", *score_cells(published)])
    return {"head": ["data and equation", "R²", "R²_log", "NRMSE", "RMSLE", "bias", "within 10 %", "within 25 %"], "rows": rows}


def score_cells(s):
    return [number(s["r2"]), number(s["r2_log"]), per_cent(s["nrmse"]), per_cent(s["rmsle"]), number(s["bias"]), per_cent(s["fraction_10"]), per_cent(s["fraction_25"])]


def aim_table(studies):
    """The aims for the narrow fitting set, a column for each study."""
    rows, heads = {}, []
    for number_of_study, study in enumerate(studies):
        aims = [aim for aim in study.fit["aims"] if aim["fitting_set"] == "narrow"]
        heads.append({"name": study.name, "runs": study.fit["runs"], "rows": study.fit["rows"], "met": sum(aim["met"] for aim in aims), "of": len(aims)})
        for aim in aims:
            row = rows.setdefault(aim["what"], {"what": aim["what"], "aim": aim["aim"].replace("<=", "≤").replace(">=", "≥"), "found": [None] * len(studies)})
            row["found"][number_of_study] = {"value": per_cent(aim["value"]), "met": aim["met"]}
    return {"studies": heads, "rows": list(rows.values())}


def cautions_of(study):
    lines = list(study.fit["cautions"])
    for fit in study.fit["fits"]:
        if fit["fitting_set"] == "narrow":
            lines += fit["cautions"]
    return lines


SECTIONS = [
    ("fig1", "Figure 1: friction and cohesion in one number", figure_1,
     "The snow is a cohesive Cam-Clay. Its internal friction *M* and its cohesion *β* act together as an effective internal friction M' (Eq. 2), the ratio of shear to mean stress at "
     "which it flows without change of volume. All that follows is drawn over M'. This figure is a formula; nothing is simulated."),
    ("fig3", "Figure 3: how the heights come about in time", figure_3,
     "Run-up is the highest particle in front of the mast; pressure height is where the smoothed pressure on the mast falls below 5 % of its mean over the flow height. Each band holds all "
     "rheologies at one Froude number Fr = v/√(gH). Slow flow piles up smoothly; fast flow first shoots up a splash, which stays in the air for some 2 v/g, and only then becomes steady. In the "
     "paper the steady run-up varies with the rheology by a factor of about 3 at Fr = 0.1, 2.5 at Fr = 1 and 15 at Fr = 5 (2 to over 30 H; above 13.5 H, Bernoulli's bound, only a peak can be meant)."),
    ("fig4", "Figure 4: which property of the snow does what", figure_4,
     "Starting from an inviscid fluid, friction, cohesion and plastic compressibility are added one after the other. The paper: the fluid follows the velocity head added to the flow height; at low Fr "
     "friction and cohesion raise the run-up by piling up, at high Fr they lower it by dissipation; compressibility matters little. Pressure height follows the run-up to Fr ≈ 2 and then stays constant."),
    ("fig5", "Figure 5: run-up is not where the pressure is", figure_5,
     "The same snow (M = 0.8, β = 0.3, ξ = 0.5) in slow and in fast flow. In the slow flow pressure acts over most of the run-up; in the fast one it is confined to a small part of it, because the jet that "
     "rises along the mast no longer pushes against it."),
    ("fig6", "Figure 6: pressure height over run-up height", figure_6,
     "Up to Fr ≈ 2 both heights are of one size; above, the run-up grows with the square of the speed, while the pressure height stays. The paper sees it saturate at about 1.5 to 2.5 H."),
    ("fig7", "Figure 7: the equations against the simulations", figure_7,
     "Every run with w = H and ξ > 0.05: predicted over simulated height, by the published coefficients and by ours. In the paper 92.9 % of the run-ups and all pressure heights lie within 25 %."),
    ("fig8", "Figure 8: the two factors of the equations", figure_8,
     "Magnification ζ = k M' is the quasi-static pile-up over H; the velocity head is divided by the dissipation factor λ = exp(κ M'). Where our curves leave the published ones, the snow of our simulations "
     "piles up or dissipates differently."),
    ("fig9", "Figure 9: the guideline's avalanche types in terms of M'", figure_9,
     "The Swiss guideline divides the velocity head by λ = 1.5 for dry, loose and by 3 for dense avalanches. For each M' the distance of our run-ups at 3 ≤ Fr ≤ 7 from H + v²/(2gλ) f(w/H) is measured as an RMSLE; "
     "where it is smallest, snow and avalanche type correspond. A minimum lies between the neighbours of the lowest point; the parabola through the three is the best guess, and decides."),
    ("fig10", "Figure 10: narrow and wide masts", figure_10,
     "Heights at other widths of the mast over those at w = H (Eq. 11), with the guideline's width factor (Eq. 6) rescaled to 1 there. The paper: run-up depends weakly on the width, pressure height follows the "
     "guideline at high Fr, and below w = H the guideline lowers the load more than the simulations do."),
    ("figS1", "Sensitivities: what the choices do that the paper leaves open", figure_s1,
     "One choice at a time is changed against the base of the study, at several points of flow and snow. The paper (its supplement S1, Sect. 4.3): robust to grid and slope; more friction on the mast lowers the run-up."),
    ("height-choices", "What is taken as the height of a run", height_choice_table,
     "The paper averages over a span of several seconds that it does not print. Ours is the longest that ends with the run and whose running mean stays within 5 % of its end. Slow piles still grow in it; the last third of "
     "the run gives a later, the peak the highest value."),
    ("compaction", "Compressible snow: what compaction takes", figure_compaction,
     "The equations know no compressibility, and fast compressible snow climbs less than they say. A plug of snow that is compacted from ρ₀ to χρ₀ in a shock standing before the mast keeps (2χ − 1)/χ² of its "
     "velocity head (mass and momentum); plastic work takes the rest. χ is measured at the mast's front face. What lies below the line loses more than the shock takes."),
]
APPENDIX = [
    ("figA2", "Figure A2: run-up height over M'", "runup", heights_over_friction,
     "Simulated run-up for three compressibilities, with both equations. At low Fr it rises with M' (pile-up), at high Fr it falls (dissipation)."),
    ("figA3", "Figure A3: where the run-up equation errs", "runup", error_breakdown,
     "RMSLE of the runs of one Froude number, and of one M'. The paper: for ξ = 5 below 10 % for Fr < 3 and 10 to 15 % above; for ξ = 0.5 7 to 15 % and 14 to 23 %; for ξ = 0.05, outside the fit, below 20 % "
     "for Fr < 3 only; best for M' from 0.4 to 1.5. Full lines: our fit; dashed: the published coefficients."),
    ("figA4", "Figure A4: pressure height over M'", "pressure_height", heights_over_friction,
     "As Figure A2, for the pressure height, whose velocity head is limited at the saturation Froude number."),
    ("figA5", "Figure A5: where the pressure-height equation errs", "pressure_height", error_breakdown,
     "NRMSE of the runs of one Froude number, and of one M'. The paper: 4 to 8 % for ξ = 5; up to 14 % at high Fr for ξ = 0.5; above 20 % for ξ = 0.05 at Fr > 3 and M' < 0.4."),
]


def make_section(identity, title, text, result):
    pictures, missing, tables = (*result, []) if len(result) == 2 else result
    return {"id": identity, "title": title, "text": text, "missing": missing, "tables": tables,
            "images": [{"title": name, "caption": caption, "data": data} for name, caption, data in pictures]}


def main():
    if len(sys.argv) < 3:
        sys.exit(__doc__)
    target, studies = sys.argv[1], [Study(folder) for folder in sys.argv[2:]]
    use_style()
    study = studies[0]
    sections = [make_section(identity, title, text, draw(study)) for identity, title, draw, text in SECTIONS]
    sections += [make_section(identity, title, text, draw(study, key)) for identity, title, key, draw, text in APPENDIX]
    sections += [make_section(identity, title, text, draw()) for identity, title, draw, text in extension_figures.SECTIONS]
    tables = [("tableA1", "Table A1: run-up height", "runup", "h_r/H = 1 + k_r M' + Fr²/2 exp(-κ_r M'), fitted to log(h_r/H)."),
              ("tableA2", "Table A2: pressure height", "pressure_height", "h_p/H = 1 + k_p M' + min(Fr, Fr_sat)²/2 exp(-κ_p M'), fitted to h_p/H.")]
    tables = [{"id": i, "title": t, "text": text, "coefficients": coefficient_table(studies, e), "scores": score_table(studies, e)} for i, t, e, text in tables]
    template = os.path.join(os.path.dirname(os.path.abspath(__file__)), "page.html.j2")
    environment = jinja2.Environment(autoescape=True, trim_blocks=True)
    environment.filters["inline"] = inline
    with open(template, encoding="utf-8") as file:
        page = environment.from_string(file.read()).render(style=markupsafe.Markup(STYLE), study=study.fit, name=study.name, sections=sections, tables=tables, aims=aim_table(studies),
                                                           others=studies[1:], cautions=cautions_of(study))
    os.makedirs(os.path.dirname(os.path.abspath(target)), exist_ok=True)
    write_page(target, page)


if __name__ == "__main__":
    main()
