"""The history of the validation suite (reference_data/validation_orders/history.csv) as a page: the results of all recordings, and what became worse.

Worse is, from one recording of a series to the next:
- check: its verdict is worse (ok, not met as known, FAILED), or its error grew by more than a tenth and by more than a fiftieth of the tolerance;
- order: it fell by more than 0.1;
- bias: its distance from 1 grew by more than 0.01; spread: it grew by more than a tenth and by more than 0.005;
- time: on the same machine and number of threads it grew by more than a quarter and by more than 2 s.
"""

import io
import math

import jinja2
import markupsafe
import numpy as np
import pandas as pd

from reports import interactive
from mpmtools.figures.style import COLOURS, STYLE, breakable, finish_axes, plt, use_style
from mpmtools.files import write_text
from mpmtools.files import read_text

SERIES = ["level", "case", "kind", "quantity"]
KINDS = {"check": "used fraction of the tolerance", "order": "observed order", "time": "wall time [s]", "bias": "bias", "spread": "standard deviation"}
BAD = "#b3262e"
SHOWN = 60  # recordings on an axis, the latest
VERDICTS = ("ok", "not met", "FAILED")  # of checks, the best first

TEMPLATE = r"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>libmpm validation: history</title>
<style>{{ style }}</style></head>
<body><div class="page">
<nav><b><a href="#top"><span></span>History</a></b>{% for name, _ in figures %}<a href="#{{ name|replace(' ', '-') }}"><span></span>{{ name }}</a>{% endfor %}</nav>
<main><h1 id="top">History of the validation suite</h1>
<p class="lead">Level <em>{{ level }}</em>: {{ recordings|length }} recording{{ '' if recordings|length == 1 else 's' }}, the latest of {{ recordings[-1].date[:10] }},
commit {{ recordings[-1].commit }}.</p>
<div class="score{{ ' bad' if latest }}"><b class="{{ 'failed' if latest else 'ok' }}">{{ latest|length }} change{{ '' if latest|length == 1 else 's' }} for the worse in the latest recording</b>
<span>{{ earlier }} in earlier ones, {{ better }} for the better in the latest</span></div>
{% if latest %}<table class="stack"><thead><tr><th>case</th><th>what</th><th>quantity</th><th class="number">before</th><th class="number">now</th><th>before: commit</th></tr></thead><tbody>
{% for w in latest %}<tr class="bad"><td class="name" data-label="case">{{ (w.case or 'all cases')|breakable }}</td><td data-label="what">{{ kinds[w.kind] }}</td><td class="what" data-label="quantity">{{ w.quantity }}</td>
<td class="number" data-label="before">{{ '%.3g'|format(w.before) }}{{ w.verdict_before|bad_verdict }}</td><td class="number" data-label="now">{{ '%.3g'|format(w.value) }}{{ w.verdict|bad_verdict }}</td>
<td data-label="commit before">{{ w.commit_before }}</td></tr>
{% endfor %}</tbody></table>{% endif %}
<p class="legend">A red mark is a change for the worse against the recording before. Of a check: its verdict is worse (ok; not met, as known; FAILED), or its error grew by more than
a tenth and by more than a fiftieth of its tolerance. A check that is not met has a square mark, one that fails a cross. Of an order: it fell by more than 0.1. Of a bias: its distance from 1 grew by more than 0.01. Of a standard deviation: it grew by more than a tenth and by more than 0.005. Of a time:
on the same machine it grew by more than a quarter and by more than 2 s. <span class="screen">Point at a mark for its value.</span></p>
{% for name, svgs in figures %}<section id="{{ name|replace(' ', '-') }}"><h2>{{ name }}</h2><div class="figures">{% for svg in svgs %}<figure>{{ svg }}</figure>{% endfor %}</div></section>
{% endfor %}</main></div><script>{{ script }}</script></body></html>
"""


def read_history(path, level="standard"):
    """The rows of one level, with the value, verdict and commit of the recording before in `before`, `verdict_before`, `commit_before`, and `worse`, `better`."""
    rows = pd.read_csv(io.StringIO(read_text(path)), dtype={"commit": str, "case": str, "verdict": str, "error": float}, keep_default_na=True)
    rows = rows[rows.level == level].fillna({"case": "", "verdict": ""}).sort_values("date", kind="stable").reset_index(drop=True)
    rows["repeat"] = rows.groupby(["date", *SERIES], sort=False).cumcount()  # a case may check one quantity on several grids under one name
    groups = rows.groupby([*SERIES, "repeat"], sort=False)
    for name in ("value", "error", "verdict", "commit", "machine", "threads"):
        rows["before" if name == "value" else f"{name}_before"] = groups[name].shift()
    rows["worse"] = [_worse(row, row.before, row.value) for row in rows.itertuples()]
    rows["better"] = [_worse(row, row.value, row.before, turned=True) for row in rows.itertuples()]
    return rows


def _worse(row, old, new, turned=False):
    """Whether `new` is worse than `old`. turned: the two recordings are exchanged, so that the verdicts are, too"""
    if pd.isna(row.before) or pd.isna(row.value):
        return False
    if row.kind == "check":
        step = (VERDICTS.index(row.verdict) - VERDICTS.index(row.verdict_before)) * (-1 if turned else 1)
        return step > 0 or (step == 0 and new > 1.1 * old and new > old + 0.02)
    if row.kind == "order":
        return new < old - 0.1
    if row.kind == "bias":
        return abs(math.log(new)) > abs(math.log(old)) + 0.01
    if row.kind == "spread":
        return new > 1.1 * old and new > old + 0.005
    same = row.machine == row.machine_before and row.threads == row.threads_before
    return bool(same and new > 1.25 * old and new > old + 2.0)


def _bad_verdict(verdict):
    """What follows the value of a check that does not hold; empty for another one, and where there is no verdict."""
    return f" ({verdict})" if verdict in VERDICTS[1:] else ""


def draw_history_page(path, target, level="standard"):
    """Writes the page; returns the number of changes for the worse in the latest recording. ValueError: nothing recorded at this level."""
    rows = read_history(path, level)
    if rows.empty:
        raise ValueError(f"{path}: no recording of level {level}")
    use_style()
    recordings = rows.drop_duplicates(["date", "commit"])[["date", "commit"]].to_dict("records")
    last = rows.date == recordings[-1]["date"]
    place = {r["date"]: i for i, r in enumerate(recordings[-SHOWN:])}
    labels = [f"{r['commit'][:8]}\n{r['date'][:10]}" for r in recordings[-SHOWN:]]
    shown = rows[rows.date.isin(place)].assign(place=lambda t: t.date.map(place))
    figures = []
    together = [_panel(shown[shown.kind == kind], labels, kind, f"{title} by quantity") for kind, title in (("bias", "Bias"), ("spread", "Standard deviation"))
                if (shown.kind == kind).any()]
    figures.append(("all cases", together + [_panel(shown[shown.kind == "time"], labels, "time", "Wall time by case", by="case")]))
    for case in sorted(set(shown.case) - {""}):
        mine = shown[shown.case == case]
        figures.append((case, [_panel(mine[mine.kind == kind], labels, kind, title) for kind, title in (("check", "Checks"), ("order", "Orders")) if (mine.kind == kind).any()]))
    environment = jinja2.Environment(autoescape=True, trim_blocks=True)
    environment.filters.update(breakable=breakable, bad_verdict=_bad_verdict)
    page = environment.from_string(TEMPLATE).render(
        style=markupsafe.Markup(STYLE + interactive.STYLE), script=markupsafe.Markup(interactive.SCRIPT), level=level, recordings=recordings, kinds=KINDS, figures=figures,
        latest=rows[last & rows.worse].to_dict("records"), earlier=int((rows.worse & ~last).sum()), better=int((rows.better & last).sum()))
    write_text(target, page)
    return int((rows.worse & last).sum())


def _panel(rows, labels, kind, title, by="quantity"):
    """Values over the recordings, a line for each series; what became worse is red."""
    figure, axes = plt.subplots(figsize=(6.2, 3.9), layout="constrained")
    texts = {}
    floor = 1e-3 if kind == "check" else None  # fraction of the tolerance below which differences are of no interest
    for i, ((name, _), series) in enumerate(rows.groupby([by, "repeat"], sort=False)):
        colour = COLOURS[i % len(COLOURS)]
        value = series.value.replace([np.inf], np.nan).clip(lower=floor)
        axes.plot(series.place, value, "-", color=colour, linewidth=0.8, alpha=0.6, zorder=1)
        for x, y, row in zip(series.place, value, series.itertuples()):
            if not np.isfinite(y):
                continue
            gid = f"history-{title}-{by}-{row.Index}".replace(" ", "-")
            marker = "v" if row.worse else {"not met": "s", "FAILED": "X"}.get(row.verdict, "o")
            axes.plot([x], [y], marker, color=BAD if row.worse else colour, markersize=7 if row.worse else 3.5, gid=gid, zorder=3 if row.worse else 2)
            before = "" if pd.isna(row.before) else f", before {row.before:.3g} ({row.commit_before[:8]})"
            texts[gid] = f"{name}\n{KINDS[kind]}: {row.value:.3g}{before}{'; worse' if row.worse else ''}{_bad_verdict(row.verdict)}\n{row.commit}, {row.date[:10]}"
    if kind in ("check", "time"):
        axes.set_yscale("log")
    if kind in ("check", "bias"):
        axes.axhline(1.0, color="black", linewidth=1.0, zorder=0)
    axes.set_xticks(range(len(labels)), labels, rotation=90 if len(labels) > 5 else 0, fontsize=7.5)
    axes.set_xlim(-0.5, len(labels) - 0.5)
    axes.set_ylabel(KINDS[kind])
    axes.set_title(title, fontsize=10.5, loc="left")
    finish_axes(axes)
    return interactive.inline_svg(figure, texts, f"{title} over the recordings")
