"""Factors of loads from the runs of validation/study: load_factors.csv, which `./run study --write` makes from the rows and --check compares.

A row for each kind of load, name and quantity in each flow (Fr, M'): factor and uncertainty (empty where the runs state none).
  arm    a beam across the flow on a square mast, base_X: its underside X flow depths above the bed; force over its front and half rho v^2
  shape  another cross-section over a square that faces the flow
  front  an inclined front, or a flow that is sheared over its depth: peak over mean, lever arm over H; means over those of a plug
"""

import pathlib

import numpy as np
import pandas as pd

from mpmtools.errors import InputError

FILE = pathlib.Path(__file__).with_name("load_factors.csv")
CONDITIONS = {"hardening_xi": 5.0, "obstacle_width_m": 1.75, "flow_height_m": 1.75}  # of all runs, the width across the flow; a test reads their rows
ROUNDING = 1e-6  # relative, of a Froude number that was turned into a speed and back


def load_factors():
    """All factors that are kept."""
    return pd.read_csv(FILE, comment="#")


def factor_at(factors, kind, name, quantity, froude, friction):
    """(factor, uncertainty) in a flow: linear in M' and in log Fr between the flows of the table. @throws InputError outside them."""
    of = factors[(factors.kind == kind) & (factors["name"] == name) & (factors.quantity == quantity)]
    if of.empty:
        raise InputError(f"no factor of the {quantity} for {kind} '{name}'")
    found = []
    for column in ("factor", "uncertainty"):
        grid = of.pivot(index="froude_number", columns="effective_friction", values=column)
        for value, points, what in ((froude, grid.index, "Fr"), (friction, grid.columns, "M'")):
            if not points.min() * (1.0 - ROUNDING) <= value <= points.max() * (1.0 + ROUNDING):
                raise InputError(f"{what} = {value:g} is outside {points.min():g} to {points.max():g}, for which the factor of {kind} '{name}' is known")
        at_froude = [np.interp(np.log(froude), np.log(grid.index), grid[m]) for m in grid.columns]
        found.append(float(np.interp(friction, grid.columns, at_froude)))
    if np.isnan(found[0]):
        raise InputError(f"the table has no factor of {kind} '{name}' at Fr = {froude:g} and M' = {friction:g}: it lacks a flow beside it")
    return tuple(found)


def over_snows(factors, kind, name, quantity, plan):
    """{snow: factor + uncertainty, or without one factor} in the flow of a site, of its snows that are within the table. @param plan  of
    design_plan.json"""
    found = {}
    for snow in plan["snows"]:
        try:
            factor, uncertainty = factor_at(factors, kind, name, quantity, plan["flow"]["froude_number"], snow["effective_friction"])
        except InputError:
            continue
        found[snow["name"]] = factor + np.nan_to_num(uncertainty)
    return found


def outside(factors, kind, plan):
    """Which flows the table of a kind has, and which snows of a site are outside, in words; empty: none is."""
    of = factors[factors.kind == kind]
    inside = over_snows(factors, kind, of["name"].iloc[0], of.quantity.iloc[0], plan)
    snows = [snow["name"].replace("_", " ") for snow in plan["snows"] if snow["name"] not in inside]
    if not snows:
        return ""
    (slow, fast), (least, most) = ((f"{column.min():.3g}", f"{column.max():.3g}") for column in (of.froude_number, of.effective_friction))
    which = f"snow {', '.join(snows)}" if inside else "this flow"
    return f"{which} is outside the table (Fr {slow if slow == fast else f'{slow} to {fast}'}, M' {least} to {most})"
