"""Runs whose snow jams between the inlet and the mast, by a stated rule.

The force on the mast has a part that grows with the speed, about the flux of momentum through the mast's width, and a static part,
S = (F - rho v^2 H w) / (rho g H^2 w / 2), in hydrostatic forces of the flow height. In one snow S hardly depends on the Froude number:
it is the weight and strength of the pile. Where slow snow presses far more than the same snow in fast flow, more than a pile leans on
the mast: the layers that enter with the speed of the belt push the snow against it, so that what is measured depends on the window.

    jam index = S / max(S_fast, 25) of a run below Fr 5,   S_fast: least S of the same snow (M, beta, xi) at Fr >= 5
    jammed    = jam index > 1.5

Both numbers were chosen on the first reproduction kept in validation/study, after its heights had been seen. In a window of twice the
length none of its jams is left (validation/study/limits.md). `jam_coefficients` shows what other limits would do. 25 keeps the quotient from
judging weak snow, whose static force is small.
"""

import numpy as np
import pandas as pd

from analysis.fits import coefficients_and_scores
from mpmtools.scores import levels
from mpmtools.fit.fits import NARROW, WIDE
from mpmtools.fit.runs import POINT

FAST, LEAST_STATIC, LIMIT = 5.0, 25.0, 1.5
LIMITS = (1.2, 1.3, 1.4, 1.5, 1.75, 2.0, np.inf)  # of the scan; infinite: all runs are kept
# The force of the one stiff point whose window was varied (M' 1.76, Fr 1, S = 54) falls by 10 % from 8.4 to 12.6 m of snow upstream, its
# heights by 2 and 1 %; at the other two points (S <= 14) nothing changes by 0.5 %. Nothing in between was tried.
WINDOW_STATIC = 50.0
COLUMNS = [*POINT, "effective_friction", "force_over_hydrostatic", "static_force", "fast_static_force", "jam_index", "jammed", "force_depends_on_window"]


def jam_indices(runs):
    """A row a run with a force, in the order of `runs` and with its index: COLUMNS. A fast run, and one without a fast run of its
    snow, has no jam index and is kept."""
    known = runs[np.isfinite(runs.force_n)]
    area = known.flow_height_m * known.obstacle_width_m
    hydrostatic = 0.5 * known.density_kg_m3 * known.gravity_m_s2 * known.flow_height_m * area
    static = (known.force_n - known.density_kg_m3 * known.velocity_m_s**2 * area) / hydrostatic
    table = known[[*POINT, "effective_friction"]].assign(
        force_over_hydrostatic=known.force_n / hydrostatic, static_force=static)
    snow = [levels(known[name]) for name in ("critical_state_slope", "cohesion_beta", "hardening_xi", "obstacle_width_m")]
    table["fast_static_force"] = static.where(known.froude_number > FAST - 1e-6).groupby(snow).transform("min")
    slow = known.froude_number <= FAST - 1e-6
    table["jam_index"] = (table.static_force / np.maximum(table.fast_static_force, LEAST_STATIC)).where(slow & table.fast_static_force.notna())
    table["jammed"] = (table.jam_index > LIMIT).astype(int)
    table["force_depends_on_window"] = (table.static_force > WINDOW_STATIC).astype(int)
    return table[COLUMNS]


def without_jams(runs, limit=LIMIT):
    index = jam_indices(runs).jam_index
    return runs.drop(index[index > limit].index)


def jam_coefficients(runs):
    """Coefficients and scores against the published equations with the runs above each limit left out: limit, fitting_set, left_out
    (runs), and one column a coefficient and score."""
    rows = []
    for limit in LIMITS:
        kept = without_jams(runs, limit)
        for fitting_set in (NARROW, WIDE):
            rows.append({"limit": limit, "fitting_set": fitting_set.name, "left_out": len(runs) - len(kept),
                         **coefficients_and_scores(kept, fitting_set)})
    return pd.DataFrame(rows)
