"""How far the heights and the force of a run are from their limit of fine grids: points of the study on three grids each.

`mpm converge` judges one case in the same way; here are many, from the table of one campaign.
"""

from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.optimize import brentq

from analysis.fits import coefficients_and_scores
from analysis.statistics import ratio_of_means
from mpmtools.errors import InputError
from mpmtools.fit.fits import NARROW, WIDE
from analysis.histories import last_third, run_means
from mpmtools.fit.runs import POINT
from mpmtools.tables import no_column, numbers, read_table

QUANTITIES = {  # mean, its standard error, its numerical uncertainty as the run states it
    "run-up": ("runup_mean_m", "runup_standard_error_m", "runup_numerical_uncertainty_m"),
    "pressure height": ("pressure_height_mean_m", "pressure_height_standard_error_m", "pressure_height_numerical_uncertainty_m"),
    "force": ("force_mean_n.x", "force_standard_error_n.x", "force_x_numerical_uncertainty_n"),
}
SAFETY, SAFETY_WITHOUT_ORDER = 1.25, 3.0  # of the grid convergence index (Roache), of the range (Eca & Hoekstra 2009)
LOWEST_ORDER, ORDER_TOLERANCE, HIGHEST_ORDER = 0.5, 0.5, 50.0
# Snow whose heights at w/5 are far from those of finer grids (evidence/grids, results/prediction/refined_kinds.csv): {kind: its runs}. They
# overlap: some stiff snow is cohesive snow of xi <= 0.5.
UNCONVERGED = {
    "fluid": lambda runs: runs.critical_state_slope < 1e-6,
    "stiff snow, M' > 1.5": lambda runs: runs.effective_friction > 1.5,
    "cohesive snow of xi <= 0.5": lambda runs: (runs.hardening_xi < 0.5 + 1e-6) & (runs.cohesion_beta > 1e-6) & (runs.critical_state_slope > 1e-6),
}
ALL_UNCONVERGED = "all that is not converged at w/5"
# Snow whose heights still depend on the length of the window, even in the long one (jams.md).
PUSHED = {"snow of M' > 2.2 below Fr 1": lambda runs: (runs.effective_friction > 2.2) & (runs.froude_number < 1.0 - 1e-6)}
# The paper has 35 sets with these xi, and does not say with which snow: our plans chose it.
CHOSEN = {"the sets that we chose (xi = 1.5 and 0.15)": lambda runs: np.isclose(runs.hardening_xi, 1.5) | np.isclose(runs.hardening_xi, 0.15)}


class Limit(NamedTuple):
    """What three grids tell about the finest of them."""

    order: float        # observed; not a number where the values do not approach a limit from one side
    uncertainty: float  # of the value on the finest grid, in the unit of the values


def limit_of(sizes, values, formal_order=1.0):
    """Eca and Hoekstra (2009), as `mpm converge` for three grids, but without its lower bound. @param sizes, values  coarse first"""
    coarse, middle, fine = values
    r32, r21 = sizes[0] / sizes[1], sizes[1] / sizes[2]
    e32, e21 = coarse - middle, middle - fine
    spread = SAFETY_WITHOUT_ORDER * (max(values) - min(values))
    if e21 == 0.0 or e32 / e21 <= np.log(r32) / np.log(r21):  # of the other sign, or growing: no order above 0
        return Limit(np.nan, spread)

    def excess(p):
        return r21**p * (r32**p - 1.0) / (r21**p - 1.0) - e32 / e21

    order = brentq(excess, 1e-9, HIGHEST_ORDER) if excess(HIGHEST_ORDER) > 0.0 else HIGHEST_ORDER
    if order < LOWEST_ORDER:
        return Limit(order, spread)
    if order <= formal_order + ORDER_TOLERANCE:
        return Limit(order, SAFETY * abs(e21) / (r21**order - 1.0))
    return Limit(order, SAFETY * max(abs(e21) / (r21**formal_order - 1.0), max(values) - min(values)))


def grid_table(path):
    """A row for each point and quantity of a campaign's results.csv that has the point on three grids: inputs; quantity; value and standard
    error on each grid, coarse first, in the unit of the table; value on the coarse and on the middle grid over that on the finest;
    observed order; numerical uncertainty of the finest over its value; the numerical uncertainty that the run on the coarse grid states, over
    its value; and whether that and two standard errors of the difference cover the finest value.

    Points without a steady mean on each of three grids are left out."""
    table = read_table(path)
    needed = [*POINT, "status", "cell_size_m", *(name for names in QUANTITIES.values() for name in names)]
    if missing := [name for name in needed if name not in table]:
        raise InputError(no_column(table, *missing))
    runs = pd.DataFrame({name: numbers(table, name) for name in needed if name != "status"})[table.status == "done"]
    rows = []
    for point, of_point in runs.groupby(POINT, sort=False):
        on_grids = of_point.sort_values("cell_size_m", ascending=False)
        if len(on_grids) != 3:
            continue
        for quantity, names in QUANTITIES.items():
            values, errors, stated = (on_grids[name].to_numpy() for name in names)
            if np.isfinite(values).all():
                rows.append({**dict(zip(POINT, point)), "quantity": quantity, **_judged(on_grids.cell_size_m.to_numpy(), values, errors, stated)})
    return pd.DataFrame(rows, columns=None if rows else [*POINT, "quantity"])


def covers(stated, coarse, fine):
    """Whether the numerical uncertainty that a coarse run states and two standard errors of the difference cover the value of a finer grid.
    @param coarse, fine  value and its standard error"""
    return abs(coarse[0] - fine[0]) <= stated + 2.0 * np.hypot(coarse[1], fine[1])


def _judged(sizes, values, errors, stated):
    limit = limit_of(sizes, values)
    row = {f"{what}_{grid}": x[i] for i, grid in enumerate(("coarse", "middle", "fine"))
           for what, x in (("cell_size_m", sizes), ("value", values), ("standard_error", errors))}
    covered = covers(stated[0], (values[0], errors[0]), (values[2], errors[2]))
    ratio, ratio_error = ratio_of_means(values[0], errors[0], values[2], errors[2])
    return {**row, "coarse_over_fine": ratio, "middle_over_fine": values[1] / values[2], "ratio_standard_error": ratio_error, "order": limit.order,
            "fine_uncertainty": limit.uncertainty / abs(values[2]), "coarse_stated_uncertainty": stated[0] / abs(values[0]),
            "covered": int(covered)}


def grid_summary(table):
    """Over all points, a row a quantity: points; geometric mean, lowest and highest ratio of the coarse and the middle grid to the finest;
    points whose finest value the stated uncertainty of the coarse run covers; points with an order."""
    rows = []
    for quantity, of in table.groupby("quantity", sort=False):
        row = {"quantity": quantity, "points": len(of)}
        for grid in ("coarse", "middle"):
            ratio = of[f"{grid}_over_fine"]
            row.update({f"{grid}_mean": np.exp(np.log(ratio).mean()), f"{grid}_lowest": ratio.min(), f"{grid}_highest": ratio.max()})
        rows.append({**row, "covered": of.covered.sum(), "with_order": int(of.order.between(LOWEST_ORDER, 1.0 + ORDER_TOLERANCE).sum())})
    return pd.DataFrame(rows)


def coefficients_without_unconverged(runs):
    """Coefficients and scores against the published equations without each kind of snow that is not converged at w/5, without all of them,
    without that which depends on the window, and without the sets that the paper does not list: without (what, empty: all runs are
    kept), fitting_set, left_out (runs), and one column a coefficient and score."""
    unconverged = {name: holds(runs) for name, holds in UNCONVERGED.items()}
    others = {name: holds(runs) for name, holds in (PUSHED | CHOSEN).items()}
    left_out = {"": np.zeros(len(runs), bool)} | unconverged | {ALL_UNCONVERGED: np.any(list(unconverged.values()), axis=0)} | others
    rows = []
    for without, out in left_out.items():
        kept = runs[~out]
        for fitting_set in (NARROW, WIDE):
            rows.append({"without": without, "fitting_set": fitting_set.name, "left_out": len(runs) - len(kept),
                         **coefficients_and_scores(kept, fitting_set)})
    return pd.DataFrame(rows)


def late_means(path):
    """A row for each run of a campaign whose folder is there, steady or not: inputs, cell size, and over the last third of its series the mean
    and standard error of both heights (over H) and of the force along the flow (N).

    @param path  results.csv of a campaign, beside its folders runs/NAME"""
    table = read_table(path)
    inputs = pd.DataFrame({name: numbers(table, name) for name in [*POINT, "cell_size_m"]})
    means = run_means(table, lambda series, run: last_third(series)).drop(columns=["from_s", "to_s"])
    return inputs.join(means, how="inner").reset_index(drop=True)


def grid_tables(paths):
    """{name: table} of campaigns that have points on three grids, each campaign for itself."""
    table = pd.concat([grid_table(path) for path in paths], ignore_index=True)
    return {"grids": table, "grids_summary": grid_summary(table)}
