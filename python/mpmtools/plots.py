"""Figures of one run on matplotlib axes: for notebooks and for figures of your own.

    from mpmtools import Run, plots
    axes = plots.runup(Run("out/fr3"))
    axes.set_title("Fr 3")

Each function draws on the axes that it is given, or on those of a new figure, and returns them. A run that lacks what a figure shows raises
InputError with the reason. What was measured is read from the run, so that a figure shows the run's own windows.
"""

import numpy as np
from matplotlib.colors import Normalize
from matplotlib.patches import Polygon, Rectangle

from mpmtools.errors import InputError
from mpmtools.figures.colours import BLUE, GREEN, GREY, ORANGE, STRESS_COLOURS
from mpmtools.inflow import measured_inflow
from mpmtools.terrain import terrain_of

STRIP = 3.0 / 7.0  # half width of the paper's measuring strip over the width of the mast (Appendix A2)


class NothingToShow(InputError):
    """The run lacks what a figure shows."""


def runup(run, axes=None):
    """Run-up over time (m, s), without and with single particles, with the steady interval, the means, Bernoulli's bound and the paper's
    equation, which is for the highest particle."""
    _series_with(run, "runup_p99_m", "the run measured no run-up")
    axes = _over_time(run, axes)
    _height_lines(axes, run, "runup_p99", "its steady mean", label="run-up (99 % of the mass is below)", color=BLUE, linewidth=1.2)
    _height_lines(axes, run, "runup", "its steady mean", label="highest particle", color=ORANGE, linewidth=0.8)
    bound = run.flow_height + run.velocity**2 / (2 * run.gravity) if run.velocity else None
    _reference_line(axes, bound, "Bernoulli, $H + v^2/2g$", color=GREY, linestyle=":")
    _reference_line(axes, run.number("predicted_runup_m"), _equation_label(run), color=GREEN, linestyle="--")
    return _height_axis(axes, run, "run-up height $h_r$ (m)")


def pressure_height(run, axes=None):
    """Pressure height over time (m, s) with the steady interval, its mean and the paper's equation."""
    _series_with(run, "pressure_height_m", "the run measured no pressure height")
    axes = _over_time(run, axes)
    _height_lines(axes, run, "pressure_height", "steady mean", label="pressure height", color=BLUE, linewidth=1.2)
    _reference_line(axes, run.number("predicted_pressure_height_m"), _equation_label(run), color=GREEN, linestyle="--")
    _reference_line(axes, run.flow_height, "flow height $H$", color=GREY, linestyle=":")
    return _height_axis(axes, run, "pressure height $h_p$ (m)")


def profile(run, axes=None):
    """Pressure over height (kPa, m), mean over the steady interval, with the threshold that defines the pressure height."""
    table = run.profile
    if table.empty:
        raise NothingToShow("the run has no steady interval, so no mean profile" if run.obstacle else "the case has no obstacle")
    axes = _axes(axes, (7.0, 6.0))
    z = table.z_m
    bin_height = z.iat[1] - z.iat[0]
    axes.step(1e-3 * table.pressure_pa, z, where="mid", color="0.65", linewidth=1.3, label=f"mean, bins of {bin_height:.3g} m")
    axes.plot(1e-3 * table.smoothed_pressure_pa, z, color=BLUE, linewidth=2, label="smoothed (Savitzky–Golay)")
    mean = run.number("impact_pressure_mean_pa")
    if mean is not None:
        axes.axvline(1e-3 * mean, color=ORANGE, linestyle="-.", label=f"impact pressure, mean below $H$: {1e-3 * mean:.3g} kPa")
        axes.axvline(0.05e-3 * mean, color=ORANGE, linestyle=":", label="threshold, 5 % of it")
    _reference_line(axes, run.number("pressure_height_of_mean_profile_m"), "pressure height of this profile", color=GREEN, linestyle="--")
    _reference_line(axes, run.flow_height, "flow height $H$", color=GREY, linestyle=":")
    axes.set_ylim(0, z.iat[-1] + 0.5 * bin_height)
    axes.set_xlim(left=min(0.0, 1.1e-3 * table.smoothed_pressure_pa.min()))
    return _finished(axes, "pressure normal to the front (kPa, Cauchy)", "height $z$ (m)")


def force(run, axes=None):
    """Force of the snow on the obstacle over time (kN, s), components x (downstream), y, z (up)."""
    return _components(run, axes, "force", "n", "F", "force (kN)")


def moment(run, axes=None):
    """Moment of the snow about the foot of the obstacle's front face over time (kN m, s)."""
    return _components(run, axes, "moment", "n_m", "M", "moment (kN m)")


class Section:
    """Particles of one frame near the axis: x, z (m), stress (stream-wise Cauchy, kPa); the heights measured at that time (m)."""

    def __init__(self, run, frame, half_width):
        position = frame["position_m"]
        order = np.argsort(-np.abs(position[:, 1]))  # nearest to the axis is drawn last, on top
        order = order[np.abs(position[order, 1]) <= half_width]
        self.time = frame.time
        self.x, self.z = position[order, 0], position[order, 2]
        self.stress = 1e-3 * (frame["kirchhoff_stress_pa"][:, 0] / frame["volume_ratio"])[order]
        self.runup, self.pressure_height = (  # NaN where the run measured none
            float(np.interp(self.time, run.series.index, run.series[column], left=np.nan, right=np.nan)) if column in run.series and len(run.series) else np.nan
            for column in ("runup_m", "pressure_height_m"))


def section_half_width(run):
    """m: the measuring strip of the paper, or three cells where there is no obstacle."""
    return STRIP * run.obstacle_width if run.obstacle else 3.0 * run.cell_size


def shown_range(run, sections):
    """(left, right), m. A published strip is hundreds of metres long: the neighbourhood of the obstacle is shown."""
    left = min(float(section.x.min()) for section in sections)
    right = max(float(section.x.max()) for section in sections)
    if run.flow_height:
        left, right = max(left, -5.0 * run.flow_height), min(right, 3.0 * run.flow_height)
    return left, max(right, 1.2 * run.obstacle_depth) if run.obstacle else right


def shown_top(sections, left, right):
    """m: a little above the highest particle that is shown."""
    shown = [section.z[(section.x >= left) & (section.x <= right)] for section in sections]
    return 1.06 * max(float(z.max()) for z in shown if z.size) + 0.2


def stress_norm(sections):
    """Colours from the strongest compression (a few particles left out) to none."""
    low = float(np.percentile(np.concatenate([section.stress for section in sections]), 0.5))
    return Normalize(low if low < 0.0 else -1.0, 0.0)


def draw_section(axes, run, section, norm, points_per_m, top):
    """The particles of a Section, the ground and the obstacle. @return the scatter, for a colour bar"""
    dot = max(1.0, (0.9 * run.particle_spacing * points_per_m) ** 2)
    points = axes.scatter(section.x, section.z, c=section.stress, s=dot, cmap=STRESS_COLOURS, norm=norm, linewidths=0, rasterized=True)
    terrain = terrain_of(run)
    if terrain:
        axes.fill_between(terrain.x, terrain.section(), terrain.height.min() - 1.0, facecolor="0.9", edgecolor="0.2", linewidth=1.5, zorder=0.5)
    else:
        axes.axhline(0.0, color="0.2", linewidth=1.5)
    for corners, foot, head in run.solids(terrain.height.min() if terrain else 0.0, 2.0 * top):
        front, back = min(x for x, _ in corners), max(x for x, _ in corners)
        axes.add_patch(Rectangle((front, foot), back - front, head - foot, facecolor="0.8",
                                 edgecolor="0.2", hatch="///", linewidth=1.2, zorder=2))  # above the dots, which are wider than particles
    axes.set(title=f"t = {section.time:.2f} s", ylabel="height $z$ (m)",
             xlabel="$x$ (m), 0 at the front of the obstacle" if run.obstacle else "$x$ (m)")
    return points


def side_view(run, frame=None, axes=None):
    """Particles of a frame (default: the last) near the axis, coloured by stream-wise Cauchy stress, with a colour bar."""
    section = Section(run, frame or run.require_frames()[-1], section_half_width(run))
    if not section.x.size:
        raise NothingToShow("no particles are near the axis in this frame")
    left, right = shown_range(run, [section])
    top = shown_top([section], left, right)
    axes = _axes(axes, (9.0, 1.5 + 7.0 * min(1.2, top / (right - left))))
    terrain = terrain_of(run)
    axes.set(xlim=(left, right), ylim=(min(-0.02 * top, terrain.section().min() if terrain else 0.0), top))
    axes.set_aspect("equal")
    width = axes.get_window_extent().width / axes.figure.dpi
    points = draw_section(axes, run, section, stress_norm([section]), 72.0 * width / (right - left), top)
    axes.figure.colorbar(points, ax=axes, extend="both", shrink=0.8, label=r"stream-wise Cauchy stress $\sigma_{xx}$ (kPa)")
    return axes


def plan_view(run, frame=None, axes=None):
    """Particles of a frame (default: the last) from above, coloured by height (m), with the outline of the obstacle. The whole flow."""
    frame = frame or run.require_frames()[-1]
    position = frame.whole("position_m")
    position = position[np.argsort(position[:, 2])]
    axes = _axes(axes, (8.0, 7.0))
    points = axes.scatter(position[:, 0], position[:, 1], c=position[:, 2], s=4.0, cmap="viridis", linewidths=0, rasterized=True)
    for corners, *_ in run.solids(0.0, np.inf):
        axes.add_patch(Polygon(corners, facecolor="0.8", edgecolor="0.2", hatch="///"))
    axes.set_aspect("equal")
    axes.set(title=f"t = {frame.time:.2f} s", xlabel="$x$ (m)", ylabel="$y$ (m)")
    axes.figure.colorbar(points, ax=axes, label="height $z$ (m)", shrink=0.8)
    return axes


def grid_study(study, metric, axes=None):
    """A metric of a GridStudy over the cell size, with its statistical errors, the limit and the band of its numerical uncertainty."""
    found = study.metric(metric)
    axes = _axes(axes, (7.0, 5.0))
    sizes, values = np.array(found["parameter"], float), np.array(found["value"], float)
    errors = np.array([np.nan if e is None else e for e in found["standard_error"]], float)
    axes.errorbar(sizes, values, yerr=np.where(np.isnan(errors), 0.0, errors), fmt="o-", color=BLUE, capsize=3,
                  label="computed, ± standard error in time")
    finest, uncertainty = values[np.argmin(sizes)], found.get("uncertainty")
    if uncertainty is not None:
        axes.axhspan(finest - uncertainty, finest + uncertainty, color=ORANGE, alpha=0.15, zorder=0,
                     label=f"numerical uncertainty of the finest grid: ± {uncertainty:.2g}")
    axes.set_xlim(left=0.0)
    return _finished(axes, "cell size (m)", metric)


def inflow(run, axes=None):
    """Depth (m) and speed (m/s) of the snow just behind the inlet, from the frames, over the rows of [[conveyor.inflow]] that should enter.
    Returns the two axes, depth first."""
    rows = run.case.get("conveyor.inflow")
    if not rows:
        raise NothingToShow("the inflow of this run does not vary in time; there is nothing to compare it with")
    measured, axes = measured_inflow(run), _axes(axes, (7.5, 5.6), 2)
    times = [row["time_s"] for row in rows]
    for panel, key, column, label in zip(axes, ("flow_height_m", "velocity_m_s"), ("depth_m", "velocity_m_s"), ("flow depth (m)", "speed (m/s)")):
        panel.plot(times, [row[key] for row in rows], color=ORANGE, linewidth=2.2, label="path model")
        panel.plot(measured.entered_s, measured[column], "o", color=BLUE, markersize=4, label="run, at the inlet")
        panel.set_ylim(0.0, 1.15 * panel.dataLim.ymax)
        panel.set_ylabel(label)
        panel.grid(alpha=0.3)
    axes[0].legend(fontsize="small")
    axes[1].set_xlabel("time at which the snow entered (s)")
    axes[1].set_xlim(0.0, max(measured.time_s))
    return axes


# ---- Parts ----------------------------------------------------------------------------------------------------------------------------


def _axes(axes, size, rows=1):
    if axes is not None:
        return axes
    from matplotlib import pyplot

    return pyplot.subplots(rows, figsize=size, sharex=True, layout="constrained")[1]


def _finished(axes, x, y, **legend):
    axes.set(xlabel=x, ylabel=y)
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small", **legend)
    return axes


def _series_with(run, column, otherwise):
    if column not in run.series:
        raise NothingToShow(otherwise)
    if run.series.empty:
        raise NothingToShow("series.csv has no row yet")
    return run.series


def _over_time(run, axes):
    axes = _axes(axes, (8.5, 4.0))
    begin, end = run.number("steady_from_s"), run.number("steady_to_s")
    if begin is not None and end is not None:
        axes.axvspan(begin, end, color="0.92", zorder=0, label="steady interval")
    axes.set_xlim(run.series.index[0], run.series.index[-1])
    axes.set_xlabel("time since the front reached the obstacle (s)" if run.flow_height else "time (s)")
    return axes


def _components(run, axes, name, unit, symbol, label):
    series = _series_with(run, f"{name}_x_{unit}", "the case has no obstacle")
    axes = _over_time(run, axes)
    means = run.results.get(f"{name}_mean_{unit}") or [None] * 3
    for component, colour, mean in zip("xyz", (BLUE, ORANGE, GREEN), means):
        text = f"${symbol}_{component}$" + (f", steady mean {1e-3 * mean:.3g}" if mean is not None else "")
        axes.plot(series.index, 1e-3 * series[f"{name}_{component}_{unit}"], color=colour, linewidth=1.1, label=text)
    _limit_to_the_flow(axes, 1e-3 * series[[f"{name}_{component}_{unit}" for component in "xyz"]].to_numpy(), label)
    return _finished(axes, axes.get_xlabel(), label, loc="upper right")


def _limit_to_the_flow(axes, values, label):
    """The spike of the first contact, a few rows, does not set the scale: it is cut, and its height written beside it."""
    values = values[np.isfinite(values).all(axis=1)]
    if not len(values):
        return
    high, peak = 1.6 * np.percentile(values.max(axis=1), 97.0), values.max()
    if peak > high > 0.0:
        axes.set_ylim(axes.get_ylim()[0] * high / peak, high)
        axes.annotate(f"up to {peak:.3g} at first contact: {label}", (0.01, 0.98), xycoords="axes fraction", va="top", fontsize="small")


def _reference_line(axes, value, label, **style):
    if value is not None:
        axes.axhline(value, label=f"{label}: {value:.3g} m", linewidth=1.3, **style)


def _equation_label(run):
    """Says so where the equation was not fitted to the case."""
    return "paper's equation, extrapolated" if run.outside_of_equations else "paper's equation"


def _height_lines(axes, run, key, of_mean, color, **style):
    """A height over time, and its steady mean where it has one."""
    axes.plot(run.series.index, run.series[f"{key}_m"], color=color, **style)
    mean, error = run.number(f"{key}_mean_m"), run.number(f"{key}_standard_error_m")
    if mean is not None:
        text = f"{of_mean}: {mean:.3g} m" + (f" ± {error:.1g} m in time" if error is not None else "")
        axes.plot([run.number("steady_from_s"), run.number("steady_to_s")], [mean, mean], color=color, linewidth=2.6, label=text)


def _height_axis(axes, run, label):
    """The height in m on the left, in flow heights on the right."""
    axes.set_ylim(0, 1.05 * axes.get_ylim()[1])
    if height := run.flow_height:
        right = axes.secondary_yaxis("right", functions=(lambda z: z / height, lambda z: z * height))
        right.set_ylabel("in flow heights H")
    return _finished(axes, axes.get_xlabel(), label, framealpha=0.9, loc="best")
