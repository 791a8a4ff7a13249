"""Runs of `mpm` as data frames; the fits, scores and figures of the paper's study.

    from mpmtools import Run
    run = Run("out/avalanche_fr3")
    run.results["runup_mean_m"]         # results.json as a dict
    run.series.plot("time_s", "runup_m")  # series.csv as a pandas DataFrame
    run.frames[-1]["position_m"]        # a frame's arrays, read when they are asked for

`python3 -m mpmtools --help` lists the commands. The paper is Kohler, Gaume, Ancey and Sovilla, "Distinguishing run-up height
from pressure distribution during avalanche impact on narrow obstacles"; equation numbers in this package are the paper's.
"""

__version__ = "0.1.0"
__all__ = ["Run", "read_series", "read_table"]


def __getattr__(name):
    """Loads what needs pandas only when it is asked for: the pages of the validation do without."""
    if name == "Run":
        from mpmtools.run import Run

        return Run
    if name in ("read_series", "read_table"):
        from mpmtools import tables

        return getattr(tables, name)
    raise AttributeError(f"module 'mpmtools' has no attribute '{name}'")
