"""A test with a temporary folder."""

import contextlib
import pathlib
import tempfile
import unittest

import h5py

from mpmtools.checksums import SEAL, checksum


@contextlib.contextmanager
def sealed_h5(path, mode="w"):
    """An HDF5 file to write to, which gets the checksum at its end that files of libmpm have."""
    with h5py.File(path, mode) as file:
        yield file
    content = pathlib.Path(path).read_bytes()
    pathlib.Path(path).write_bytes(content + SEAL + checksum(content).encode())


class InFolder(unittest.TestCase):
    """self.folder is the temporary folder."""

    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def write(self, name, text):
        """Path, as a string, of a new file of this name in the folder."""
        path = self.folder / name
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text, encoding="utf-8")
        return str(path)
