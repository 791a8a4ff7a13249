"""Several solvers side by side: what each made of the same cases, from the results.json of mpm-validate run and grade."""

import pathlib

import jinja2
import markupsafe

from reports import interactive
from mpmtools.figures.style import COLOURS, MARKERS, STYLE, breakable, finish_axes, plt, use_style, verdict_class
from mpmtools.files import write_text
from mpmtools.files import read_json

LEAST = 1e-3  # fraction of the tolerance below which differences are of no interest

TEMPLATE = r"""<!doctype html>
<html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width, initial-scale=1">
<title>libmpm validation: solvers</title><style>{{ style }}</style></head>
<body><div class="page"><nav><b><a href="#top"><span></span>Solvers</a></b>{% for c in cases %}<a href="#{{ c.name }}"><span></span>{{ c.name }}</a>{% endfor %}</nav>
<main><h1 id="top">Solvers side by side</h1>
<p class="lead">The same cases, references and checks for every solver. A solver that has no results for a case, or a check that knows the scheme of libmpm, leaves its cell empty.</p>
<table class="stack"><thead><tr><th>solver</th><th class="number">cases</th><th class="number">checks passed</th><th class="number">failed</th><th>version, level</th></tr></thead><tbody>
{% for s in solvers %}<tr class="{{ 'bad' if s.failed }}"><td class="name" data-label="solver">{{ s.name }}</td><td class="number" data-label="cases">{{ s.cases }}</td>
<td class="number" data-label="passed">{{ s.passed }}</td><td class="number" data-label="failed">{{ s.failed }}</td><td data-label="version">{{ s.version }}</td></tr>
{% endfor %}</tbody></table>
{% for c in cases %}<section id="{{ c.name }}"><h2>{{ c.title }}</h2>
<div class="figures"><figure>{{ c.svg }}</figure></div>
<table class="stack"><thead><tr><th>quantity</th><th class="number">reference</th><th class="number">tolerance</th>{% for s in c.solvers %}<th class="number">{{ s }}: result</th><th class="number">error</th>{% endfor %}</tr></thead><tbody>
{% for row in c.rows %}<tr><td class="what" data-label="quantity">{{ row.quantity }}</td><td class="number" data-label="reference">{{ '≤ ' if row.bound }}{{ row.reference }} {{ row.unit }}</td>
<td class="number" data-label="tolerance">{{ row.tolerance }}</td>{% for s in c.solvers %}{% set k = row.of[s] %}{% if k %}<td class="number" data-label="{{ s }}">{{ k.text.value }}</td>
<td class="number verdict {{ k.verdict|verdict_class }}" data-label="error">{{ k.text.error }}{{ '' if k.verdict == 'ok' else ' ' + k.verdict }}</td>{% else %}<td class="empty"></td><td class="empty"></td>{% endif %}{% endfor %}</tr>
{% endfor %}</tbody></table></section>
{% endfor %}</main></div><script>{{ script }}</script></body></html>
"""


def draw_comparison(directories, target):
    """Writes the page for the reports in `directories`: folders with a results.json. ValueError: two levels, or no case that two of them have."""
    reports = {}
    for directory in directories:
        results = read_json(pathlib.Path(directory) / "results.json")
        reports.setdefault(results["solver"] or "libmpm", []).append(results)
    levels = {r["level"] for parts in reports.values() for r in parts}
    if len(levels) > 1:
        raise ValueError(f"the reports are of several levels: {', '.join(sorted(levels))}")
    by_solver = {solver: {c["name"]: c for r in parts for c in r["cases"]} for solver, parts in reports.items()}
    names = sorted({name for cases in by_solver.values() for name in cases})
    shared = [name for name in names if sum(name in cases for cases in by_solver.values()) > 1]
    if not shared:
        raise ValueError("no case is in the reports of two solvers")
    use_style()
    cases = [_case(name, {s: c[name] for s, c in by_solver.items() if name in c}) for name in shared]
    solvers = [{"name": s, "cases": sum(n in c for n in shared), "passed": sum(c[n]["checks_passed"] for n in shared if n in c),
                "failed": sum(c[n]["checks_failed"] for n in shared if n in c), "version": f"judged by libmpm {reports[s][0]['version']}, {reports[s][0]['commit']}, {min(levels)}"}
               for s, c in by_solver.items()]
    environment = jinja2.Environment(autoescape=True, trim_blocks=True)
    environment.filters.update(breakable=breakable, verdict_class=verdict_class)
    write_text(target, environment.from_string(TEMPLATE).render(style=markupsafe.Markup(STYLE + interactive.STYLE), script=markupsafe.Markup(interactive.SCRIPT),
                                                                     cases=cases, solvers=solvers))


def _case(name, by_solver):
    """One case: a row for each check that any of the solvers has, in the order of the first solver that has it."""
    rows = {}
    for solver, case in by_solver.items():
        for check in case["checks"]:
            row = rows.setdefault(check["quantity"], {"quantity": check["quantity"], "reference": check["text"]["reference"], "unit": check["unit"],
                                                      "bound": check["measure"] == "at_most", "tolerance": check["text"]["tolerance"], "of": dict.fromkeys(by_solver)})
            row["of"][solver] = check
    together = [row for row in rows.values() if sum(k is not None for k in row["of"].values()) > 1]
    return {"name": name, "title": next(iter(by_solver.values()))["title"], "solvers": list(by_solver), "rows": together or list(rows.values()),
            "svg": _used_shares(name, list(by_solver), together or list(rows.values()))}


def _used_shares(name, solvers, rows):
    """The fraction of its tolerance that each solver uses, check by check; right of 1 a check fails."""
    figure, axes = plt.subplots(figsize=(6.2, 1.3 + 0.28 * len(rows)), layout="constrained")
    texts = {}
    for i, solver in enumerate(solvers):
        for y, row in enumerate(rows):
            check = row["of"][solver]
            if check is None or check["tolerance_used"] is None:
                continue
            gid = f"solver-{name}-{i}-{y}"
            axes.plot([max(check["tolerance_used"], LEAST)], [y], MARKERS[i % len(MARKERS)], color=COLOURS[i % len(COLOURS)], markersize=6,
                      markerfacecolor="none" if i else COLOURS[0], gid=gid, label=solver if y == 0 else None)
            texts[gid] = f"{solver}\n{row['quantity']}\nresult {check['text']['value']}, error {check['text']['error']}, tolerance {row['tolerance']}"
    axes.axvline(1.0, color="black", linewidth=1.0)
    axes.set_xscale("log")
    axes.set_ylim(len(rows) - 0.5, -0.5)
    axes.set_yticks(range(len(rows)), [row["quantity"][:44] + ("…" if len(row["quantity"]) > 44 else "") for row in rows], fontsize=7)
    axes.set_xlabel("used fraction of the tolerance")
    finish_axes(axes)
    handles = [plt.Line2D([], [], linestyle="", marker=MARKERS[i % len(MARKERS)], color=COLOURS[i % len(COLOURS)], markerfacecolor="none" if i else COLOURS[0], label=s)
               for i, s in enumerate(solvers)]
    axes.legend(handles=handles, fontsize=8, frameon=False, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=3)
    return interactive.inline_svg(figure, texts, f"Used fraction of the tolerance, {name}")
