"""The folder of a design: its plan, and a Run for each snow and grid."""

import math
import os

from mpmtools.checksums import read_results
from mpmtools.errors import InputError
from mpmtools.run import Run
from mpmtools.wording import counted, verb

FORMAT_VERSION = 1


def snow_cover(plan):
    """Height of the snow cover or deposit under the flow, m. @param plan  design_plan.json as a dict"""
    return plan["flow"].get("snow_cover_m", 0.0)


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
            elif not self._has_site_of(run):
                raise InputError(f"{os.path.join(run.folder, 'case.toml')}: it was altered: its flow or its mast is not that of the site; put back the case of the run")
            self.runs[entry["snow"]][entry["grid"]] = run
        if unfinished:
            raise InputError(f"{counted(len(unfinished), 'run')} {verb(len(unfinished), 'is', 'are')} not finished, or of another site, first "
                             f"{os.path.join(self.folder, 'runs', unfinished[0])}; `mpm design` runs what is missing")

    def _has_site_of(self, run):
        """Whether the case of a run states flow and mast of the plan, by which its loads are scaled."""
        flow, width = self.plan["flow"], self.plan["mast"]["width_m"]
        pairs = ((run.velocity, flow["velocity_m_s"]), (run.flow_height, flow["depth_m"]), (run.obstacle["width_m"], width),
                 (run.case["material"]["density_kg_m3"], flow["density_kg_m3"]))
        arm = {key: value - self.base * (key in ("base_m", "height_m")) for key, value in self.plan.get("arm", {}).items()}
        arm_of_run = run.case.get("arm") or {}
        return arm.keys() == arm_of_run.keys() and all(math.isclose(of_run, of_plan, rel_tol=1e-9)
                                                       for of_run, of_plan in (*pairs, *((arm_of_run[key], arm[key]) for key in arm)))

    def label(self, snow):
        """Of a snow, for figures."""
        return self.plan["snows"][snow]["name"].replace("_", " ")
