"""What enters a run, and what arrives at the mast, measured in its frames."""

import numpy as np
import pandas as pd

from mpmtools.errors import InputError

SECTION_CELLS = 3.0  # length along the flow of the section that is measured
RESERVOIR_CELLS = 2.0  # before the inlet, where fresh snow appears


def measured_inflow(run, at=None):
    """Depth and speed of the snow in the first cells behind the inlet: a data frame with time_s, entered_s (when the snow in the middle of
    the section appeared before the inlet), depth_m, velocity_m_s; a row a frame.

    The depth is that of snow at the density at which it enters: volume in the section over its area. The speed is the mean over the mass.
    @param at  x of the middle of the section, m, in place of the first cells; 0 is where the mast stands: in a run without one, depth and
               speed there are what arrives at it. entered_s then takes the speed of the snow to be the same all the way
    """
    conveyor = run.case.get("conveyor")
    if not conveyor or conveyor.get("feed", "window") != "window":
        raise InputError(f'{run.folder}: only a [conveyor] with feed = "window" has an inlet')
    length = SECTION_CELLS * run.cell_size
    inlet = -conveyor["upstream_length_m"]
    left = inlet if at is None else at - 0.5 * length
    area = length * conveyor["width_m"] * (0.5 if run.mirrored_y else 1.0)
    rows = []
    for frame in run.require_frames():
        x = frame["position_m"][:, 0]
        inside = (x >= left) & (x < left + length)
        volume = (frame["reference_volume_m3"] * frame["volume_ratio"])[inside]
        mass = frame["reference_volume_m3"][inside]
        speed = float(np.average(frame["velocity_m_s"][inside, 0], weights=mass)) if inside.any() else np.nan
        way = left + 0.5 * length - inlet + RESERVOIR_CELLS * run.cell_size
        rows.append((frame.time, frame.time - way / speed, float(volume.sum()) / area, speed))
    return pd.DataFrame(rows, columns=["time_s", "entered_s", "depth_m", "velocity_m_s"])
