#!/usr/bin/python3
"""Pictures of one run, as the paper's Figs. 3 and 5.

    plot_run.py DIR [--out FOLDER] [--times T,T,...] [--format png|pdf|svg]

DIR is a result folder of `mpm run`; the pictures go to FOLDER (default DIR/post):
  heights    run-up and pressure height over time, with the steady span, means, Bernoulli's bound and the paper's equations
  profile    time-mean pressure profile on the obstacle, with the threshold that defines the pressure height
  forces     force and overturning moment on the obstacle over time
  side_view  particles near the axis coloured by stream-wise stress, with the pressure profile beside them
Pictures for which a run holds nothing (no obstacle, no frames, no steady span) are left out, and a message says so.
Needs Debian's python3-matplotlib, python3-h5py and python3-numpy. Ends with 4 if the folder cannot be read.
"""
import argparse
import csv
import json
import os
import sys
import tomllib

try:
    import h5py
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt
    import numpy as np
    from matplotlib.colors import LinearSegmentedColormap, Normalize
    from matplotlib.patches import Rectangle
except ImportError as error:
    sys.exit(f"no pictures: {error}; install Debian's python3-matplotlib, python3-h5py and python3-numpy")

from obstacle_plan import obstacle_plan

BLUE, ORANGE, GREEN, GREY = "#1f5fa8", "#d9641e", "#2f8f4e", "0.45"
# Almost white for nothing, over blue and yellow to dark red for strong compression: as in render_paraview.py, a little darker at its light end.
STRESS_COLOURS = LinearSegmentedColormap.from_list(
    "stress", [(0.45, 0.04, 0.14), (0.89, 0.36, 0.20), (0.98, 0.82, 0.40), (0.42, 0.66, 0.88), (0.78, 0.86, 0.93)])


def say(text):
    print(text, file=sys.stderr)


class Run:
    """What a result folder holds. Missing files are empty; `fallback` is looked at for what DIR itself lacks."""

    def __init__(self, directory, fallback):
        self.directory = directory
        with open(os.path.join(directory, "case.toml"), "rb") as file:
            self.case = tomllib.load(file)
        self.series = self._table("series.csv", fallback)
        self.profile = self._table("profile.csv", fallback)
        self.results = {}
        path = self._find("results.json", fallback)
        if path:
            with open(path) as file:
                self.results = json.load(file)
        self.title = self.case.get("title", "")
        self.obstacle = self.case.get("obstacle")
        self.conveyor = self.case.get("conveyor")
        self.gravity = self.case.get("numerics", {}).get("gravity_m_s2", 9.81)
        self.flow_height = self.conveyor["flow_height_m"] if self.conveyor else None
        self.velocity = self._velocity()

    def _velocity(self):
        if not self.conveyor:
            return None
        if "velocity_m_s" in self.conveyor:
            return self.conveyor["velocity_m_s"]
        return self.conveyor["froude_number"] * (self.gravity * self.flow_height) ** 0.5

    def _find(self, name, fallback):
        for folder in (self.directory, fallback):
            path = os.path.join(folder, name)
            if os.path.exists(path):
                return path
        return None

    def _table(self, name, fallback):
        """Columns of a CSV file as arrays; a last line that was cut off by a kill is left out."""
        path = self._find(name, fallback)
        if not path:
            return {}
        with open(path, newline="") as file:
            rows = [row for row in csv.reader(line for line in file if line.endswith("\n") and not line.startswith("#")) if row]
        if len(rows) < 2:
            return {}
        return {name: np.array([float(row[i]) for row in rows[1:]]) for i, name in enumerate(rows[0])}

    def figure(self, key):
        """A number of results.json, None where there is none."""
        value = self.results.get(key)
        return value if isinstance(value, (int, float)) and not isinstance(value, bool) else None

    def frames(self):
        """Paths and times (s) of the frames, in order."""
        folder = os.path.join(self.directory, "frames")
        found = []
        for name in sorted(os.listdir(folder)) if os.path.isdir(folder) else []:
            if name.endswith(".h5") and name[:-3].isdigit():
                with h5py.File(os.path.join(folder, name), "r") as file:
                    found.append((os.path.join(folder, name), float(file.attrs["time_s"])))
        return found


def new_figure(width, height, **arguments):
    return plt.subplots(figsize=(width, height), layout="constrained", **arguments)


def shade_steady_span(axes, run, label=True):
    begin, end = run.figure("steady_from_s"), run.figure("steady_to_s")
    if begin is not None and end is not None:
        axes.axvspan(begin, end, color="0.92", zorder=0, label="steady span" if label else None)


def reference_line(axes, value, label, **style):
    if value is not None:
        axes.axhline(value, label=f"{label}: {value:.3g} m", linewidth=1.3, **style)


def mean_line(axes, run, key, label, colour):
    mean, error = run.figure(f"{key}_mean_m"), run.figure(f"{key}_standard_error_m")
    if mean is None:
        return
    span = [run.figure("steady_from_s"), run.figure("steady_to_s")]
    text = f"{label}: {mean:.3g} m" + (f" ± {error:.1g} m" if error is not None else "")
    axes.plot(span, [mean, mean], color=colour, linewidth=2.6, label=text)


def add_relative_axis(axes, height):
    """The same heights in flow heights, on the right."""
    if height:
        right = axes.secondary_yaxis("right", functions=(lambda z: z / height, lambda z: z * height))
        right.set_ylabel("in flow heights H")


def plot_heights(run, path):
    series = run.series
    if "runup_m" not in series:
        return "the run measured no run-up"
    figure, (top, bottom) = new_figure(8.5, 7.5, nrows=2, sharex=True)
    figure.suptitle(f"{run.title}\nrun-up and pressure height on the obstacle over time")
    bound = run.flow_height + run.velocity**2 / (2 * run.gravity) if run.velocity else None
    for axes in (top, bottom):
        shade_steady_span(axes, run)
        axes.set_xlim(series["time_s"][0], series["time_s"][-1])
    top.plot(series["time_s"], series["runup_m"], color=BLUE, linewidth=1.2, label="run-up (highest particle)")
    top.plot(series["time_s"], series["runup_p99_m"], color=ORANGE, linewidth=1.0, label="99th percentile of heights at the obstacle")
    mean_line(top, run, "runup", "steady mean of the run-up", BLUE)
    reference_line(top, bound, "Bernoulli, $H + v^2/2g$", color=GREY, linestyle=":")
    reference_line(top, run.figure("predicted_runup_m"), "paper's equation", color=GREEN, linestyle="--")
    top.set_ylabel("run-up height $h_r$ (m)")
    bottom.plot(series["time_s"], series["pressure_height_m"], color=BLUE, linewidth=1.2, label="pressure height")
    mean_line(bottom, run, "pressure_height", "steady mean", BLUE)
    reference_line(bottom, run.figure("predicted_pressure_height_m"), "paper's equation", color=GREEN, linestyle="--")
    reference_line(bottom, run.flow_height, "flow height $H$", color=GREY, linestyle=":")
    bottom.set_ylabel("pressure height $h_p$ (m)")
    bottom.set_xlabel("time since the front reached the obstacle (s)")
    for axes in (top, bottom):
        axes.set_ylim(0, 1.05 * axes.get_ylim()[1])
        axes.grid(alpha=0.3)
        add_relative_axis(axes, run.flow_height)
        axes.legend(fontsize="small", framealpha=0.9, loc="upper left", bbox_to_anchor=(1.10, 1.0))
    figure.set_size_inches(11.5, 7.5)
    figure.savefig(path, dpi=150)
    return None


def plot_profile(run, path):
    profile = run.profile
    if not profile:
        return "no steady span was found, hence no mean profile" if run.obstacle else "the case has no obstacle"
    figure, axes = new_figure(7.0, 6.5)
    figure.suptitle(f"{run.title}\nmean pressure on the obstacle over the steady span")
    z = profile["z_m"]
    axes.step(1e-3 * profile["pressure_pa"], z, where="mid", color="0.65", linewidth=1.3, label="raw (bins of half a cell)")
    axes.plot(1e-3 * profile["smoothed_pressure_pa"], z, color=BLUE, linewidth=2, label="smoothed (Savitzky–Golay)")
    mean = run.figure("impact_pressure_mean_pa")
    if mean is not None:
        axes.axvline(1e-3 * mean, color=ORANGE, linestyle="-.", label=f"impact pressure, mean below $H$: {1e-3 * mean:.3g} kPa")
        axes.axvline(0.05e-3 * mean, color=ORANGE, linestyle=":", label="threshold, 5 % of it")
    height = run.figure("pressure_height_of_mean_profile_m")
    reference_line(axes, height, "pressure height of this profile", color=GREEN, linestyle="--")
    reference_line(axes, run.flow_height, "flow height $H$", color=GREY, linestyle=":")
    axes.set_xlabel(r"pressure $-\langle\sigma_{xx}\rangle$ (kPa, Cauchy)")
    axes.set_ylabel("height $z$ (m)")
    axes.set_ylim(0, z[-1] + 0.5 * (z[1] - z[0]))
    axes.set_xlim(left=min(0.0, 1.1e-3 * float(np.min(profile["smoothed_pressure_pa"]))))
    axes.grid(alpha=0.3)
    axes.legend(fontsize="small")
    figure.savefig(path, dpi=150)
    return None


def plot_forces(run, path):
    series = run.series
    if "force_x_n" not in series:
        return "the case has no obstacle"
    figure, (top, bottom) = new_figure(8.5, 7.0, nrows=2, sharex=True)
    figure.suptitle(f"{run.title}\nforce of the snow on the obstacle, and moment about the foot of its front face")
    colours = (BLUE, ORANGE, GREEN)
    for axes, name, unit, factor, label in ((top, "force", "n", 1e-3, "force (kN)"), (bottom, "moment", "n_m", 1e-3, "moment (kN m)")):
        shade_steady_span(axes, run)
        means = run.results.get(f"{name}_mean_{unit}") or [None] * 3
        for component, colour, mean in zip("xyz", colours, means):
            text = f"${'F' if name == 'force' else 'M'}_{component}$"
            if mean is not None:
                text += f", steady mean {factor * mean:.3g}"
            axes.plot(series["time_s"], factor * series[f"{name}_{component}_{unit}"], color=colour, linewidth=1.1, label=text)
        axes.set_ylabel(label)
        axes.set_xlim(series["time_s"][0], series["time_s"][-1])
        axes.grid(alpha=0.3)
        axes.legend(fontsize="small", loc="upper right")
    bottom.set_xlabel("time since the front reached the obstacle (s)" if run.conveyor else "time (s)")
    figure.savefig(path, dpi=150)
    return None


def chosen_frames(run, frames, times):
    """First contact, middle and end, or the frames nearest to the times that were asked for."""
    if times:
        return sorted({min(frames, key=lambda frame: abs(frame[1] - t)) for t in times}, key=lambda frame: frame[1])
    after_start = [frame for frame in frames if frame[1] > 0.0] or frames
    picked = {after_start[0], frames[len(frames) // 2], frames[-1]}
    return sorted(picked, key=lambda frame: frame[1])


def obstacle_depth(obstacle):
    """Extent along the flow, m."""
    return max(x for x, _ in obstacle_plan(obstacle))


class Section:
    """Particles of one frame near the axis, and the pressure profile on the obstacle at that instant (paper, Appendix A2)."""

    def __init__(self, run, path, half_width):
        with h5py.File(path, "r") as file:
            position = file["position_m"][:]
            ratio = file["volume_ratio"][:]
            kirchhoff_xx = file["kirchhoff_stress_pa"][:, 0]
        inside = np.abs(position[:, 1]) <= half_width
        order = np.argsort(-np.abs(position[inside, 1]))  # nearest to the axis is drawn last, on top
        self.x, self.z = position[inside, 0][order], position[inside, 2][order]
        self.stress = 1e-3 * (kirchhoff_xx / ratio)[inside][order]
        self.profile_z = self.profile = None
        if run.obstacle and run.conveyor:
            cell = run.case["numerics"]["cell_size_m"]
            edges = np.arange(0.0, 5 * run.flow_height + 0.01 * cell, 0.5 * cell)
            box = inside & (position[:, 0] >= -2.5 * cell) & (position[:, 0] <= 0.5 * cell)
            height = np.maximum(position[box, 2], 0.0)
            volume = np.histogram(height, edges, weights=ratio[box])[0]
            stress = np.histogram(height, edges, weights=kirchhoff_xx[box])[0]
            self.profile = -1e-3 * np.divide(stress, volume, out=np.zeros_like(stress), where=volume > 0)
            self.profile_z = 0.5 * (edges[1:] + edges[:-1])


def plot_side_view(run, path, times):
    frames = run.frames()
    if not frames:
        return "the run stored no frames"
    half_width = 3.0 / 7.0 * run.obstacle["width_m"] if run.obstacle else 3.0 * run.case["numerics"]["cell_size_m"]
    picked = chosen_frames(run, frames, times)
    sections = [(time, Section(run, file, half_width)) for file, time in picked]
    sections = [(time, section) for time, section in sections if section.x.size > 0]
    if not sections:
        return "no particles are near the axis in the chosen frames"

    left = min(float(section.x.min()) for _, section in sections)
    right = max(float(section.x.max()) for _, section in sections)
    if run.flow_height:  # a published strip is hundreds of metres long: the neighbourhood of the obstacle is shown
        left, right = max(left, -5.0 * run.flow_height), min(right, 3.0 * run.flow_height)
        right = max(right, 1.2 * obstacle_depth(run.obstacle) if run.obstacle else right)
    shown = [section.z[(section.x >= left) & (section.x <= right)] for _, section in sections]
    top = 1.06 * max(float(z.max()) for z in shown if z.size) + 0.2
    width = right - left
    with_profile = sections[0][1].profile is not None

    # Stacked where the sections are flat, side by side where jets are tall: a metre is a metre in both directions, and the page stays readable.
    # Everything is placed in inches, so that the profiles share the sections' z axes whatever the aspect.
    side_by_side = top > 0.6 * width
    n = len(sections)
    rows, columns = (1, n) if side_by_side else (n, 1)
    before, gap, profile_width, after = 0.75, 0.12, 1.4 if with_profile else 0.0, 0.25  # left of, between and right of section and profile
    below, above, heading = 0.6, 0.4, 0.65  # under and over a section; over all
    bar_width, bar_height = (0.0, 0.85) if side_by_side else (1.1, 0.0)  # room of the colour bar: below all, or right of all
    bottom = -0.02 * top
    scale = min(((15.0 if side_by_side else 10.5) / columns - before - gap - profile_width - after) / width, 8.0 / (top - bottom))  # inches a metre
    section_width, section_height = width * scale, (top - bottom) * scale
    cell_width, cell_height = before + section_width + gap + profile_width + after, below + section_height + above
    page_width, page_height = columns * cell_width + bar_width, rows * cell_height + heading + bar_height
    figure = plt.figure(figsize=(page_width, page_height))

    def place(x, y, w, h, **arguments):
        """Axes whose lower left corner is x, y inches from the page's."""
        return figure.add_axes((x / page_width, y / page_height, w / page_width, h / page_height), **arguments)

    figure.suptitle(f"{run.title}\nparticles with |y| < {half_width:.2g} m, coloured by stream-wise Cauchy stress" +
                    (", and pressure on the obstacle" if with_profile else ""), y=1.0 - 0.1 / page_height, va="top", fontsize="large")

    near = np.concatenate([section.stress for _, section in sections])
    low = float(np.percentile(near, 0.5))
    norm = Normalize(low if low < 0.0 else -1.0, 0.0)
    spacing = run.case["numerics"]["cell_size_m"] / round(run.case["numerics"].get("particles_per_cell", 8) ** (1 / 3))
    dot = max(1.0, (0.9 * spacing * scale * 72.0) ** 2)
    # One pressure scale for all, that of the later sections: the first contact is a short peak, and may leave the picture.
    pressures = [section.profile.max() for _, section in sections[1:] or sections] if with_profile else []
    if run.profile:
        pressures.append(1e-3 * float(run.profile["pressure_pa"].max()))
    for k, (time, section) in enumerate(sections):
        row, column = (0, k) if side_by_side else (k, 0)
        x, y = column * cell_width + before, bar_height + (rows - 1 - row) * cell_height + below
        axes = place(x, y, section_width, section_height)
        points = axes.scatter(section.x, section.z, c=section.stress, s=dot, cmap=STRESS_COLOURS, norm=norm, linewidths=0, rasterized=True)
        axes.axhline(0.0, color="0.2", linewidth=1.5)
        if run.obstacle:
            height = run.obstacle.get("height_m", 2.0 * top)
            axes.add_patch(Rectangle((0.0, 0.0), obstacle_depth(run.obstacle), height, facecolor="0.8", edgecolor="0.2", hatch="///", linewidth=1.2, zorder=0))
        axes.set(xlim=(left, right), ylim=(bottom, top), title=f"t = {time:.2f} s")
        axes.set_ylabel("height $z$ (m)")
        axes.set_xlabel("$x$ (m), front face at 0" if run.obstacle else "$x$ (m)")
        if not with_profile:
            continue
        beside = place(x + section_width + gap, y, profile_width, section_height, sharey=axes)
        beside.step(section.profile, section.profile_z, where="mid", color=BLUE, linewidth=1.3, label="at this time")
        if run.profile:
            beside.plot(1e-3 * run.profile["pressure_pa"], run.profile["z_m"], color=ORANGE, linewidth=1.6, label="steady mean")
        beside.axhline(run.flow_height, color=GREY, linestyle=":", label="flow height $H$")
        beside.set_xlim(0.0, 1.15 * max(max(pressures), 1e-3))
        beside.set_xlabel("pressure (kPa)")
        beside.tick_params(labelleft=False)
        beside.grid(alpha=0.3)
        if k == 0:
            beside.legend(fontsize="x-small", loc="upper right")
    if side_by_side:
        strip = place(0.25 * page_width, 0.55, 0.5 * page_width, 0.18)
    else:
        strip = place(page_width - bar_width + 0.1, 0.2 * page_height, 0.2, 0.6 * page_height)
    bar = figure.colorbar(points, cax=strip, orientation="horizontal" if side_by_side else "vertical", extend="both")
    bar.set_label(r"stream-wise Cauchy stress $\sigma_{xx}$ (kPa, compression negative)")
    figure.savefig(path, dpi=150)
    return None


def main():
    parser = argparse.ArgumentParser(description="Pictures of one run")
    parser.add_argument("directory", help="result folder of `mpm run`")
    parser.add_argument("--out", help="folder for the pictures (default: DIR/post)")
    parser.add_argument("--times", help="s, separated by commas: sections of the side view (default: first contact, middle, end)")
    parser.add_argument("--format", choices=["png", "pdf", "svg"], default="png")
    options = parser.parse_args()
    out = options.out or os.path.join(options.directory, "post")
    try:
        times = [float(t) for t in options.times.split(",")] if options.times else []
    except ValueError:
        parser.error(f"--times {options.times}: numbers separated by commas are needed, such as 0.2,3,6")
    try:
        run = Run(options.directory, out)
        os.makedirs(out, exist_ok=True)
        for name, draw in (("heights", plot_heights), ("profile", plot_profile), ("forces", plot_forces),
                           ("side_view", lambda r, p: plot_side_view(r, p, times))):
            path = os.path.join(out, f"{name}.{options.format}")
            reason = draw(run, path)
            plt.close("all")
            say(f"wrote {path}" if reason is None else f"no picture {name}: {reason}")
    except (OSError, KeyError, ValueError) as error:
        say(f"{options.directory}: {type(error).__name__}: {error}; give the result folder of `mpm run`")
        return 4
    return 0


if __name__ == "__main__":
    sys.exit(main())
