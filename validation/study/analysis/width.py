"""Masts of other widths (Sect. 4.3, Fig. 10)."""

import numpy as np
import pandas as pd

from analysis.statistics import ratio_of_means
from mpmtools.equations import rescaled_width_factor
from mpmtools.scores import levels
from mpmtools.fit.runs import POINT

INPUTS = ["critical_state_slope", "cohesion_beta", "effective_friction", "hardening_xi", "froude_number", "relative_width"]
COLUMNS = [*INPUTS, "runup_factor", "runup_standard_error", "pressure_height_factor", "pressure_height_standard_error", "guideline"]


def width_factors(runs):
    """Eq. 11: heights over those of the run with w = H and all else equal, standard errors by propagation of both runs'; beside it the
    guideline's Eq. 6, rescaled to 1 at w = H. Empty unless the table varies the width."""
    keys = [levels(runs[name]) for name in POINT]
    factors = [_factors(group) for _, group in runs.groupby(keys, sort=False)
               if group.at_reference_width.any() and not group.at_reference_width.all()]
    return pd.concat(factors).sort_index() if factors else pd.DataFrame(columns=COLUMNS, dtype=float)


def _factors(group):
    """Of runs that differ in the width of the mast only."""
    reference = group[group.at_reference_width].iloc[0]
    factors = group[INPUTS].copy()
    for name in ("runup", "pressure_height"):
        factor, error = ratio_of_means(group[name], group[f"{name}_standard_error"], reference[name], reference[f"{name}_standard_error"])
        factors[f"{name}_factor"] = factor
        factors[f"{name}_standard_error"] = np.where(group.index == reference.name, 0.0, error)  # 1 without error over itself
    return factors.assign(guideline=rescaled_width_factor(group.relative_width))[COLUMNS]
