#!/usr/bin/python3
"""Draws the report of mpm-validate: DIR/index.html from DIR/results.json.

Every number and every verdict was computed by mpm-validate; this script formats and draws, and decides nothing. The page holds its
images and needs no other file.

usage: validation_report.py DIR
"""

import base64
import json
import os
import pathlib
import sys
import textwrap

import jinja2
import markupsafe
import numpy as np
from matplotlib.patches import Polygon

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent.parent / "python"))
from mpmtools.figures.style import (COLOURS, MARKERS, STYLE, breakable, finish_axes, inline, plain_ticks, plt, png_data,  # noqa: E402
                                    short, use_style, verdict_class)
from mpmtools.files import write_text  # noqa: E402
from reports import interactive  # noqa: E402
from reports.summary import REFERENCES, summary_figures  # noqa: E402
from mpmtools.frame import Frame  # noqa: E402  (after the path to the package)

LONG_TABLE, SHOWN_ROWS = 40, 20  # a table of more checks shows so many at first

FLOW_FIELDS = {
    "speed": "speed |v|",
    "velocity_x": "velocity $v_x$",
    "velocity_z": "velocity $v_z$",
    "pressure": "pressure, compression positive",
    "stress_xx": r"stress $\sigma_{xx}$, tension positive",
    "density": "density",
}

TEMPLATE = r"""<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{{ 'libmpm' if not r.solver else r.solver + ', judged by libmpm' }} validation: {{ r.passed }} passed, {{ r.failed }} failed</title>
<style>
{{ style }}{{ interactive_style }}</style>
</head>
<body><div class="page">
<nav id="cases"><b><a href="#summary"><span></span>Summary</a></b>
{% for c in r.cases %}<a href="#{{ c.name }}"><span class="{{ c.verdict|verdict_class }}">{{ '✗' if not c.passed else '–' if c.checks_not_met else '✓' }}</span>{{ c.title }}</a>
{% endfor %}</nav>
<main>
<h1 id="summary">{{ 'libmpm validation' if not r.solver else 'Validation of ' + r.solver }}</h1>
<p class="lead">Theory against simulation, level <em>{{ r.level }}</em>. Verification compares with an exact solution or property, validation with an experiment or the
paper, regression with an earlier result of this program.{% if r.solver %} Another solver made the runs: {{ r.solver }}. The references and the checks are those of libmpm.{% endif %}</p>
<div class="score{{ ' bad' if failing else ' missed' if r.not_met }}"><span><b class="{{ 'failed' if failing else 'known' if r.not_met else 'ok' }}">{{ r.passed }} passed, {{ r.failed }} failed{% if r.not_met %}, {{ r.not_met }} not met as known{% endif %}</b></span>
{% if failing %}<span class="failed">failing: {% for c in failing %}<a class="failed" href="#{{ c.name }}">{{ c.name }}</a>{{ ', ' if not loop.last }}{% endfor %}</span>{% endif %}
<span>{{ r.cases|length }} case{{ '' if r.cases|length == 1 else 's' }} in {{ '%.0f'|format(r.wall_time_s) }} s{% if r.time_budget_s and not r.solver %}; the level may take {{ '%.0f'|format(r.time_budget_s) }} s on two idle cores{% endif %}</span></div>
{% if r.summary.rows %}<h3 id="predicted">Predicted against reference</h3>
<table class="stack"><thead><tr><th>quantity</th><th>compared with</th><th class="number">values</th><th class="number">cases</th>
<th class="number">uncertainty of the references</th><th class="number">bias of the model</th><th class="number">relative standard deviation of the model</th>
<th>farthest from 1</th></tr></thead><tbody>
{% for s in r.summary.rows %}<tr><td class="name" data-label="quantity">{{ s.quantity }}</td><td data-label="compared with">{{ references[s.label] }}</td>
<td class="number" data-label="values">{{ s['values'] }}</td><td class="number" data-label="cases">{{ s.cases }}</td>
<td class="number" data-label="references">{{ s.reference_uncertainty|percent if s.reference_uncertainty else 'exact' }}</td>
<td class="number" data-label="bias"><b>{{ '%.3f'|format(s.bias) if s.bias is not none }}</b></td>
<td class="number" data-label="model">{% if s.model_spread is none %}one value{% elif s.model_spread == 0 and s.spread > 0 %}below the references' ({{ s.spread|percent }} in all){% else %}<b>{{ s.model_spread|percent }}</b>{% endif %}</td>
<td data-label="farthest"><span>{{ '%.3f'|format(s.farthest) }}: {{ s.farthest_name }}{% if s.without_ratio %}; {{ s.without_ratio }} without a ratio{% endif %}</span></td></tr>
{% endfor %}</tbody></table>
<p class="legend">Bias: predicted over reference value; above 1 the model predicts too much. Bias and standard deviations are those of the logarithm of the ratio, as in the validation
guide of FDS (McGrattan and Toman 2011): the spread of the ratios is that of the model and of the references together. Values of one case depend on each other.</p>
{% if summary_figures %}<div class="figures summary">{% for title, svg in summary_figures %}<figure>{{ svg }}</figure>
{% endfor %}</div>
<p class="legend">Filled marks: exact solutions; open marks: experiments or the paper. Black: equality; grey: twice the standard deviation of the references. Solid and dashed lines: bias of the
model, and twice its standard deviation (blue: against exact solutions, red: against experiments and the paper). <span class="screen">Point at a mark for its case and value, in
the figures of a case at a curve for its values; drag to enlarge, double-click to return.</span></p>{% endif %}
{% endif %}<dl class="facts">
<dt>command</dt><dd><code>{{ r.command }}</code></dd>
<dt>version</dt><dd>{{ r.version }}, commit {{ r.commit }}, {{ r.compiler }}, {{ r.build_type }}, {{ r.instruction_set }}</dd>
<dt>machine</dt><dd>{{ r.machine }}; {{ r.threads }} thread{{ '' if r.threads == 1 else 's' }} used</dd>
<dt>date</dt><dd>{{ r.started }}</dd>
</dl>
{% if failing %}<h3>What failed</h3>
<table class="stack"><thead><tr><th>case</th><th>label</th><th>quantity</th><th class="number">reference</th><th class="number">result</th><th class="number">error</th>
<th class="number">order</th><th class="number">tolerance</th></tr></thead><tbody>
{% for c in failing %}{% if c.fault %}<tr class="bad"><td class="name" data-label="case"><a href="#{{ c.name }}">{{ c.name|breakable }}</a></td><td class="fault" data-label="message" colspan="7">{{ c.fault }}</td></tr>{% endif %}
{% for k in c.checks if k.verdict == 'FAILED' %}<tr class="bad"><td class="name" data-label="case"><a href="#{{ c.name }}">{{ c.name|breakable }}</a></td><td data-label="label">{{ k.label }}</td><td class="what" data-label="quantity">{{ k.quantity }}</td>
{{ numbers(k) }}<td class="number" data-label="tolerance">{{ k.text.tolerance }}{{ ', known: ' + k.text.miss_bound if k.text.miss_bound }}</td></tr>{% endfor %}{% endfor %}
</tbody></table>
{% endif %}
{% if r.not_met %}<h3>Targets that are known not to be met</h3>
<table class="stack"><thead><tr><th>case</th><th>label</th><th>quantity</th><th class="number">reference</th><th class="number">result</th><th class="number">error</th>
<th class="number">order</th><th class="number">tolerance</th><th class="number">must be</th><th>cause</th></tr></thead><tbody>
{% for c in r.cases %}{% for k in c.checks if k.verdict == 'not met' %}<tr class="known"><td class="name" data-label="case"><a href="#{{ c.name }}">{{ c.name|breakable }}</a></td><td data-label="label">{{ k.label }}</td><td class="what" data-label="quantity">{{ k.quantity }}</td>
{{ numbers(k) }}<td class="number" data-label="tolerance">{{ k.text.tolerance }}</td><td class="number" data-label="must be">{{ k.text.miss_bound }}</td><td data-label="cause">{{ k.miss_cause }}</td></tr>{% endfor %}{% endfor %}
</tbody></table>
{% endif %}
<h3>Case by case</h3>
<table class="stack">
<thead><tr><th>case</th><th>label</th><th class="number">checks</th><th>closest to its tolerance</th><th class="number">reference</th><th class="number">result</th><th class="number">error</th>
<th class="number">order</th><th class="number">tolerance</th><th class="number">used</th><th>verdict</th><th class="number">time</th></tr></thead>
<tbody>
{% for c in r.cases %}{% set k = c.tightest %}
<tr class="{{ 'bad' if not c.passed }}"><td class="name" data-label="case"><a href="#{{ c.name }}">{{ c.name|breakable }}</a></td><td data-label="label">{{ c.labels }}</td>
<td class="number" data-label="checks">{{ c.checks_passed }}/{{ c.checks_passed + c.checks_failed + c.checks_not_met }}</td>
{% if c.fault %}<td class="fault" data-label="message" colspan="7">{{ c.fault }}</td>
{% else %}<td class="what" data-label="closest">{{ k.quantity }}</td>{{ numbers(k) }}
<td class="number" data-label="tolerance">{{ k.text.tolerance }}</td><td class="number" data-label="used"><span>{{ k.text.tolerance_used }}{{ bar(k) }}</span></td>{% endif %}
<td data-label="verdict" class="verdict {{ c.verdict|verdict_class }}">{{ c.verdict }}</td>
<td class="number" data-label="time">{{ '%.1f'|format(c.wall_time_s) }} s</td></tr>
{% endfor %}
<tr><td class="name" data-label="case">all</td><td class="empty"></td><td class="number" data-label="checks">{{ r.passed }}/{{ r.passed + r.failed + r.not_met }}</td><td class="empty" colspan="7"></td>
<td data-label="verdict" class="verdict {{ 'failed' if failing else 'known' if r.not_met else 'ok' }}">{{ 'FAILED' if failing else 'ok, %d not met'|format(r.not_met) if r.not_met else 'ok' }}</td><td class="number" data-label="time">{{ '%.1f'|format(r.wall_time_s) }} s</td></tr>
</tbody></table>
<p class="legend">A row shows the check of its case that uses most of its tolerance; all checks are below, with their case, and in <code>orders.csv</code>. Errors and tolerances in per cent or
without unit are relative, those with the quantity's unit absolute. '≤' is a bound; its error is how far the result lies above it.</p>
{% for c in r.cases %}
<section id="{{ c.name }}">
<div class="heading"><h2>{{ c.title }}</h2><span class="tag">{{ c.name }}{{ ', ' if c.labels }}{{ c.labels }}</span><span class="verdict {{ c.verdict|verdict_class }}">{{ c.verdict }}</span>
<span class="tag">{{ c.checks_passed }} of {{ c.checks_passed + c.checks_failed + c.checks_not_met }} checks, {{ '%.1f'|format(c.wall_time_s) }} s</span><a class="top" href="#summary">summary</a></div>
{% if c.fault %}<p class="failed">{{ c.fault }}</p>{% endif %}
<p class="physics">{{ c.physics|inline }}</p>
<p class="legend">Repeat it: <code>{{ c.command }}</code>. Derivation and sources: <code>validation/cases/{{ c.name }}/README.md</code>.</p>
{% if c.images %}<div class="figures">{% for f in c.images %}<figure>{% if f.svg %}{{ f.svg }}{% else %}<img alt="{{ f.title }}" src="{{ f.data }}">{% endif %}{% if f.caption %}<figcaption>{{ f.caption|inline }}</figcaption>{% endif %}</figure>
{% endfor %}</div>{% endif %}
{% if c.studies %}<h3>Grid convergence</h3>
<div class="figures">{% for s in c.studies %}<figure>{{ s.svg }}</figure>
{% endfor %}</div>
<table class="stack"><thead><tr><th>quantity</th><th>value at each size</th><th class="number">order</th><th class="number">extrapolated</th>
<th class="number">GCI of the finest</th><th class="number">numerical uncertainty</th><th>remark</th></tr></thead><tbody>
{% for s in c.studies %}<tr><td class="what" data-label="quantity">{{ s.quantity }}{% if s.unit %} [{{ s.unit }}]{% endif %}</td>
<td data-label="values">{% for h in s.size %}{{ '%.4g'|format(h) }}:&nbsp;{{ s.value[loop.index0]|short }}{{ ', ' if not loop.last }}{% endfor %}</td>
<td class="number" data-label="order">{{ s.order|short }}</td>
<td class="number" data-label="extrapolated">{{ s.extrapolated|short }}</td>
<td class="number" data-label="GCI">{% if s.gci is not none %}{{ '%.2g'|format(100 * s.gci) }} % (Fs {{ s.safety_factor|short }}){% endif %}</td>
<td class="number" data-label="uncertainty">{{ s.uncertainty|short }}</td><td data-label="remark">{{ s.remark }}</td></tr>{% endfor %}
</tbody></table>{% endif %}
{% if c.checks %}<h3>Checks</h3>
<div>{% if c.rest %}<input type="checkbox" class="unfold" id="unfold-{{ c.name }}">{% endif %}
<table class="stack"><thead><tr><th>label</th><th>quantity</th><th class="number">reference</th><th class="number">result</th><th class="number">error</th>
<th class="number">order</th><th class="number">tolerance, why</th><th class="number">used</th><th>verdict</th></tr></thead><tbody>
{% for k in c.checks %}<tr class="{{ {'FAILED': 'bad', 'not met': 'known'}.get(k.verdict, '') }}{{ ' rest' if k.rest }}"><td data-label="label">{{ k.label }}</td><td class="what" data-label="quantity">{{ k.quantity }}</td>
{{ numbers(k) }}<td class="number" data-label="tolerance"><span>{{ k.text.tolerance }}{% if k.reason %}<sup><a href="#{{ c.name }}-{{ k.reason }}">{{ k.reason }}</a></sup>{% endif %}</span></td>
<td class="number" data-label="used"><span>{{ k.text.tolerance_used }}{{ bar(k) }}</span></td><td data-label="verdict" class="verdict {{ k.verdict|verdict_class }}">{{ k.verdict }}{% if k.text.miss_bound and not k.passed %}<br>{{ k.text.miss_bound }}{% endif %}</td></tr>
{% endfor %}</tbody></table>
{% if c.rest %}<label class="more" for="unfold-{{ c.name }}"><span class="closed">Show the {{ c.rest }} checks that use least of their tolerance</span><span class="open">Hide them</span></label>{% endif %}</div>
{% if c.reasons %}<p class="legend">Why these tolerances:</p><ol class="reasons">{% for why in c.reasons %}<li id="{{ c.name }}-{{ why.letter }}">{{ why.text|inline }}</li>{% endfor %}</ol>{% endif %}{% endif %}
{% if c.notes %}<h3>Notes</h3><ul class="notes">{% for n in c.notes %}<li>{{ n|inline }}</li>{% endfor %}</ul>{% endif %}
</section>
{% endfor %}
</main></div><script>{{ script }}</script></body></html>
"""

# Cells that two tables share.
MACROS = r"""{% macro numbers(k) %}<td class="number" data-label="reference">{{ '≤ ' if k.measure == 'at_most' }}{{ k.text.reference }} {{ k.unit }}</td>
<td class="number" data-label="result">{{ k.text.value }}</td><td class="number" data-label="error">{{ k.text.error }}</td>
<td class="number{{ '' if k.text.order else ' empty' }}" data-label="order">{{ k.text.order }}</td>{% endmacro %}
{% macro bar(k) %}{% if k.tolerance_used is not none %}<i class="used" style="--share: {{ [100 * k.tolerance_used, 100]|min|round(1) }}%; --bar: var(--{{ 'good' if k.passed else 'bad' }})"></i>{% endif %}{% endmacro %}
"""


REFERENCE_LINES = ("-", "-.", ":")  # to distinguish several references in one plot


def clean(values):
    return [float("nan") if v is None else v for v in values]


def embed(path):
    kind = "jpeg" if path.lower().endswith((".jpg", ".jpeg")) else "png"
    with open(path, "rb") as file:
        return f"data:image/{kind};base64," + base64.b64encode(file.read()).decode()


def draw(plot):
    """One plot as SVG whose curves give their values under the pointer."""
    figure, axes = plt.subplots(figsize=(6.2, 4.3), layout="constrained")
    used = references = 0
    for series in plot["series"]:
        x, y = clean(series["x"]), clean(series["y"])
        style = series["style"]
        if style == "reference":
            dashes = REFERENCE_LINES[references % len(REFERENCE_LINES)]
            references += 1
            axes.plot(x, y, dashes if len(x) > 1 else "_", color="black", linewidth=1.6, markersize=14, label=series["name"], zorder=2)
        elif style == "bound":
            axes.plot(x, y, "--", color="#808890", linewidth=1.3, label=series["name"], zorder=1)
        else:
            colour, marker = COLOURS[used % len(COLOURS)], MARKERS[used % len(MARKERS)]
            used += 1
            if style == "points":
                axes.plot(x, y, marker, color=colour, markersize=4.5, markerfacecolor="none" if len(x) > 25 else colour, label=series["name"], zorder=3)
            else:
                axes.plot(x, y, "-", color=colour, linewidth=1.4, marker=marker if len(x) <= 12 else None, markersize=5, label=series["name"], zorder=3)
    if plot["log_x"]:
        axes.set_xscale("log")
        plain_ticks(axes.xaxis, [v for s in plot["series"] for v in clean(s["x"])])
    if plot["log_y"]:
        axes.set_yscale("log")
        plain_ticks(axes.yaxis, [v for s in plot["series"] for v in clean(s["y"])])
    axes.set_xlabel(plot["x_label"])
    axes.set_ylabel(textwrap.fill(plot["y_label"], 42))
    axes.set_title(plot["title"], fontsize=10.5, loc="left")
    finish_axes(axes)
    if len(plot["series"]) > 1:
        axes.legend(fontsize=8.5, frameon=True, framealpha=0.9, edgecolor="none", ncols=1 if len(plot["series"]) <= 7 else 2)
    curves = [interactive.Curve(s["name"], clean(s["x"]), clean(s["y"])) for s in plot["series"]]
    return interactive.inline_svg(figure, {}, plot["title"], curves)


def flow_values(frame, field):
    """The field of a frame that colours the particles, in the unit of its colour bar."""
    if field == "speed":
        return np.linalg.norm(frame["velocity_m_s"], axis=1)
    if field in ("velocity_x", "velocity_z"):
        return frame["velocity_m_s"][:, 0 if field == "velocity_x" else 2]
    if field == "density":
        return frame["density_kg_m3"]
    return 1e-3 * frame[f"{field}_pa"]


def draw_flow(flow, directory):
    """Side view of the particles of one instant as a PNG data address."""
    frame = Frame(os.path.join(directory, flow["snapshot"]))
    position = frame["position_m"]
    spacing = float(np.median(frame["reference_volume_m3"] * frame["volume_ratio"])) ** (1 / 3) if len(position) else 1.0
    values = flow_values(frame, flow["field"])
    mirror_x = bool(frame.attributes["mirror_x"])
    half_width = flow["slice_half_width_m"]
    keep = np.abs(position[:, 1]) <= half_width if half_width > 0 else np.ones(len(position), bool)
    order = np.flatnonzero(keep)[np.argsort(-np.abs(position[keep, 1]), kind="stable")]  # nearest to the axis is drawn last, on top
    x, z, values = position[order, 0], position[order, 2], values[order]
    if flow["window_m"]:
        left, right, bottom, top = flow["window_m"]
    elif len(x):
        margin = 0.04 * max(np.ptp(x), np.ptp(z)) + spacing
        left, right, bottom, top = x.min() - margin, x.max() + margin, z.min() - margin, z.max() + margin
    else:
        left, right, bottom, top = 0.0, 1.0, 0.0, 1.0
    shown = values[(x >= left) & (x <= right) & (z >= bottom) & (z <= top)]
    low, high = flow["range"] or (np.percentile(shown, [0.5, 99.5]) if len(shown) else (0.0, 1.0))
    if not flow["range"] and flow["field"] in ("speed", "pressure"):
        low = min(low, 0.0)
    # A metre is a metre in both directions. Long and flat flows get the colour bar below, tall ones beside; all is placed in inches.
    flat = (right - left) > 1.4 * (top - bottom)
    page_width, before, below = 6.2, 0.75, 1.3 if flat else 0.6
    scale = min((page_width - before - (0.25 if flat else 1.4)) / (right - left), 4.2 / (top - bottom))  # inches a metre
    width, height = scale * (right - left), scale * (top - bottom)
    if not flat:
        before = max(before, 0.5 * (page_width - width - 0.6))
    page_height = below + height + 0.4
    figure = plt.figure(figsize=(page_width, page_height))
    axes = figure.add_axes((before / page_width, below / page_height, width / page_width, height / page_height))
    size = (0.9 * spacing * scale * 72.0) ** 2
    points = axes.scatter(x, z, c=values, s=max(size, 0.6), marker="s", cmap="viridis", vmin=low, vmax=max(high, low + 1e-12), linewidths=0, rasterized=True)
    span = max(right - left, top - bottom)
    for px, pz, nx, nz in flow["walls"]:
        norm = np.hypot(nx, nz)
        tx, tz, nx, nz = -nz / norm, nx / norm, nx / norm, nz / norm
        centre = (0.5 * (left + right) - px) * tx + (0.5 * (bottom + top) - pz) * tz
        a, b = [(px + (centre + side * 2 * span) * tx, pz + (centre + side * 2 * span) * tz) for side in (-1, 1)]
        behind = [(p[0] - 4 * span * nx, p[1] - 4 * span * nz) for p in (b, a)]
        axes.add_patch(Polygon([a, b, *behind], facecolor="#e6e8eb", edgecolor="#3a424d", linewidth=1.1, zorder=0))
    for x0, z0, x1, z1 in flow["boxes"]:
        axes.add_patch(Polygon([(x0, z0), (x1, z0), (x1, z1), (x0, z1)], facecolor="#c9ced5", edgecolor="#3a424d", hatch="///", linewidth=1.1, zorder=0))
    if mirror_x:
        axes.axvline(0.0, color="#5a6675", linestyle="-.", linewidth=1.0)
        axes.annotate("mirror plane", (0.0, 0.98), xycoords=("data", "axes fraction"), xytext=(-3, 0), textcoords="offset points", rotation=90,
                      ha="right", va="top", fontsize=8, color="#5a6675")
    axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xlabel="x [m]", ylabel="z [m]")
    figure.text(0.75 / page_width, 1.0 - 0.12 / page_height, flow["title"], fontsize=10.5, ha="left", va="top")
    extend = {(False, False): "neither", (True, False): "min", (False, True): "max", (True, True): "both"}[
        bool(len(shown) and shown.min() < low), bool(len(shown) and shown.max() > high)]
    place = (before + 0.1 * width, 0.5, 0.8 * width, 0.13) if flat else (before + width + 0.15, below + 0.1 * height, 0.13, 0.8 * height)
    strip = figure.add_axes((place[0] / page_width, place[1] / page_height, place[2] / page_width, place[3] / page_height))
    bar = figure.colorbar(points, cax=strip, orientation="horizontal" if flat else "vertical", extend=extend)
    bar.set_label(f"{FLOW_FIELDS[flow['field']]} [{flow['unit']}]")
    bar.outline.set_visible(False)
    return png_data(figure)


def flow_caption(flow):
    """What is seen, after the case's own words."""
    seen = f"Particles with |y| ≤ {flow['slice_half_width_m']:.3g} m" if flow["slice_half_width_m"] > 0 else "All particles"
    return f"{flow['caption']} {seen} at t = {flow['time_s']:.4g} s.".strip()


def draw_study(study):
    """Values over the size, with the extrapolated limit and the numerical uncertainty of the finest as an error bar."""
    figure, axes = plt.subplots(figsize=(6.2, 3.6), layout="constrained")
    size, value = np.array(clean(study["size"])), np.array(clean(study["value"]))
    axes.plot(size, value, "o-", color=COLOURS[0], markersize=5, linewidth=1.2, label="simulation")
    if study["uncertainty"] is not None:
        axes.errorbar(size[-1], value[-1], yerr=study["uncertainty"], color=COLOURS[0], capsize=4, linewidth=1.2, label="numerical uncertainty")
    if study["extrapolated"] is not None:
        axes.plot([0.0], [study["extrapolated"]], "*", color=COLOURS[1], markersize=10, clip_on=False, label="extrapolated" + ("" if study["asymptotic"] else " (not asymptotic)"))
    axes.set_xlim(0.0, 1.05 * size.max())
    axes.set_xlabel(study["size_label"])
    axes.set_ylabel(textwrap.fill(study["quantity"] + (f" [{study['unit']}]" if study["unit"] else ""), 42))
    axes.set_title(f"Convergence: {study['quantity']}", fontsize=10.5, loc="left")
    finish_axes(axes)
    axes.legend(fontsize=8.5, frameon=True, framealpha=0.9, edgecolor="none")
    return interactive.inline_svg(figure, {}, f"Convergence: {study['quantity']}", [interactive.Curve("simulation", size, value)])


def percent(share):
    """A share with two digits, in per cent."""
    return f"{100 * share:.2g} %"


def letter(index):
    """a, b, ... z, aa, ab, ...: as an ordered list numbers its items."""
    text = ""
    while index >= 0:
        text = chr(ord("a") + index % 26) + text
        index = index // 26 - 1
    return text


def arrange_checks(case):
    """Failing checks first; each reason once; a long table starts with what uses most of its tolerance, and the rest unfolds."""
    reasons = {}
    for check in case["checks"]:
        why = check["tolerance_reason"]
        check["reason"] = reasons.setdefault(why, letter(len(reasons))) if why else ""
    case["reasons"] = [{"letter": name, "text": why} for why, name in reasons.items()]
    by_use = sorted(case["checks"], key=lambda k: (k["passed"], -(k["tolerance_used"] if k["tolerance_used"] is not None else float("inf"))))
    shown = len(by_use) if len(by_use) <= LONG_TABLE else max(SHOWN_ROWS, sum(not k["passed"] for k in by_use))
    for position, check in enumerate(by_use):
        check["rest"] = position >= shown
    case["rest"] = len(by_use) - shown
    case["tightest"] = case["checks"][case["tightest_check"]] if case["tightest_check"] is not None else None
    case["checks"] = by_use if case["rest"] else sorted(case["checks"], key=lambda k: k["passed"])


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    directory = sys.argv[1]
    with open(os.path.join(directory, "results.json"), encoding="utf-8") as file:
        results = json.load(file)
    use_style()
    for case in results["cases"]:
        case["images"] = [{"title": p["title"], "caption": p["caption"], "svg": draw(p)} for p in case["plots"]]
        case["images"] += [{"title": p["caption"], "caption": p["caption"], "data": embed(os.path.join(directory, p["file"]))} for p in case["pictures"]]
        case["images"] += [{"title": f["title"], "caption": flow_caption(f), "data": draw_flow(f, directory)} for f in case["flows"]]
        for study in case["studies"]:
            study["svg"] = draw_study(study)
        arrange_checks(case)
    environment = jinja2.Environment(autoescape=True, trim_blocks=True)
    environment.filters.update(breakable=breakable, verdict_class=verdict_class, inline=inline, short=short, percent=percent)
    page = environment.from_string(MACROS + TEMPLATE).render(
        r=results, style=markupsafe.Markup(STYLE), failing=[c for c in results["cases"] if not c["passed"]], references=REFERENCES,
        summary_figures=summary_figures(results.get("summary", {"rows": [], "points": []}), {c["name"]: c["title"] for c in results["cases"]}),
        interactive_style=markupsafe.Markup(interactive.STYLE), script=markupsafe.Markup(interactive.SCRIPT))
    write_text(os.path.join(directory, "index.html"), page)


if __name__ == "__main__":
    main()
