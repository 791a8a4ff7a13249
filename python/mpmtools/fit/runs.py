"""Tables of runs (results.csv of campaigns) as one DataFrame of the quantities that the study compares."""

import os
import re
from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from mpmtools import equations
from mpmtools.errors import ConfigError, InputError
from mpmtools.quantities import COMPONENT, known
from mpmtools.scores import levels, same_input
from mpmtools.tables import find_column, no_column, numbers, read_table
from mpmtools.wording import counted

PAPER_DENSITY = 300.0  # kg/m^3, Table 1: campaigns that do not vary it do not list it
# Inputs that Eqs. 7 to 10 know or that follow from others; one equation cannot describe a table that varies any other one.
EQUATIONS_KNOW = ("froude_number", "velocity_m_s", "flow_height_m", "gravity_m_s2", "critical_state_slope", "cohesion_beta", "effective_friction",
                  "hardening_xi", "plastic_compressibility", "obstacle_width_m", "obstacle.width_m", "relative_width", "obstacle_friction_ratio")
COARSER = "the same set-up is there on a finer grid"
POINT = ["froude_number", "critical_state_slope", "cohesion_beta", "hardening_xi"]  # flow and snow: what the study varies
SET_UP = [*POINT, "flow_height_m", "obstacle_width_m"]  # what makes two runs one set-up, whatever their grid


@dataclass
class StudyTable:
    """What the tables hold. `runs` has a row for each run with a steady run-up:

    folder                                              of the run; empty where the table names none
    froude_number, critical_state_slope, cohesion_beta, hardening_xi, effective_friction
    flow_height_m, obstacle_width_m, velocity_m_s, gravity_m_s2, relative_width (w/H)
    runup, runup_standard_error, runup_peak             over the flow height H
    pressure_height, pressure_height_standard_error, pressure_height_peak
    runup_numerical_uncertainty, pressure_height_numerical_uncertainty   of grid and time step, over H; NaN where a table has none
    compaction                                          density at the front face of the mast over the initial density
    cell_size_m, obstacle_friction, planned_duration_s  NaN where not in the table
    force_n, density_kg_m3                              mean force along the flow on the mast; initial density, the paper's where not in the table
    at_reference_width                                  w = H, the set-up of Eqs. 7 to 10
    """

    runs: pd.DataFrame
    rows: int  # of the files
    left_out: dict = field(default_factory=dict)  # reason: number of rows
    cautions: list = field(default_factory=list)  # inputs that vary although the equations do not know them
    files: list = field(default_factory=list)
    provenance: list = field(default_factory=list)  # who computed the runs, and how
    coarser: pd.DataFrame = field(default_factory=pd.DataFrame)  # as `runs`: steady, and left out because the same set-up is there on a finer grid


class RowFilter:
    """A condition on a column, `column OP value[,value...]`, OP one of = != < <= > >=.

    hardening_xi=0.5,5 keeps rows with either. Cells are compared as numbers where both are numbers, else as text (= and != only).
    """

    PATTERN = re.compile(r"\s*([^=!<>]+?)\s*(!=|<=|>=|=|<|>)\s*([^=!<>].*)")

    def __init__(self, text):
        self.text = text
        match = self.PATTERN.fullmatch(text)
        if not match:
            raise ConfigError(f"--filter '{text}': a condition is `column OP value[,value]`, OP one of = != < <= > >=")
        self.column, self.operator, values = match.groups()
        self.values = [value.strip() for value in values.split(",")]
        if self.operator not in ("=", "!=") and (len(self.values) > 1 or number_of(self.values[0]) is None):
            raise ConfigError(f"--filter '{text}': {self.operator} needs one number")

    def keeps(self, cell):
        if self.operator in ("=", "!="):
            return any(_equal(cell, value) for value in self.values) == (self.operator == "=")
        if not cell:
            return False
        number, limit = number_of(cell), number_of(self.values[0])
        if number is None:
            raise ConfigError(f"--filter '{self.text}': '{cell}' in the table is no number; use = or !=")
        return {"<": number < limit, "<=": number <= limit or same_input(number, limit),
                ">": number > limit, ">=": number >= limit or same_input(number, limit)}[self.operator]


def number_of(cell):
    try:
        return float(cell)
    except ValueError:
        return None


def _equal(cell, value):
    a, b = number_of(cell), number_of(value)
    return cell == value if a is None or b is None else bool(same_input(a, b))


def read_study_table(files, filters=(), finest=False):
    """Reads tables and puts their rows together. `finest`: of the rows of one set-up only that on the finest grid counts.

    A column is found by its name (`hardening_xi`), else by the one that ends in it (`material.hardening_xi`). Needed are
    froude_number or velocity_m_s; effective_friction, or critical_state_slope and cohesion_beta; hardening_xi; flow_height_m;
    runup_mean_m; pressure_height_mean_m. Used where there: run or name (folder beside the table), obstacle.width_m or
    obstacle_width_m (else w = H), gravity_m_s2, force_mean_n.x, density_kg_m3, standard errors and peaks of the heights, compaction_mean, steady, status.
    """
    tables = read_tables_once(files)
    parts, reasons = [], []
    for table, given_before in tables:
        if finest and not find_column(table, "cell_size_m"):
            raise ConfigError(f"finest grid: {no_column(table, 'cell_size_m')}")
        runs = _runs_of(table)
        reason = _why_left_out(table, runs)
        for condition in filters:
            reason = reason.mask(~_kept(table, condition) & ~reason.str.startswith("filter "), f"filter {condition.text}")
        parts.append(runs.join(_other_inputs(table)))
        reasons.append(reason.mask(given_before, "the same row as one before"))
    runs, reason = pd.concat(parts, ignore_index=True), pd.concat(reasons, ignore_index=True)
    if finest:
        reason = reason.mask(_comes_after_another(runs, reason, levels(runs.cell_size_m)), COARSER)
    kept, coarser = (runs[reason == of].reset_index(drop=True) for of in ("", COARSER))
    shown = [column for column in runs if not column.startswith("other ")]
    return StudyTable(runs=kept[shown],
                      coarser=coarser[np.isfinite(coarser.runup)][shown].reset_index(drop=True),
                      rows=len(runs),
                      left_out=reason[reason != ""].value_counts(sort=False).to_dict(),
                      cautions=_cautions(kept.drop(columns="other cell_size_m", errors="ignore") if finest else kept),
                      files=[str(path) for path in files],
                      provenance=[line for table, _ in tables for line in _provenance(table)])


def read_tables_once(files):
    """[(table as text, which of its rows came before, in this table or an earlier one)]; the same file named twice is refused."""
    for i, path in enumerate(files):
        if os.path.realpath(path) in (os.path.realpath(other) for other in files[:i]):
            raise ConfigError(f"'{path}' is given twice, and its runs would count twice; name each table once")
    tables = [read_table(path) for path in files]
    given_before = np.split(pd.concat(tables).duplicated().to_numpy(), np.cumsum([len(table) for table in tables])[:-1])
    return [(table, pd.Series(before, index=table.index)) for table, before in zip(tables, given_before)]


def _require_columns(table):
    """All that are missing in one message."""
    needed = ["hardening_xi", "flow_height_m", "runup_mean_m", "pressure_height_mean_m"]
    if not find_column(table, "velocity_m_s"):
        needed.append("froude_number")
    if not find_column(table, "effective_friction"):
        needed += ["critical_state_slope", "cohesion_beta"]
    missing = [name for name in needed if not find_column(table, name)]
    if missing:
        instead = {"froude_number": "velocity_m_s", "critical_state_slope": "effective_friction"}
        hints = [f"; {other} will do in place of {name}" for name, other in instead.items() if name in missing]
        raise InputError(no_column(table, *missing) + "".join(hints))


def _runs_of(table):
    _require_columns(table)

    def column(*names):
        """Numbers of the first of these columns that there is, else NaN."""
        found = next((c for name in names if (c := find_column(table, name))), None)
        return numbers(table, found) if found else pd.Series(np.nan, index=table.index)

    here = os.path.dirname(table.attrs["path"])
    folders = [os.path.join(here, name) if name else "" for name in _text(table, "run", "name")]
    height, gravity = column("flow_height_m"), column("gravity_m_s2").fillna(equations.STANDARD_GRAVITY)
    runs = pd.DataFrame({
        "folder": folders, "hardening_xi": column("hardening_xi"), "flow_height_m": height, "gravity_m_s2": gravity,
        "obstacle_width_m": column("obstacle.width_m", "obstacle_width_m").fillna(height), "froude_number": column("froude_number"),
        "velocity_m_s": column("velocity_m_s"), "critical_state_slope": column("critical_state_slope"),
        "cohesion_beta": column("cohesion_beta"), "effective_friction": column("effective_friction"), "compaction": column("compaction_mean"),
        "cell_size_m": column("cell_size_m"), "force_n": column("force_mean_n.x"), "density_kg_m3": column("density_kg_m3").fillna(PAPER_DENSITY),
        "obstacle_friction": column("obstacle_friction", "obstacle.friction"), "planned_duration_s": column("output.duration_s"),
    }, index=table.index)
    if find_column(table, "froude_number"):
        runs["velocity_m_s"] = equations.flow_velocity(runs.froude_number, height, gravity)
    else:
        runs["froude_number"] = equations.froude_number(runs.velocity_m_s, height, gravity)
    if not find_column(table, "effective_friction"):
        runs["effective_friction"] = equations.effective_friction(runs.critical_state_slope, runs.cohesion_beta)
    for name in ("runup", "pressure_height"):
        runs[name] = _height(table, column, f"{name}_mean_m") / height
        runs[f"{name}_standard_error"] = column(f"{name}_standard_error_m") / height
        runs[f"{name}_peak"] = column(f"{name}_peak_m") / height
        runs[f"{name}_numerical_uncertainty"] = column(f"{name}_numerical_uncertainty_m") / height
    runs["relative_width"] = runs.obstacle_width_m / height
    runs["at_reference_width"] = same_input(runs.relative_width, 1.0)
    return runs


def _height(table, column, name):
    """A column of mean heights, NaN where there is none; refuses others that are not positive and finite."""
    values = column(name)
    wrong = (values <= 0.0) | np.isinf(values)
    if wrong.any():
        raise InputError(f"{table.attrs['path']}:{wrong.idxmax()}: column '{name}' holds {values[wrong.idxmax()]:g}; a mean height is positive and finite")
    return values


def _text(table, *names):
    """Cells of the first of these columns that there is, else empty."""
    found = next((c for name in names if (c := find_column(table, name))), None)
    return table[found] if found else pd.Series("", index=table.index)


def _why_left_out(table, runs):
    """Why a row has no steady run-up, in the table's own words where it has some; empty for the rows that are kept."""
    status, steady = _text(table, "status"), _text(table, "steady")
    inputs = runs[["froude_number", "effective_friction", "hardening_xi", "flow_height_m", "obstacle_width_m"]]
    reason = pd.Series("", index=table.index)
    no_mean = ~np.isfinite(runs.runup)
    reason[no_mean] = "no steady mean of the run-up"
    reason[no_mean & steady.isin(["false", "0"])] = "no steady span"
    stopped = no_mean & ~status.isin(["", "ok", "done", "finished"])
    reason[stopped] = "status: " + status[stopped]
    reason[~np.isfinite(inputs).all(axis=1)] = "an input is missing"
    return reason


def _comes_after_another(runs, reason, order):
    """Which rows that were computed to their end, with a steady mean or not, have such a row of the same set-up that is lower in `order`."""
    computed = reason.isin(["", "no steady mean of the run-up", "no steady span"])
    inputs = [levels(runs[name]) for name in SET_UP]
    return computed & (order > order.where(computed).groupby(inputs, dropna=False).transform("min"))


def _kept(table, condition):
    column = find_column(table, condition.column)
    if not column:
        raise ConfigError(f"--filter '{condition.text}': {no_column(table, condition.column)}")
    return table[column].map(condition.keeps)


def _other_inputs(table):
    in_equations = {find_column(table, name) for name in EQUATIONS_KNOW}
    columns = {f"other {column}": table[column] for column in table if _is_input(column) and column not in in_equations}
    if ratio := find_column(table, "obstacle_friction_ratio"):
        columns["other obstacle_friction_ratio"] = numbers(table, ratio)
    return pd.DataFrame(columns, index=table.index)


def _is_input(column):
    """Whether a column says what was computed: no result, no text of the campaign, and nothing of [output], which only says how long and how often."""
    is_result = COMPONENT.fullmatch(column) or column in known() and column != "precision"
    return not (is_result or column in ("name", "run", "campaign", "status", "cause") or column.startswith("output."))


def _cautions(kept):
    """Inputs of the kept runs that vary although the equations do not know them."""
    varied = {column.removeprefix("other "): found for column in kept if column.startswith("other ") and len(found := _distinct(kept[column])) > 1}
    ratios = kept.get("other obstacle_friction_ratio", pd.Series(dtype=float))
    varied.pop("obstacle_friction_ratio", None)
    if ratios[np.isfinite(ratios)].map("{:.6g}".format).nunique() == 1:
        varied.pop("obstacle_friction", None)  # one choice: the friction of the mast follows that of the snow
    if "numerics.precision" in varied:
        varied.pop("precision", None)
    return [f"{name} varies ({', '.join(values[:6] + ['...'] * (len(values) > 6))}), which the equations do not know; "
            f"choose one with --filter '{name}=...'" for name, values in varied.items()]


def _distinct(column):
    """The different cells of a column, numbers by size. No cell and an empty one are a value: that of a key which the case leaves out."""
    found = []
    for cell in sorted(column.fillna("").astype(str).unique(), key=lambda text: (number_of(text) is None, number_of(text) or 0.0, text)):
        if not found or not _equal(cell, found[-1]):
            found.append(cell)
    return [cell or "not given" for cell in found]


def _provenance(table):
    """Comments of the table, machines and time of the campaign (runs.csv beside it), versions that computed the runs."""
    lines = list(table.attrs["comments"])
    executions = os.path.join(os.path.dirname(table.attrs["path"]), "runs.csv")
    if os.path.exists(executions):
        lines += _executions(read_table(executions))
    if find_column(table, "version"):
        program = table[table["version"] != ""].groupby(["version", "commit"] if "commit" in table else ["version"])
        for key, rows in program:
            version, commit = (*([key] if isinstance(key, str) else key), "")[:2]
            lines.append(f"{counted(len(rows), 'run')} by version {version}" + (f", commit {commit}" if commit else ""))
    return lines


def _executions(table):
    lines = []
    if {"instruction_set", "compiler", "threads"} <= set(table):
        machine = table.threads + " thread(s) a run, " + table.instruction_set + ", " + table.compiler
        lines = [f"{counted(count, 'run')} with {name}" for name, count in machine[table.threads != ""].value_counts().sort_index().items()]
    if "wall_time_s" in table:
        lines.append(f"{numbers(table, 'wall_time_s').sum() / 3600.0:.1f} h of wall time, summed over the runs")
    return lines


def read_runs_or_refuse(files, filters=(), finest=False):
    """As read_study_table(); refuses tables of which no run is left."""
    table = read_study_table(files, filters, finest)
    if table.runs.empty:
        reasons = "; ".join(f"{rows} {reason}" for reason, rows in table.left_out.items())
        raise ConfigError(f"{', '.join(map(str, files))}: no run with a steady run-up is left of {counted(table.rows, 'row')}" + (f" ({reasons})" if reasons else ""))
    return table
