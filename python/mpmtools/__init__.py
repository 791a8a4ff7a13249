"""libmpm from Python: cases, runs, campaigns and comparisons; figures; the fits and figures of the paper's study.

    from mpmtools import Case, plots
    case = Case.read("examples/avalanche_fr3.toml").changed({"numerics.cell_size_m": 0.35})
    print(case.check())                       # cost, and warnings of what may spoil the result
    run = case.run("out/fr3")                 # a Run; Run("out/fr3") opens it again
    print(run.quantity("runup_p99_mean_m"))   # value, errors and unit; run.results is results.json as a dict
    run.series.runup_p99_m.plot()             # series.csv as a pandas DataFrame over time_s
    run.frames[-1]["position_m"]              # a frame's arrays, read when they are asked for; .table: a DataFrame
    plots.runup(run)                          # figures return matplotlib axes

Cases are run by the program `mpm`: see `find_program`. `python3 -m mpmtools --help` lists the commands. The paper is Kohler, Gaume, Ancey
and Sovilla, "Distinguishing run-up height from pressure distribution during avalanche impact on narrow obstacles"; equation numbers in this
package are the paper's.
"""

import importlib

__version__ = "0.1.0"

# Loaded only when asked for: the pages of the validation do without pandas.
_PLACES = {
    "Case": "case", "Check": "case", "Run": "run", "Frame": "frame", "Quantity": "quantities", "Campaign": "campaign", "CampaignStatus": "campaign", "compare": "comparison",
    "GridStudy": "grid_study", "study_grids": "grid_study", "find_program": "program", "Progress": "program",
    "vtk_arrays": "vtk", "to_pyvista": "vtk", "write_vtp": "vtk", "read_series": "tables", "read_table": "tables",
    "MpmError": "errors", "ConfigError": "errors", "InputError": "errors", "UnstableError": "errors",
}
__all__ = [*_PLACES, "equations", "plots"]


def __getattr__(name):
    if name in _PLACES:
        return getattr(importlib.import_module(f"mpmtools.{_PLACES[name]}"), name)
    if name in ("equations", "plots"):
        return importlib.import_module(f"mpmtools.{name}")
    raise AttributeError(f"module 'mpmtools' has no attribute '{name}'")


def __dir__():
    return sorted({*globals(), *__all__})
