#!/usr/bin/python3
"""The page of a design: `python3 -m mpmtools design` from a source or an installed tree."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "python"))
from mpmtools.__main__ import main  # noqa: E402  (after the path to the package)

sys.exit(main(["design", *sys.argv[1:]]))
