"""What enters a run, measured in its frames."""

import numpy as np
import pandas as pd

from mpmtools.errors import InputError

SECTION_CELLS = 3.0  # length along the flow of the section that is measured
RESERVOIR_CELLS = 2.0  # before the inlet, where fresh snow appears


def measured_inflow(run):
    """Depth and speed of the snow in the first cells behind the inlet: a data frame with time_s, entered_s (when the snow in the middle of
    the section appeared before the inlet), depth_m, velocity_m_s; a row a frame.

    The depth is that of snow at the density at which it enters: volume in the section over its area. The speed is the mean over the mass.
    """
    conveyor = run.case.get("conveyor")
    if not conveyor or conveyor.get("feed", "window") != "window":
        raise InputError(f'{run.folder}: only a [conveyor] with feed = "window" has an inlet')
    if not run.frames:
        raise InputError(f"{run.folder}: there are no frames; let the run write some ([output] frames_per_second)")
    length = SECTION_CELLS * run.cell_size
    left = -conveyor["upstream_length_m"]
    area = length * conveyor["width_m"] * (0.5 if run.mirrored_y else 1.0)
    rows = []
    for frame in run.frames:
        x = frame["position_m"][:, 0]
        inside = (x >= left) & (x < left + length)
        volume = (frame["reference_volume_m3"] * frame["volume_ratio"])[inside]
        mass = frame["reference_volume_m3"][inside]
        speed = float(np.average(frame["velocity_m_s"][inside, 0], weights=mass)) if inside.any() else np.nan
        way = (0.5 * SECTION_CELLS + RESERVOIR_CELLS) * run.cell_size
        rows.append((frame.time, frame.time - way / speed, float(volume.sum()) / area, speed))
    return pd.DataFrame(rows, columns=["time_s", "entered_s", "depth_m", "velocity_m_s"])
