"""The speed of the program as one page that needs no other file: kernels by commit with what changed, and what bench_mpm measured last."""

import io
import math
import pathlib
import re

import jinja2
import markupsafe
import numpy as np
import pandas as pd

from reports import change_points
from mpmtools.errors import InputError
from reports import interactive
from mpmtools.figures.style import COLOURS, MARKERS, STYLE, finish_axes, plt, use_style
from mpmtools.files import write_text
from mpmtools.files import read_text
from mpmtools.paired_times import THRESHOLD
from mpmtools.wording import counted

SLOWER, FASTER, CALM = "#b3262e", "#1c7a43", "#5a6675"
COLUMNS = {"commit": str, "baseline": str}  # 005551511e13 is a commit, not a number
SIZES = {"k": 1e3, "M": 1e6}


def read_history(path, machine, baseline=None, commits=None):
    """The latest rows of each commit and kernel that one machine measured against one baseline (default: that of the latest row), the commits in the
    order of `commits` (default: of the measurements). InputError if there are none."""
    try:
        rows = pd.read_csv(io.StringIO(read_text(path)), dtype=COLUMNS)
    except (OSError, ValueError, KeyError) as error:
        raise InputError(f"cannot read the history '{path}': {error}") from None
    rows = rows[rows.machine == machine].sort_values("date", kind="stable")
    baseline = baseline or (rows.baseline.iloc[-1] if len(rows) else "")
    rows = rows[rows.baseline == baseline].drop_duplicates(["commit", "kernel"], keep="last")
    if commits is None:
        commits = list(dict.fromkeys(rows.commit))
    place = {commit: i for i, commit in enumerate(commits)}
    rows = rows[rows.commit.isin(place)].assign(place=lambda t: t.commit.map(place)).sort_values("place", kind="stable").reset_index(drop=True)
    if rows.empty:
        raise InputError(f"{path}: nothing that {machine} measured against {baseline or 'any baseline'}")
    return rows


def find_changes(rows):
    """The changes of a history: [{kernel, commit, place, time, instructions}], the last two a change_points.Change or None."""
    kernels = list(dict.fromkeys(rows.kernel))
    found = []
    for kernel in kernels:
        mine = rows[rows.kernel == kernel].sort_values("place")
        at = {}
        for change in change_points.changes(mine.ratio, mine.ratio_low, mine.ratio_high, series=len(kernels)):
            at.setdefault(change.place, {})["time"] = change
        for change in change_points.instruction_changes(mine.instruction_ratio):
            at.setdefault(change.place, {})["instructions"] = change
        for i, what in at.items():
            found.append({"kernel": kernel, "commit": mine.commit.iloc[i], "place": mine.place.iloc[i], "time": None, "instructions": None, **what})
    return sorted(found, key=lambda c: (c["place"], c["kernel"]))


def per_cent(ratio):
    return f"{100.0 * (ratio - 1.0):+z.1f} %"


def write_dashboard(target, machine, rows=None, titles=None, measured=None):
    """Writes the page.

    machine: [(what, value)]; rows: from read_history; titles: by commit; measured: content of a JSON file of bench_mpm. Returns find_changes(rows).
    """
    use_style()
    titles = titles or {}
    found = find_changes(rows) if rows is not None else []
    times = [c for c in found if c["time"]]
    commits = [] if rows is None else rows.drop_duplicates("commit")[["commit", "place"]].to_dict("records")
    kernels = [] if rows is None else [{"name": k, "svg": _kernel_figure(rows[rows.kernel == k], [c for c in times if c["kernel"] == k], commits, titles)}
                                       for k in dict.fromkeys(rows.kernel)]
    blocks = _measured_blocks(measured) if measured else []
    if measured:
        machine = [*machine, *_context(measured)]
    sections = [*([("changes", "Marked changes"), ("kernels", "Kernels by commit")] if commits else []), *((b[0], b[1]) for b in blocks), ("machine", "Machine")]
    environment = jinja2.Environment(autoescape=True, trim_blocks=True)
    template = environment.from_string(pathlib.Path(__file__).with_name("bench_dashboard.html.j2").read_text(encoding="utf-8"))
    marked = [{**c, "title": titles.get(c["commit"], ""), "worse": bool(c["time"] and c["time"].ratio > 1.0), "time": per_cent(c["time"].ratio) if c["time"] else "–",
               "interval": f"{per_cent(c['time'].low)} .. {per_cent(c['time'].high)}" if c["time"] else "", "instructions": per_cent(c["instructions"].ratio) if c["instructions"] else "–"}
              for c in found]
    page = template.render(style=markupsafe.Markup(STYLE + interactive.STYLE), script=markupsafe.Markup(interactive.SCRIPT), sections=sections, commits=commits, kernels=kernels,
                           baseline=rows.baseline.iloc[0] if rows is not None else "", marked=marked, slower=sum(c["time"].ratio > 1.0 for c in times),
                           faster=sum(c["time"].ratio < 1.0 for c in times), threshold=f"{100 * THRESHOLD:.0f}", blocks=blocks, machine=machine)
    write_text(target, page)
    return found


def _kernel_figure(rows, times, commits, titles):
    """In per cent off the baseline, over the commits."""
    figure, axes = plt.subplots(figsize=(6.2, 3.6), layout="constrained")
    rows = rows.sort_values("place").reset_index(drop=True)
    kernel, order = rows.kernel.iloc[0], {c["commit"]: i for i, c in enumerate(commits)}
    x = rows.commit.map(order).to_numpy()
    off = {name: 100.0 * (rows[name].to_numpy(float) - 1.0) for name in ("ratio", "ratio_low", "ratio_high", "instruction_ratio")}
    axes.axhspan(-100.0 * THRESHOLD, 100.0 * THRESHOLD, color="#eef1f4", zorder=0)
    axes.axhline(0.0, color="black", linewidth=0.8, zorder=1)
    by_commit = {c["commit"]: c["time"] for c in times}
    edges = [0, *(i for i, commit in enumerate(rows.commit) if commit in by_commit), len(rows)]
    weight = change_points.sigma_of(rows.ratio_low.to_numpy(float), rows.ratio_high.to_numpy(float)) ** -2.0
    for a, b in zip(edges, edges[1:]):
        level = 100.0 * (math.exp(np.average(np.log(rows.ratio[a:b]), weights=weight[a:b])) - 1.0)
        axes.plot([x[a] - 0.4, x[b - 1] + 0.4], [level, level], color=COLOURS[0], linewidth=2.0, alpha=0.45, zorder=1)
    axes.plot(x, off["instruction_ratio"], "x", color="black", markersize=5, zorder=2)
    texts = {}
    for i, row in rows.iterrows():
        change = by_commit.get(row.commit)
        colour = CALM if change is None else SLOWER if change.ratio > 1.0 else FASTER
        axes.plot([x[i], x[i]], [off["ratio_low"][i], off["ratio_high"][i]], color=colour, linewidth=1.4, zorder=3)
        gid = f"bench-{kernel}-{i}"
        axes.plot([x[i]], [off["ratio"][i]], "o" if change is None else "v" if change.ratio < 1.0 else "^", color=colour, markersize=5 if change is None else 9, gid=gid, zorder=4)
        count = f"\n{row.instructions_per_particle:.0f} instructions ({per_cent(row.instruction_ratio)})" if math.isfinite(row.instruction_ratio) else ""
        texts[gid] = (f"{row.commit} {titles.get(row.commit, '')}\n{kernel}: {row.ns_per_particle:.2f} ns, {per_cent(row.ratio)} ({per_cent(row.ratio_low)} .. {per_cent(row.ratio_high)})"
                      f"{count}" + (f"\nfrom here on {per_cent(change.ratio)}" if change else ""))
    reach = 1.15 * max(6.0, *(np.nanmax(np.abs(values)) for values in off.values() if np.isfinite(values).any()))
    axes.set_ylim(-reach, reach)
    axes.set_xticks(range(len(commits)), [c["commit"][:8] for c in commits], rotation=90 if len(commits) > 5 else 0, fontsize=7.5)
    axes.set_xlim(-0.6, len(commits) - 0.4)
    axes.set_ylabel("against the baseline [%]")
    axes.set_title(kernel, fontsize=10.5, loc="left")
    finish_axes(axes)
    return interactive.inline_svg(figure, texts, f"{kernel}: change of the time by commit")


# --- what bench_mpm measured ------------------------------------------------------------------------------------------------

def _context(measured):
    context = measured["context"]
    caches = ", ".join(f"L{c['level']} {c['type'].lower()} {c['size'] // 1024} kB" for c in context.get("caches", []))
    rows = [("cores", context.get("num_cpus")), ("caches", caches), ("compiler", context.get("compiler")), ("instruction set", context.get("instruction_set")),
            ("commit of the measured program", context.get("commit")), ("measured at", context.get("date")), ("load at the start", (context.get("load_avg") or [None])[0])]
    ceilings = [(f"STREAM triad, multiply-add; {counted(int(re.search('threads:([0-9]+)', b['name'])[1]), 'thread')}", f"{b['stream_GB/s']:.1f} GB/s, {b['fma_GFLOP/s']:.0f} GFLOP/s")
                for b in measured["benchmarks"] if b["name"].startswith("ceilings/")]
    return [(what, value) for what, value in rows if value not in (None, "")] + ceilings


def medians(measured):
    """The median repetitions of bench_mpm, with the parts of their names: kernel, problem, particles, threads."""
    rows = []
    for b in measured["benchmarks"]:
        name = re.fullmatch(r"(?:(?P<kernel>[^/]+)/)(?P<problem>.+)/(?P<size>[0-9]+)(?P<unit>[kM])/threads:(?P<threads>\d+)(?:/(?:iterations|repeats|manual_time).*)?", b.get("run_name", b["name"]))
        if name and (b.get("aggregate_name") == "median" or b.get("run_type") == "iteration") and not b.get("error_occurred"):
            rows.append({**b, **name.groupdict(), "threads": int(name["threads"]), "size": float(name["size"]) * SIZES[name["unit"]]})
    return rows


def _measured_blocks(measured):
    """(id, heading, text, figures, table) of each kind of result that the file holds."""
    rows = medians(measured)
    timed = [r for r in rows if {"ns", "flops", "bytes"} <= r.keys()]
    blocks = []
    if timed:
        blocks.append(("roofline", "Roofline", "What each kernel computes in a second over the operations for each byte of its least memory traffic. The lines are the measured limits of "
                       "memory and of arithmetic; a point above the memory limit found data in the cache.", [_roofline(timed, threads) for threads in sorted({r["threads"] for r in timed})], None))
        if any(len({r["size"] for r in timed if _series(r) == _series(t)}) > 1 for t in timed):
            blocks.append(("sizes", "Problem size", "Speed over the number of particles.", [_sizes(timed, kernel) for kernel in dict.fromkeys(r["kernel"] for r in timed)], None))
        by_cell = [r for r in timed if re.search(r"block:\d+$", r["problem"])]
        if len({r["problem"] for r in by_cell}) > 2:
            blocks.append(("cells", "Particles a cell", "Speed over the number of particles in a cell, at the largest problem of each.",
                           [_per_cell(by_cell, kernel) for kernel in dict.fromkeys(r["kernel"] for r in by_cell)], None))
    runs = [r for r in rows if "run_over_step" in r]
    if runs:
        table = [["run", "particles", "threads", "million particle-steps/s", "of the step's speed", "of that of 512 k particles", "start-up s", "peak bytes a particle"]]
        table += [[f"{r['kernel']}/{r['problem']}", f"{r['particles']:.0f}", r["threads"], f"{r['M/s']:.2f}", f"{100 * r['run_over_step']:.0f} %",
               f"{100 * r['run_over_512k']:.0f} %" if "run_over_512k" in r else "–", f"{r['start_up_s']:.3f}", f"{r['peak_bytes']:.0f}"] for r in runs]
        blocks.append(("runs", "Whole runs", "From start to end, with frames and checkpoints.", [], table))
    held = [r for r in rows if "memory_bytes" in r]
    both = [r for r in rows if "single_memory_bytes" in r]
    if held or both:
        table = [["problem", "particles", "threads", "precision", "bytes a particle"]]
        table += [[r["problem"], f"{r['particles']:.0f}", r["threads"], "double", f"{r['memory_bytes']:.0f}"] for r in held]
        table += [[r["problem"], f"{r['particles']:.0f}", r["threads"], p, f"{r[p + '_memory_bytes']:.0f}"] for r in both for p in ("double", "single")]
        blocks.append(("memory", "Memory", "Memory of the grid and its particles, for one particle.", [], table))
    return blocks


def _series(row):
    return row["kernel"], row["problem"], row["threads"]


def _label(row):
    return f"{row['kernel']}/{row['problem']}/{row['size']:g}, {counted(row['threads'], 'thread')}: {row['ns']:.1f} ns, {row['M/s']:.1f} million/s"


def _finish(figure, axes, texts, title, x, y):
    axes.set_xlabel(x)
    axes.set_ylabel(y)
    axes.set_title(title, fontsize=10.5, loc="left")
    axes.legend(fontsize=7.5, frameon=False)
    finish_axes(axes)
    return interactive.inline_svg(figure, texts, title)


def _roofline(rows, threads):
    rows = [r for r in rows if r["threads"] == threads and r["flops"] > 0]
    figure, axes = plt.subplots(figsize=(6.2, 4.4), layout="constrained")
    stream, peak = rows[0]["stream_GB/s"], rows[0]["fma_GFLOP/s"]
    intensity = np.geomspace(0.5 * min(r["flops"] / r["bytes"] for r in rows), 2.0 * max(peak / stream, *(r["flops"] / r["bytes"] for r in rows)), 60)
    axes.loglog(intensity, np.minimum(stream * intensity, peak), color="black", linewidth=1.2)
    texts = {}
    for k, kernel in enumerate(dict.fromkeys(r["kernel"] for r in rows)):
        for i, r in enumerate(m for m in rows if m["kernel"] == kernel):
            gid = f"roofline-{threads}-{k}-{i}"
            axes.loglog([r["flops"] / r["bytes"]], [r["flops"] / r["ns"]], MARKERS[k % len(MARKERS)], color=COLOURS[k % len(COLOURS)], gid=gid, label=kernel if i == 0 else None)
            texts[gid] = _label(r) + f"\n{100 * r['of_stream']:.0f} % of memory, {100 * r['of_fma']:.0f} % of arithmetic"
    return _finish(figure, axes, texts, f"{counted(threads, 'thread')}: {stream:.1f} GB/s, {peak:.0f} GFLOP/s", "operations a byte", "GFLOP/s")


def _sizes(rows, kernel):
    figure, axes = plt.subplots(figsize=(6.2, 3.6), layout="constrained")
    texts = {}
    for s, series in enumerate(dict.fromkeys(_series(r) for r in rows if r["kernel"] == kernel)):
        mine = sorted((r for r in rows if _series(r) == series), key=lambda r: r["size"])
        axes.semilogx([r["size"] for r in mine], [r["M/s"] for r in mine], "-", color=COLOURS[s % len(COLOURS)], linewidth=0.9, label=f"{series[1]}, {counted(series[2], 'thread')}")
        for i, r in enumerate(mine):
            gid = f"size-{kernel}-{s}-{i}"
            axes.semilogx([r["size"]], [r["M/s"]], "o", color=COLOURS[s % len(COLOURS)], markersize=4, gid=gid)
            texts[gid] = _label(r)
    axes.set_ylim(bottom=0.0)
    return _finish(figure, axes, texts, kernel, "particles", "million particles/s")


def _per_cell(rows, kernel):
    figure, axes = plt.subplots(figsize=(6.2, 3.6), layout="constrained")
    texts, largest = {}, max(r["size"] for r in rows if r["kernel"] == kernel)
    for s, (shape, threads) in enumerate(dict.fromkeys((r["problem"].rsplit(":")[0], r["threads"]) for r in rows if r["kernel"] == kernel)):
        mine = [r for r in rows if r["kernel"] == kernel and r["size"] == largest and r["threads"] == threads and r["problem"].rsplit(":")[0] == shape]
        mine.sort(key=lambda r: int(r["problem"].rsplit(":")[1]))
        for i, r in enumerate(mine):
            gid = f"cell-{kernel}-{s}-{i}"
            axes.plot([int(r["problem"].rsplit(":")[1])], [r["M/s"]], "o", color=COLOURS[s % len(COLOURS)], markersize=4, gid=gid, label=f"{shape}, {counted(threads, 'thread')}" if i == 0 else None)
            texts[gid] = _label(r)
    axes.set_ylim(bottom=0.0)
    return _finish(figure, axes, texts, f"{kernel}, {largest:g} particles", "particles a cell", "million particles/s")
