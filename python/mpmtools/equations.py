"""The paper's semi-empirical equations and the guideline that they extend. All functions take numbers or arrays.

Symbols: M' effective internal friction, Fr Froude number, H flow height, w width of the mast, h_r run-up, h_p pressure height.
"""

from typing import NamedTuple

import numpy as np

from mpmtools.errors import ConfigError

STANDARD_GRAVITY = 9.81  # m/s^2, the paper's
LAMBDA_LOOSE, LAMBDA_DENSE = 1.5, 3.0  # the guideline's dissipation factors for dry loose and for dense avalanches


class HeightCoefficients(NamedTuple):
    """Coefficients of h/H = 1 + k M' + min(Fr, Fr_sat)^2/2 exp(-kappa M'), Eqs. 7 to 10."""

    k: float  # pile-up, Eq. 8
    kappa: float  # dissipation, Eq. 10
    saturation_froude: float = np.inf  # Fr_sat, Eq. 9


PUBLISHED_RUNUP = HeightCoefficients(0.9468, 1.5745)  # Table A1
PUBLISHED_PRESSURE_HEIGHT = HeightCoefficients(0.5277, 1.3072, 1.5380)  # Table A2


def _require(holds, what, values):
    """NaN, an unknown input, passes: the caller leaves such rows out."""
    wrong = ~(holds | np.isnan(values))
    if np.any(wrong):
        raise ConfigError(f"{what}, not {np.atleast_1d(values)[np.atleast_1d(wrong)][0]:g}")


def _require_flow(flow_height, gravity):
    _require(np.asarray(flow_height) > 0.0, "the flow height must be greater than 0", flow_height)
    _require(np.asarray(gravity) > 0.0, "gravity must be greater than 0", gravity)


def effective_friction(critical_state_slope, cohesion_beta):
    """M' = (1 + beta) / ((1 - beta) sqrt(1 + 2 beta)) M, Eq. 2, for M >= 0 and 0 <= beta < 1."""
    slope, beta = np.asarray(critical_state_slope, float), np.asarray(cohesion_beta, float)
    _require(slope >= 0.0, "the critical-state slope M must be at least 0", slope)
    _require((beta >= 0.0) & (beta < 1.0), "the cohesion beta must be at least 0 and less than 1", beta)
    return (1.0 + beta) / ((1.0 - beta) * np.sqrt(1.0 + 2.0 * beta)) * slope


def friction_angle(friction):
    """phi' = asin(3 M' / (M' + 6)), rad (text below Eq. 2)."""
    return np.arcsin(3.0 * friction / (friction + 6.0))


def flow_velocity(froude, flow_height, gravity=STANDARD_GRAVITY):
    """v = Fr sqrt(g H), m/s."""
    _require_flow(flow_height, gravity)
    _require(np.asarray(froude) >= 0.0, "the Froude number must be at least 0", froude)
    return froude * np.sqrt(gravity * flow_height)


def froude_number(velocity, flow_height, gravity=STANDARD_GRAVITY):
    """Fr = v / sqrt(g H)."""
    _require_flow(flow_height, gravity)
    _require(np.asarray(velocity) >= 0.0, "the velocity must be at least 0", velocity)
    return velocity / np.sqrt(gravity * flow_height)


def magnification_factor(friction, coefficients):
    """zeta = k M', Eq. 8: quasi-static pile-up over H."""
    return coefficients.k * friction


def dissipation_factor(friction, coefficients):
    """lambda = exp(kappa M'), Eq. 10: the velocity head is divided by it."""
    return np.exp(coefficients.kappa * friction)


def relative_height(friction, froude, coefficients):
    """h/H by Eqs. 7 to 10, for a mast as wide as the flow is high."""
    head = 0.5 * np.minimum(froude, coefficients.saturation_froude) ** 2
    return 1.0 + magnification_factor(friction, coefficients) + head / dissipation_factor(friction, coefficients)


def across_flow(shape, width, depth=None, angle_deg=0.0):
    """(width across the flow, shape) of an obstacle turned about its vertical axis; the shape of a box that has no face against the flow is
    "turned box". @param depth  along the flow; None: that of its width"""
    quarters = angle_deg / 90.0
    if shape != "box" or quarters == 0.0:
        return width, shape
    depth = width if depth is None else depth
    if abs(quarters - round(quarters)) < 1e-9:
        return (depth if round(quarters) % 2 else width), shape
    angle = np.radians(angle_deg)
    return float(width * abs(np.cos(angle)) + depth * abs(np.sin(angle))), "turned box"


def outside_of_fit(relative_width, froude, shape="box", friction=None, hardening_xi=None):
    """What a mast and its flow have that Eqs. 7 to 10 were not fitted to (Sect. 2.2 and 4.3), as a list of texts; empty: nothing. The rule
    range_of_equations of libmpm/driver/advice.cpp is the same.

    @param shape  of the obstacle, as in a case file. @param friction  M'; None: not known. @param hardening_xi  likewise"""
    outside = []
    if shape != "box":
        outside.append("a mast that is no box with its face against the flow")
    if abs(relative_width - 1.0) > 0.05:
        simulated = "" if 0.5 - 1e-9 <= relative_width <= 3.0 + 1e-9 else ", outside the 0.5 to 3 that were simulated"
        outside.append(f"w/H = {relative_width:.2f} (fitted: 1{simulated})")
    if not 0.1 - 1e-9 <= froude <= 7.0 + 1e-9:
        outside.append(f"Fr = {froude:.2g} (fitted: 0.1 to 7)")
    if friction is not None and friction > 2.3:
        outside.append(f"M' = {friction:.3g} (fitted: 0 to 2.3)")
    if hardening_xi is not None and not 0.15 <= hardening_xi <= 15.0:
        outside.append(f"xi = {hardening_xi:.3g} (fitted: 0.15 to 15)")
    return outside


def bernoulli_height(froude):
    """1 + Fr^2/2: flow height plus velocity head, Eq. 1, over H."""
    return 1.0 + 0.5 * froude**2


def width_factor(relative_width):
    """f(w/H) = 1 - exp(-1.14 w/H), Eq. 6."""
    return -np.expm1(-1.14 * relative_width)


def rescaled_width_factor(relative_width):
    """f(w/H) / f(1): the form that is compared with simulations (Sect. 4.3)."""
    return width_factor(relative_width) / width_factor(1.0)


def guideline_runup(velocity, dissipation, factor, gravity=STANDARD_GRAVITY):
    """v^2 / (2 g lambda) f(w/H), Eq. 5, m above the surface of the avalanche."""
    return velocity**2 / (2.0 * gravity) / dissipation * factor
