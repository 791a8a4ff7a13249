"""What a design takes from one run: heights, forces and moments with their statistical errors, and profiles over height."""

import math
import os
from functools import cached_property
from typing import NamedTuple

import numpy as np

from mpmtools.design.oscillator import equivalent_static_force
from mpmtools.errors import InputError
from mpmtools.frame import open_hdf5

WINDOW = 0.1  # s, of the moving mean behind peaks, the default of [measurement] force_window_s


class Value(NamedTuple):
    """One number of a run."""

    value: float  # NaN: the run has none
    standard_error: float = math.nan  # of a mean in time; NaN for peaks
    known: float = math.nan  # numerical uncertainty that the program states for the resolution, in the unit of the value


def moving_mean(values, rows):
    """Mean over an odd number of neighbours along the first axis. Before the first row nothing touches the mast: zeros count there. At the
    end over those that are there."""
    values = np.asarray(values, float)
    half = rows // 2
    padded = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])
    at = np.arange(len(values))
    low, high = np.maximum(at - half, 0), np.minimum(at + half + 1, len(values))
    return (padded[high] - padded[low]) / (high - at + half).reshape(-1, *[1] * (values.ndim - 1))


class Loads:
    """Series of a run as arrays without the first row, whose interval is empty; forces in N, moments in N m, times in s."""

    def __init__(self, run):
        self.run = run
        series = run.series
        if "force_x_n" not in series or len(series) < 3:
            raise InputError(f"{run.folder}: series.csv has no forces; run `mpm design` again")
        self.interval = float(series.time_s.iat[1] - series.time_s.iat[0])
        self.time = series.time_s.to_numpy()[1:]
        self.force = series.force_x_n.to_numpy()[1:]
        self.axis = run.number("overturning_moment_axis_x_m") or 0.0
        self.moment = (series.moment_y_n_m + self.axis * series.force_z_n).to_numpy()[1:]
        self.runup, self.highest = series.runup_p99_m.to_numpy()[1:], series.runup_m.to_numpy()[1:]
        self.pressure_height = series.pressure_height_m.to_numpy()[1:]
        self.rows = 2 * int(0.5 * WINDOW / self.interval + 1e-9) + 1
        self.smooth_force, self.smooth_moment = moving_mean(self.force, self.rows), moving_mean(self.moment, self.rows)
        begin, end = run.number("steady_from_s"), run.number("steady_to_s")
        self.steady = (self.time >= begin) & (self.time <= end) if begin is not None and end is not None else np.zeros(len(self.time), bool)
        self.impact = self.time <= 2.0 * run.velocity / run.gravity

    @property
    def is_steady(self):
        return bool(self.steady.any())

    def _mean(self, key, error, known=None):
        run = self.run

        def first(name):
            value = run.results.get(name)
            value = value[0] if isinstance(value, list) else value
            return math.nan if value is None else float(value)

        return Value(first(key), first(error), first(known) if known else math.nan)

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
        means = {
            "runup_p99_mean_m": self._mean("runup_p99_mean_m", "runup_p99_standard_error_m", "runup_p99_numerical_uncertainty_m"),
            "runup_mean_m": self._mean("runup_mean_m", "runup_standard_error_m", "runup_numerical_uncertainty_m"),
            "pressure_height_mean_m": self._mean("pressure_height_mean_m", "pressure_height_standard_error_m",
                                                 "pressure_height_numerical_uncertainty_m"),
            "force_mean_n": self._mean("force_mean_n", "force_standard_error_n", "force_x_numerical_uncertainty_n"),
            "moment_mean_n_m": self._mean("overturning_moment_mean_n_m", "overturning_moment_standard_error_n_m",
                                          "overturning_moment_numerical_uncertainty_n_m"),
        }
        force, moment = means["force_mean_n"], means["moment_mean_n_m"]
        case = self.run.case
        head = 0.5 * case["material"]["density_kg_m3"] * self.run.velocity**2 * case["obstacle"]["width_m"] * self.run.flow_height
        return {
            **means,
            "runup_peak_m": Value(float(np.nanmax(self.highest))),
            "force_steady_peak_n": self._peak(self.smooth_force, self.steady, force),
            "force_first_impact_n": self._peak(self.smooth_force, self.impact, force),
            "moment_steady_peak_n_m": self._peak(self.smooth_moment, self.steady, moment),
            "moment_first_impact_n_m": self._peak(self.smooth_moment, self.impact, moment),
            "resultant_height_m": Value(self.run.number("force_resultant_height_m") or math.nan),
            "drag_coefficient": Value(*(part / head for part in force)),
        }

    def response(self, frequency, damping):
        """Equivalent static force of a mode over time, N."""
        return equivalent_static_force(self.interval, self.force, frequency, damping)

    def mode_values(self, frequency, damping):
        """Its largest value, as the other peaks: (of the whole series; of the steady interval, from rest under its mean force, so that
        what the first impact left in the mast is not in it)."""
        mean = self.values["force_mean_n"]
        whole = self._peak(np.abs(self.response(frequency, damping)), np.ones(len(self.time), bool), mean)
        steady, level = np.zeros(len(self.time)), np.mean(self.force[self.steady]) if self.is_steady else math.nan
        steady[self.steady] = level + equivalent_static_force(self.interval, self.force[self.steady] - level, frequency, damping)
        return whole, self._peak(np.abs(steady), self.steady, mean)

    @cached_property
    def profiles(self):
        """z (m) and pressures in Pa: force per height of the impulses over the width: 'mean', 'steady_peak' and 'first_impact' (largest of
        the moving mean at each height, not at one time); 'stress': the paper's profile of stress before the mast, its steady mean."""
        path = os.path.join(self.run.folder, "profiles.h5")
        with open_hdf5(path) as file:
            z, pressure = file["z_m"][:], file["force_x_per_height_n_m"][1:] / self.run.case["obstacle"]["width_m"]
            stress = file["pressure_pa"][1:]
        if not pressure.shape == stress.shape == (len(self.time), len(z)):
            raise InputError(f"{path}: {pressure.shape} and {stress.shape} values, {(len(self.time), len(z))} are needed; run `mpm design` again")
        smooth = moving_mean(pressure, self.rows)
        nothing = np.full(len(z), math.nan)
        return {"z_m": z, "mean": pressure[self.steady].mean(axis=0) if self.is_steady else nothing,
                "steady_peak": smooth[self.steady].max(axis=0) if self.is_steady else nothing,
                "first_impact": smooth[self.impact].max(axis=0) if self.impact.any() else nothing,
                "stress": stress[self.steady].mean(axis=0) if self.is_steady else nothing}
