"""Colours of the pictures of runs."""

import numpy as np
from matplotlib.colors import LinearSegmentedColormap

BLUE, ORANGE, GREEN, GREY = "#1f5fa8", "#d9641e", "#2f8f4e", "0.45"
# Almost white for nothing, over blue and yellow to dark red for strong compression.
STRESS_COLOURS = LinearSegmentedColormap.from_list(
    "stress", [(0.45, 0.04, 0.14), (0.89, 0.36, 0.20), (0.98, 0.82, 0.40), (0.42, 0.66, 0.88), (0.78, 0.86, 0.93)])


def colour_range(values, field):
    """(lowest, highest) shown value of a field: 1st and 99th percentile, since single particles must not set the colours. Compression is
    negative and ends at 0; a few particles in slight tension would shift the colours. Others but the density begin at 0."""
    low, high = map(float, np.percentile(values, [1, 99]))
    if field == "stress_xx":
        high = 0.0
    elif field != "density":
        low = 0.0
    return (low, high) if high > low else (low - 0.5, low + 0.5)
