"""The same set-ups on two grids: how much the finer one changes the heights and the force of each kind of snow, and the coefficients."""

import numpy as np
import pandas as pd

from analysis.fits import coefficients_and_scores
from mpmtools.scores import levels
from analysis.campaigns import ALIKE, QUANTITIES, alike_pairs, keyed, paired_summary, ratio_summary
from mpmtools.fit.fits import NARROW, WIDE
from analysis.grids import UNCONVERGED, covers
from mpmtools.fit.regression import PRESSURE_HEIGHT
from mpmtools.fit.runs import POINT

# Kinds of snow by how their heights change with the grid; a set-up is of the first kind that holds it.
KINDS = UNCONVERGED | {"other snow": lambda runs: runs.effective_friction > 0.0}
HEIGHTS = ("runup", "pressure_height")
FINEST_ALONE, WITH_COARSER = "finest grid alone", "coarser grid where the finest has no steady mean"
SPEEDS = {"from Fr 1 on": lambda runs: runs.froude_number > 1.0 - 1e-6, "below Fr 1": lambda runs: runs.froude_number < 1.0 - 1e-6}


def _finest_and_coarsest(runs):
    """Of each set-up at the reference width the run on its finest grid, and that on its coarsest."""
    ordered = runs.assign(cell_size_m=levels(runs.cell_size_m)).sort_values("cell_size_m", kind="stable")
    return keyed(ordered), keyed(ordered[::-1])


def refined_rows(runs):
    """A row for each set-up that is there on two grids, with the same friction of the mast and the same duration where both tables name them:
    inputs, M', both cell sizes, each quantity (heights over H, force in N) on both, that on the finest grid over that on the coarsest, and
    for each height whether the coarsest run said so (1 or 0 by grids.covers(); NaN where it states no uncertainty)."""
    fine, coarse = _finest_and_coarsest(runs)
    errors, stated = [f"{name}_standard_error" for name in HEIGHTS], [f"{name}_numerical_uncertainty" for name in HEIGHTS]
    columns = ["cell_size_m", *ALIKE, *QUANTITIES, *errors, *stated]
    both = alike_pairs(fine[[*POINT, "effective_friction", *columns]], coarse[[*POINT, *columns]], ("_fine", "_coarse"))
    both = both[both.cell_size_m_fine < both.cell_size_m_coarse].reset_index(drop=True)
    ratios = {f"{name}_ratio": both[f"{name}_fine"] / both[f"{name}_coarse"] for name in QUANTITIES}
    covered = {f"{name}_covered": _covered(both, name) for name in HEIGHTS}
    helpers = [f"{name}{grid}" for name in (*errors, *stated) for grid in ("_fine", "_coarse")]
    return both.drop(columns=helpers).assign(**ratios, **covered)


def _covered(both, name):
    coarse, fine = ((both[f"{name}{grid}"], both[f"{name}_standard_error{grid}"]) for grid in ("_coarse", "_fine"))
    stated = both[f"{name}_numerical_uncertainty_coarse"]
    known = both[f"{name}_fine"].notna() & both[f"{name}_coarse"].notna() & stated.notna()
    return covers(stated, coarse, fine).astype(float).where(known)


def refined_coefficients(runs, rows):
    """Coefficients and scores against the published equations on both grids of the same set-ups, those of `rows` (of refined_rows()) that have
    both heights on both grids: grid (coarse, fine), fitting_set, runs (of the set), and one column a coefficient and score. Without
    runs below the saturation of the pressure height its coefficients are NaN: fast runs alone do not tell k_p from kappa_p and Fr_sat."""
    rows = rows.dropna(subset=["runup_ratio", "pressure_height_ratio"])
    if rows.empty:
        return pd.DataFrame()
    fine, coarse = _finest_and_coarsest(runs)
    all_saturated = rows.froude_number.min() > PRESSURE_HEIGHT.published_estimates["Fr_sat"][0]
    undetermined = dict.fromkeys(PRESSURE_HEIGHT.parameters, np.nan) if all_saturated else {}
    table = []
    for fitting_set in (NARROW, WIDE):
        for grid, of in (("coarse", coarse), ("fine", fine)):
            both = of.merge(rows[POINT], on=POINT)
            table.append({"grid": grid, "fitting_set": fitting_set.name, "runs": int(fitting_set.holds(both).sum()),
                          **coefficients_and_scores(both, fitting_set), **undetermined})
    return pd.DataFrame(table)


def refined_kinds(runs, rows):
    """How much the finer grid changes what, and whether the coarse runs said so: a row for each kind of snow, slow or not, and quantity. kind;
    speeds; sets (set-ups with a steady run-up), fine (those on the finest grid); quantity; pairs, ratio, spread, lowest and highest as in
    paired_summary(), finest over coarsest grid; covered (the pairs of which the coarse run said so, as in refined_rows(); NaN for the force)."""
    fine, _ = _finest_and_coarsest(runs)
    on_finest = fine.cell_size_m < fine.cell_size_m.min() * (1.0 + 1e-6)
    table, set_kinds, row_kinds = [], _kinds(fine), _kinds(rows)
    for kind in KINDS:
        for speeds, holds in SPEEDS.items():
            sets, pairs = (set_kinds == kind) & holds(fine), rows[(row_kinds == kind) & holds(rows)]
            for name, label in QUANTITIES.items():
                if summary := ratio_summary(pairs[f"{name}_ratio"]):
                    table.append({"kind": kind, "speeds": speeds, "sets": sets.sum(), "fine": (sets & on_finest).sum(), "quantity": label,
                                  **summary, "covered": pairs[f"{name}_covered"].sum(min_count=1) if name in HEIGHTS else np.nan})
    return pd.DataFrame(table)


def coefficients_with_coarser(runs, coarser):
    """What it does that a set-up without a steady mean on its finest grid counts nowhere, although a coarser run of it is steady (`coarser`:
    those left out, as in StudyTable): a row for each fitting set without these runs and with them. rows; fitting_set; runs (of the
    set with a run-up); one column a coefficient and score against the published equations."""
    finest_steady, _ = _finest_and_coarsest(pd.concat([runs, coarser], ignore_index=True))
    table = []
    for rows, of in ((FINEST_ALONE, keyed(runs)), (WITH_COARSER, finest_steady)):
        for fitting_set in (NARROW, WIDE):
            table.append({"rows": rows, "fitting_set": fitting_set.name, "runs": int(fitting_set.holds(of).sum()),
                          **coefficients_and_scores(of, fitting_set)})
    return pd.DataFrame(table)


def _kinds(runs):
    return pd.Series(np.select([holds(runs) for holds in KINDS.values()], list(KINDS), default=""), index=runs.index)


def refinement_tables(runs):
    """{name: table}: refined_rows(), their ratios by Froude number and by kind of snow, and the coefficients on both grids."""
    rows = refined_rows(runs)
    return {"refined_rows": rows, "refined_summary": paired_summary(rows), "refined_kinds": refined_kinds(runs, rows),
            "refined_coefficients": refined_coefficients(runs, rows)}
