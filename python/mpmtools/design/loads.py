"""What a design takes from one run: heights, forces and moments with their statistical errors, and profiles over height."""

import copy
import math
import os
import re
from functools import cached_property
from typing import NamedTuple

import numpy as np
import scipy.stats

from mpmtools.design.oscillator import equivalent_static_force
from mpmtools.design.uncertainty import BATCHES, statistical
from mpmtools.design.vibration import MOST, modes_of
from mpmtools.errors import InputError
from mpmtools.frame import open_hdf5

PARTS = min(BATCHES)  # of the time over which growth is looked for
GROWTH = 0.05  # rise over the mean: the tolerance within which the program calls a series steady
CHANCE = 0.05  # probability of a rise that is none
WINDOW = 0.1  # s, of the moving mean behind peaks, the default of [measurement] force_window_s


class Value(NamedTuple):
    """One number of a run."""

    value: float  # NaN: the run has none
    standard_error: float = math.nan  # of a mean in time; NaN for peaks
    known: float = math.nan  # numerical uncertainty that the program states for the resolution, in the unit of the value
    statistical: float = math.nan  # half width of 95 % of a mean in time, from the standard error; NaN for peaks


def total(*values):
    """Sum of Values of things that fluctuate together: their errors add up."""
    return Value(*map(sum, zip(*values)))


class Effect(NamedTuple):
    """What the snow does to the mast, or to its arm, over time; moments about the mast's own axis at the ground."""

    force: np.ndarray  # N, downstream
    lateral_force: np.ndarray
    vertical: np.ndarray  # upwards
    lateral_moment: np.ndarray  # N m
    moment: np.ndarray  # overturning, downstream
    torsion: np.ndarray


def moving_mean(values, rows):
    """Mean over a number of neighbours along the first axis, of an even number one more after than before. Before the first row nothing touches
    the mast: zeros count there. At the end over those that are there."""
    values = np.asarray(values, float)
    before, after = (rows - 1) // 2, rows // 2
    padded = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])
    at = np.arange(len(values))
    low, high = np.maximum(at - before, 0), np.minimum(at + after + 1, len(values))
    return (padded[high] - padded[low]) / (high - at + before).reshape(-1, *[1] * (values.ndim - 1))


def rows_of(interval):
    """Rows of the moving mean, as the program counts them."""
    return max(1, int(WINDOW / interval + 1e-9))


HIGHEST_FREQUENCY = 20.0  # Hz, of the modes: rows of 10 ms resolve no more


def all_modes(plan):
    """The modes of the site file by frequency, and up to HIGHEST_FREQUENCY those of the cantilever with this first mode that the file does not
    list. Only the lowest MOST: a mast of unknown height has no others."""
    listed = sorted(plan["modes"], key=lambda m: m["frequency_hz"])[:MOST]
    if not listed or plan["mast"]["height_m"] is None:
        return listed
    higher = [{"frequency_hz": listed[0]["frequency_hz"] * mode.frequency_ratio, "damping_ratio": listed[0]["damping_ratio"],
               "shape_at_load": None} for mode in modes_of(plan["mast"])[len(listed):]]
    return listed + [m for m in higher if listed[-1]["frequency_hz"] < m["frequency_hz"] <= HIGHEST_FREQUENCY]


class Loads:
    """Series of a run as arrays without the first row, whose interval is empty; forces in N, moments in N m, times in s. Heights and moments
    are from the ground, which lies `base` below the bed of the run (a snow cover). Force and moment are those of mast and arm together, as
    the foundation feels them; `mast` and `arm` hold the parts."""

    def __init__(self, run, base=0.0):
        self.run, self.base = run, base
        series = run.series
        if "force_x_n" not in series or len(series) < 3:
            raise InputError(f"{run.folder}: series.csv has no forces; run `mpm design` again")
        self.interval = float(series.index[1] - series.index[0])
        self.time = series.index.to_numpy()[1:]
        self.axis = run.number("overturning_moment_axis_x_m") or 0.0
        self.mast = self._effect("")
        self.has_arm = run.case.get("arm") is not None
        self.arm = self._effect("arm_") if self.has_arm else Effect(*np.zeros((len(Effect._fields), len(self.time))))
        whole = Effect(*map(np.add, self.mast, self.arm))
        self.force, self.moment = whole.force, whole.moment
        self.vertical = moving_mean(whole.vertical, rows_of(self.interval))
        self.runup, self.highest, self.pressure_height = (base + series[name].to_numpy()[1:]
                                                          for name in ("runup_p99_m", "runup_m", "pressure_height_m"))
        self.rows = rows_of(self.interval)
        self.lateral = {name: moving_mean(getattr(whole, name), self.rows) for name in ("lateral_force", "lateral_moment", "torsion")}
        self.smooth_force, self.smooth_moment = moving_mean(self.force, self.rows), moving_mean(self.moment, self.rows)
        begin, end = run.number("steady_from_s"), run.number("steady_to_s")
        self.steady = (self.time >= begin) & (self.time <= end) if begin is not None and end is not None else np.zeros(len(self.time), bool)
        self.splash_back = 2.0 * run.velocity / run.gravity
        self.impact = self.time <= self.splash_back

    def _effect(self, part):
        """@param part  of the names of the columns of series.csv: nothing, or arm_"""
        columns = (f"{part}{kind}_{axis}_{unit}" for kind, unit in (("force", "n"), ("moment", "n_m")) for axis in "xyz")
        along, across, up, roll, pitch, yaw = (self.run.series[name].to_numpy()[1:] for name in columns)
        return Effect(along, across, up, roll - self.base * across, pitch + self.axis * up + self.base * along, yaw - self.axis * across)

    @property
    def is_steady(self):
        return bool(self.steady.any())

    @property
    def is_late(self):
        """Whether the steady interval begins after half of the time that is left when the splash is back, 2v/g."""
        return self.is_steady and self.time[self.steady][0] > 0.5 * (self.splash_back + self.time[-1])

    @cached_property
    def growth(self):
        """{name: rise over the mean} of what still grows when the run ends; heights above the bed, since a snow cover does not grow.

        The steady interval, or where it begins late all time after the splash, is cut into PARTS of equal length. What grows is what a straight
        line through their means rises by more than GROWTH, with a probability below CHANCE that parts without a trend rise so (t-test).
        """
        where = (self.time >= self.splash_back if self.is_late else self.steady).nonzero()[0]
        found = {}
        arm = [("arm's force", self.arm.force)] if np.any(self.arm.force[where]) else []
        for name, values in (("run-up", self.runup - self.base), ("pressure height", self.pressure_height - self.base), ("force", self.force), ("moment", self.moment), *arm):
            if not self.is_steady or len(where) < PARTS:
                break
            means = [np.nanmean(values[part]) if np.isfinite(values[part]).any() else math.nan for part in np.array_split(where, PARTS)]
            line = scipy.stats.linregress(np.arange(PARTS), means, alternative="greater")
            rise = line.slope * PARTS / np.mean(means)
            if rise > GROWTH and line.pvalue < CHANCE:
                found[name] = float(rise)
        return found

    @property
    def during(self):
        """Rows over which a peak is taken, by the name of the peak; the first impact and what is later together cover the run."""
        return {"steady_peak": self.steady, "first_impact": self.impact, "later_peak": ~self.impact}

    def _mean(self, mean, error, known="", component=0):
        """The Value whose parts have these names in results.json; of vectors one component."""
        effective = re.sub("_standard_error.*", "_effective_samples", error).removeprefix("overturning_")
        parts = [part[component] if isinstance(part, list) else part for part in map(self.run.results.get, (mean, error, known, effective))]
        mean, error, known, effective = (math.nan if part is None else float(part) for part in parts)
        return Value(mean, error, known, statistical(error, effective))

    def _means_of_arm(self, force, moment):
        """Values of its force, lift and moment. A run states no numerical uncertainty of them: those of the mast are taken, relatively."""
        along, up = (self._mean("arm_force_mean_n", "arm_force_standard_error_n", component=i) for i in (0, 2))
        about = self._mean("arm_moment_mean_n_m", "arm_moment_standard_error_n_m", component=1)
        about = total(about, Value(*(self.axis * part for part in up)), Value(*(self.base * part for part in along)))
        return [mean._replace(known=abs(mean.value) * of.known / of.value if of.value else math.nan)
                for mean, of in ((along, force), (up, force), (about, moment))]

    def _peak(self, values, where, known_of):
        """A peak has no standard error; its numerical uncertainty is taken to be that of the mean, relatively."""
        if not where.any():
            return Value(math.nan)
        value = float(np.nanmax(values[where]))
        relative = known_of.known / known_of.value if math.isfinite(known_of.value) and known_of.value != 0.0 else math.nan
        return Value(value, math.nan, abs(relative * value))

    @cached_property
    def values(self):
        """Every number of the design by its name; the names are those of design.json."""
        parts = ("mean", "standard_error", "numerical_uncertainty")
        heights = {f"{name}_mean_m": self._mean(*(f"{name}_{part}_m" for part in parts)) for name in ("runup_p99", "runup", "pressure_height")}
        force = self._mean("force_mean_n", "force_standard_error_n", "force_x_numerical_uncertainty_n")
        moment = self._mean(*(f"overturning_moment_{part}_n_m" for part in parts), component=1)
        if self.base:
            moment = Value(*(about_bed + self.base * part for about_bed, part in zip(moment, force)))
            heights = {name: height._replace(value=self.base + height.value) for name, height in heights.items()}
        arm, peaks_of_arm, drag = {}, [], force
        if self.has_arm:
            along, up, about = self._means_of_arm(force, moment)
            arm = {"mast_force_mean_n": force, "mast_moment_mean_n_m": moment, "arm_force_mean_n": along, "arm_lift_mean_n": up,
                   "arm_height_m": Value(about.value / along.value if along.value > 0.0 else math.nan)}
            peaks_of_arm = [(f"arm_{name}", "_n", moving_mean(values, self.rows), mean)
                            for name, values, mean in (("force", self.arm.force, along), ("lift", self.arm.vertical, up))]
            force, moment = total(force, along), total(moment, about)
        peaks = [("force", "_n", self.smooth_force, force), ("moment", "_n_m", self.smooth_moment, moment), *peaks_of_arm,
                 *((name, "", np.abs(values), force if name == "lateral_force" else moment) for name, values in self.lateral.items())]
        case = self.run.case
        head = 0.5 * case["material"]["density_kg_m3"] * self.run.velocity**2 * self.run.obstacle_width * self.run.flow_height
        return {
            **heights, "force_mean_n": force, "moment_mean_n_m": moment, **arm,
            "runup_peak_m": self._peak(self.highest, np.ones_like(self.time, bool), heights["runup_mean_m"]),
            **{f"{name}_{which}{unit}": self._peak(values, where, known) for name, unit, values, known in peaks for which, where in self.during.items()},
            "resultant_height_m": Value(moment.value / force.value if force.value > 0.0 else math.nan),
            "drag_coefficient": Value(*(part / head for part in drag)),
        }

    @cached_property
    def line_load(self):
        """(z, m; spacing of z, m; force per height in N/m, a row for each time), downstream."""
        z, line = self._profiles("force_x_per_height_n_m")
        return self.base + z, float(z[1] - z[0]), line

    def _profiles(self, name):
        """(z above the bed, m; values, a row for each time) of profiles.h5."""
        path = os.path.join(self.run.folder, "profiles.h5")
        with open_hdf5(path) as file:
            z, values = file["z_m"][:], file[name][1:]
        if values.shape != (len(self.time), len(z)) or len(z) < 2:
            raise InputError(f"{path}: {values.shape} values, {(len(self.time), len(z))} are needed; run `mpm design` again")
        return z, values

    def generalised_force(self, mode, number, mast):
        """Q(t) of a mode, N: the force times the mode's shape, weighted by the pressure over height; or times shape_at_load, where given; and
        the arm's force times the shape at its middle. A mast of unknown height takes all force as if at its top. @param mast  of
        design_plan.json"""
        height = mast["height_m"]
        if height is None:
            return self.force
        shape, of_arm = modes_of(mast)[number - 1].shape, 0.0
        if self.has_arm:
            of_arm = self.arm.force * shape(min(self.arm_middle / height, 1.0))
        if mode["shape_at_load"] is not None:
            return mode["shape_at_load"] * self.mast.force + of_arm
        z, step, line = self.line_load
        whole = step * line.sum(axis=1)
        acting = np.abs(whole) > 1e-3 * np.max(np.abs(whole))  # what the snow hardly touches has no centre
        weighted = step * line @ shape(z / height)
        return self.mast.force * np.clip(np.divide(weighted, whole, out=np.zeros_like(whole), where=acting), -1.0, 1.0) + of_arm

    @cached_property
    def arm_middle(self):
        """Height of the middle of the arm, m."""
        arm = self.run.case["arm"]
        return self.base + 0.5 * (arm["base_m"] + arm["height_m"])

    def scaled(self, force, height, time):
        """These loads for with_vibration(), with forces, heights above the bed and times multiplied; an arm stays where it is."""
        other, (z, step, line) = copy.copy(self), self.line_load
        other.interval = time * self.interval
        other.rows = rows_of(other.interval)
        other.line_load = self.base + height * (z - self.base), height * step, force / height * line
        other.mast, other.arm = (effect._replace(force=force * effect.force) for effect in (self.mast, self.arm))
        other.force, other.moment = force * self.force, force * (height * (self.moment - self.base * self.force) + self.base * self.force)
        other.smooth_force, other.smooth_moment = (moving_mean(values, other.rows) for values in (other.force, other.moment))
        return other

    def with_vibration(self, plan, front=1):
        """What the modes add to force and moment at the foundation. @param front  rows over which the front rises to full depth: the
        responses to vertical fronts that arrive one after the other are averaged. @return {name: values}: 'force', 'moment' (0.1 s, with
        the masses of the mast), 'force_steady', 'moment_steady' (from rest under the mean, NaN outside the steady interval), and for each
        mode a tuple (shape at the load, amplification) under 'modes'"""
        height = plan["mast"]["height_m"]

        def inclined(values):
            return np.convolve(values, np.full(front, 1.0 / front))[: len(values)] if front > 1 else values

        force, moment = inclined(self.smooth_force), inclined(self.smooth_moment)
        steady_force, steady_moment = (np.where(self.steady, values, math.nan) for values in (self.smooth_force, self.smooth_moment))
        result = {"force": force.copy(), "moment": moment.copy(), "force_steady": steady_force, "moment_steady": steady_moment, "modes": {}}
        lever = float(np.max(moment) / np.max(force)) if np.max(force) > 0.0 else 0.0
        for number, mode in enumerate(all_modes(plan), 1):
            beam = modes_of(plan["mast"])[number - 1]
            shares = (1.0, lever) if height is None else (beam.force_share, beam.moment_share * height)
            load = inclined(self.generalised_force(mode, number, plan["mast"]))
            smooth = moving_mean(load, self.rows)
            oscillator = mode["frequency_hz"], mode["damping_ratio"]
            response = equivalent_static_force(self.interval, load, *oscillator)
            steady = np.full(len(load), math.nan)
            if self.is_steady:
                level = np.mean(load[self.steady])
                steady[self.steady] = level + equivalent_static_force(self.interval, load[self.steady] - level, *oscillator)
            for name, share in zip(("force", "moment"), shares):
                result[name] += share * (response - smooth)
                result[f"{name}_steady"] += share * (steady - smooth)
            if number <= len(plan["modes"]):
                most = float(np.max(np.abs(smooth)))
                shape = float(np.sum(smooth) / np.sum(force)) if np.sum(force) else math.nan
                result["modes"][mode["frequency_hz"]] = (shape, float(np.max(np.abs(response))) / most if most > 0.0 else math.nan)
        return result

    def vibration_values(self, plan):
        """The largest of them, by the names of design.json."""
        if not plan["modes"]:
            return {}
        found, force, moment = self.with_vibration(plan), self.values["force_mean_n"], self.values["moment_mean_n_m"]
        values = {f"{name}_with_vibration{which}_{unit}": self._peak(found[name + which], where, known) for name, unit, known in (
            ("force", "n", force), ("moment", "n_m", moment)) for which, where in (("", np.ones_like(self.time, bool)), ("_steady", self.steady))}
        for frequency, (shape, amplification) in found["modes"].items():
            values[f"mode_{frequency:g}_hz_shape_at_load"] = Value(shape)
            values[f"mode_{frequency:g}_hz_amplification"] = Value(amplification)
        return values

    def at(self, which, values, greatest=None):
        """Values with a row for each time: their steady mean, or the moving mean over 0.1 s when the force is greatest ('steady_peak',
        'first_impact', 'later_peak'). @param greatest  another series than that of the force"""
        where = self.steady if which == "mean" else self.during[which]
        if not where.any():
            return np.full(values.shape[1:], math.nan)
        if which == "mean":
            return values[where].mean(axis=0)
        return moving_mean(values, self.rows)[np.flatnonzero(where)[np.argmax((self.smooth_force if greatest is None else greatest)[where])]]

    @cached_property
    def profiles(self):
        """z (m) and pressures in Pa: force per height of the impulses over the width: 'mean', and of during() (largest of
        the moving mean at each height, not at one time); 'stress': the paper's profile of stress before the mast, its steady mean."""
        z, _, line = self.line_load
        pressure, (_, stress) = line / self.run.obstacle_width, self._profiles("pressure_pa")
        smooth = moving_mean(pressure, self.rows)

        def over(reduce, values, where):
            return reduce(values[where], axis=0) if where.any() else np.full(len(z), math.nan)

        return {"z_m": z, "mean": over(np.mean, pressure, self.steady), "stress": over(np.mean, stress, self.steady),
                **{name: over(np.max, smooth, where) for name, where in self.during.items()}}
