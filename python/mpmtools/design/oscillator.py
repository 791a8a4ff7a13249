"""What a mast feels of a force over time: the linear oscillator of one mode, m u'' + c u' + k u = F(t).

The result is the equivalent static force k u: the static force that bends the mast as far. The force is the generalised force of the
mode (vibration.py), or acts where the mode has its unit of displacement.
"""

import numpy as np
import scipy.signal


def equivalent_static_force(interval, force, frequency, damping):
    """k u at the end of each interval, in the unit of the force, for a mast at rest at the start.

    Exact for a force that is constant in each interval, as the rows of series.csv are (means over the interval before).
    @param interval s; @param force one value an interval; @param frequency Hz; @param damping ratio to critical, 0 <= damping < 1
    """
    omega = 2.0 * np.pi * frequency
    damped = omega * np.sqrt(1.0 - damping**2)
    decay = np.exp(-damping * omega * interval)
    c, s = decay * np.cos(damped * interval), decay * np.sin(damped * interval) * damping * omega / damped
    return scipy.signal.lfilter([1.0 - c - s, decay**2 - c + s], [1.0, -2.0 * c, decay**2], force)


def shock_response_spectrum(interval, force, frequencies, damping):
    """Largest equivalent static force at each frequency (maximax of the whole series), in the unit of the force."""
    return np.array([np.max(np.abs(equivalent_static_force(interval, force, f, damping))) for f in frequencies])
