"""One result folder of `mpm run`: results, tables and frames."""

import os
import shlex
from functools import cached_property

import pandas as pd

from mpmtools import equations, quantities
from mpmtools.checksums import read_results, read_table_of
from mpmtools.errors import InputError
from mpmtools.case import Case
from mpmtools.files import read_json
from mpmtools.frame import Frame, open_hdf5


def _of_case(key, default, text):
    return property(lambda run: run.case.get(key, default), doc=text)


class Run:
    """What a result folder holds; every part is read when it is first asked for.

    case      the resolved case.toml as a Case: run.case["numerics.cell_size_m"]
    results   results.json as a dict; empty where the run has not written it
    series    series.csv as a DataFrame over time_s, a row a sample (columns with units: runup_p99_m, force_x_n, ...); empty without it
    profile   profile.csv, the mean pressure on the mast over its height (z_m, pressure_pa, ...); empty without a steady span
    profiles  profiles.h5, {"pressure_pa": DataFrame, a row a sample over time_s and a column a height z_m, ...}; empty without it
    frames    list of Frame, in order of time
    final     the last state (final.h5) as a Frame; None without it

    `fallback` is a folder that is looked at for the files that the run itself lacks, such as what `mpm post` wrote.
    """

    def __init__(self, folder, fallback=None):
        self.folder, self.fallback = str(folder), fallback
        if not os.path.exists(os.path.join(self.folder, "case.toml")):
            raise InputError(f"{self.folder}: there is no case.toml; give the result folder of `mpm run`")

    def __repr__(self):
        return f"Run({self.folder!r})"

    @cached_property
    def case(self):
        return Case.read(os.path.join(self.folder, "case.toml"))

    @cached_property
    def results(self):
        path = self._find("results.json")
        return read_results(path) if path else {}

    @cached_property
    def series(self):
        table = self._table("series.csv")
        return table.set_index("time_s") if "time_s" in table else table

    @cached_property
    def profile(self):
        return self._table("profile.csv")

    @cached_property
    def profiles(self):
        path = self._find("profiles.h5")
        if not path:
            return {}
        with open_hdf5(path) as file:
            time, height = pd.Index(file["time_s"][:], name="time_s"), pd.Index(file["z_m"][:], name="z_m")
            return {name: pd.DataFrame(file[name][:], time, height) for name in file if name not in ("time_s", "z_m")}

    @cached_property
    def frames(self):
        folder = os.path.join(self.folder, "frames")
        names = sorted(os.listdir(folder)) if os.path.isdir(folder) else []
        return [Frame(os.path.join(folder, name)) for name in names if name.endswith(".h5") and name[:-3].isdigit()]

    def require_frames(self):
        """The frames; an InputError that says how to get some where there are none."""
        if not self.frames:
            again = f"mpm run {shlex.quote(os.path.join(self.folder, 'case.toml'))} --out OTHER --set output.frames_per_second=1"
            of_campaign = os.path.exists(os.path.join(self.folder, "attempts.json"))
            raise InputError(f"{self.folder}: the run stored no frames; " + (
                f'a campaign keeps those of its runs with keep = ["frames"] in its plan; this run alone: {again}' if of_campaign
                else "set output.frames_per_second above 0"))
        return self.frames

    @property
    def final(self):
        path = os.path.join(self.folder, "final.h5")
        return Frame(path) if os.path.exists(path) else None

    def quantity(self, name):
        """An entry of results.json with unit, meaning and errors: print(run.quantity("runup_p99_mean_m")), or "force_mean_n.x" of a vector.
        MissingEntry, an InputError and a KeyError, where there is none."""
        return quantities.quantity(self.results, name)

    @property
    def quantities(self):
        """All numbers of results.json, as a list of Quantity."""
        return [self.quantity(name) for name, value in self.results.items() if not isinstance(value, (str, bool))
                and "_standard_error" not in name and "_effective_samples" not in name and "_numerical_uncertainty" not in name]

    @property
    def units(self):
        """{column or entry: unit} of series, profile and results."""
        return {name: quantities.known()[name]["unit"] for name in (*self.series, *self.profile, *self.results) if name in quantities.known()}

    def number(self, key):
        """A number of results.json, or a component of a vector; None where there is none."""
        try:
            value = self.quantity(key).value
        except KeyError:
            return None
        return value if isinstance(value, (int, float)) and not isinstance(value, bool) else None

    def is_finished(self, case_hash, end=None):
        """Did the run itself finish, and is it of the case with this hash? end: s, that it must have reached unless output.stop_when_steady
        ended it; None: any."""
        results = self.results
        if results.get("case_hash") != case_hash or "measured_from" in results:  # the latter: by mpm post, from frames
            return False
        missing = 0.0 if end is None else end - (self.number("duration_s") or 0.0)
        return abs(missing) <= 1e-9 * (end or 0.0) or (missing > 0.0 and bool(results.get("stopped_when_steady")))

    def require(self, case_hash, remedy):
        """This run, if is_finished(case_hash); else InputError, which ends in the remedy."""
        if not self.is_finished(case_hash):
            raise InputError(f"{self.folder}: it does not hold the finished run of the case with hash {case_hash}; {remedy}")
        return self

    # ---- the set-up ----

    title = _of_case("title", "", "Of the case.")
    gravity = _of_case("numerics.gravity_m_s2", 9.81, "m/s^2.")
    obstacle = _of_case("obstacle", None, "The table [obstacle]; None in a case without one.")
    flow_height = _of_case("conveyor.flow_height_m", None, "H, m; None without a conveyor.")

    @property
    def cell_size(self):
        """m."""
        return self.case["numerics.cell_size_m"]

    @property
    def particle_spacing(self):
        """Of the lattice at the start, m."""
        return self.cell_size / round(self.case.get("numerics.particles_per_cell", 8) ** (1.0 / 3.0))

    @cached_property
    def _solids(self):
        """(corners, base, top) of the obstacle and, if it has one, of its arm, as in obstacle.json; None: on the ground, taller than any jet."""
        path = self._find("obstacle.json")
        if not path:
            raise InputError(f"{self.folder}: there is no obstacle.json with the outline of the obstacle; `mpm post` writes it")
        try:
            obstacle = read_json(path)
            return [([(float(x), float(y)) for x, y in solid["outline_m"]], solid.get("base_m"), solid.get("top_m"))
                    for solid in (obstacle, *([obstacle["arm"]] if "arm" in obstacle else []))]
        except (KeyError, ValueError, TypeError) as error:
            raise InputError(f"{path}: {error}") from None

    @property
    def obstacle_outline(self):
        """Corners (x, y), m, counter-clockwise from above, of the obstacle, whose most upstream point is at x = 0. From obstacle.json."""
        return self._solids[0][0]

    def solids(self, ground, sky):
        """[(corners, foot, top), ...], m, of the obstacle and of its arm in a picture; corners as in obstacle_outline. None: no obstacle.

        @param ground, sky  foot of what stands on the ground, top of what is taller than any jet
        """
        return [(corners, base or ground, sky if top is None else top) for corners, base, top in self._solids] if self.obstacle is not None else []

    @property
    def obstacle_depth(self):
        """Along the flow, m."""
        return max(x for x, _ in self.obstacle_outline)

    @property
    def obstacle_width(self):
        """Across the flow, m; for a turned box more than its width_m."""
        return 2.0 * max(y for _, y in self.obstacle_outline)

    @property
    def velocity(self):
        """v of the inflow, m/s; None without a conveyor."""
        conveyor = self.case.get("conveyor")
        if not conveyor:
            return None
        if "velocity_m_s" in conveyor:
            return conveyor["velocity_m_s"]
        return conveyor["froude_number"] * (self.gravity * self.flow_height) ** 0.5

    @property
    def outside_of_equations(self):
        """What this impact has that the paper's equations were not fitted to, as a list of texts; empty: nothing, or no impact."""
        conveyor, obstacle, snow = self.case.get("conveyor"), self.obstacle, self.case.get("material", {})
        if not conveyor or not obstacle:
            return []
        slope, beta = snow.get("critical_state_slope"), snow.get("cohesion_beta", 0.0)
        friction = None if slope is None else float(equations.effective_friction(slope, beta))
        width, shape = equations.across_flow(obstacle.get("shape", "box"), obstacle["width_m"], obstacle.get("depth_m"), obstacle.get("rotation_deg", 0.0))
        return equations.outside_of_fit(width / self.flow_height, self.velocity / (self.gravity * self.flow_height) ** 0.5, shape, friction, snow.get("hardening_xi"))

    @property
    def mirrored_y(self):
        """Is half of the domain computed, mirrored at y = 0?"""
        if "conveyor" in self.case:
            return bool(self.case.get("conveyor.mirror_y", True))
        return "y" in self.case.get("domain.mirror", [])

    def _find(self, name):
        folders = [folder for folder in (self.folder, self.fallback) if folder]
        return next((path for folder in folders if os.path.exists(path := os.path.join(folder, name))), None)

    def _table(self, name):
        path = self._find(name)
        if not path:
            return pd.DataFrame()
        table = read_table_of(path)
        for column in table.columns[table.dtypes == object] if len(table) else ():  # a table without rows has no types
            raise InputError(f"{path}: column '{column}' holds what is no number; compute the run again")
        return table
