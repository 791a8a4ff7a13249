"""The numbers of a design: each quantity of each snow with its uncertainties, and its range over the snows."""

import math
from typing import NamedTuple

import numpy as np

from mpmtools.design.loads import Loads
from mpmtools.design.uncertainty import combined, grid_estimate


class Quantity(NamedTuple):
    """How a quantity is shown."""

    key: str
    label: str
    unit: str
    scale: float  # shown value over the stored one


QUANTITIES = [
    Quantity("runup_p99_mean_m", "run-up above ground (99 % of the mass is below it), steady mean", "m", 1.0),
    Quantity("runup_mean_m", "highest particle, steady mean", "m", 1.0),
    Quantity("runup_peak_m", "highest particle, first splash included", "m", 1.0),
    Quantity("pressure_height_mean_m", "pressure height above ground, steady mean", "m", 1.0),
    Quantity("force_mean_n", "force downstream, steady mean", "kN", 1e-3),
    Quantity("force_steady_peak_n", "force, steady peak (0.1 s)", "kN", 1e-3),
    Quantity("force_first_impact_n", "force, first impact (0.1 s)", "kN", 1e-3),
    Quantity("moment_mean_n_m", "overturning moment, steady mean", "kN m", 1e-3),
    Quantity("moment_steady_peak_n_m", "overturning moment, steady peak (0.1 s)", "kN m", 1e-3),
    Quantity("moment_first_impact_n_m", "overturning moment, first impact (0.1 s)", "kN m", 1e-3),
    Quantity("resultant_height_m", "height of the resultant of the mean force", "m", 1.0),
    Quantity("drag_coefficient", "drag coefficient, mean force over ½ρv²wH", "", 1.0),
]


def mode_keys(mode):
    """Of the whole series, and of the steady interval."""
    name = f"equivalent_static_force_{mode['frequency_hz']:g}_hz"
    return f"{name}_n", f"{name}_steady_n"


def quantities_of(plan):
    """All quantities: the fixed ones, and one for each mode."""
    modes = []
    for mode in plan["modes"]:
        text = f"equivalent static force of the mode at {mode['frequency_hz']:g} Hz, damping {100 * mode['damping_ratio']:.3g} %"
        modes += [Quantity(key, text + when, "kN", 1e-3) for key, when in zip(mode_keys(mode), ("", ", while steady"))]
    return QUANTITIES + modes


class Entry(NamedTuple):
    """A quantity of one snow, in its stored unit; NaN: not known."""

    by_grid: list  # on each grid, coarse first
    value: float  # on the finest grid
    gci: float  # from this ensemble's grids
    known: float  # that the program states for the finest resolution
    grid: float  # the larger of the two
    standard_error: float
    total: float  # half width of about 95 %: grid and two standard errors, root of the sum of squares
    method: str  # how the grid convergence index was found
    note: str  # the same, and whether the known uncertainty is larger


class Range(NamedTuple):
    """A quantity over all snows."""

    low: float  # least value minus its uncertainty, at least 0: all quantities are positive
    lowest: float  # least value
    middle: float  # of the middle snow
    highest: float  # greatest value
    high: float  # greatest of value plus uncertainty: to design with


def entry_of(sizes, values):
    """@param values  one Value for each grid"""
    numbers = [v.value for v in values]
    finest, estimate = values[-1], grid_estimate(sizes, numbers)
    parts = [part for part in (estimate.uncertainty, finest.known) if math.isfinite(part)]
    grid = max(parts) if parts else math.nan
    note = estimate.note
    if parts and grid == finest.known:
        note += "; what is known at this resolution is larger and is taken"
    total = combined(grid, finest.standard_error) if math.isfinite(finest.value) else math.nan
    return Entry(numbers, finest.value, estimate.uncertainty, finest.known, grid, finest.standard_error, total, estimate.note, note)


class Results:
    """loads[snow][grid]; table[snow][key]: Entry; ranges[key]: Range. The upper value of the steady run-up ends at the ensemble's bound
    (unless a snow is above it)."""

    def __init__(self, ensemble):
        plan = ensemble.plan
        self.loads = [[Loads(run) for run in row] for row in ensemble.runs]
        self.table = []
        for row in self.loads:
            values = [{**loads.values, **self._responses(loads, plan)} for loads in row]
            self.table.append({q.key: entry_of(ensemble.sizes, [v[q.key] for v in values]) for q in quantities_of(plan)})
        self.ranges = {q.key: self._range(q.key, ensemble.middle) for q in quantities_of(plan)}
        for key in ("runup_p99_mean_m", "runup_mean_m"):
            runup = self.ranges[key]
            self.ranges[key] = runup._replace(high=max(min(runup.high, ensemble.bound), runup.highest))
        self.not_steady = [run.folder for row, runs in zip(self.loads, ensemble.runs) for loads, run in zip(row, runs) if not loads.is_steady]

    @property
    def finest(self):
        """Loads of each snow on the finest grid."""
        return [row[-1] for row in self.loads]

    def _range(self, key, middle):
        entries = [row[key] for row in self.table]
        known = [e for e in entries if math.isfinite(e.value)]
        if not known:
            return Range(*[math.nan] * 5)
        spread = [0.0 if math.isnan(e.total) else e.total for e in known]
        return Range(max(min(e.value - s for e, s in zip(known, spread)), 0.0), min(e.value for e in known), entries[middle].value,
                     max(e.value for e in known), max(e.value + s for e, s in zip(known, spread)))

    @staticmethod
    def _responses(loads, plan):
        values = {}
        for mode in plan["modes"]:
            values.update(zip(mode_keys(mode), loads.mode_values(mode["frequency_hz"], mode["damping_ratio"])))
        return values

    def design_force(self, plan, steady_only=False):
        """(key, N): the largest upper value among steady peak, first impact and the responses of the modes; (None, NaN) without any.

        @param steady_only  without the first impact
        """
        keys = ["force_steady_peak_n"] + [mode_keys(m)[1] for m in plan["modes"]]
        if not steady_only:
            keys += ["force_first_impact_n"] + [mode_keys(m)[0] for m in plan["modes"]]
        keys = [k for k in keys if math.isfinite(self.ranges[k].high)]
        if not keys:
            return None, math.nan
        best = max(keys, key=lambda k: self.ranges[k].high)
        return best, self.ranges[best].high

    def profile_table(self, ensemble):
        """Columns of pressure_over_height.csv: z_m, and low, middle and high of the snows for each envelope, Pa."""
        finest = [loads.profiles for loads in self.finest]
        columns = {"z_m": finest[0]["z_m"]}
        for key in ("mean", "steady_peak", "first_impact", "stress"):
            curves = np.array([p[key] for p in finest])
            columns[f"{key}_lowest_pa"], columns[f"{key}_middle_pa"], columns[f"{key}_highest_pa"] = (
                curves.min(axis=0), curves[ensemble.middle], curves.max(axis=0))
        return columns
