"""The folder of a design: its plan, and a Run for each snow and grid."""

import copy
import math
import os

from mpmtools import equations
from mpmtools.checksums import read_results
from mpmtools.errors import InputError
from mpmtools.run import Run
from mpmtools.wording import counted, verb

FORMAT_VERSION = 1


def snow_cover(plan):
    """Height of the snow cover or deposit under the flow, m. @param plan  design_plan.json as a dict"""
    return plan["flow"].get("snow_cover_m", 0.0)


def across_flow(plan):
    """(width across the flow, m; shape) of the mast as it is turned: equations.across_flow()."""
    mast = plan["mast"]
    return equations.across_flow(mast["shape"], mast["width_m"], mast.get("depth_m"), mast.get("angle_deg", 0.0))


class Ensemble:
    """The plan of a design and its runs.

    plan    design_plan.json as a dict
    runs    runs[snow][grid]: Run, snows and grids (coarse first) in the order of the plan
    sizes   of the cells, m, coarse first
    base    snow_cover() of the plan, m
    bound   Bernoulli's H + v^2/2g above the bed, m from the ground, which the steady mean of the run-up cannot pass
    middle  number of the snow in the middle of the range, by M'
    """

    def __init__(self, folder):
        self.folder = str(folder)
        path = os.path.join(self.folder, "design_plan.json")
        if not os.path.exists(path):
            raise InputError(f"{path}: there is no such file; give the folder of `mpm design`")
        self.plan = read_results(path, "run `mpm design` again")
        if self.plan.get("format_version") != FORMAT_VERSION:
            raise InputError(f"{path}: format version {self.plan.get('format_version')}, this program reads {FORMAT_VERSION}")
        flow, snows = self.plan["flow"], self.plan["snows"]
        self.sizes = [grid["cell_size_m"] for grid in self.plan["grids"]]
        self.base = snow_cover(self.plan)
        self.bound = self.base + flow["depth_m"] + flow["velocity_m_s"] ** 2 / (2.0 * flow["gravity_m_s2"])
        self.middle = sorted(range(len(snows)), key=lambda snow: snows[snow]["effective_friction"])[(len(snows) - 1) // 2]
        self.runs = [[None] * len(self.sizes) for _ in snows]
        unfinished = []
        for entry in self.plan["runs"]:
            if "case_hash" not in entry:
                raise InputError(f"{path}: it does not name the cases of its runs, as an older version wrote it; `mpm design SITE --page` writes it again")
            folder = os.path.join(self.folder, "runs", entry["name"])
            run = Run(folder) if os.path.exists(os.path.join(folder, "results.json")) else None
            if run is None or not run.is_finished(entry["case_hash"], entry["end_s"]):
                unfinished.append(entry["name"])
            elif difference := self._difference(run, snows[entry["snow"]], self.sizes[entry["grid"]]):
                raise InputError(f"{os.path.join(run.folder, 'case.toml')}: it is not of the site: {difference}; put back the case of the run, or compute the design again "
                                 "without a change by --set")
            self.runs[entry["snow"]][entry["grid"]] = run
        if unfinished:
            raise InputError(f"{counted(len(unfinished), 'run')} {verb(len(unfinished), 'is', 'are')} not finished, or of another site, first "
                             f"{os.path.join(self.folder, 'runs', unfinished[0])}; `mpm design` runs what is missing")

    @property
    def wall_minutes(self):
        """Of all runs together."""
        return sum(run.number("wall_time_s") or 0.0 for row in self.runs for run in row) / 60.0

    def raised(self, by):
        """The same runs on a snow cover that is higher. @param by  m"""
        other = copy.copy(self)
        other.base, other.bound = self.base + by, self.bound + by
        return other

    def _difference(self, run, snow, size):
        """What in the case of a run is not that of the plan, which the page describes and by which loads are scaled, in words; empty: nothing."""
        flow, mast, case = self.plan["flow"], self.plan["mast"], run.case
        site = {"conveyor.velocity_m_s": flow["velocity_m_s"], "conveyor.flow_height_m": flow["depth_m"], "numerics.gravity_m_s2": flow["gravity_m_s2"],
                "numerics.slope_deg": 0.0, "numerics.cell_size_m": size, "obstacle.rotation_deg": mast.get("angle_deg", 0.0),
                "obstacle.height_m": None if mast["height_m"] is None else mast["height_m"] - self.base, "material.density_kg_m3": flow["density_kg_m3"],
                **{f"obstacle.{key}": mast[key] for key in ("shape", "width_m", "friction", *["depth_m"] * (mast["shape"] == "box"))},
                **{f"material.{key}": snow[key] for key in ("critical_state_slope", "cohesion_beta", "hardening_xi")},
                **{f"arm.{key}": None for key in case.get("arm", {})},
                **{f"arm.{key}": value - self.base * (key in ("base_m", "height_m")) for key, value in self.plan.get("arm", {}).items()}}
        of_run = {"conveyor.velocity_m_s": run.velocity, "numerics.gravity_m_s2": run.gravity, "numerics.slope_deg": 0.0, "obstacle.rotation_deg": 0.0, **case}
        for key, planned in site.items():
            computed = of_run.get(key)
            numbers = not isinstance(planned, str) and None not in (computed, planned)
            if not (math.isclose(computed, planned, rel_tol=1e-9, abs_tol=1e-12) if numbers else computed == planned):
                given, expected = ("left out" if value is None else value for value in (computed, planned))
                return f"{key} is {given}, by the site {expected}"
        return ""

    def label(self, snow):
        """Of a snow, for figures."""
        return self.plan["snows"][snow]["name"].replace("_", " ")
