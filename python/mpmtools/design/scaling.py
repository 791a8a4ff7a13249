"""Loads of another avalanche at the same mast, scaled from those that were computed.

Force ~ c_D rho v^2/2 w H and moment ~ force times H, with the drag coefficient c_D(Fr, M') = inertia + weight / Fr^2. The second part is a
multiple of the hydrostatic force rho g H^2 w / 2: in slow flow the speed does not matter. Fitted to the runs of the study's prediction with
M' from 0.4 to 1.53 (validation/study/rows/prediction_w5.csv: square masts as wide as the flow is deep, Fr 0.1 to 7, xi 0.05 to 5); a test fits
again. Heights scale by the paper's equations.
"""

import itertools
import math
from typing import NamedTuple

import numpy as np

from mpmtools import equations

INERTIA, WEIGHT = (0.291, 0.095), (0.724, 1.624)  # logarithms at M' = 0, and their slopes
FITTED, RUNS = (0.4, 1.53), 232  # M', and the number of runs
CONTINUED, GROWN = 1.1, 2.0  # M' over the end of the fit up to which it is continued, as runs at 1.15 times the end allow (a test); error over ERRORS there
FROUDE = (0.1, 7.0)  # numbers of the runs
ERRORS = ((1.7, 0.13), (2.5, 0.22), (FROUDE[1] / FROUDE[0], 0.38))  # up to this ratio of Froude numbers: root mean square of the worst group of runs
ROUNDING = 1e-6  # relative, of a Froude number that was turned into a speed and back


class Avalanche(NamedTuple):
    """Before it meets the mast."""

    depth: float  # m
    velocity: float  # m/s
    density: float  # kg/m^3

    def froude_number(self, gravity):
        return float(equations.froude_number(self.velocity, self.depth, gravity))


class Factors(NamedTuple):
    """Of a load or height of another avalanche over the computed one, above the bed."""

    force: float
    moment: float
    runup: float
    pressure_height: float
    error: float  # of force and moment, root mean square over the study's runs; NaN: not known


def weight_factor(friction):
    """Force over the hydrostatic one, rho g H^2 w / 2, in slow flow."""
    return math.exp(WEIGHT[0] + WEIGHT[1] * friction)


def drag_coefficient(friction, froude):
    """c_D of a square mast as wide as the flow is deep."""
    return math.exp(INERTIA[0] + INERTIA[1] * friction) + weight_factor(friction) / froude**2


def is_fitted(froude):
    """Whether the coefficients were fitted to flows like this."""
    return FROUDE[0] * (1.0 - ROUNDING) <= froude <= FROUDE[1] * (1.0 + ROUNDING)


def is_known(friction):
    """Whether the coefficients hold for this M'."""
    return FITTED[0] * (1.0 - ROUNDING) <= friction <= FITTED[1] * CONTINUED


def unknown_snows(plan):
    """The snows whose loads do not scale, with M', in words; empty: none."""
    return ", ".join(f"{snow['name'].replace('_', ' ')} M' {snow['effective_friction']:.3g}" for snow in plan["snows"] if not is_known(snow["effective_friction"]))


def scaling_error(before, after, friction=FITTED[0]):
    """Of force and moment, relative; NaN beyond the flows and snows of the fit. @param before, after  Froude numbers"""
    if math.isclose(before, after, rel_tol=1e-9):
        return 0.0
    if not (is_fitted(before) and is_fitted(after) and is_known(friction)):
        return math.nan
    ratio = max(before, after) / min(before, after)
    error = next(error for most, error in ERRORS if ratio <= most * (1.0 + 3.0 * ROUNDING))
    return error * (GROWN if friction > FITTED[1] * (1.0 + 1e-3) else 1.0)


def factors(computed, other, friction, gravity):
    """Of force and moment NaN for a snow beyond the fit. @param computed, other  Avalanche; @param friction  M' of the snow"""
    before, after = computed.froude_number(gravity), other.froude_number(gravity)
    deeper = other.depth / computed.depth
    force = (other.density / computed.density * (other.velocity / computed.velocity) ** 2 * deeper
             * drag_coefficient(friction, after) / drag_coefficient(friction, before))
    if not (is_known(friction) or math.isclose(before, after, rel_tol=1e-9)):
        force = math.nan
    heights = [deeper * float(equations.relative_height(friction, after, c) / equations.relative_height(friction, before, c))
               for c in (equations.PUBLISHED_RUNUP, equations.PUBLISHED_PRESSURE_HEIGHT)]
    return Factors(force, force * deeper, *heights, scaling_error(before, after, friction))


def avalanche_of(plan):
    """That of [flow]."""
    flow = plan["flow"]
    return Avalanche(flow["depth_m"], flow["velocity_m_s"], flow["density_kg_m3"])


def half_range(plan, name):
    """Over the value. @param name  of Avalanche"""
    return plan.get("range", {}).get(f"{name}_ratio", 0.2)


def ranges_of(plan):
    """{name: (Avalanche at the lower, at the upper end)} of density, depth and speed, one at a time."""
    computed = avalanche_of(plan)
    return {name: tuple(computed._replace(**{name: getattr(computed, name) * (1.0 + sign * half_range(plan, name))})
                        for sign in (-1.0, 1.0)) for name in ("velocity", "depth", "density")}


def corners_of(plan):
    """Every combination of the ends and middles of the ranges."""
    computed, ends = avalanche_of(plan), ranges_of(plan)
    values = ([getattr(avalanche, name) for avalanche in (ends[name][0], computed, ends[name][1])] for name in Avalanche._fields)
    return [Avalanche(*corner) for corner in itertools.product(*values)]


def scaled_loads(results, plan, other):
    """(force, N; moment about the ground, N m; error of the scaling, NaN: not known): upper values of the headline for another avalanche, over
    all snows; NaN where one does not scale."""
    computed, gravity = avalanche_of(plan), plan["flow"]["gravity_m_s2"]
    time, loads, errors = other.depth * computed.velocity / (other.velocity * computed.depth), [], []
    for number, snow in enumerate(plan["snows"]):
        scale = factors(computed, other, snow["effective_friction"], gravity)
        loads.append(results.scaled_upper(plan, number, scale.force, other.depth / computed.depth, time))
        errors.append(scale.error)
    return tuple(float(np.max(values)) for values in (*zip(*loads), errors))
