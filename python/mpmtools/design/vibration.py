"""Vibration of a mast under a load that varies in time and height: modes of a cantilever, fixed at the ground.

A mode feels the generalised force Q(t) = integral of q(z, t) phi(z) dz, with the line load q and the shape phi (1 at the top). Its amplitude
times its generalised stiffness, r(t), is the response of the oscillator to Q. What the masses of the mast add at the foundation is
(r - Q) times the mode's share: integral of phi dm over integral of phi^2 dm for the force, integral of phi z dm over it for the moment. The
part of the load that the modes do not carry acts statically.
"""

import functools
from typing import NamedTuple

import numpy as np
import scipy.linalg
from numpy.polynomial import Legendre, Polynomial

MOST = 10  # modes
TERMS = 18  # of the polynomials: the first seven modes of a uniform mast are right within 1e-6, the tenth within 0.2 %


class Mode(NamedTuple):
    """Of a cantilever (Euler and Bernoulli), over its height."""

    frequency_ratio: float  # over that of the first mode
    polynomial: Polynomial  # phi over the relative height, 1 at the top
    force_share: float  # integral phi dm / integral phi^2 dm
    moment_share: float  # integral phi zeta dm / integral phi^2 dm, over the height of the mast

    def shape(self, relative_height):
        """phi, 1 at the top; nothing above it and in the ground."""
        zeta = np.asarray(relative_height)
        return np.where((zeta >= 0.0) & (zeta <= 1.0), self.polynomial(np.clip(zeta, 0.0, 1.0)), 0.0)


def mass_per_height(relative_height, taper):
    """Over that at the foot: as the width of a tube of constant wall."""
    return 1.0 + (taper - 1.0) * np.asarray(relative_height)


@functools.lru_cache
def cantilever_modes(taper=1.0, top_mass_ratio=0.0):
    """The lowest MOST modes, by Rayleigh and Ritz with polynomials zeta^2 P(zeta).

    @param taper  width at the top over that at the foot; stiffness as its cube (tube of constant wall)
    @param top_mass_ratio  mass at the top over that of the mast
    """
    points, weights = np.polynomial.legendre.leggauss(TERMS + 6)
    zeta, weights = 0.5 * (points + 1.0), 0.5 * weights
    basis = [Polynomial([0.0, 0.0, 1.0]) * Legendre.basis(n, domain=[0.0, 1.0]).convert(kind=Polynomial) for n in range(TERMS)]
    width = mass_per_height(zeta, taper)
    values, bending, top = (np.array([f(at) for f in functions]) for functions, at in (
        (basis, zeta), ([f.deriv(2) for f in basis], zeta), (basis, np.array([1.0]))))
    top_mass = top_mass_ratio * (weights @ width)
    squares, vectors = scipy.linalg.eigh((bending * weights * width**3) @ bending.T,
                                         (values * weights * width) @ values.T + top_mass * top @ top.T, subset_by_index=[0, MOST - 1])
    modes = []
    for square, vector in zip(squares, vectors.T):
        vector = vector / (vector @ top[:, 0])
        phi = vector @ values
        whole = weights @ (width * phi**2) + top_mass
        modes.append(Mode(float(np.sqrt(square / squares[0])), sum(c * f for c, f in zip(vector, basis)),
                          float((weights @ (width * phi) + top_mass) / whole), float((weights @ (width * phi * zeta) + top_mass) / whole)))
    return tuple(modes)


def modes_of(mast):
    """cantilever_modes() of a mast of design_plan.json."""
    return cantilever_modes(mast.get("taper", 1.0), mast.get("top_mass_ratio", 0.0))
