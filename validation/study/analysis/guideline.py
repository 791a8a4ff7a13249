"""The guideline's dissipation factor in terms of M' (Sect. 4.2, Fig. 9)."""

from dataclasses import dataclass, field

import numpy as np
import pandas as pd

from mpmtools import equations
from mpmtools.scores import compute_scores, levels
from mpmtools.tables import number_text
from mpmtools.wording import counted, verb

PUBLISHED = {equations.LAMBDA_LOOSE: (0.45, 0.65), equations.LAMBDA_DENSE: (1.0, 1.5)}  # lambda: M' of the paper's minima
SLOWEST, FASTEST = 3.0, 7.0


@dataclass
class GuidelineCorrespondence:
    """curves: lambda, hardening_xi, effective_friction, runs, rmsle, normalised (0 at the lowest and 1 at the highest of its curve)
    minima: lambda, hardening_xi, minimum_at, neighbour_below, neighbour_above (the minimum of the continuous curve is between them; NaN
    beyond the ends), parabola_at (vertex of the parabola through the three; NaN at an end), rmsle, published_from, published_to, inside
    notes: what is missing"""

    curves: pd.DataFrame
    minima: pd.DataFrame
    notes: list = field(default_factory=list)


def guideline_correspondence(runs):
    """Distance of the run-up from the guideline's, H + v^2/(2 g lambda) f(w/H), by M', for each lambda and xi.

    The RMSLE is over the runs with 3 <= Fr <= 7. Only M' with a run at every such Froude number of their xi are compared, so that all
    points of a curve mean the same.
    """
    fast = runs[runs.at_reference_width & runs.froude_number.between(SLOWEST - 1e-6, FASTEST + 1e-6)]
    notes = [] if len(fast) else ["no run with 3 <= Fr <= 7 and w = H"]
    curves, minima = [], []
    for xi, of_xi in fast.groupby(levels(fast.hardening_xi)):
        complete, incomplete = _with_every_froude_number(of_xi)
        if incomplete:
            count = levels(of_xi.froude_number).nunique()
            notes.append(f"xi = {number_text(xi)}: {counted(incomplete, 'value')} of M' {verb(incomplete, 'lacks', 'lack')} a run at one of the {count} Froude numbers and "
                         f"{verb(incomplete, 'is', 'are')} left out")
        if len(complete) < 3:
            notes.append(f"xi = {number_text(xi)}: {counted(len(complete), 'value')} of M' with all Froude numbers; a curve needs three")
            continue
        for dissipation, published in PUBLISHED.items():
            curve = _curve(complete, dissipation, xi)
            curves.append(curve)
            minima.append(_minimum(curve, *published))
    no_curve = _curve({}, np.nan, np.nan)
    return GuidelineCorrespondence(pd.concat(curves, ignore_index=True) if curves else no_curve,
                                   pd.DataFrame(minima, columns=MINIMUM_COLUMNS), notes)


MINIMUM_COLUMNS = ["lambda", "hardening_xi", "minimum_at", "neighbour_below", "neighbour_above", "parabola_at", "rmsle", "published_from",
                   "published_to", "inside"]


def _with_every_froude_number(runs):
    """{M': its runs} of those M' that have a run at every Froude number of the table, and how many have not."""
    froude = levels(runs.froude_number)
    groups = dict(list(runs.groupby(levels(runs.effective_friction))))
    complete = {at: group for at, group in groups.items() if froude[group.index].nunique() == froude.nunique()}
    return complete, len(groups) - len(complete)


def _curve(groups, dissipation, xi):
    rows = [{"lambda": dissipation, "hardening_xi": xi, "effective_friction": at, "runs": len(group), "rmsle": _distance(group, dissipation)}
            for at, group in groups.items()]
    curve = pd.DataFrame(rows, columns=["lambda", "hardening_xi", "effective_friction", "runs", "rmsle"])
    return curve.assign(normalised=(curve.rmsle - curve.rmsle.min()) / (curve.rmsle.max() - curve.rmsle.min()))


def _distance(runs, dissipation):
    """RMSLE of the run-ups from Eq. 5, with the flow height that the text below Eq. 7 adds."""
    guideline = equations.guideline_runup(runs.velocity_m_s, dissipation, equations.width_factor(runs.relative_width), runs.gravity_m_s2)
    return compute_scores(runs.runup * runs.flow_height_m, runs.flow_height_m + guideline).rmsle


def _minimum(curve, published_from, published_to):
    lowest = int(curve.rmsle.argmin())
    x, y = curve.effective_friction.to_numpy(), curve.rmsle.to_numpy()
    below = x[lowest - 1] if lowest > 0 else np.nan
    above = x[lowest + 1] if lowest + 1 < len(x) else np.nan
    vertex = _vertex(x[lowest - 1:lowest + 2], y[lowest - 1:lowest + 2]) if np.isfinite(below + above) else np.nan
    return {"lambda": curve["lambda"].iat[0], "hardening_xi": curve.hardening_xi.iat[0], "minimum_at": x[lowest], "neighbour_below": below,
            "neighbour_above": above, "parabola_at": vertex, "rmsle": y[lowest], "published_from": published_from,
            "published_to": published_to, "inside": int(published_from <= vertex <= published_to)}


def _vertex(x, y):
    """Of the parabola through three points, the middle one lowest."""
    left, right = np.diff(y) / np.diff(x)
    curvature = (right - left) / (x[2] - x[0])
    return 0.5 * (x[0] + x[1] - left / curvature) if curvature > 0.0 else x[1]


def guideline_lines(guideline):
    """What was found, for the terminal."""
    lines = []
    for m in guideline.minima.to_dict("records"):
        end = np.isnan(m["parabola_at"])
        verdict = "no minimum located" if end else "inside" if m["inside"] else "outside"
        where = " (an end of the curve)" if end else f", parabola {m['parabola_at']:.3f}"
        lines.append(f"guideline lambda = {m['lambda']:g}, xi = {m['hardening_xi']:g}: lowest RMSLE {m['rmsle']:.3f} at M' = "
                     f"{m['minimum_at']:.3f}{where}; published {m['published_from']:g} to {m['published_to']:g}: {verdict}")
    return lines + [f"guideline: {note}" for note in guideline.notes]
