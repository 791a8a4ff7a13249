"""`python3 -m mpmtools fit`: the paper's two regressions over tables of runs; as text, in the layout of the paper's Tables A1 and A2."""

import sys

import numpy as np

from mpmtools.errors import ConfigError
from mpmtools.fit.fits import coefficients_csv, fit_paper_sets, fits_json, scores_csv
from mpmtools.fit.runs import RowFilter, read_runs_or_refuse
from mpmtools.wording import counted

SCORE_LINES = (("R2", "r2", False), ("R2_log", "r2_log", False), ("NRMSE", "nrmse", False), ("RMSLE", "rmsle", False), ("Bias_x", "bias", False),
               ("Frac_10", "fraction_10", True), ("Frac_25", "fraction_25", True))


def table_lines(table):
    """How many rows were read, and why some are left out."""
    return [f"{counted(table.rows, 'row')}, {counted(len(table.runs), 'run')} with a steady run-up",
            *(f"  left out: {rows} ({reason})" for reason, rows in table.left_out.items())]


def fit_lines(s, breakdown=False):
    """One equation on one set: coefficients, scores and, with `breakdown`, the errors by every input."""
    left_out = ((f"; left out: {s.other_width} of another width than H" if s.other_width else "")
                + (f"; left out: {s.without_height} without a steady pressure height" if s.without_height else ""))
    return ["", f"{s.equation.title}, {s.equation.formula}", f"  set '{s.fitting_set.name}': {s.fitting_set.description}; {counted(s.runs, 'run')}{left_out}",
            *(_coefficient_lines(s) if s.fit else [f"  not fitted: {s.why_not}"]), *_score_lines(s), *(_breakdown_lines(s) if breakdown else [])]


def _short(x, digits=4):
    return "-" if np.isnan(x) else f"{x:.{digits}f}"


def _coefficient_lines(s):
    layout = "  {:<12} {:>9} {:>16} {:>12} {:>9}   {:>9} {:>16} {:>11}"
    lines = [layout.format("parameter", "value", "rel. std. error", "t-statistic", "p-value", "published", "rel. std. error", "difference")]
    for name, e in s.fit.estimates.items():
        published, published_error, _ = s.equation.published_estimates[name]
        lines.append(layout.format(f"{name} (-)", _short(e.value), _short(e.relative_error), _short(e.t_statistic, 3),
                                   "-" if np.isnan(e.p_value) else f"{e.p_value:.1e}", _short(published), _short(published_error),
                                   f"{100.0 * (e.value / published - 1.0):.1f}%"))
    if "Fr_sat" in s.fit.estimates:
        lines.append("  Fr_sat, interval of 95 % by the profile of the sum of squares: {:.3f} to {:.3f}".format(*s.fit.saturation_interval))
    return lines + [f"  note: {caution}" for caution in s.fit.cautions]


def _score_lines(s):
    ours, theirs = s.whole("fitted"), s.whole("published")
    if theirs is None:
        return []
    layout = "  {:<10} {:>22} {:>22} {:>24}"

    def text(scores, key, as_per_cent):
        if scores is None or np.isnan(scores[key]):
            return "-"
        return f"{100.0 * scores[key]:.1f} %" if as_per_cent else f"{scores[key]:.3f}"

    return [layout.format("metric", "our data, our fit", "our data, published", "published on its own data"),
            *(layout.format(name, *(text(scores, key, as_per_cent) for scores in (ours, theirs, s.equation.published_scores)))
              for name, key, as_per_cent in SCORE_LINES)]


def _breakdown_lines(s):
    """RMSLE or NRMSE of both sets of coefficients, by each input."""
    groups = s.scores[s.scores.group != ""]
    keys = ["hardening_xi", "group", "at", "runs"]
    ours, theirs = (groups.loc[groups.coefficients == source, [*keys, s.equation.score]] for source in ("fitted", "published"))
    both = theirs.merge(ours, "left", on=keys, suffixes=("_published", "_fitted"))
    layout = "  {:<16}{:>28} {:>10} {:>6} {:>10} {:>10}"
    lines = [layout.format(f"{s.equation.score.upper()} by input", "input", "value", "runs", "our fit", "published")]
    for row in both.to_dict("records"):
        which = "set" if np.isnan(row["hardening_xi"]) else f"xi = {row['hardening_xi']:g}"
        errors = (row[f"{s.equation.score}_{source}"] for source in ("fitted", "published"))
        lines.append(layout.format(which, row["group"], f"{row['at']:.4g}", row["runs"],
                                   *("-" if np.isnan(error) else f"{100.0 * error:.1f}%" for error in errors)))
    return lines


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
