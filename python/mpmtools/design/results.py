"""The numbers of a design: each quantity of each snow with its uncertainties, and its range over the snows."""

import math
import os
from typing import NamedTuple

import numpy as np

from mpmtools.design.loads import Loads, all_modes
from mpmtools.design.uncertainty import combined, grid_estimate
from mpmtools.design.vibration import mass_per_height, modes_of


class Quantity(NamedTuple):
    """How a quantity is shown."""

    key: str
    label: str
    unit: str
    scale: float  # shown value over the stored one


LATER = "peak after the first impact, steady or not"
PEAKS = {"steady_peak": "steady peak (0.1 s)", "first_impact": "first impact (0.1 s)", "later_peak": f"{LATER} (0.1 s)"}
STATIC = {"mean": "steady mean", **PEAKS}
LINE_LOADS = {"mean": "steady mean", "steady_peak": "steady peak", "first_impact": "first impact",
              "later_peak": "later peak", "with_vibration": "design load, with the mast's masses"}
LATERAL = (("lateral_force", "lateral force, either way", "kN"), ("lateral_moment", "moment of the lateral force at the ground", "kN m"),
           ("torsion", "torsion about the mast's own axis", "kN m"))


def _of_each(values, key, label, unit):
    """A Quantity for each of the values of a load, in thousands. @param values  of STATIC; @param key  with {} in place of their names"""
    return [Quantity(key.format(which), f"{label}, {text}", unit, 1e-3) for which, text in values.items()]


QUANTITIES = [
    Quantity("runup_p99_mean_m", "run-up above ground (99 % of the mass is below it), steady mean", "m", 1.0),
    Quantity("runup_mean_m", "highest particle, steady mean", "m", 1.0),
    Quantity("runup_peak_m", "highest particle, first splash included", "m", 1.0),
    Quantity("pressure_height_mean_m", "pressure height above ground, steady mean", "m", 1.0),
    *(_of_each({"mean": "steady mean"}, "force_{}_n", "force downstream", "kN") + _of_each(PEAKS, "force_{}_n", "force", "kN")),
    *_of_each(STATIC, "moment_{}_n_m", "overturning moment", "kN m"),
    Quantity("resultant_height_m", "height at which the mean force gives the mean overturning moment", "m", 1.0),
    Quantity("drag_coefficient", "drag coefficient, mean force over ½ρv²wH", "", 1.0),
]
ARM = [Quantity("mast_force_mean_n", "force downstream on the mast without its arm, steady mean", "kN", 1e-3),
       Quantity("mast_moment_mean_n_m", "overturning moment of the mast without its arm, steady mean", "kN m", 1e-3),
       *_of_each(STATIC, "arm_force_{}_n", "arm: force downstream", "kN"), *_of_each(STATIC, "arm_lift_{}_n", "arm: force upwards", "kN"),
       Quantity("arm_height_m", "arm: height at which its mean force gives its moment", "m", 1.0)]

STEADY, IMPACT = ("mean", "steady_peak", "with_vibration_steady"), ("first_impact", "later_peak", "with_vibration")
STEADY_FORCES, IMPACT_FORCES, STATIC_FORCES = ([f"force_{which}_n" for which in of] for of in (STEADY, IMPACT, STATIC))
STEADY_MOMENTS, IMPACT_MOMENTS, STATIC_MOMENTS = ([f"moment_{which}_n_m" for which in of] for of in (STEADY, IMPACT, STATIC))
FORCES, MOMENTS = STEADY_FORCES + IMPACT_FORCES, STEADY_MOMENTS + IMPACT_MOMENTS
ARM_FORCES, ARM_LIFTS = ([f"arm_{name}_{which}_n" for which in STATIC] for name in ("force", "lift"))
HEADLINES = {  # load: of what it is the greatest while the flow is steady, and at any time; the mean can have the greatest uncertainty
    "force": (STEADY_FORCES, FORCES), "moment": (STEADY_MOMENTS, MOMENTS), "arm_force": (ARM_FORCES[:2], ARM_FORCES), "arm_lift": (ARM_LIFTS[:2], ARM_LIFTS)}


def is_oblique(plan):
    """Whether the mast is turned, so that the whole flow was computed."""
    return plan["mast"].get("angle_deg", 0.0) != 0.0


def quantities_of(plan):
    """All quantities: the fixed ones, those of an arm and of an oblique flow, and where there are modes, what they add."""
    lateral = [quantity for name, label, unit in LATERAL for quantity in _of_each(PEAKS, f"{name}_{{}}", label, unit)]
    fixed = QUANTITIES + (ARM if "arm" in plan else []) + (lateral if is_oblique(plan) else [])
    if not plan["modes"]:
        return fixed
    vibrating = [quantity for name, unit in (("force", "n"), ("moment", "n_m")) for quantity in _of_each(
        {"": "first impact included", "_steady": "while steady"}, f"{name}_with_vibration{{}}_{unit}", f"{name} at the foundation with the vibration",
        "kN" if name == "force" else "kN m")]
    counted = all_modes(plan)
    for mode in (mode for mode in plan["modes"] if mode in counted):
        name, text = f"mode_{mode['frequency_hz']:g}_hz", f"mode at {mode['frequency_hz']:g} Hz: "
        vibrating += [Quantity(f"{name}_shape_at_load", text + "shape at the load, 1 at the top", "", 1.0),
                      Quantity(f"{name}_amplification", text + "amplification of its own part, vertical front (upper bound)", "", 1.0)]
    return fixed + vibrating


class Entry(NamedTuple):
    """A quantity of one snow, in its stored unit; NaN: not known."""

    by_grid: list  # on each grid, coarse first
    value: float  # on the finest grid
    gci: float  # from this ensemble's grids
    order: float  # observed on three grids; NaN: none
    known: float  # that the program states for the finest resolution
    grid: float  # the larger of the two
    standard_error: float
    total: float  # half width of about 95 %: grid and statistical part, root of the sum of squares
    method: str  # how the grid convergence index was found
    note: str  # the same, and whether the known uncertainty is larger
    statistical: float  # half width of 95 % of a mean, by Student's t of its batches times the standard error; NaN of a peak
    without_known: bool  # the known uncertainty, relative to the steady mean, is missing because the finest run has none

    @property
    def spread(self):
        """total, 0 where it is not known."""
        return 0.0 if math.isnan(self.total) else self.total

    @property
    def upper(self):
        return self.value + self.spread

    @property
    def at_least(self):
        """Whether fewer than two grids have the value, or without_known, so that its uncertainty may be greater."""
        return math.isfinite(self.value) and (not math.isfinite(self.gci) or self.without_known)


class Range(NamedTuple):
    """A quantity over all snows."""

    low: float  # least value minus its uncertainty, at least 0 where all values are
    lowest: float  # least value
    middle: float  # of the middle snow
    highest: float  # greatest value
    high: float  # greatest of value plus uncertainty: to design with
    at_least: bool = False  # Entry.at_least of a snow


def entry_of(sizes, values, without_known=False):
    """@param values  one Value for each grid; @param without_known  of Entry"""
    numbers = [v.value for v in values]
    finest, estimate = values[-1], grid_estimate(sizes, numbers)
    parts = [part for part in (estimate.uncertainty, finest.known) if math.isfinite(part)]
    grid = max(parts) if parts else math.nan
    note = estimate.note + "; what is known at this resolution is larger and is taken" * (bool(parts) and grid == finest.known)
    total = combined(grid, finest.statistical) if math.isfinite(finest.value) else math.nan
    return Entry(numbers, finest.value, estimate.uncertainty, estimate.order, finest.known, grid, finest.standard_error, total, estimate.note, note,
                 finest.statistical, without_known)


MOMENT_STEPS = 4  # of the stretch of a line load, until its moment is met within 1e-6


def fitted_line(z, profile, edges, force, moment, base=0.0):
    """The profile at z, stretched from z = base over height and scaled, as values between the edges: its integral is the force (N), and about
    z = 0 it has the moment (N m)."""
    z, edges, moment = z - base, edges - base, moment - base * force
    step = z[1] - z[0]
    profile = np.maximum(profile, 0.0)
    whole = step * profile.sum()
    if not whole > 0.0:
        return np.full(len(edges) - 1, math.nan)
    stretch = (moment / force) / (step * profile @ z / whole)
    below = np.concatenate([[0.0], np.cumsum(step * profile)]) * force / whole  # of the load, up to each edge
    bounds, middle = np.concatenate([[z[0] - 0.5 * step], z + 0.5 * step]), 0.5 * (edges[1:] + edges[:-1])
    for _ in range(MOMENT_STEPS):  # between the edges the load is constant, so that its moment is another than that of the pieces of the profile
        pieces = np.diff(np.interp(edges, stretch * bounds, below))
        stretch *= moment / (pieces @ middle)
    return pieces / np.diff(edges)


class Results:
    """finest[snow]: Loads on the finest grid; table[snow][key]: Entry; ranges[key]: Range. The upper value of the steady run-up ends at the
    ensemble's bound (unless a snow is above it). not_steady: names of the runs without a steady interval."""

    def __init__(self, ensemble):
        plan = ensemble.plan
        all_loads = [[Loads(run, ensemble.base) for run in row] for row in ensemble.runs]
        self.finest = [row[-1] for row in all_loads]
        self.not_steady = [os.path.basename(loads.run.folder) for row in all_loads for loads in row if not loads.is_steady]
        self.table, self.scaled_peaks, keys = [], {}, [q.key for q in quantities_of(plan)]
        for row in all_loads:
            values = [{**loads.values, **loads.vibration_values(plan)} for loads in row]
            self.table.append({key: entry_of(ensemble.sizes, [v[key] for v in values], not row[-1].is_steady and not key.startswith("mode_")) for key in keys})
        self.ranges = {key: self._range(key, ensemble.middle) for key in keys}
        for key in ("runup_p99_mean_m", "runup_mean_m"):
            runup = self.ranges[key]
            self.ranges[key] = runup._replace(high=max(min(runup.high, ensemble.bound), runup.highest))

    @property
    def peaks(self):
        """Names of the peaks that the page shows: a later one only where it is above the steady one."""
        later = any(range_.high > 0.0 and not range_.high <= self.ranges[key.replace("later_peak", "steady_peak")].high
                    for key, range_ in self.ranges.items() if "later_peak" in key)
        return ("steady_peak", "first_impact", *["later_peak"] * later)

    def shown(self, plan):
        """The quantities of the page's tables."""
        return [q for q in quantities_of(plan) if "later_peak" not in q.key or "later_peak" in self.peaks]

    def _range(self, key, middle):
        entries = [row[key] for row in self.table]
        known = [e for e in entries if math.isfinite(e.value)]
        if not known:
            return Range(*[math.nan] * 5)
        least, lowest = min(e.value - e.spread for e in known), min(e.value for e in known)
        return Range(max(least, 0.0) if lowest >= 0.0 else least, lowest, entries[middle].value, max(e.value for e in known), max(e.upper for e in known),
                     any(e.at_least for e in known))

    def upper(self, keys):
        """(key, its upper value): the greatest of these that is known; (None, NaN) without any."""
        keys = [k for k in keys if k in self.ranges and math.isfinite(self.ranges[k].high)]
        best = max(keys, key=lambda k: self.ranges[k].high, default=None)
        return best, self.ranges[best].high if best else math.nan

    def is_at_least(self, keys):
        """Whether the greatest of these may be greater: one of them is Range.at_least."""
        return any(self.ranges[key].at_least for key in keys if key in self.ranges)

    def headline(self, load, steady_only=False):
        """upper() of a load of HEADLINES. @param steady_only  without first impact and later peak"""
        return self.upper(HEADLINES[load][0 if steady_only else 1])

    def snow_upper(self, snow, part="upper", steady_only=False):
        """(force, moment): the greatest upper values of the headline, of one snow; NaN where there is none. @param part  of Entry: or value"""
        return tuple(max((getattr(e, part) for e in self._known(snow, keys).values()), default=math.nan)
                     for keys in (HEADLINES[load][0 if steady_only else 1] for load in ("force", "moment")))

    def _known(self, snow, keys):
        """{key: Entry} of these that a snow has."""
        return {key: entry for key in keys if (entry := self.table[snow].get(key)) is not None and math.isfinite(entry.value)}

    def scaled_upper(self, plan, snow, force, height, time):
        """snow_upper() with forces, heights above the bed and times multiplied. What the masses of the mast add is computed anew, since the
        modes feel another part of a higher load; relative uncertainties stay."""
        if (force, height, time) == (1.0, 1.0, 1.0):
            return self.snow_upper(snow)
        if not math.isfinite(force):
            return math.nan, math.nan
        key, base = (snow, force, height, time), self.finest[snow].base
        if key not in self.scaled_peaks:
            grown = [{**m, "shape_at_load": m["shape_at_load"] and max(-1.0, min(1.0, m["shape_at_load"] * max(1.0, height) ** 2))} for m in plan["modes"]]
            self.scaled_peaks[key] = self.finest[snow].scaled(force, height, time).vibration_values({**plan, "modes": grown})
        peaks = self.scaled_peaks[key]

        def upper(name, e):
            if name in peaks:
                return peaks[name].value * (e.upper / e.value if e.value else 1.0)
            if name in STATIC_FORCES:
                return force * e.upper
            lifted = base * self.table[snow][name.replace("moment", "force").replace("_n_m", "_n")].upper
            return force * (height * (e.upper - lifted) + lifted)

        return tuple(max((upper(*item) for item in self._known(snow, keys).items()), default=math.nan)
                     for keys in (FORCES, MOMENTS))

    def governing(self, key):
        """Number of the snow whose value plus uncertainty is greatest."""
        return int(np.nanargmax([row[key].upper for row in self.table]))

    def arm_loads(self):
        """{name of a line load: (force, N; height, m)} of the arm: its part of the upper value of the moment when that is reached."""
        found = {}
        for name in ("mean", *self.peaks):
            moment = self.ranges[f"moment_{name}_n_m"].high
            if self.finest[0].has_arm and math.isfinite(moment):
                of = self.finest[self.governing(f"moment_{name}_n_m")]
                force, of_arm, whole = (of.at(name, values, of.smooth_moment) for values in (of.arm.force, of.arm.moment, of.moment))
                found[name] = (moment * force / whole, of_arm / force if force > 0.0 else of.arm_middle)
        return found

    def line_loads(self, plan):
        """(lower edges of z, upper edges, {name: N/m}, {name: arm_loads()}): loads on the mast that have with those on its arm the upper values
        of the page as integral and moment about the ground.

        'mean' and the peaks: the profile of the snow that gives the greatest force, at that time, stretched over height
        and scaled to both. 'with_vibration': the static load that overturns most, and the force of the mast's masses in the first mode.
        """
        height, base = plan["mast"]["height_m"], self.finest[0].base
        z, step, _ = self.finest[0].line_load
        top = max(z[-1] + 0.5 * step, height or 0.0) * 1.25
        edges = step * np.arange(math.ceil(top / step - 1e-9) + 1)
        loads, arm, centre = {}, self.arm_loads(), 0.5 * (edges[1:] + edges[:-1])
        for name in ("mean", *self.peaks):
            force, moment = self.ranges[f"force_{name}_n"].high, self.ranges[f"moment_{name}_n_m"].high
            if math.isfinite(force) and math.isfinite(moment):
                of, (on_arm, at) = self.finest[self.governing(f"force_{name}_n")], arm.get(name, (0.0, 0.0))
                loads[name] = fitted_line(z, of.at(name, of.line_load[2]), edges, force - on_arm, moment - at * on_arm, base)
        (_, force), (_, moment) = self.headline("force"), self.headline("moment")
        statics = list(loads)
        if plan["modes"] and statics:
            static = max(statics, key=lambda name: loads[name] @ centre)
            snow, (on_arm, at) = loads[static], arm.get(static, (0.0, 0.0))
            loads["with_vibration"] = fitted_line(centre, snow, edges, force - on_arm, moment - at * on_arm, base)
            scale = 1.0
            if height:
                masses = self._inertia(plan["mast"], edges)
                system = np.array([[step * snow.sum() + on_arm, step * masses.sum()], [step * snow @ centre + at * on_arm, step * masses @ centre]])
                found, inertia = np.linalg.solve(system, [force, moment])
                if 0.8 <= found <= 1.25:
                    loads["with_vibration"], scale = found * snow + inertia * masses, found
            if arm:
                arm["with_vibration"] = (scale * on_arm, at)
        return edges[:-1], edges[1:], loads, arm

    @staticmethod
    def _inertia(mast, edges):
        """Masses times the shape of the first mode between the edges; that at the top is in the last piece of the mast. Any unit."""
        zeta = 0.5 * (edges[1:] + edges[:-1]) / mast["height_m"]
        along = mass_per_height(zeta, mast.get("taper", 1.0)) * (zeta <= 1.0)
        along[np.flatnonzero(zeta <= 1.0)[-1]] += mast.get("top_mass_ratio", 0.0) * along.sum()
        return along * modes_of(mast)[0].shape(zeta)

    def profile_table(self, ensemble):
        """Columns of pressure_over_height.csv: z_m, and low, middle and high of the snows for each envelope, Pa."""
        finest = [loads.profiles for loads in self.finest]
        columns = {"z_m": finest[0]["z_m"]}
        for key in (*STATIC, "stress"):
            curves = np.array([p[key] for p in finest])
            columns |= {f"{key}_lowest_pa": curves.min(axis=0), f"{key}_middle_pa": curves[ensemble.middle], f"{key}_highest_pa": curves.max(axis=0)}
        return columns
