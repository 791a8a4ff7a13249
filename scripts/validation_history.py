#!/usr/bin/python3
"""Draws the history of the validation suite as a page, and says how many values became worse in the latest recording.

usage: validation_history.py HISTORY.csv PAGE.html [LEVEL]    (default level: standard)
"""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "python"))
from reports.validation_history import draw_history_page  # noqa: E402  (after the path to the package)

if __name__ == "__main__":
    if len(sys.argv) not in (3, 4):
        sys.exit(__doc__)
    try:
        worse = draw_history_page(sys.argv[1], sys.argv[2], *sys.argv[3:])
    except (OSError, ValueError) as error:
        sys.exit(f"validation_history: {error}")
    print(f"{sys.argv[2]}: {worse} change{'' if worse == 1 else 's'} for the worse in the latest recording", file=sys.stderr)
