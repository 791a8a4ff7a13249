#!/usr/bin/python3
"""Several solvers on one page, from the reports of `mpm-validate run` and `mpm-validate grade`.

usage: compare_solvers.py PAGE.html REPORT...    REPORT: a directory with a results.json
"""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "python"))
from reports.solver_comparison import draw_comparison  # noqa: E402  (after the path to the package)

if __name__ == "__main__":
    if len(sys.argv) < 4:
        sys.exit(__doc__)
    try:
        draw_comparison(sys.argv[2:], sys.argv[1])
    except (OSError, ValueError, KeyError) as error:
        sys.exit(f"compare_solvers: {error}")
    print(sys.argv[1], file=sys.stderr)
