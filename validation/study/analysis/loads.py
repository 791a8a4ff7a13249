"""Loads beyond the paper as factors: cross-sections, sheared inflow and inclined fronts, cross-arms; from the rows of the plans in ../extensions.

A table of factors has a row for each kind, name and quantity in each flow (Fr, M'): factor, uncertainty (two standard errors, and the numerical
uncertainties that the rows state, of both values; nan where a row states none). `mpm design` reads it: mpmtools/design/factors.py, beside which
./run study --write puts the table.
"""

import functools

import numpy as np
import pandas as pd

from analysis.study import ROWS
from mpmtools.scores import levels

FILES = {"shape": "shapes", "front": "fronts", "arm": "arms"}  # in rows/, of the plans in extensions/
FLOW = ["froude_number", "effective_friction"]
ARM_LENGTH = 5.25  # m, as arms.toml has it
# Of each quantity the columns of its value, its standard error and its numerical uncertainty.
VALUES = {
    "force": ("force_mean_n.x", "force_standard_error_n.x", "force_x_numerical_uncertainty_n"),
    "moment": ("overturning_moment_mean_n_m", "overturning_moment_standard_error_n_m", "overturning_moment_numerical_uncertainty_n_m"),
    "runup": ("runup_p99_mean_m", "runup_p99_standard_error_m", "runup_p99_numerical_uncertainty_m"),
    "pressure_height": ("pressure_height_mean_m", "pressure_height_standard_error_m", "pressure_height_numerical_uncertainty_m"),
}


def cross_section(row):
    """The name of an obstacle's plan: a square with its angle to the flow, a wedge with half the angle of its edge."""
    if row["obstacle.shape"] == "wedge":
        return f"wedge_{np.degrees(np.arctan(row['obstacle_width_m'] / (2.0 * row['obstacle.depth_m']))):.0f}"
    if row["obstacle.shape"] == "cylinder":
        return "cylinder"
    return f"square_{row['obstacle.rotation_deg']:.0f}" if row["obstacle.rotation_deg"] > 0.0 else "square"


def read_rows(path):
    """Finished runs with a steady mean; columns that no run has are nan."""
    table = pd.read_csv(path, comment="#")
    wanted = [column for columns in VALUES.values() for column in columns]
    wanted += ["obstacle.rotation_deg", "obstacle.depth_m", "conveyor.inflow_slip_ratio", "conveyor.front_angle_deg"]
    table = table.reindex(columns=[*table.columns, *(name for name in wanted if name not in table)])
    table = table[(table.status == "done") & (table.steady == 1)]
    return table.assign(froude_number=levels(table.froude_number), effective_friction=table.effective_friction.round(3))


def relative_error(row, quantity):
    """(two standard errors and the numerical uncertainty, over the value)"""
    value, error, numerical = (row[column] for column in VALUES[quantity])
    return np.hypot(2.0 * error, numerical) / abs(value)


def _factor(kind, name, quantity, row, factor, relative):
    return {"kind": kind, "name": name, "quantity": quantity, **{key: row[key] for key in FLOW}, "factor": factor, "uncertainty": abs(factor) * relative}


def _ratio(row, base, quantity):
    """(value over that of the base, relative uncertainty)"""
    column = VALUES[quantity][0]
    return row[column] / base[column], 0.0 if row is base else np.hypot(relative_error(row, quantity), relative_error(base, quantity))


def shape_factors(rows):
    """Over the square that faces the flow, in the same flow; flows without that square are left out."""
    found = []
    for _, of in rows.groupby(FLOW):
        named = {cross_section(row): row for row in of.to_dict("records")}
        square = named.get("square")
        for name, row in named.items() if square else ():
            found += [_factor("shape", name, quantity, row, *_ratio(row, square, quantity)) for quantity in VALUES]
    return pd.DataFrame(found)


def front_factors(rows):
    """Filtered peak over the steady mean, of force and moment; the arm of the mean force over the flow height (moment over force); and steady means over
    those of a plug (slip 1) behind the same front, where that is there."""
    rows = rows.fillna({"conveyor.inflow_slip_ratio": 1.0, "conveyor.front_angle_deg": 90.0})
    found = []
    for (*_, front), of in rows.groupby([*FLOW, "conveyor.front_angle_deg"], sort=False):
        of = of.to_dict("records")
        plug = next((row for row in of if row["conveyor.inflow_slip_ratio"] == 1.0), None)
        for row in of:
            slip, force, moment = row["conveyor.inflow_slip_ratio"], row["force_mean_n.x"], row["overturning_moment_mean_n_m"]
            both = np.hypot(relative_error(row, "force"), relative_error(row, "moment"))
            factors = [("peak_force", row["force_filtered_peak_n"] / force, relative_error(row, "force")),
                       ("peak_moment", row["overturning_moment_filtered_peak_n_m"] / moment, relative_error(row, "moment")),
                       ("lever_arm", moment / force / row["flow_height_m"], both)]
            if plug:
                factors += [(f"{quantity}_over_plug", *_ratio(row, plug, quantity)) for quantity in VALUES]
            found += [_factor("front", f"front_{front:g}_slip_{slip:g}", quantity, row, factor, relative) for quantity, factor, relative in factors]
    return pd.DataFrame(found)


def arm_factors(rows, density=300.0):
    """Coefficients C of an arm: forces over half rho v^2 and the front of its protruding parts. Mean along the flow (drag) and upwards (lift), with two
    standard errors, and filtered peaks, whose uncertainty is not known: a run states no numerical uncertainty of an arm's force."""
    found = []
    for row in rows.to_dict("records"):
        front = (ARM_LENGTH - row["obstacle_width_m"]) * (row["arm.height_m"] - row["arm.base_m"])
        head = 0.5 * density * row["velocity_m_s"]**2 * front
        name = f"base_{row['arm.base_m'] / row['flow_height_m']:g}"
        for quantity, axis, peak in (("drag", "x", "arm_force_filtered_peak_n"), ("lift", "z", "arm_force_z_filtered_peak_n")):
            mean, error = row[f"arm_force_mean_n.{axis}"], row[f"arm_force_standard_error_n.{axis}"]
            found.append(_factor("arm", name, quantity, row, mean / head, 2.0 * error / abs(mean) if mean else 0.0))
            found.append(_factor("arm", name, f"peak_{quantity}", row, row[peak] / head, np.nan))
    return pd.DataFrame(found)


MAKERS = {"shape": shape_factors, "front": front_factors, "arm": arm_factors}


@functools.cache
def load_factors():
    """All factors, with a key for the texts: 'shape square_15 force 3 0.4'."""
    found = pd.concat([MAKERS[kind](read_rows(ROWS / f"{FILES[kind]}.csv")) for kind in FILES], ignore_index=True)
    keys = [f"{r.kind} {r.name_} {r.quantity} {r.froude_number:g} {r.effective_friction:.2f}" for r in found.rename(columns={"name": "name_"}).itertuples()]
    return pd.concat([pd.Series(keys, name="key"), found], axis=1)


def provenance():
    """Of load_factors(), in a line."""
    files = []
    for kind in FILES:
        name = f"{FILES[kind]}.csv"
        files.append(f"{name} (commits {', '.join(sorted(pd.read_csv(ROWS / name, comment='#').commit.astype(str).unique()))})")
    return f"made by ./run study --write from validation/study/rows/{', '.join(files)}"


def over_snow(factors):
    """Mean, lowest and highest over M' of each factor at each Froude number, and the largest uncertainty: a row each, with a key for the texts."""
    found = []
    for (kind, name, quantity, froude), of in factors.groupby(["kind", "name", "quantity", "froude_number"], sort=False):
        found.append({"key": f"{kind} {name} {quantity} {froude:g}", "points": len(of), "factor": of.factor.mean(), "factor_low": of.factor.min(),
                      "factor_high": of.factor.max(), "uncertainty": of.uncertainty.max(skipna=False)})
    return pd.DataFrame(found)
