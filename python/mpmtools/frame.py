"""One stored state of a run: a frame, or its last state."""

import contextlib
from functools import cached_property

import h5py
import numpy as np

from mpmtools.checksums import check_seal
from mpmtools.errors import InputError
from mpmtools.files import MissingEntry


class _Arrays:
    """The datasets of an open file; one that is missing is a MissingEntry, which names the file."""

    def __init__(self, file, path):
        self.file, self.path = file, path

    def __getitem__(self, name):
        if not isinstance(self.file.get(name), h5py.Dataset):
            raise MissingEntry(f"{self.path}: no array '{name}'; there are: {', '.join(self.file)}")
        return self.file[name]

    def __iter__(self):
        return iter(self.file)

    @property
    def attrs(self):
        return self.file.attrs


@contextlib.contextmanager
def open_hdf5(path):
    """The datasets of an HDF5 file of libmpm, for reading. A file that is damaged, does not match its checksum, or lacks one, is an
    InputError that names it."""
    try:
        check_seal(path)
        with h5py.File(path, "r") as file:
            yield _Arrays(file, path)
    except InputError:
        raise
    except (OSError, RuntimeError, ValueError, TypeError, KeyError) as error:  # what h5py raises where the file is damaged
        raise InputError(f"cannot read '{path}': {error}") from None


class Frame:
    """One stored state. `frame["position_m"]` reads an array; `frame.names` lists them; `frame.attributes` holds time_s and more."""

    def __init__(self, path):
        self.path = path

    def __repr__(self):
        return f"Frame({self.path!r})"

    def __getitem__(self, name):
        with open_hdf5(self.path) as file:
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
        with open_hdf5(self.path) as file:
            return list(file)

    @cached_property
    def attributes(self):
        with open_hdf5(self.path) as file:
            return dict(file.attrs)

    @property
    def time(self):
        """s."""
        if "time_s" not in self.attributes:
            raise MissingEntry(f"{self.path}: there is no attribute 'time_s'; the file is damaged, or of another program")
        return float(self.attributes["time_s"])
