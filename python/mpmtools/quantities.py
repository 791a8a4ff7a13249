"""What a run measures: unit and meaning of every column and of every entry of results.json.

quantities.json holds what `mpm schema --results --json` prints (docs/generate.py writes it), so that results can be read without the program.
"""

import functools
import json
import pathlib
import re
from dataclasses import dataclass
from difflib import get_close_matches

import numpy as np

from mpmtools.files import MissingEntry

COMPONENT = re.compile(r"(.+)(?:\.([xyz])|\[([012])\])")  # force_mean_n.x; force_mean_n[0] is understood


@functools.cache
def known():
    """{name: {"unit", "meaning", ...}} of columns of series.csv and profile.csv and of entries of results.json."""
    text = pathlib.Path(__file__).with_name("quantities.json").read_text(encoding="utf-8")
    parts = json.loads(text)
    return {entry["name"]: entry for part in ("profiles", "columns", "results") for entry in parts[part]}


@dataclass(frozen=True)
class Quantity:
    """One entry of results.json.

    value                  a number, or an array of the components x, y, z; None where it is not known
    unit                   "" for a number without one
    meaning                in words
    standard_error         statistical error of a mean; None where there is none
    numerical_uncertainty  the error that the grid may have; None where it is unknown
    """

    name: str
    value: object
    unit: str
    meaning: str
    standard_error: object = None
    numerical_uncertainty: object = None

    def __str__(self):
        text = _text(self.value)
        for value, label in ((self.standard_error, "statistics"), (self.numerical_uncertainty, "grid")):
            if value is not None:
                text += f" ± {_text(value, 2)} ({label})"
        return f"{text} {self.unit}".rstrip()

    def _repr_html_(self):
        return f"<b>{self}</b><br>{self.meaning}"


def quantity(results, name):
    """The Quantity of a name in results.json, or of a component (force_mean_n.x), with its errors. Raises MissingEntry where there is none."""
    if (found := COMPONENT.fullmatch(name)) and isinstance(results.get(found[1], 0.0), (list, type(None))):
        i = "xyz".index(found[2]) if found[2] else int(found[3])
        whole = quantity(results, found[1])
        parts = (None if v is None or np.isnan(v[i]) else float(v[i]) for v in (whole.value, whole.standard_error, whole.numerical_uncertainty))
        value, *errors = parts
        return Quantity(f"{found[1]}.{'xyz'[i]}", value, whole.unit, whole.meaning, *errors)
    if name not in results:
        raise MissingEntry(f"'{name}' is not among the results: {', '.join(get_close_matches(name, results, 5, 0.55) or results)}")
    about = known().get(name, {"unit": "", "meaning": ""})

    def beside(kind):  # runup_mean_m has runup_standard_error_m beside it; force_mean_n has force_x_numerical_uncertainty_n
        if "_mean" not in name:
            return None
        whole = _value(results.get(name.replace("_mean", f"_{kind}", 1)))
        parts = [results.get(name.replace("_mean", f"_{axis}_{kind}", 1)) for axis in "xyz"]
        return _value(parts) if whole is None and any(part is not None for part in parts) else whole

    return Quantity(name, _value(results[name]), about["unit"], about["meaning"], beside("standard_error"), beside("numerical_uncertainty"))


def _value(value):
    return np.array([np.nan if v is None else v for v in value], float) if isinstance(value, list) else value


def _text(value, digits=4):
    if value is None:
        return "unknown"
    if isinstance(value, np.ndarray):
        return "(" + ", ".join("-" if np.isnan(v) else _text(float(v), digits) for v in value) + ")"
    return f"{value:.{digits}g}" if isinstance(value, float) else str(value)
