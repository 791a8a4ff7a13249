"""Two runs side by side, by the rules of `mpm compare`."""

import io

import pandas as pd

from mpmtools.errors import InputError
from mpmtools.program import run_program
from mpmtools.run import Run


def compare(a, b, tolerance=None):
    """Compares every quantity of two runs (Run, or result folders). Returns a DataFrame, a row a quantity, with the columns

    a, b        the values
    difference  b - a
    relative    the difference over the larger magnitude
    allowed     twice the combined standard error, or the tolerance, whichever is larger; NaN where it is not judged
    verdict     identical | agrees | DIFFERS | not judged

    tolerance: also allow this relative difference, and judge every quantity.
    Where the steady intervals were found by different columns (measurement.steady_by), the first row, steady_column, names them.
    Raises InputError for a folder without results, ConfigError where nothing can be judged.
    """
    folders = [side.folder if isinstance(side, Run) else str(side) for side in (a, b)]
    options = ["--tolerance", tolerance] if tolerance is not None else []
    _, text, _ = run_program("compare", *folders, "--csv", *options, accepted=(0, 1))
    if not text:
        raise InputError(f"mpm compare printed nothing about {' and '.join(folders)}")
    return pd.read_csv(io.StringIO(text), index_col="quantity", na_values=["nan"], keep_default_na=False, float_precision="round_trip")
