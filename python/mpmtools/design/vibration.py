"""Vibration of a mast under a load that varies in time and height: modes of a cantilever, fixed at the ground.

A mode feels the generalised force Q(t) = integral of q(z, t) phi(z) dz, with the line load q and the shape phi (1 at the top). Its amplitude
times its generalised stiffness, r(t), is the response of the oscillator to Q. What the mass of the mast adds at the foundation is
(r - Q) times the mode's share: integral of phi over integral of phi^2 for the force, integral of phi z over it for the moment (uniform
mass). The part of the load that the modes do not carry acts statically.
"""

from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq


class Mode(NamedTuple):
    """Of a uniform cantilever (Euler and Bernoulli), over its height."""

    number: int
    wave_number: float  # beta: cos beta cosh beta = -1

    @property
    def sigma(self):
        b = self.wave_number
        return (np.cosh(b) + np.cos(b)) / (np.sinh(b) + np.sin(b))

    @property
    def top(self):
        """Value of the textbook's shape at the top."""
        return 2.0 if self.number % 2 else -2.0

    def shape(self, relative_height):
        """phi, 1 at the top; nothing above it."""
        x = self.wave_number * np.clip(relative_height, 0.0, 1.0)
        phi = np.cosh(x) - np.cos(x) - self.sigma * (np.sinh(x) - np.sin(x))
        return np.where(np.asarray(relative_height) <= 1.0, phi / self.top, 0.0)

    @property
    def force_share(self):
        """integral phi / integral phi^2."""
        return 8.0 * self.sigma / (self.wave_number * self.top)

    @property
    def moment_share(self):
        """integral phi zeta / integral phi^2, over the height of the mast."""
        return 8.0 / (self.wave_number**2 * self.top)


def cantilever_mode(number):
    """The mode of this number, 1 is the lowest; up to 10, beyond which the hyperbolic functions lose the digits of the shape."""
    if not 1 <= number <= 10:
        raise ValueError(f"mode {number} of a cantilever: 1 to 10 are possible")
    middle = (number - 0.5) * np.pi
    return Mode(number, brentq(lambda b: np.cos(b) + 1.0 / np.cosh(b), middle - 0.6, middle + 0.6, xtol=1e-14))
