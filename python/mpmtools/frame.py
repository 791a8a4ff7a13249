"""One stored state of a run: a frame, or its last state."""

from functools import cached_property

import h5py

from mpmtools.errors import InputError


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
        try:
            return h5py.File(self.path, "r")
        except OSError as error:
            raise InputError(f"cannot read '{self.path}': {error}") from None
