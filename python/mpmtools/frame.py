"""One stored state of a run: a frame, or its last state."""

from functools import cached_property

import numpy as np

from mpmtools.checksums import open_h5


class Frame:
    """One stored state. `frame["position_m"]` reads an array; `frame.names` lists them; `frame.attributes` holds time_s and more."""

    def __init__(self, path):
        self.path = path

    def __repr__(self):
        return f"Frame({self.path!r})"

    def __getitem__(self, name):
        with self._open() as file:
            if name not in file:
                raise KeyError(f"{self.path}: no array '{name}'; there are: {', '.join(file)}")
            return file[name][:]

    def whole(self, name):
        """An array for the whole flow: where half of it was computed, the mirror image at y = 0 follows. For positions, velocities and
        scalars."""
        array = self[name]
        if not self.attributes.get("mirror_y"):
            return array
        return np.concatenate([array, array * [1.0, -1.0, 1.0] if array.ndim == 2 else array])

    @cached_property
    def names(self):
        with self._open() as file:
            return list(file)

    @cached_property
    def attributes(self):
        with self._open() as file:
            return dict(file.attrs)

    @property
    def time(self):
        """s."""
        return float(self.attributes["time_s"])

    def _open(self):
        return open_h5(self.path)
