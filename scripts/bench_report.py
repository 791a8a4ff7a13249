"""The tables of benchmarks/README.md, from the JSON output of bench_mpm."""

import re
import textwrap

BEGIN, END = "<!-- results: begin (written by run_benchmarks --report) -->", "<!-- results: end -->"


def faults(data):
    return [f"{b['name']}: {b['error_message']}" for b in data["benchmarks"] if b.get("error_occurred")]


def medians(data, counter="ns"):
    """(kernel or problem path, threads) -> counters of the median repetition, of the benchmarks that have one of this name."""
    found = {}
    for b in data["benchmarks"]:
        if b.get("aggregate_name") == "median" and counter in b:
            path, threads = re.match(r"(.*)/threads:(\d+)", b["run_name"]).groups()
            found[path, int(threads)] = b
    return found


def row(*cells):
    return "| " + " | ".join(str(c) for c in cells) + " |"


def header(*cells):
    return [row(*cells), "|---|" + "---:|" * (len(cells) - 1)]


def machine_lines(data, machine):
    context = data["context"]
    caches = ", ".join(f"L{c['level']}{c['type'][0].lower() if c['type'] != 'Unified' else ''} {c['size'] // 1024} kB" for c in context["caches"])
    text = (f"Machine: {machine}; {caches}. {context.get('compiler', '')}, {context.get('instruction_set', '')}, commit {context.get('commit', '')}, "
            f"{context['date'][:10]}. Load at the start: {context['load_avg'][0] if context.get('load_avg') else 'unknown'}.")
    lines = [*textwrap.wrap(text, 118), ""]
    lines += header("threads", "STREAM triad GB/s", "FMA GFLOP/s")
    for b in data["benchmarks"]:
        if b["name"].startswith("ceilings/"):
            lines.append(row(re.search(r"threads:(\d+)", b["name"])[1], f"{b['stream_GB/s']:.1f}", f"{b['fma_GFLOP/s']:.0f}"))
    return lines


def kernel_lines(found):
    lines = header("kernel, problem, particles", "threads", "ns", "million/s", "bytes", "flops", "of STREAM", "of FMA", "binds")
    for (path, threads), b in found.items():
        binds = "memory" if b["of_stream"] > b["of_fma"] else "arithmetic"
        lines.append(row(path, threads, f"{b['ns']:.1f}", f"{b['M/s']:.1f}", f"{b['bytes']:.0f}", f"{b['flops']:.0f}", f"{100 * b['of_stream']:.0f} %",
                         f"{100 * b['of_fma']:.0f} %", binds))
    return lines


def step_lines(found):
    lines = header("step", "threads", "ns", "P2G", "grid", "G2P", "law", "sort", "sum/step", "yielding", "change cell", "change block", "bytes held")
    for (path, threads), b in found.items():
        lines.append(row(path.removeprefix("step/"), threads, f"{b['ns']:.1f}", *(f"{b[part]:.1f}" for part in ("p2g_ns", "grid_ns", "g2p_ns", "law_ns", "sort_ns")),
                         f"{b['sum_over_step']:.2f}", *(f"{100 * b[share]:.1f} %" for share in ("yielding", "changing_cell", "changing_block")),
                         f"{b['memory_bytes']:.0f}"))
    return lines


def whole_run_lines(data):
    """Whole runs, medians of their repetitions; no lines if there are none."""
    rows = []
    for (path, threads), b in medians(data, "run_over_step").items():
        of_512k = f"{b['run_over_512k']:.2f}" if "run_over_512k" in b else "–"
        rows.append(row(path.removeprefix("whole_run/"), threads, f"{b['particles']:.0f}", f"{b['M/s']:.2f}", f"{b['run_over_step']:.3f}", of_512k,
                        f"{b['start_up_s']:.3f}", f"{b['peak_bytes']:.0f}"))
    return [*header("whole run", "threads", "particles at the end", "million/s", "run/steps", "run/steps of 512 k", "start-up s", "peak bytes"), *rows] if rows else []


def scaling_lines(found):
    """Efficiency of two threads, and the largest reference problem against the 512 k one."""
    lines = []
    for (path, threads), b in found.items():
        if threads == 2 and (path, 1) in found:
            lines.append(row(path, f"{found[path, 1]['ns'] / (2.0 * b['ns']):.2f}"))
    lines = [*header("one to two threads", "efficiency"), *lines, ""] if lines else []
    for threads in (1, 2):
        pair = [found.get((f"step/reference/{size}", threads)) for size in ("512k", "8M")]
        if all(pair):
            lines.append(f"Reference step, {threads} {'thread' if threads == 1 else 'threads'}: 8 M particles take {pair[1]['ns'] / pair[0]['ns']:.2f} times the time a particle of 512 k.")
    return lines


def tables(data, machine):
    found = medians(data)
    steps = {key: b for key, b in found.items() if "sum_over_step" in b}
    return "\n".join([*machine_lines(data, machine), "", *kernel_lines(found), "", *step_lines(steps), "", *scaling_lines(found), "", *whole_run_lines(data)]).rstrip() + "\n"


def replace_between_marks(readme, text, begin=BEGIN, end=END):
    before, rest = readme.split(begin)
    return f"{before}{begin}\n\n{text}\n{end}{rest.split(end)[1]}"
