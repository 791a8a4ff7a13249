"""The paper's figures from the tables of a study, with its fitted curves beside ours.

Every function takes a Study (page.py) and returns what its section of the page shows. A figure without data says what is missing.
"""

import numpy as np
from matplotlib.patches import Rectangle

from analysis.axes import Drawn, decades, froude_colour, number, per_cent, scatter_runs
from mpmtools.figures.colours import STRESS_COLOURS
from mpmtools.figures.style import COLOURS, MARKERS, Picture, finish_axes, new_axes, picture, plt, png_data

COMPRESSIBILITY = {0.05: 205.3, 0.15: 127.1, 0.5: 107.5, 1.5: 102.4, 5.0: 100.7, 15.0: 100.2}  # chi(25 kPa) in per cent, Table 1
THREE_XI = (5.0, 0.5, 0.05)  # of Figs. A2 to A5
ENVELOPE_COLOURS = {0.1: COLOURS[0], 1.0: COLOURS[2], 5.0: COLOURS[1]}
PUBLISHED_RANGES = ((0.45, 0.65, "dry, loose"), (1.0, 1.5, "dense"))
HEIGHTS = {"runup": ("Run-up height", "$h_r/H$"), "pressure_height": ("Pressure height", "$h_p/H$")}
FRICTION_AXIS = "effective internal friction $M'$"
SLOW = 0.1  # Froude number up to which a height is all pile-up


def xi_label(xi):
    chi = COMPRESSIBILITY.get(round(xi, 3))
    return rf"$\xi$ = {xi:g}" + (rf", $\chi$ = {chi} %" if chi else "")


def shade_guideline(axes):
    for low, high, name in PUBLISHED_RANGES:
        axes.axvspan(low, high, color="#e8ebef", zorder=0)
        axes.annotate(name, (0.5 * (low + high), 0.985), xycoords=("data", "axes fraction"), ha="center", va="top", fontsize=8,
                      color="#5a6675")


def reference_points(study):
    """Runs with w = H."""
    points = study.table("points")
    return points if points.empty else points[np.isclose(points.relative_width, 1.0, rtol=1e-6) & np.isfinite(points.runup)]


def figure_1(study):
    table = study.table("effective_friction")
    pictures = []
    for column, title, label in (("effective_friction", "(a) effective internal friction", "$M'$"),
                                 ("friction_angle_deg", "(b) effective friction angle", r"$\varphi'$ [°]")):
        axes = new_axes(height=3.8)
        for k, (slope, rows) in enumerate(table.groupby("critical_state_slope")):
            axes.plot(rows.cohesion_beta, rows[column], color=COLOURS[k], linewidth=1.6, label=f"M = {slope:g}")
            axes.plot(rows.cohesion_beta[::30], rows[column][::30], MARKERS[k], color=COLOURS[k], markersize=5)
        pictures.append(picture(axes, title, r"cohesion $\beta$", label, "Symbols: the rheologies of the study."))
    return Drawn(pictures)


def figure_3(study):
    table, spread = study.table("envelopes"), study.table("spreads")
    drawn = {froude: rows for froude, rows in table.groupby("froude_number")} if len(table) else {}
    missing = [f"Fr = {f:g}: no time histories of runs" for f in ENVELOPE_COLOURS if f not in drawn]
    pictures = []
    for key, title in (("runup", "(a) run-up height"), ("pressure_height", "(b) pressure height")):
        if not drawn:
            break
        axes = new_axes()
        for froude, colour in ENVELOPE_COLOURS.items():
            rows = drawn.get(froude, table[:0])
            rows = rows[(rows.runs == rows.all_runs) & (rows.time_s > 0.1)]
            if rows.empty:
                continue
            low, high = rows[f"{key}_low"], rows[f"{key}_high"]
            axes.fill_between(rows.time_s, low, high, color=colour, alpha=0.22, linewidth=0)
            axes.plot(rows.time_s, low, color=colour, linewidth=1.2)
            axes.plot(rows.time_s, high, color=colour, linewidth=1.2, label=f"Fr = {froude:g}, {rows.all_runs.iat[0]:.0f} runs")
        decades(axes, "x", [0.1, 100])
        if key == "runup":
            decades(axes, "y", [0.5, 40])
        pictures.append(picture(axes, title, "time since the front reached the mast [s]", HEIGHTS[key][1],
                                "Lowest and highest of all rheologies at each time, as far as every run reaches. The axis of time is "
                                "logarithmic, because slow flow takes ten times as long."))
    rows = [[f"Fr = {s.froude_number:g}", f"{s.runs:.0f}", f"{number(s.runup_low, 2)} to {number(s.runup_high, 2)}", number(s.runup_ratio, 1),
             f"{number(s.pressure_height_low, 2)} to {number(s.pressure_height_high, 2)}", number(s.pressure_height_ratio, 1)]
            for s in spread.itertuples()]
    tables = [{"title": "Spread of the steady means over all rheologies",
               "head": ["flow", "runs", "h_r/H", "factor of h_r", "h_p/H", "factor of h_p"], "rows": rows}] if rows else []
    return Drawn(pictures, missing, tables)


def figure_4(study):
    table = study.table("decomposition")
    if table.empty:
        return Drawn([], ["no run of the chain"])
    links = dict(list(table.groupby("link")))
    added = {0: "fluid: M = β = 0, ξ = 5", 1: "+ friction M = {0.critical_state_slope:g}", 2: "+ cohesion β = {0.cohesion_beta:g}",
             3: "+ compressibility ξ = {0.hardening_xi:g}"}
    missing = []
    for rows in links.values():
        without = rows[~np.isfinite(rows.runup)]
        if len(without):
            first, numbers = rows.iloc[0], ", ".join(f"{f:g}" for f in without.froude_number)
            missing.append(f"M = {first.critical_state_slope:g}, β = {first.cohesion_beta:g}, ξ = {first.hardening_xi:g}: "
                           f"no steady run at Fr {numbers}")
    pictures = []
    for key, title in (("runup", "(a) run-up height"), ("pressure_height", "(b) pressure height")):
        if not np.isfinite(table[key]).any():
            continue
        axes = new_axes()
        for link, rows in links.items():
            known = rows[np.isfinite(rows[key])]
            axes.plot(known.froude_number, known[key], marker=MARKERS[int(link)], color=COLOURS[int(link)], linewidth=1.5, markersize=5,
                      label=added[int(link)].format(rows.iloc[0]), zorder=3)
        bernoulli = links[0] if key == "runup" else links[0][links[0].froude_number <= 2.0]
        axes.plot(bernoulli.froude_number, bernoulli.bernoulli, "--", color="black", linewidth=1.2, label="$H$ + velocity head", zorder=2)
        if key == "runup":
            decades(axes, "y", [*bernoulli.bernoulli, *table[key]])
        pictures.append(picture(axes, title, "Froude number Fr", HEIGHTS[key][1], "One property of the snow is added at a time."))
    return Drawn(pictures, missing)


def figure_5(study):
    sections = study.table("sections")
    pictures, missing = [], []
    for name, froude, title in (("slow", 0.1, "(a) gravity-driven, Fr = 0.1"), ("fast", 5.0, "(b) inertia-driven, Fr = 5")):
        rows = sections[np.isclose(sections.froude_number, froude)] if len(sections) else sections
        particles, profile = study.table(f"section_{name}"), study.table(f"section_profile_{name}")
        if rows.empty or particles.empty or profile.empty:
            missing.append(f"Fr = {froude:g}: no run with M = 0.8, β = 0.3, ξ = 0.5 that kept its last state (final.h5) and its mean profile")
            continue
        caption = ("Left: particles near the plane of symmetry in the last state, coloured by the stream-wise stress. Right: mean pressure on "
                   "the mast over the steady interval, on the same axis of height.")
        pictures.append(Picture(title, caption, draw_section(title, particles, profile, rows.iloc[0])))
    return Drawn(pictures, missing)


def draw_section(title, particles, profile, run):
    height = run.flow_height_m
    x, z = particles.x_m / height, particles.z_m / height
    top = max(1.05 * z.max(), 2.2)
    left, right = max(x.min(), -4.0), 1.3
    # Placed in inches, so that a flow height is as long in both directions and the profile shares the section's axis of height.
    profile_width, before, between, after, below = 1.75, 0.65, 0.2, 0.15, 1.3
    section_width = min((right - left) * 3.9 / top, 6.2 - profile_width - before - between - after)
    scale = section_width / (right - left)  # inches a flow height
    page_width, page_height = before + section_width + between + profile_width + after, below + scale * top + 0.4
    figure = plt.figure(figsize=(page_width, page_height))

    def place(x0, y0, width, tall, **arguments):
        return figure.add_axes((x0 / page_width, y0 / page_height, width / page_width, tall / page_height), **arguments)

    axes = place(before, below, section_width, scale * top)
    beside = place(before + section_width + between, below, profile_width, scale * top, sharey=axes)
    shown = (x >= left) & (x <= right)
    stress = 1e-3 * particles.stress_xx_pa[shown]
    size = (0.9 * scale * 72.0 * run.particle_spacing_m / height) ** 2
    points = axes.scatter(x[shown], z[shown], c=stress, s=max(size, 0.8), marker="s", cmap=STRESS_COLOURS,
                          vmin=min(np.percentile(stress, 0.5), -0.1), vmax=0.0, linewidths=0, rasterized=True)
    axes.add_patch(Rectangle((0.0, 0.0), 1.0, 2 * top, facecolor="#c9ced5", edgecolor="#3a424d", hatch="///", linewidth=1.0, zorder=0))
    axes.axhline(0.0, color="#3a424d", linewidth=1.2)
    axes.set(xlim=(left, right), ylim=(-0.02 * top, top), xlabel="$x/H$", ylabel="$z/H$")
    beside.step(1e-3 * profile.pressure_pa, profile.z_m / height, where="mid", color="0.65", linewidth=1.0, label="mean")
    beside.plot(1e-3 * profile.smoothed_pressure_pa, profile.z_m / height, color=COLOURS[0], linewidth=1.7, label="smoothed")
    for value, colour, label in ((run.runup, COLOURS[1], "$h_r$"), (run.pressure_height, COLOURS[2], "$h_p$")):
        if np.isfinite(value):
            beside.axhline(value, color=colour, linestyle="--", linewidth=1.3, label=f"{label} = {value:.2f} $H$")
    beside.set_xlabel("pressure [kPa]")
    beside.tick_params(labelleft=False)
    beside.set_xlim(left=0.0)
    finish_axes(axes)
    finish_axes(beside)
    axes.grid(False)
    beside.legend(fontsize=7.5, frameon=False, loc="upper center", bbox_to_anchor=(0.5, -0.45 / (scale * top)), ncols=2, columnspacing=0.8,
                  handlelength=1.4, handletextpad=0.4)  # below the axis: the dashed lines cross all of the panel
    bar = figure.colorbar(points, cax=place(before, 0.5, section_width, 0.13), orientation="horizontal", extend="both")
    bar.set_label(r"$\sigma_{xx}$ [kPa], compression negative", fontsize=9)
    bar.outline.set_visible(False)
    figure.text(before / page_width, 1.0 - 0.1 / page_height, title, fontsize=10.5, ha="left", va="top")
    return png_data(figure)


def figure_6(study):
    points = reference_points(study)
    points = points[np.isfinite(points.pressure_height)] if len(points) else points
    if points.empty:
        return Drawn([], ["no run with both a steady run-up and a steady pressure height"])
    axes = new_axes(height=4.8)
    handles = scatter_runs(axes, points, "runup", "pressure_height")
    limit = [0.9, 1.05 * points.pressure_height.max()]
    handles += axes.plot(limit, limit, "--", color="black", linewidth=1.1, label="$h_p = h_r$")
    decades(axes, "x", points.runup)
    return Drawn([picture(axes, "Pressure height over run-up height", "$h_r/H$", "$h_p/H$", handles=handles, ncols=2, fontsize=8)])


def figure_7(study):
    points = reference_points(study)
    points = points[points.hardening_xi > 0.051] if len(points) else points
    if points.empty:
        return Drawn([], ["no runs with w = H and ξ > 0.05"])
    pictures = []
    for key, panel in (("runup", "a"), ("pressure_height", "b")):
        for source, whose in (("published", "published coefficients"), ("fitted", "our fit")):
            rows = points[np.isfinite(points[key]) & np.isfinite(points[f"{key}_{source}"])]
            if len(rows):
                pictures.append(_predicted_over_simulated(rows, key, source, f"({panel}) {HEIGHTS[key][0].lower()}: {whose}"))
    return Drawn(pictures, _not_fitted(study))


def _predicted_over_simulated(rows, key, source, title):
    axes = new_axes(height=4.8)
    handles = scatter_runs(axes, rows, key, f"{key}_{source}")
    both = rows[[key, f"{key}_{source}"]].to_numpy()
    line = np.array([0.9 * both.min(), 1.08 * both.max()])
    axes.plot(line, line, color="black", linewidth=1.2)
    for factor in (1 - 0.25, 1 + 0.25):  # |y - f| <= 0.25 y, as the score counts it
        axes.plot(line, factor * line, "--", color="#808890", linewidth=1.0)
    if key == "runup":
        decades(axes, "x", rows[key])
        decades(axes, "y", rows[key])
    return picture(axes, title, f"{HEIGHTS[key][1]}, simulation", f"{HEIGHTS[key][1]}, equation", "Dashed: 25 % of the simulated value.",
                   handles=handles, ncols=2, fontsize=8, loc="upper left")


def _not_fitted(study):
    return [f"our fit of the {HEIGHTS[key][0].lower()}: {study.why_not(key)}" for key in HEIGHTS if not study.is_fitted(key)]


def figure_8(study):
    table, points = study.table("factor_curves"), study.table("points")
    slow = points[(points.froude_number <= SLOW) & (points.hardening_xi > 0.1)] if len(points) else points
    grey = "Grey: the ranges of M' that the paper assigns to the guideline's avalanche types."
    shown = f" Symbols: height over H, less 1, of the runs at Fr ≤ {SLOW:g} with ξ > 0.1, whose velocity head is at most {SLOW**2 / 2:g} H."
    pictures = []
    for quantity, title, label in (("zeta", "(a) magnification factor", r"$\zeta = k\,M'$"),
                                   ("lambda", "(b) dissipation factor", r"$\lambda = \exp(\kappa\,M')$")):
        axes, caption = new_axes(), grey
        shade_guideline(axes)
        for k, (letter, name) in enumerate((("r", "run-up"), ("p", "pressure height"))):
            for source, style, whose in (("fitted", "-", "our fit"), ("published", "--", "published")):
                values = table[f"{quantity}_{letter}_{source}"]
                if np.isfinite(values).any():
                    axes.plot(table.effective_friction, values, style, color=COLOURS[k], linewidth=1.6, label=f"{name}, {whose}")
        if quantity == "zeta" and len(slow):
            for k, (key, name) in enumerate((("runup", "run-up"), ("pressure_height", "pressure height"))):
                axes.plot(slow.effective_friction, slow[key] - 1.0, MARKERS[k], color=COLOURS[k], markersize=4, markerfacecolor="none",
                          label=f"{name}, Fr ≤ {SLOW:g}")
            caption += shown
        axes.set_xlim(0, 2.4)
        if quantity == "lambda":
            decades(axes, "y", [1, 40])
        pictures.append(picture(axes, title, FRICTION_AXIS, label, caption, loc="lower right"))
    return Drawn(pictures, _not_fitted(study))


def figure_9(study):
    table, minima = study.table("guideline"), study.table("guideline_minima")
    if table.empty:
        return Drawn([], ["no ξ with three or more values of M' that have a run at every Froude number from 3 to 7"])
    known = sorted(table.hardening_xi.unique(), reverse=True)
    xis = [xi for xi in known if xi in (5.0, 0.5)] or known
    pictures = []
    for key, title, label in (("normalised", "RMSLE, normalised to 0–1", "normalised RMSLE"), ("rmsle", "RMSLE itself", "RMSLE")):
        axes = new_axes()
        shade_guideline(axes)
        for k, (dissipation, of_lambda) in enumerate(table.groupby("lambda")):
            for j, xi in enumerate(xis):
                rows = of_lambda[of_lambda.hardening_xi == xi]
                axes.plot(rows.effective_friction, rows[key], ("-", "--", ":", "-.")[j % 4], marker=MARKERS[j], markersize=4, color=COLOURS[k],
                          linewidth=1.4, label=rf"$\lambda$ = {dissipation:g}, $\xi$ = {xi:g}")
        axes.set_ylim(0, 1.35 * axes.get_ylim()[1])  # room for the legend
        pictures.append(picture(axes, title, FRICTION_AXIS, label,
                                "Grey: the paper's minima, 0.45–0.65 for λ = 1.5 (dry, loose) and 1.0–1.5 for λ = 3 (dense).", ncols=2,
                                loc="upper right", bbox_to_anchor=(1.0, 0.95), fontsize=8))
    rows = [[f"{m['lambda']:g}", f"{m['hardening_xi']:g}", number(m["minimum_at"], 3),
             f"{number(m['neighbour_below'], 2)} to {number(m['neighbour_above'], 2)}", number(m["parabola_at"], 3), number(m["rmsle"], 3),
             f"{m['published_from']:g} to {m['published_to']:g}",
             "no minimum: an end of the curve" if not np.isfinite(m["parabola_at"]) else "yes" if m["inside"] else "no"]
            for m in minima.to_dict("records")]
    head = ["λ", "ξ", "lowest M' of the table", "between its neighbours", "vertex of the parabola", "RMSLE", "published M'", "inside"]
    return Drawn(pictures, [], [{"title": "Where the curves are lowest", "head": head, "rows": rows}])


def figure_10(study):
    table = study.table("width_factors")
    if table.empty:
        return Drawn([], ["no table of the width study: runs with w/H other than 1 and their reference with w = H"])
    pictures = []
    for key, letter, symbol in (("runup", "a", "$f_r$"), ("pressure_height", "b", "$f_p$")):
        for j, (slope, rows) in enumerate(table.sort_values("relative_width").groupby("critical_state_slope")):
            axes = new_axes()
            for froude, of in rows.groupby("froude_number"):
                axes.errorbar(of.relative_width, of[f"{key}_factor"], yerr=of[f"{key}_standard_error"], marker="o", markersize=4.5, capsize=3,
                              linewidth=1.4, color=froude_colour(froude), label=f"Fr = {froude:g}")
            guideline = rows.groupby("relative_width").guideline.first()
            axes.plot(guideline.index, guideline, "--", color="black", linewidth=1.3, label="guideline (Eq. 6, 1 at $w = H$)")
            first = rows.iloc[0]
            title = f"({letter}.{j + 1}) {HEIGHTS[key][0].lower()}, M = {slope:g}, β = {first.cohesion_beta:g}, ξ = {first.hardening_xi:g}"
            pictures.append(picture(axes, title, "$w/H$", symbol))
    return Drawn(pictures)


def heights_over_friction(study, key):
    """Figs. A2 and A4."""
    points, curves = reference_points(study), study.table("height_curves")
    lines = dict(list(curves.groupby("froude_number"))) if len(curves) else {}
    pictures, missing = [], []
    for xi in THREE_XI:
        rows = points[np.isclose(points.hardening_xi, xi) & np.isfinite(points[key])] if len(points) else points
        if rows.empty:
            missing.append(f"ξ = {xi:g}: no steady run")
            continue
        axes = new_axes(height=4.6)
        for froude, of in rows.groupby("froude_number"):
            colour, line = froude_colour(froude), lines[froude]
            axes.plot(of.effective_friction, of[key], MARKERS[0], color=colour, markersize=4.5, label=f"Fr = {froude:g}", zorder=3)
            if f"{key}_numerical_uncertainty" in of:
                band = of.sort_values("effective_friction")
                low, high = (band[key] + sign * band[f"{key}_numerical_uncertainty"] for sign in (-1, 1))
                axes.fill_between(band.effective_friction, low, high, color=colour, alpha=0.15, linewidth=0)
            axes.plot(line.effective_friction, line[f"{key}_fitted"], "-", color=colour, linewidth=1.2)
            axes.plot(line.effective_friction, line[f"{key}_published"], "--", color=colour, linewidth=0.9)
        if key == "runup":
            decades(axes, "y", [0.9, 30])
        caption = "Symbols: simulations. Full lines: our fit. Dashed: the published equation."
        if f"{key}_numerical_uncertainty" in rows:
            caption += " Bands: numerical uncertainty of grid and time step."
        drawn = picture(axes, f"{HEIGHTS[key][0]}, {xi_label(xi)}", FRICTION_AXIS, HEIGHTS[key][1],
                        caption + (" Outside the range of the fits." if xi < 0.1 else ""), ncols=2, fontsize=8)
        pictures.append(drawn._replace(title=f"{HEIGHTS[key][0]}, ξ = {xi:g}"))
    return Drawn(pictures, missing)


def error_breakdown(study, key):
    """Figs. A3 and A5: the scores of our fit to the narrow set, and of the published equation, by Froude number and by M'."""
    table = study.table("scores")
    if len(table):
        table = table[(table.equation == key) & (table.fitting_set == "narrow")]
    score = "rmsle" if key == "runup" else "nrmse"
    pictures, missing = [], []
    for group, axis, title in (("froude_number", "Froude number Fr", "over all M', by Froude number"),
                               ("effective_friction", FRICTION_AXIS, "over all Fr, by M'")):
        axes = new_axes()
        for j, xi in enumerate(THREE_XI):
            for source, style, whose in (("fitted", "-", "our fit"), ("published", "--", "published")):
                rows = table[(table.group == group) & (table.coefficients == source) & np.isclose(table.hardening_xi, xi)]
                if len(rows):
                    axes.plot(rows["at"], 100 * rows[score], style, marker=MARKERS[j], markersize=4.5, color=COLOURS[j], linewidth=1.4,
                              label=f"{xi_label(xi)}, {whose}")
        if not axes.lines:
            missing.append(f"no scores by {axis}")
            plt.close(axes.figure)
            continue
        axes.set_ylim(bottom=0)
        pictures.append(picture(axes, f"{score.upper()} {title}", axis, f"{score.upper()} [%]", fontsize=8))
    return Drawn(pictures, missing)


CHOICES = {"obstacle_friction": "mast friction μ", "obstacle_friction_ratio": "μ / tan φ'", "cell_size_m": "cell size [m]",
           "numerics.slope_deg": "slope [°]", "conveyor.sidewall_contact": "side walls",
           "conveyor.sidewall_contact, conveyor.sidewall_friction": "side walls", "numerics.transfer": "transfer",
           "numerics.transfer, numerics.flip_ratio": "transfer", "numerics.precision": "precision",
           "numerics.particles_per_cell": "particles a cell", "conveyor.lattice": "feed's lattice",
           "conveyor.upstream_length_m, conveyor.downstream_length_m": "window up-, downstream [m]", "numerics.cfl": "CFL number",
           "conveyor_width_m": "width of the belt [m]"}


def choice_labels(table):
    return [f"{CHOICES.get(choice, choice)} {value.replace('_', '-')}" if choice else "base"
            for choice, value in zip(table.choice.fillna(""), table.value.fillna(""))]


def figure_s1(study):
    """Supplement S1: one choice changed at a time."""
    table, summary = study.table("sensitivity", text=("value",)), study.table("sensitivity_summary", text=("value",))
    if table.empty:
        return Drawn([], ["no table of runs that change one choice at a time"])
    table, summary = table.assign(label=choice_labels(table)), summary.assign(label=choice_labels(summary))
    shown = list(dict.fromkeys(label for label in summary.label if label != "base"))  # two campaigns may vary the same choice
    pictures = []
    for key, title in (("runup", "(a) run-up height, one choice changed"), ("pressure_height", "(b) pressure height, one choice changed"),
                       ("force", "(c) mean force on the mast, one choice changed")):
        axes = new_axes(height=1.2 + 0.21 * len(shown))
        for i, (froude, rows) in enumerate(table[table.label != "base"].groupby("froude_number")):
            axes.errorbar(rows[f"{key}_to_base"], rows.label.map(shown.index) + 0.16 * (i - 1), xerr=rows[f"{key}_standard_error"],
                          fmt=MARKERS[i], color=froude_colour(froude), markersize=4, linewidth=0.9, label=f"Fr = {froude:g}")
        axes.axvline(1.0, color="black", linewidth=1.1)
        axes.set_yticks(range(len(shown)), shown, fontsize=8)
        axes.set_ylim(len(shown) - 0.5, -0.5)
        pictures.append(picture(axes, title, "over that of the base", "", "Bars: standard errors of both runs' means. Line: the base.",
                                loc="best", fontsize=8))
    rows = [[s["label"], f"{s['points']:.0f}",
             *(f"{number(s[key], 2)} ({number(s[key + '_low'], 2)} to {number(s[key + '_high'], 2)})" for key in ("runup", "pressure_height", "force")),
             per_cent(s["runup_rmsle"]), per_cent(s["base_runup_rmsle"])] for s in summary.to_dict("records")]
    head = ["what differs", "points", "h_r", "h_p", "force", "RMSLE of h_r from the published equation", "the base's at the same points"]
    return Drawn(pictures, [], [{"title": "Over the base: geometric mean of the points (lowest to highest)", "head": head, "rows": rows}])


def height_choice_table(study):
    table = study.table("height_choices")
    if table.empty:
        return Drawn([], ["no time histories of runs"])
    rows = [[row["height"], f"{row['runs']:.0f}", number(row["k_r"]), number(row["kappa_r"]), per_cent(row["runup_rmsle_published"]),
             per_cent(row["runup_fraction_25_published"]), number(row["k_p"]), number(row["Fr_sat"]), number(row["kappa_p"]),
             per_cent(row["pressure_height_nrmse_published"]), per_cent(row["pressure_height_fraction_25_published"])]
            for row in table.to_dict("records")]
    head = ["height of a run", "runs", "k_r", "κ_r", "RMSLE", "within 25 %", "k_p", "Fr_sat", "κ_p", "NRMSE", "within 25 %"]
    return Drawn([], [], [{"title": "Coefficients of the narrow set, and scores against the published equations", "head": head, "rows": rows}])


def figure_compaction(study):
    table, curve, summary = (study.table(name) for name in ("compaction", "compaction_curve", "compaction_summary"))
    if table.empty:
        return Drawn([], ["no runs of compressible and hardly compressible snow at one flow that hold their density at the mast"])
    fast = table[table.froude_number > 2.99]
    cohesive = fast.critical_state_slope * fast.cohesion_beta > 0
    caption = ("Run-up above H over that of the least compressible snow at the same flow and strength (times what the shock leaves of that "
               "one's head). Bars: two standard errors.")
    pictures = []
    for rows, title in ((fast[~cohesive], "(a) snow without cohesion, and the fluid"), (fast[cohesive], "(b) cohesive snow")):
        if rows.empty:
            continue
        axes = new_axes()
        handles = scatter_runs(axes, rows, "compaction", "share")
        axes.errorbar(rows.compaction, rows["share"], yerr=2.0 * rows.share_standard_error, fmt="none", ecolor="#5a6675", linewidth=0.8, zorder=2)
        handles += axes.plot(curve.compaction, curve["share"], "--", color="black", linewidth=1.2, zorder=2,
                             label=r"behind the shock, $(2\chi-1)/\chi^2$")
        axes.set(xlim=(0.9, 1.08 * rows.compaction.max()), ylim=(0, None))
        pictures.append(picture(axes, title, r"density at the mast over the initial density, $\chi$", "part of the velocity head", caption,
                                handles=handles, fontsize=8, ncols=2))
    rows = [["with" if s.cohesive else "without", "all" if np.isnan(s.hardening_xi) else number(s.hardening_xi, 2), f"{s.runs:.0f}",
             number(s.mean_head, 2), number(s.mean_behind_shock, 2), number(s.rms, 2), number(s.rms_without_loss, 2)]
            for s in summary.itertuples()]
    head = ["cohesion", "ξ", "runs", "run-up above H over the least compressible snow's, mean", "behind the shock, mean", "rms difference",
            "rms difference from no loss"]
    return Drawn(pictures, [], [{"title": "Fr ≥ 3", "head": head, "rows": rows}])
