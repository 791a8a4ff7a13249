"""A grid study: one case at several cell sizes, by `mpm converge` (docs/grid-studies.md)."""

import os

from mpmtools.errors import InputError
from mpmtools.files import MissingEntry, read_json
from mpmtools.program import run_with_bar
from mpmtools.run import Run
from mpmtools.tables import read_series


class GridStudy:
    """What `mpm converge` has written into a folder.

    table    a row a grid: cell_size_m, each metric, and its standard error as "<metric>:standard_error"
    results  converge.json: for each metric the observed orders, the limit, the uncertainty and the verdict
    """

    def __init__(self, folder):
        self.folder = str(folder)
        try:
            self.results = read_json(os.path.join(self.folder, "converge.json"))
        except InputError as error:
            raise InputError(f"{self.folder}: no converge.json that can be read ({error}); give the folder of `mpm converge`") from None
        self.table = read_series(os.path.join(self.folder, "converge.csv"))

    def __repr__(self):
        return f"GridStudy({self.folder!r})"

    @property
    def runs(self):
        """The Run of every grid, in the order of the table. Raises InputError where a folder holds another case than the study had there."""
        return [Run(os.path.join(self.folder, point["directory"])).require(point["case_hash"], "run `mpm converge` again")
                for point in self.results["points"]]

    def metric(self, name):
        """What is known about one metric, as a dict. Raises MissingEntry where it was not studied."""
        found = {metric["name"]: metric for metric in self.results["metrics"]}
        if name not in found:
            raise MissingEntry(f"'{name}' was not studied; there are: {', '.join(found)}")
        return found[name]


def study_grids(case, cell_sizes, metrics, out, threads=None, progress=True):
    """Runs a Case at several cell sizes (m) into the folder `out`, and keeps what an earlier call has computed. Returns the GridStudy.

    metrics: names of results.json; components as "force_mean_n.x". progress: True (a bar over all grids), a function of a Progress, or False.
    """
    options = ["--cell-size", ",".join(repr(float(size)) for size in cell_sizes), "--metric", ",".join(metrics), "--out", out,
               *(["--threads", threads] if threads else [])]
    with case.as_file() as path:
        run_with_bar("grids", progress, "converge", path, *options)
    return GridStudy(out)
