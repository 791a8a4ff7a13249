"""The figures of the design page; each returns a Picture with its caption, or None where there is nothing to draw."""

import numpy as np
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize

from mpmtools.design.ensemble import snow_cover
from mpmtools.design.oscillator import shock_response_spectrum
from mpmtools.design.results import LINE_LOADS
from mpmtools.figures.snow_surface import SnowDensity, draw, standpoint
from mpmtools.figures.style import COLOURS, MARKERS, Picture, finish_axes, new_axes, picture, plt, png_data
from mpmtools.plots import Section, draw_section, section_half_width, stress_norm

GREY = "#5a6675"
FREQUENCIES = np.geomspace(0.2, 20.0, 61)  # Hz, of the shock response spectrum
DEFAULT_DAMPING = 0.02
TIME = "time since the front reached the mast (s)"


def each_snow(ensemble, of_snows):
    """(what there is of a snow, its colour, its label) of each."""
    return [(of_snow, COLOURS[snow % len(COLOURS)], ensemble.label(snow)) for snow, of_snow in enumerate(of_snows)]


def mark_heights(axes, plan, values):
    """Flow depth, and the middle snow's heights."""
    for value, label, style in ((snow_cover(plan) + plan["flow"]["depth_m"], "surface of the flow", ":"), (values["pressure_height_mean_m"].value, "pressure height", "--"),
                                (values["runup_p99_mean_m"].value, "run-up, mean", "-.")):
        if np.isfinite(value):
            axes.axhline(value, color=GREY, linestyle=style, linewidth=1.2, label=f"{label}: {value:.3g} m")


def side_view(ensemble, loads):
    """Particles near the axis at the end of the middle snow's finest run, by stress, with the heights."""
    run, values, plan = loads.run, loads.values, ensemble.plan
    if run.final is None:
        return None
    section, height = Section(run, run.final, section_half_width(run)), plan["flow"]["depth_m"]
    section.z += loads.base
    reach = max(run.obstacle_width, height)
    length = 8.0 * reach + run.obstacle_depth
    left, right = -5.0 * reach, length - 5.0 * reach
    shown = section.z[(section.x > left) & (section.x < right)]
    highest = [values["runup_mean_m"].value, values["pressure_height_mean_m"].value, loads.base + 2.0 * height]
    top = max(1.08 * float(np.percentile(shown, 99.99)) if shown.size else 0.0, 1.1 * float(np.nanmax(highest)))
    figure, axes = plt.subplots(figsize=(7.5, float(np.clip(5.6 * top / length + 1.1, 2.6, 8.0))), layout="constrained")
    points = draw_section(axes, run, section, stress_norm([section]), 5.6 * 72.0 / length, top)
    if loads.base:
        mast, *arm = axes.patches
        mast.set_height(loads.base + mast.get_height())  # the mast stands on the ground, not on the cover
        for part in arm:
            part.set_y(loads.base + part.get_y())
        axes.axhspan(0.0, loads.base, color="0.93", zorder=0, label=f"snow cover: {loads.base:g} m")
    mark_heights(axes, plan, values)
    axes.set(xlim=(left, right), ylim=(-0.02 * top, top), xlabel="x (m), 0 at the front of the mast", ylabel="height z (m)", title="")
    axes.set_title(f"Side view at t = {run.final.time:.1f} s, snow {ensemble.label(ensemble.middle)}", fontsize=10.5, loc="left")
    axes.set_aspect("equal")
    figure.colorbar(points, ax=axes, label="stress along the flow (kPa)", extend="both", shrink=0.85)
    axes.legend(fontsize=9, loc="upper right", framealpha=0.85, edgecolor="none")
    return Picture("Side view", f"Particles with |y| below {section_half_width(run):.2g} m on the finest grid ({run.cell_size:.3g} m), at the end of the run. "
                   "Pressure is negative.", png_data(figure))


def view_3d(ensemble, loads):
    """The snow at the end of the same run as a surface, coloured by speed."""
    run, final = loads.run, loads.run.final
    if final is None:
        return None
    position, speed = final.whole("position_m"), np.linalg.norm(final.whole("velocity_m_s"), axis=1)
    camera, solid = standpoint(run, position, float(np.percentile(position[:, 2], 99.9)))
    colours = ScalarMappable(Normalize(0.0, float(np.percentile(speed, 99.5))), "viridis")
    snow = SnowDensity(position, final.whole("reference_volume_m3"), run.particle_spacing, speed)
    image = draw(snow, camera, (810, 540), solid, lambda values: colours.to_rgba(values)[:, :3])
    figure, axes = plt.subplots(figsize=(7.5, 4.5), layout="constrained")
    axes.imshow(image)
    axes.axis("off")
    axes.set_title(f"The snow at the mast at t = {final.time:.1f} s, snow {ensemble.label(ensemble.middle)}", fontsize=10.5, loc="left")
    figure.colorbar(colours, ax=axes, label="speed (m/s)", shrink=0.7)
    return Picture("View in three dimensions", "Surface of the snow, seen from upstream; loose snow and single lumps are left out. " + (
        "Half of it was computed, and is mirrored here." if run.mirrored_y else ""), png_data(figure))


def pressure_over_height(ensemble, all_loads):
    axes = new_axes(6.6, 4.6)
    finest = [loads.profiles for loads in all_loads]
    z = finest[0]["z_m"]
    shown = (("first_impact", "first impact", COLOURS[1]), ("steady_peak", "steady, highest 0.1 s", COLOURS[2]), ("mean", "steady, mean", COLOURS[0]))
    if not all(loads.is_steady for loads in all_loads):
        shown += (("later_peak", "after the first impact, not steady", COLOURS[3]),)
    for key, label, shade in shown:
        curves = 1e-3 * np.array([p[key] for p in finest])
        if not np.isfinite(curves).any():
            continue
        low, high = np.nanmin(curves, axis=0), np.nanmax(curves, axis=0)
        axes.fill_betweenx(z, low, high, color=shade, alpha=0.25, linewidth=0)
        axes.plot(curves[ensemble.middle], z, color=shade, linewidth=1.8, label=f"{label}, {ensemble.label(ensemble.middle)}")
    middle = finest[ensemble.middle]
    if np.isfinite(middle["stress"]).any():
        axes.plot(1e-3 * middle["stress"], z, color=GREY, linewidth=1.0, linestyle=(0, (4, 2)), label="steady mean of the stress before the mast")
    mark_heights(axes, ensemble.plan, all_loads[ensemble.middle].values)
    axes.set_xlim(left=min(0.0, axes.get_xlim()[0]))
    axes.set_ylim(0.0, z[-1])
    return picture(axes, "Pressure over height", "pressure (kPa)", "height z (m)",
                   "Force per height that the mast took, over its width: impulses on all its sides, exact sums over the time steps. Bands: all "
                   "snows. 'Highest' is at each height the highest moving mean over 0.1 s, not at one time: an envelope. The dashed profile is "
                   "the paper's definition, the stress of the snow in a box before the mast.", fontsize=10)


def line_load(results, plan):
    low, high, loads, arm = results.line_loads(plan)
    if not loads:
        return None
    axes = new_axes(6.6, 4.2)
    if arm:
        axes.axhspan(plan["arm"]["base_m"], plan["arm"]["height_m"], color="0.9", zorder=0, label="arm, whose load comes in addition")
    for name, shade in (("mean", COLOURS[0]), ("steady_peak", COLOURS[2]), ("first_impact", COLOURS[1]), ("later_peak", COLOURS[3]), ("with_vibration", "0.2")):
        if name in loads:
            axes.stairs(1e-3 * loads[name], np.append(low, high[-1]), orientation="horizontal", color=shade, linewidth=1.6, baseline=None,
                        linestyle="--" if name == "with_vibration" else "-", label=LINE_LOADS[name])
    axes.axvline(0.0, color=GREY, linewidth=0.8)
    axes.set_ylim(0.0, plan["mast"]["height_m"] if "with_vibration" in loads and plan["mast"]["height_m"] else None)
    arm = ", with those of the arm (arm_load.csv)," if "arm" in plan else ""
    return picture(axes, "Line load on the mast", "load (kN/m)", "height z (m)",
                   f"Static loads whose integral and moment about the ground{arm} are the upper values of the page (line_load.csv).", fontsize=10)


def tornado(rows):
    """What decides: bars of the effect on the design moment, greatest first."""
    if not rows:
        return None
    axes = new_axes(6.6, 0.8 + 0.42 * len(rows))
    at = np.arange(len(rows))[::-1]
    for place, (_, _, (low, high)) in zip(at, rows):
        axes.barh(place, 100.0 * high, color=COLOURS[1], height=0.6)
        axes.barh(place, 100.0 * low, color=COLOURS[0], height=0.6)
    axes.axvline(0.0, color=GREY, linewidth=1.0)
    axes.set_yticks(at, [what for what, *_ in rows], fontsize=10)
    return picture(axes, "What decides: effect on the design moment", "change of the design moment (%)", "",
                   "Each alone, from the lower to the upper end of its range; the headline is at 0.", legend=False)


def over_time(ensemble, all_loads, quantity):
    """Force or moment of all snows on the finest grid."""
    axes = new_axes(6.6, 4.2)
    middle, smooth = all_loads[ensemble.middle], [getattr(loads, f"smooth_{quantity}") for loads in all_loads]
    axes.plot(middle.time, 1e-3 * getattr(middle, quantity), color="0.78", linewidth=0.8, label=f"rows of {middle.interval:.2g} s, {ensemble.label(ensemble.middle)}")
    for (loads, values), colour, label in each_snow(ensemble, zip(all_loads, smooth)):
        axes.plot(loads.time, 1e-3 * values, color=colour, linewidth=1.5, label=f"mean over 0.1 s, {label}")
    steady = [loads.time[loads.steady][0] for loads in all_loads if loads.is_steady]
    if steady:
        axes.axvspan(max(steady), middle.time[-1], color="0.94", zorder=0)
    axes.axvline(2.0 * middle.run.velocity / middle.run.gravity, color=GREY, linestyle=":", linewidth=1.2, label="2v/g: the splash is back")
    axes.set_xlim(0.0, middle.time[-1])
    axes.set_ylim(min(0.0, 1.1e-3 * min(map(np.min, smooth))), None)
    title, label, caption = {
        "force": ("Force downstream", "force (kN)", "Finest grid. Grey area: steady interval, over which means are taken."),
        "moment": ("Overturning moment", "moment (kN m)",
                   f"About the mast's own axis (x = {middle.axis:.3g} m) at the ground, positive downstream.")}[quantity]
    return picture(axes, f"{title} over time", TIME, label, caption, fontsize=10)


def runup_over_time(ensemble, all_loads):
    axes = new_axes(6.6, 4.2)
    for loads, colour, label in each_snow(ensemble, all_loads):
        axes.plot(loads.time, loads.runup, color=colour, linewidth=1.2, label=f"run-up, {label}")
        axes.plot(loads.time, loads.highest, color=colour, linewidth=0.6, alpha=0.5)
        axes.plot(loads.time, loads.pressure_height, color=colour, linewidth=1.0, linestyle="--")
    axes.plot([], [], color=GREY, linewidth=0.6, label="highest particle")
    axes.plot([], [], color=GREY, linestyle="--", label="pressure height")
    axes.axhline(ensemble.bound, color=GREY, linestyle=":", label=f"Bernoulli's bound: {ensemble.bound:.3g} m")
    axes.set_xlim(0.0, all_loads[0].time[-1])
    axes.set_ylim(0.0, 1.5 * max(ensemble.bound, *(np.nanmax(loads.highest) for loads in all_loads)))  # room for the legend
    return picture(axes, "Run-up and pressure height over time", TIME, "height (m)",
                   "Run-up: 99 % of the mass in a strip before the mast lies below it. The first splash can pass the bound, which holds for steady flow.",
                   fontsize=10)


def damping_of_spectrum(plan):
    return plan["modes"][0]["damping_ratio"] if plan["modes"] else DEFAULT_DAMPING


def spectra(ensemble, all_loads):
    """Largest equivalent static force (N) at FREQUENCIES, a row for each snow."""
    damping = damping_of_spectrum(ensemble.plan)
    return np.array([shock_response_spectrum(loads.interval, loads.force, FREQUENCIES, damping) for loads in all_loads])


def shock_spectrum(ensemble, all_loads, spectrum):
    axes = new_axes(6.6, 4.2)
    for (loads, responses), colour, label in each_snow(ensemble, zip(all_loads, spectrum)):
        axes.plot(FREQUENCIES, 1e-3 * responses, color=colour, linewidth=1.6, label=label)
        mean = loads.values["force_mean_n"].value
        if np.isfinite(mean):
            axes.axhline(1e-3 * mean, color=colour, linewidth=0.8, linestyle=":")
    for mode in ensemble.plan["modes"]:
        axes.axvline(mode["frequency_hz"], color=GREY, linewidth=1.0, linestyle="--")
    axes.set_xscale("log")
    axes.set_xticks([0.2, 0.5, 1, 2, 5, 10, 20], ["0.2", "0.5", "1", "2", "5", "10", "20"])
    axes.minorticks_off()
    axes.set_ylim(0.0, None)
    return picture(axes, "Shock response spectrum", "eigenfrequency of the mast (Hz)", "equivalent static force (kN)",
                   "Largest response of an oscillator on which the whole force acts (not that of this mast, whose modes feel only their share), damping "
                   f"{100 * damping_of_spectrum(ensemble.plan):.3g} % of critical. Dotted: steady mean force. Dashed: the modes of the site file. The force "
                   f"is known in rows of {1e3 * all_loads[0].interval:.3g} ms: above 10 Hz the first contact is not resolved.", fontsize=10)


def grid_convergence(ensemble, table):
    """Heights and force over the cell size, relative to the finest grid, with the grid uncertainty there."""
    sizes = ensemble.sizes
    figure, panels = plt.subplots(3, 1, figsize=(6.6, 5.6), layout="constrained", sharex=True)
    figure.suptitle("Grids: value over that of the finest grid", fontsize=10.5, x=0.02, ha="left")
    for axes, (key, label) in zip(panels, (("runup_p99_mean_m", "run-up"), ("pressure_height_mean_m", "pressure height"), ("force_mean_n", "force"))):
        for snow, (row, colour, name) in enumerate(each_snow(ensemble, table)):
            entry = row[key]
            if not np.isfinite(entry.value):
                continue
            at = np.array(sizes) * (1.0 + 0.012 * (snow - 0.5 * (len(table) - 1)))  # side by side
            axes.plot(at, np.array(entry.by_grid) / entry.value, color=colour, marker=MARKERS[snow % len(MARKERS)], linewidth=1.2, label=name)
            if np.isfinite(entry.grid):
                axes.errorbar([at[-1]], [1.0], yerr=entry.grid / entry.value, color=colour, capsize=4)
        axes.set_xlim(0.0, 1.08 * sizes[0])
        axes.set_ylabel(label)
        finish_axes(axes)
    panels[-1].set_xlabel("cell size (m)")
    if panels[0].lines:  # without a steady run there are none
        panels[0].legend(fontsize=10)
    return Picture("Grids", "Mean run-up, pressure height and force. Bars: grid uncertainty of the value on the finest grid.", png_data(figure))
