"""Pictures of one run, as the paper's Figs. 3 and 5.

  heights    run-up and pressure height over time, with the steady interval, means, Bernoulli's bound and the paper's equations
  profile    time-mean pressure profile on the obstacle, with the threshold that defines the pressure height
  forces     force and overturning moment on the obstacle over time
  side_view  particles near the axis coloured by stream-wise stress, with the mean pressure profile beside them

What was measured is read from the run (series.csv, profile.csv, results.json), so that the pictures show its own windows.
Pictures for which a run holds nothing (no obstacle, no frames, no steady interval) are left out, and a message says so.
"""

import os
import sys

import numpy as np
from matplotlib.colors import Normalize
from matplotlib.patches import Rectangle

from mpmtools.errors import ConfigError, InputError
from mpmtools.figures.style import STRESS_COLOURS, plt
from mpmtools.run import Run

BLUE, ORANGE, GREEN, GREY = "#1f5fa8", "#d9641e", "#2f8f4e", "0.45"
STRIP = 3.0 / 7.0  # half width of the paper's measuring strip over the width of the mast (Appendix A2)


def draw_run(folder, out=None, times=(), kind="png"):
    """Draws all pictures of a run into `out` (default FOLDER/post). @return {name: path, or the reason why there is none}"""
    out = out or os.path.join(folder, "post")
    run = Run(folder, fallback=out)
    try:
        os.makedirs(out, exist_ok=True)
    except OSError as error:
        raise InputError(f"cannot write to '{out}': {error.strerror}") from None
    pictures = {"heights": draw_heights(run), "profile": draw_profile(run), "forces": draw_forces(run),
                "side_view": draw_side_view(run, times)}
    written = {}
    for name, picture in pictures.items():
        if isinstance(picture, str):
            written[name] = (None, picture)
            continue
        path = os.path.join(out, f"{name}.{kind}")
        picture.savefig(path, dpi=150)
        plt.close(picture)
        written[name] = (path, "")
    return written


def new_figure(width, height, **arguments):
    return plt.subplots(figsize=(width, height), layout="constrained", **arguments)


def shade_steady_interval(axes, run):
    begin, end = run.number("steady_from_s"), run.number("steady_to_s")
    if begin is not None and end is not None:
        axes.axvspan(begin, end, color="0.92", zorder=0, label="steady interval")


def reference_line(axes, value, label, **style):
    if value is not None:
        axes.axhline(value, label=f"{label}: {value:.3g} m", linewidth=1.3, **style)


def mean_line(axes, run, key, label, colour):
    mean, error = run.number(f"{key}_mean_m"), run.number(f"{key}_standard_error_m")
    if mean is None:
        return
    interval = [run.number("steady_from_s"), run.number("steady_to_s")]
    text = f"{label}: {mean:.3g} m" + (f" ± {error:.1g} m (standard error in time, not of the grid)" if error is not None else "")
    axes.plot(interval, [mean, mean], color=colour, linewidth=2.6, label=text)


def add_relative_axis(axes, height):
    """The same heights in flow heights, on the right."""
    if height:
        right = axes.secondary_yaxis("right", functions=(lambda z: z / height, lambda z: z * height))
        right.set_ylabel("in flow heights H")


def draw_heights(run):
    series = run.series
    if "runup_m" not in series:
        return "the run measured no run-up"
    figure, (top, bottom) = new_figure(11.5, 7.5, nrows=2, sharex=True)
    figure.suptitle(f"{run.title}\nrun-up and pressure height on the obstacle over time")
    bound = run.flow_height + run.velocity**2 / (2 * run.gravity) if run.velocity else None
    for axes in (top, bottom):
        shade_steady_interval(axes, run)
        axes.set_xlim(series.time_s.iat[0], series.time_s.iat[-1])
    top.plot(series.time_s, series.runup_m, color=BLUE, linewidth=1.2, label="run-up (highest particle)")
    top.plot(series.time_s, series.runup_p99_m, color=ORANGE, linewidth=1.0, label="99th percentile of heights at the obstacle")
    mean_line(top, run, "runup", "steady mean of the run-up", BLUE)
    reference_line(top, bound, "Bernoulli, $H + v^2/2g$", color=GREY, linestyle=":")
    reference_line(top, run.number("predicted_runup_m"), "paper's equation", color=GREEN, linestyle="--")
    top.set_ylabel("run-up height $h_r$ (m)")
    bottom.plot(series.time_s, series.pressure_height_m, color=BLUE, linewidth=1.2, label="pressure height")
    mean_line(bottom, run, "pressure_height", "steady mean", BLUE)
    reference_line(bottom, run.number("predicted_pressure_height_m"), "paper's equation", color=GREEN, linestyle="--")
    reference_line(bottom, run.flow_height, "flow height $H$", color=GREY, linestyle=":")
    bottom.set_ylabel("pressure height $h_p$ (m)")
    bottom.set_xlabel("time since the front reached the obstacle (s)")
    for axes in (top, bottom):
        axes.set_ylim(0, 1.05 * axes.get_ylim()[1])
        axes.grid(alpha=0.3)
        add_relative_axis(axes, run.flow_height)
        axes.legend(fontsize="small", framealpha=0.9, loc="upper left", bbox_to_anchor=(1.10, 1.0))
    return figure


def draw_profile(run):
    profile = run.profile
    if profile.empty:
        return "the run has no steady interval, so no mean profile" if run.obstacle else "the case has no obstacle"
    figure, axes = new_figure(7.0, 6.5)
    figure.suptitle(f"{run.title}\nmean pressure on the obstacle over the steady interval")
    z = profile.z_m
    bin_height = z.iat[1] - z.iat[0]
    axes.step(1e-3 * profile.pressure_pa, z, where="mid", color="0.65", linewidth=1.3, label=f"mean, bins of {bin_height:.3g} m")
    axes.plot(1e-3 * profile.smoothed_pressure_pa, z, color=BLUE, linewidth=2, label="smoothed (Savitzky–Golay)")
    mean = run.number("impact_pressure_mean_pa")
    if mean is not None:
        axes.axvline(1e-3 * mean, color=ORANGE, linestyle="-.", label=f"impact pressure, mean below $H$: {1e-3 * mean:.3g} kPa")
        axes.axvline(0.05e-3 * mean, color=ORANGE, linestyle=":", label="threshold, 5 % of it")
    reference_line(axes, run.number("pressure_height_of_mean_profile_m"), "pressure height of this profile", color=GREEN, linestyle="--")
    reference_line(axes, run.flow_height, "flow height $H$", color=GREY, linestyle=":")
    axes.set_xlabel("pressure normal to the front (kPa, Cauchy)")
    axes.set_ylabel("height $z$ (m)")
    axes.set_ylim(0, z.iat[-1] + 0.5 * bin_height)
    axes.set_xlim(left=min(0.0, 1.1e-3 * profile.smoothed_pressure_pa.min()))
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small")
    return figure


def draw_forces(run):
    series = run.series
    if "force_x_n" not in series:
        return "the case has no obstacle"
    figure, (top, bottom) = new_figure(8.5, 7.0, nrows=2, sharex=True)
    figure.suptitle(f"{run.title}\nforce of the snow on the obstacle, and moment about the foot of its front face")
    for axes, name, unit, symbol, label in ((top, "force", "n", "F", "force (kN)"), (bottom, "moment", "n_m", "M", "moment (kN m)")):
        shade_steady_interval(axes, run)
        means = run.results.get(f"{name}_mean_{unit}") or [None] * 3
        for component, colour, mean in zip("xyz", (BLUE, ORANGE, GREEN), means):
            text = f"${symbol}_{component}$" + (f", steady mean {1e-3 * mean:.3g}" if mean is not None else "")
            axes.plot(series.time_s, 1e-3 * series[f"{name}_{component}_{unit}"], color=colour, linewidth=1.1, label=text)
        axes.set_ylabel(label)
        axes.set_xlim(series.time_s.iat[0], series.time_s.iat[-1])
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small", loc="upper right")
    bottom.set_xlabel("time since the front reached the obstacle (s)" if run.flow_height else "time (s)")
    return figure


# ---- Side view ----------------------------------------------------------------------------------------------------------------------


def chosen_frames(frames, times):
    """First contact, middle and end, or the frames nearest to the times that were asked for."""
    if times:
        picked = [min(frames, key=lambda frame: abs(frame.time - t)) for t in times]
    else:
        picked = [next((frame for frame in frames if frame.time > 0.0), frames[0]), frames[len(frames) // 2], frames[-1]]
    return list({frame.time: frame for frame in sorted(picked, key=lambda frame: frame.time)}.values())


class Section:
    """Particles of one frame near the axis: x, z (m), stress (stream-wise Cauchy, kPa); the heights measured at that time (m)."""

    def __init__(self, run, frame, half_width):
        position = frame["position_m"]
        order = np.argsort(-np.abs(position[:, 1]))  # nearest to the axis is drawn last, on top
        order = order[np.abs(position[order, 1]) <= half_width]
        self.time = frame.time
        self.x, self.z = position[order, 0], position[order, 2]
        self.stress = 1e-3 * (frame["kirchhoff_stress_pa"][:, 0] / frame["volume_ratio"])[order]
        self.runup, self.pressure_height = (self._height_of(run, column) for column in ("runup_m", "pressure_height_m"))

    def _height_of(self, run, column):
        """NaN where the run measured none."""
        if column not in run.series:
            return np.nan
        return float(np.interp(self.time, run.series.time_s, run.series[column], left=np.nan, right=np.nan))


class Page:
    """Places sections in inches, so that a metre is a metre in both directions and the profiles share their axes of height.

    Sections are stacked where they are flat, side by side where jets are tall.
    """

    BEFORE, GAP, AFTER, BELOW, ABOVE, HEADING = 0.75, 0.12, 0.25, 0.6, 0.4, 0.65

    def __init__(self, count, width, bottom, top, with_profile):
        self.side_by_side = top > 0.6 * width
        self.rows, columns = (1, count) if self.side_by_side else (count, 1)
        self.profile_width = 1.4 if with_profile else 0.0
        around = self.BEFORE + self.GAP + self.profile_width + self.AFTER
        self.scale = min(((15.0 if self.side_by_side else 10.5) / columns - around) / width, 8.0 / (top - bottom))  # inches a metre
        self.section = (width * self.scale, (top - bottom) * self.scale)
        self.cell = (around + self.section[0], self.BELOW + self.section[1] + self.ABOVE)
        self.bar_width, self.bar_height = (0.0, 0.85) if self.side_by_side else (1.1, 0.0)  # room of the colour bar
        self.size = (columns * self.cell[0] + self.bar_width, self.rows * self.cell[1] + self.HEADING + self.bar_height)
        self.figure = plt.figure(figsize=self.size)

    def place(self, x, y, width, height, **arguments):
        """Axes whose lower left corner is x, y inches from the page's."""
        return self.figure.add_axes((x / self.size[0], y / self.size[1], width / self.size[0], height / self.size[1]), **arguments)

    def add_section(self, number):
        """(axes of the section, axes of its profile or None)"""
        row, column = (0, number) if self.side_by_side else (number, 0)
        x, y = column * self.cell[0] + self.BEFORE, self.bar_height + (self.rows - 1 - row) * self.cell[1] + self.BELOW
        axes = self.place(x, y, *self.section)
        if not self.profile_width:
            return axes, None
        return axes, self.place(x + self.section[0] + self.GAP, y, self.profile_width, self.section[1], sharey=axes)

    def add_colour_bar(self, points, label):
        if self.side_by_side:
            strip = self.place(0.25 * self.size[0], 0.55, 0.5 * self.size[0], 0.18)
        else:
            strip = self.place(self.size[0] - self.bar_width + 0.1, 0.2 * self.size[1], 0.2, 0.6 * self.size[1])
        bar = self.figure.colorbar(points, cax=strip, orientation="horizontal" if self.side_by_side else "vertical", extend="both")
        bar.set_label(label)


def draw_side_view(run, times):
    if not run.frames:
        return "the run stored no frames"
    half_width = STRIP * run.obstacle_width if run.obstacle else 3.0 * run.cell_size
    sections = [Section(run, frame, half_width) for frame in chosen_frames(run.frames, times)]
    sections = [section for section in sections if section.x.size > 0]
    if not sections:
        return "no particles are near the axis in the chosen frames"
    left, right = _shown_range(run, sections)
    shown = [section.z[(section.x >= left) & (section.x <= right)] for section in sections]
    top = 1.06 * max(float(z.max()) for z in shown if z.size) + 0.2
    bottom = -0.02 * top
    with_profile = not run.profile.empty
    page = Page(len(sections), right - left, bottom, top, with_profile)
    page.figure.suptitle(f"{run.title}\nparticles with |y| < {half_width:.2g} m, coloured by stream-wise Cauchy stress" +
                         (";\nbeside them the mean pressure on the obstacle over the steady interval" if with_profile else ""),
                         y=1.0 - 0.1 / page.size[1], va="top", fontsize="large" if not with_profile else "medium")
    low = float(np.percentile(np.concatenate([section.stress for section in sections]), 0.5))
    norm = Normalize(low if low < 0.0 else -1.0, 0.0)
    dot = max(1.0, (0.9 * run.particle_spacing * page.scale * 72.0) ** 2)
    for number, section in enumerate(sections):
        axes, beside = page.add_section(number)
        points = axes.scatter(section.x, section.z, c=section.stress, s=dot, cmap=STRESS_COLOURS, norm=norm, linewidths=0, rasterized=True)
        axes.axhline(0.0, color="0.2", linewidth=1.5)
        if run.obstacle:
            axes.add_patch(Rectangle((0.0, 0.0), run.obstacle_depth, run.obstacle.get("height_m", 2.0 * top), facecolor="0.8",
                                     edgecolor="0.2", hatch="///", linewidth=1.2, zorder=0))
        axes.set(xlim=(left, right), ylim=(bottom, top), title=f"t = {section.time:.2f} s", ylabel="height $z$ (m)",
                 xlabel="$x$ (m), 0 at the front of the obstacle" if run.obstacle else "$x$ (m)")
        if beside is not None:
            _draw_profile_beside(beside, run, section, with_legend=number == 0)
    page.add_colour_bar(points, r"stream-wise Cauchy stress $\sigma_{xx}$ (kPa, compression negative)")
    return page.figure


def _shown_range(run, sections):
    """A published strip is hundreds of metres long: the neighbourhood of the obstacle is shown."""
    left = min(float(section.x.min()) for section in sections)
    right = max(float(section.x.max()) for section in sections)
    if run.flow_height:
        left, right = max(left, -5.0 * run.flow_height), min(right, 3.0 * run.flow_height)
    return left, max(right, 1.2 * run.obstacle_depth) if run.obstacle else right


def _draw_profile_beside(axes, run, section, with_legend):
    axes.plot(1e-3 * run.profile.pressure_pa, run.profile.z_m, color=ORANGE, linewidth=1.6, label="mean pressure")
    for value, colour, label in ((section.runup, BLUE, "run-up now"), (section.pressure_height, GREEN, "pressure height now")):
        if np.isfinite(value):
            axes.axhline(value, color=colour, linestyle="--", linewidth=1.2, label=label)
    axes.axhline(run.flow_height, color=GREY, linestyle=":", label="flow height $H$")
    axes.set_xlim(0.0, 1.15 * max(1e-3 * run.profile.pressure_pa.max(), 1e-3))
    axes.set_xlabel("pressure (kPa)")
    axes.tick_params(labelleft=False)
    axes.grid(alpha=0.3)
    if with_legend:
        axes.legend(fontsize="x-small", loc="upper right")


# ---- Command ------------------------------------------------------------------------------------------------------------------------


def run_command(options):
    try:
        times = [float(t) for t in options.times.split(",")] if options.times else []
    except ValueError:
        raise ConfigError(f"--times {options.times}: numbers separated by commas are needed, such as 0.2,3,6") from None
    for name, (path, reason) in draw_run(options.directory, options.out, times, options.format).items():
        print(f"wrote {path}" if path else f"no picture {name}: {reason}", file=sys.stderr)
