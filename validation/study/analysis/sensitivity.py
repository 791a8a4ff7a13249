"""What one choice at a time does to run-up, pressure height and force (supplement S1 of the paper).

Each run of a table is set against the base's run of the same flow, snow and width of the mast.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from analysis.statistics import ratio_of_means
from mpmtools.errors import InputError
from mpmtools.fit.runs import POINT, number_of
from mpmtools.tables import no_column, numbers, read_table
from mpmtools.wording import counted, verb

AT_MAST = [*POINT, "obstacle_width_m"]
FRICTION, FRICTION_RATIO, BELT_WIDTH = "obstacle_friction", "obstacle_friction_ratio", "conveyor_width_m"
OUTPUTS = {"runup": ("runup_mean_m", "runup_standard_error_m"),
           "pressure_height": ("pressure_height_mean_m", "pressure_height_standard_error_m"),
           "force": ("force_mean_n.x", "force_standard_error_n.x")}
NEEDED = ["name", "status", *AT_MAST, "effective_friction", *(c for pair in OUTPUTS.values() for c in pair), "predicted_runup_m",
          "predicted_pressure_height_m"]


@dataclass
class SensitivityStudy:
    """runs: choice (column that differs from the base, or several joined by ", "; empty for the base), its value, the inputs, heights
    and force over the base's with standard errors, heights over the published equations (Eqs. 7 to 10).
    summaries: a row a value of a choice over all its points: geometric mean, lowest and highest of each ratio, RMSLE of the run-up from
    the published equation, and that of the base at the same points. notes: points without a base, runs that were left out."""

    runs: pd.DataFrame
    summaries: pd.DataFrame
    notes: list


def sensitivities(*paths):
    """Compares the runs of each campaign's results.csv with the base of this campaign.

    Choices are the columns obstacle_friction, obstacle_friction_ratio, cell_size_m, conveyor_width_m and those named after a key
    (`numerics.slope_deg`), durations and rates of output excepted. The base has in each of them the value that most rows have, of the width
    of the belt, which follows the hardening xi, most rows of the same xi; the friction of the mast follows from its ratio where the ratio is
    the base's. A run with another friction is described by the one of the two columns whose value more points share.
    """
    studies = [_sensitivities_of(read_table(path)) for path in paths]
    return SensitivityStudy(pd.concat([of.runs for of in studies], ignore_index=True),
                            pd.concat([of.summaries for of in studies], ignore_index=True), [note for of in studies for note in of.notes])


def _sensitivities_of(table):
    if missing := [column for column in NEEDED if column not in table]:
        raise InputError(no_column(table, *missing))
    choices = choices_of(table)
    shown = table[[*choices, *AT_MAST]].applymap(_shown)
    if BELT_WIDTH in choices:
        usual = shown.groupby("hardening_xi")[BELT_WIDTH].transform(_most_common)
        shown[BELT_WIDTH] = shown[BELT_WIDTH].mask(shown[BELT_WIDTH] == usual, "that of xi")
    differences = _differences(shown, choices)
    values = pd.DataFrame({column: numbers(table, column) for column in NEEDED[2:]})
    steady, done = np.isfinite(values.runup_mean_m), table.status == "done"
    point = shown[AT_MAST].agg(" ".join, axis=1)
    base = point[steady & (differences.map(len) == 0)].drop_duplicates()  # the first row of each point
    of_point = pd.Series(base.index, index=base.to_numpy())
    used = done & steady & point.isin(of_point.index)
    notes = [f"{row['name']}: {'no run of the base with a steady mean at this point' if steady[i] else 'no steady mean of the run-up'}"
             for i, row in table[done & ~used].iterrows()]
    if not done.all():
        notes.append(f"{counted((~done).sum(), 'run')} that {verb((~done).sum(), 'is', 'are')} not done")
    runs = _over_base(values[used], values.loc[of_point[point[used]]].set_axis(values.index[used]))
    runs.insert(0, "choice", [", ".join(choices) for choices in differences[used]])
    runs.insert(1, "value", [", ".join(shown.loc[i, choices]) for i, choices in differences[used].items()])
    return SensitivityStudy(runs, _summaries(runs), notes)


def choices_of(table):
    """Columns that hold a choice: keys (`table.key`, not `vector.x`), but not how long and how often a run writes."""
    keys = [c for c in table if "." in c and c.split(".")[-1] not in ("x", "y", "z") and not c.startswith("output.")]
    return [c for c in table if c in keys or c in (FRICTION, FRICTION_RATIO, BELT_WIDTH, "cell_size_m")]


def _shown(cell):
    """A number as it was meant: without the rounding of having been computed."""
    number = number_of(cell)
    return cell if number is None else f"{number:.6g}"


def _differences(shown, choices):
    """For each row the choices in which it differs from the base, friction first."""
    base = {choice: _most_common(shown[choice]) for choice in choices}
    others = [choice for choice in choices if choice not in (FRICTION, FRICTION_RATIO)]
    differs = shown[others].ne(pd.Series({choice: base[choice] for choice in others}))
    result = pd.Series([list(differs.columns[row]) for row in differs.to_numpy()], index=shown.index)
    if FRICTION_RATIO in base:
        as_base = (shown[FRICTION_RATIO] == base[FRICTION_RATIO]) | ((shown[FRICTION_RATIO] == "nan") & (shown[FRICTION] == "0"))
        sharers = {c: shown[c].map(shown[c].value_counts()) for c in (FRICTION, FRICTION_RATIO)}
        name = np.where(sharers[FRICTION] >= sharers[FRICTION_RATIO], FRICTION, FRICTION_RATIO)
    elif FRICTION in base:
        as_base, name = shown[FRICTION] == base[FRICTION], np.full(len(shown), FRICTION)
    else:
        return result
    return pd.Series([rest if same else [n, *rest] for rest, same, n in zip(result, as_base, name)], index=shown.index)


def _most_common(cells):
    """nan, the ratio of no friction at all, is no choice; of equally common values the first in the alphabet."""
    counts = cells[cells != "nan"].value_counts().sort_index()
    return counts.idxmax() if len(counts) else "nan"


def _over_base(runs, base):
    compared = runs[[*POINT, "effective_friction"]].copy()
    for name, (value, error) in OUTPUTS.items():
        compared[f"{name}_to_base"], compared[f"{name}_standard_error"] = ratio_of_means(runs[value], runs[error], base[value], base[error])
    for name in ("runup", "pressure_height"):
        compared[f"{name}_to_published"] = runs[f"{name}_mean_m"] / runs[f"predicted_{name}_m"]
    return compared


def _summaries(runs):
    """Points without a steady mean of a quantity are left out of its geometric mean."""
    logs = pd.DataFrame({name: np.log(runs[f"{name}_to_base"]) for name in OUTPUTS}).replace(-np.inf, np.nan)
    of_run = np.log(runs.runup_to_published)
    logs["rmsle"], logs["base_rmsle"] = of_run**2, (of_run - logs.runup) ** 2
    groups = logs.groupby([runs.choice, runs.value], sort=False)
    summary = pd.DataFrame({"points": groups.size()})
    for name in OUTPUTS:
        summary[name] = np.exp(groups[name].mean())
        summary[f"{name}_low"], summary[f"{name}_high"] = np.exp(groups[name].min()), np.exp(groups[name].max())
    summary["runup_rmsle"], summary["base_runup_rmsle"] = np.sqrt(groups.rmsle.mean()), np.sqrt(groups.base_rmsle.mean())
    return summary.reset_index()
