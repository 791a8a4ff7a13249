"""`python3 -m mpmtools fit`: the paper's two regressions over tables of runs."""

import sys

from mpmtools.errors import ConfigError
from mpmtools.fit.text import fit_lines, table_lines
from mpmtools.fit.fits import coefficients_csv, fit_paper_sets, fits_json, scores_csv
from mpmtools.fit.runs import RowFilter, read_runs_or_refuse


def run_command(options):
    table = read_runs_or_refuse(options.tables, [RowFilter(text) for text in options.filter])
    fits = fit_paper_sets(table.runs)
    if not any(s.fit for s in fits):
        raise ConfigError(f"{', '.join(options.tables)}: {fits[0].why_not}")
    for caution in table.cautions:
        print(f"note: {caution}", file=sys.stderr)
    if options.json:
        print(fits_json(fits, table), end="")
    elif options.csv:
        print((coefficients_csv if options.csv == "coefficients" else scores_csv)(fits), end="")
    else:
        print(*table_lines(table), *(line for s in fits for line in fit_lines(s, options.breakdown)), sep="\n")
