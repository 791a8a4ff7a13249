"""Pictures of one run, as the paper's Figs. 3 and 5.

  heights    run-up and pressure height over time, with the steady interval, means, Bernoulli's bound and the paper's equations
  profile    time-mean pressure profile on the obstacle, with the threshold that defines the pressure height
  forces     force and overturning moment on the obstacle over time
  side_view  particles near the axis coloured by stream-wise stress, with the mean pressure profile beside them

What was measured is read from the run (series.csv, profile.csv, results.json), so that the pictures show its own windows.
Pictures for which a run has no data (no obstacle, no frames, no steady interval) are omitted, and a message reports that.
"""

import os
import sys
from pathlib import Path

import numpy as np

from mpmtools import plots
from mpmtools.errors import ConfigError, InputError
from mpmtools.files import save_figure
from mpmtools.figures.colours import BLUE, GREEN, GREY, ORANGE
from mpmtools.figures.style import plt
from mpmtools.plots import Section
from mpmtools.run import Run


PANELS = {  # picture: functions of plots, one below the other; inches; what they show; place of their legends
    "heights": ((plots.runup, plots.pressure_height), (9.0, 8.5), "run-up and pressure height on the obstacle over time",
                {"frameon": False, "loc": "lower center", "bbox_to_anchor": (0.5, 1.0), "ncols": 2}),
    "profile": ((plots.profile,), (7.0, 6.5), "mean pressure on the obstacle over the steady interval", None),
    "forces": ((plots.force, plots.moment), (8.5, 7.0), "force of the snow on the obstacle, and moment about the foot of its front face", None),
}


def draw_run(folder, out=None, times=(), kind="png"):
    """Draws all pictures of a run into `out` (default FOLDER/post). @return {name: path, or the reason why there is none}"""
    out = out or os.path.join(folder, "post")
    run, written = Run(folder, fallback=out), {}
    for name in (*PANELS, "side_view"):
        try:
            figure = draw_panels(run, name) if name in PANELS else draw_side_view(run, times)
        except plots.NothingToShow as reason:
            written[name] = (None, str(reason))
            continue
        path = os.path.join(out, f"{name}.{kind}")
        save_figure(figure, path, dpi=150)
        written[name] = (path, "")
    return written


def draw_panels(run, name):
    """A picture of PANELS."""
    functions, size, title, legend = PANELS[name]
    figure, panels = plt.subplots(len(functions), figsize=size, sharex=True, squeeze=False, layout="constrained")
    figure.suptitle(f"{run.title}\n{title}")
    try:
        for draw, axes in zip(functions, panels[:, 0]):
            draw(run, axes).label_outer()
            if legend:
                axes.legend(fontsize="small", **legend)
    except plots.NothingToShow:
        plt.close(figure)
        raise
    return figure


# ---- Side view ----------------------------------------------------------------------------------------------------------------------


def chosen_frames(frames, times):
    """First contact, middle and end, or the frames nearest to the times that were asked for."""
    if times:
        picked = [min(frames, key=lambda frame: abs(frame.time - t)) for t in times]
    else:
        picked = [next((frame for frame in frames if frame.time > 0.0), frames[0]), frames[len(frames) // 2], frames[-1]]
    return list({frame.time: frame for frame in sorted(picked, key=lambda frame: frame.time)}.values())


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
        raise plots.NothingToShow("the run stored no frames")
    half_width = plots.section_half_width(run)
    sections = [Section(run, frame, half_width) for frame in chosen_frames(run.frames, times)]
    sections = [section for section in sections if section.x.size > 0]
    if not sections:
        raise plots.NothingToShow("no particles are near the axis in the chosen frames")
    left, right = plots.shown_range(run, sections)
    top = plots.shown_top(sections, left, right)
    bottom = -0.02 * top
    with_profile = not run.profile.empty
    page = Page(len(sections), right - left, bottom, top, with_profile)
    page.figure.suptitle(f"{run.title}\nparticles with |y| < {half_width:.2g} m, coloured by stream-wise Cauchy stress" +
                         (";\nbeside them the mean pressure on the obstacle over the steady interval" if with_profile else ""),
                         y=1.0 - 0.1 / page.size[1], va="top", fontsize="large" if not with_profile else "medium")
    norm = plots.stress_norm(sections)
    for number, section in enumerate(sections):
        axes, beside = page.add_section(number)
        points = plots.draw_section(axes, run, section, norm, 72.0 * page.scale, top)
        axes.set(xlim=(left, right), ylim=(bottom, top))
        if beside is not None:
            _draw_profile_beside(beside, run, section, with_legend=number == 0)
    page.add_colour_bar(points, r"stream-wise Cauchy stress $\sigma_{xx}$ (kPa, compression negative)")
    return page.figure


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
        if not np.isfinite(times).all():
            raise ValueError
    except ValueError:
        raise ConfigError(f"--times {options.times}: numbers separated by commas are needed, such as 0.2,3,6") from None
    if not (Path(options.directory) / "series.csv").exists():
        raise InputError(f"{options.directory}: no series.csv; give the result folder of a run")
    for name, (path, reason) in draw_run(options.directory, options.out, times, options.format).items():
        print(f"wrote {path}" if path else f"no picture {name}: {reason}", file=sys.stderr)
