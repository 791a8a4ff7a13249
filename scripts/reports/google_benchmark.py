"""Google Benchmark's JSON, in and out: what bench_mpm writes, and what other tools (its own compare.py) read.

One file holds the results of one commit. Names are those of the kernels, so that two files can be compared name by name. Ratios against a
baseline, with their intervals, are counters beside the times.
"""

import json
import math
import os
import re

import numpy as np
import pandas as pd

from mpmtools.errors import InputError
from mpmtools.files import read_json, write_text

COUNTERS = ["ratio", "ratio_low", "ratio_high", "instructions_per_particle", "instruction_ratio"]  # columns of history.csv that become counters
NANOSECONDS = {"ns": 1.0, "us": 1e3, "ms": 1e6, "s": 1e9}


def load(path):
    """The content of a file. InputError if it is not such a file."""
    data = read_json(path, "give a file of Google Benchmark")
    if not isinstance(data.get("benchmarks"), list) or not isinstance(data.get("context"), dict):
        raise InputError(f"'{path}' is not what Google Benchmark writes: it needs 'context' and 'benchmarks'")
    if not _times(data):
        raise InputError(f"'{path}' holds no time of a repetition: every benchmark failed, or the file was written with "
                         "--benchmark_report_aggregates_only, whose means cannot be compared; write it without that option")
    return data


def written(rows):
    """The rows of one commit in history.csv as the content of a file."""
    first = rows.iloc[0]
    cores = re.search(r"(\d+) cores", first.machine)
    benchmarks = []
    for index, row in enumerate(rows.itertuples()):
        entry = {"name": row.kernel, "family_index": index, "per_family_instance_index": 0, "run_name": row.kernel, "run_type": "iteration",
                 "repetitions": 1, "repetition_index": 0, "threads": 1, "iterations": 1, "real_time": row.ns_per_particle,
                 "cpu_time": row.ns_per_particle, "time_unit": "ns"}
        entry |= {name: getattr(row, name) for name in COUNTERS if math.isfinite(getattr(row, name))}
        benchmarks.append(entry)
    context = {"date": first.date, "host_name": first.machine, "executable": "bench_paired", "num_cpus": int(cores[1]) if cores else 0,
               "mhz_per_cpu": 0, "cpu_scaling_enabled": False, "caches": [], "load_avg": [], "library_build_type": "release",
               "commit": first.commit, "baseline": first.baseline}
    return {"context": context, "benchmarks": benchmarks}


def write(rows, folder):
    """A file for each commit of a history. Returns their paths."""
    paths = []
    for commit, mine in rows.groupby("commit", sort=False):
        paths.append(os.path.join(folder, f"{commit}.json"))
        write_text(paths[-1], json.dumps(written(mine), indent=1))
    return paths


def history_rows(data, baseline=None):
    """The rows of history.csv for the content of a file.

    Ratios come from its counters. Where they are missing they are those of the processor times to the same names in `baseline`, another
    file; their interval then follows from the scatter of the repetitions of both, and needs at least two of each.
    """
    context, rows = data["context"], []
    reference = _times(baseline) if baseline else {}
    counters = {b["run_name"]: b for b in data["benchmarks"] if "run_name" in b}
    for name, times in _times(data).items():
        known = counters.get(name, {})
        row = {"date": context.get("date", ""), "commit": context.get("commit", "unknown"), "machine": context.get("host_name", "unknown"), "kernel": name,
               "ns_per_particle": float(np.median(times)), "baseline": context.get("baseline", ""), **{c: known.get(c, math.nan) for c in COUNTERS}}
        if name in reference and not math.isfinite(row["ratio"]):
            row |= _ratio(times, reference[name])
            row["baseline"] = baseline["context"].get("commit", "unknown")
        rows.append(row)
    return pd.DataFrame(rows)


def _times(data):
    """Processor times by name, ns."""
    times = {}
    for b in data["benchmarks"]:
        if b.get("run_type", "iteration") == "iteration" and not b.get("error_occurred"):
            try:
                times.setdefault(b.get("run_name", b["name"]), []).append(b["cpu_time"] * NANOSECONDS[b.get("time_unit", "ns")])
            except KeyError as missing:
                raise InputError(f"benchmark '{b.get('name', '?')}': {missing} is missing or of no known unit") from None
    return times


def _ratio(times, reference):
    from scipy.stats import t

    from mpmtools.paired_times import CONFIDENCE

    logs = [np.log(times), np.log(reference)]
    centre = float(np.mean(logs[0]) - np.mean(logs[1]))
    if min(len(log) for log in logs) < 2:
        return {"ratio": math.exp(centre), "ratio_low": math.nan, "ratio_high": math.nan}
    error = math.sqrt(sum(np.var(log, ddof=1) / len(log) for log in logs))
    reach = float(t.ppf(0.5 + 0.5 * CONFIDENCE, min(len(log) for log in logs) - 1)) * error
    return {"ratio": math.exp(centre), "ratio_low": math.exp(centre - reach), "ratio_high": math.exp(centre + reach)}
