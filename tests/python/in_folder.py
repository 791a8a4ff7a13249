"""A test with a temporary folder."""

import pathlib
import tempfile
import unittest


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
