"""Colours of the pictures of runs."""

from matplotlib.colors import LinearSegmentedColormap

BLUE, ORANGE, GREEN, GREY = "#1f5fa8", "#d9641e", "#2f8f4e", "0.45"
# Almost white for nothing, over blue and yellow to dark red for strong compression.
STRESS_COLOURS = LinearSegmentedColormap.from_list(
    "stress", [(0.45, 0.04, 0.14), (0.89, 0.36, 0.20), (0.98, 0.82, 0.40), (0.42, 0.66, 0.88), (0.78, 0.86, 0.93)])
