#!/usr/bin/python3
"""Pictures of one run: `python3 -m mpmtools plot` from a source or an installed tree."""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "python"))
from mpmtools.__main__ import main  # noqa: E402  (after the path to the package)

sys.exit(main(["plot", *sys.argv[1:]]))
