"""One stored state of a run: a frame, or its last state."""

import contextlib
import re
from collections.abc import Mapping
from functools import cached_property

import h5py
import numpy as np
import pandas as pd

from mpmtools.checksums import check_seal
from mpmtools.errors import InputError
from mpmtools.files import MissingEntry


class _Arrays:
    """The datasets of an open file; one that is missing is a MissingEntry, which names the file."""

    def __init__(self, file, path):
        self.file, self.path, self.attrs = file, path, file.attrs

    def __getitem__(self, name):
        if not isinstance(self.file.get(name), h5py.Dataset):
            raise MissingEntry(f"{self.path}: no array '{name}'; there are: {', '.join(self.file)}")
        return self.file[name]

    def __iter__(self):
        return iter(self.file)


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


AXES = {"kirchhoff_stress_pa": ("xx", "yy", "zz", "xy", "xz", "yz"), "velocity_gradient_1_s": tuple(i + j for i in "xyz" for j in "xyz"),
        "position_m": "xyz", "velocity_m_s": "xyz"}  # of each component of an array
UNIT = re.compile(r"_(kg_m3|m_s|m3|1_s|pa|m)$")


def mirror_image(name, array, axis):
    """An array of the particles behind the mirror plane: a component changes its sign if it names the axis an odd number of times."""
    if name not in AXES:
        return array
    signs = np.array([(-1.0) ** component.count(axis) for component in AXES[name]], array.dtype)
    return array * signs.reshape(array.shape[1:])


def by_components(array):
    """An array of the particles with a column a component."""
    return array if array.ndim == 1 else array.reshape(len(array), int(np.prod(array.shape[1:])))  # -1 is refused where no particle is left


class Frame(Mapping):
    """One stored state: a mapping from the names of its arrays to the arrays, each read when it is asked for; `attributes` holds time_s and more."""

    def __init__(self, path):
        self.path = path

    def __repr__(self):
        return f"Frame({self.path!r})"

    def __getitem__(self, name):
        with open_hdf5(self.path) as file:
            return file[name][:]

    def __iter__(self):
        return iter(self._names)

    def __len__(self):
        return len(self._names)

    def __contains__(self, name):  # that of Mapping reads the array
        return name in self._names

    __eq__, __hash__ = object.__eq__, object.__hash__

    @property
    def table(self):
        """The particles as a DataFrame, a row a particle by its `id`: position_x_m, velocity_x_m_s, kirchhoff_stress_xx_pa, density_kg_m3, ..."""
        columns, count = {}, len(self["position_m"])
        for name in self:
            array, stem = by_components(self[name]), UNIT.sub("", name)
            if name == "vertex" or len(array) != count:  # the list of cells of frames.xdmf
                continue
            if array.ndim == 1:
                columns[name] = array
                continue
            for axes, component in zip(AXES.get(name, range(array.shape[1])), array.T):
                columns[f"{stem}_{axes}{name[len(stem):]}"] = component
        table = pd.DataFrame(columns)
        return table.set_index("id") if "id" in table else table

    def whole(self, name):
        """An array for the whole flow: where half of it was computed, or a quarter, the mirror images at x = 0 and y = 0 follow."""
        array = self[name]
        for axis in "xy":
            if self.attributes.get(f"mirror_{axis}"):
                array = np.concatenate([array, mirror_image(name, array, axis)])
        return array

    @cached_property
    def _names(self):
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
