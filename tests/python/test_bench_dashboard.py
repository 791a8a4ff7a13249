"""The dashboard of the benchmarks on made-up measurements: a planted change is marked on its commit, and nothing else is."""

import functools
import json
import math
import pathlib
import sys
import tempfile
import unittest

import numpy as np
import pandas as pd

from mpmtools import paired_times
from mpmtools.errors import ConfigError, InputError
from reports import bench_dashboard, change_points, google_benchmark

KERNELS = ["particle_to_grid", "grid_to_particle", "grid_update", "law_elastic", "law_yielding", "law_apexes", "sort", "step"]
COMMITS = [f"{i:012x}" for i in range(15)]
PLANTED = (("particle_to_grid", (9, 1.05)),)  # kernel: from this commit on, 5 % slower


def launches(ratio, random):
    """Pairs on a busy machine, as tests/support/check_bench_statistics.py makes them: drift that a pair shares, 5 % jitter, one sample in ten
    disturbed by up to three times, 1 % for the memory layout of each process."""
    result = []
    for _ in range(8):
        drift = np.exp(0.3 * np.sin(np.arange(40) / 5.0 + random.uniform(0.0, 6.0)))
        pairs = drift[:, None] * np.array([1.0, ratio]) * np.exp(0.01 * random.standard_normal(2))
        pairs *= np.exp(0.05 * random.standard_normal((40, 2)))
        result.append(pairs * np.where(random.random((40, 2)) < 0.1, random.uniform(1.0, 3.0, (40, 2)), 1.0))
    return result


@functools.cache
def made_up(planted, seed):
    """A history as the tracker writes it."""
    random, rows, planted = np.random.default_rng(seed), [], dict(planted)
    for place, commit in enumerate(COMMITS):
        for kernel in KERNELS:
            at, ratio = planted.get(kernel, (len(COMMITS), 1.0))
            c = paired_times.compare(launches(ratio if place >= at else 1.0, random), resamples=200)
            rows.append([f"2026-01-{place + 1:02d}T00:00:00Z", commit, "a machine, 2 cores", kernel, 20.0 * c.ratio, COMMITS[0], c.ratio, c.low, c.high,
                         c.verdict, 500.0 * (1.04 if place >= at else 1.0), 1.04 if place >= at else 1.0])
    return pd.DataFrame(rows, columns=["date", "commit", "machine", "kernel", "ns_per_particle", "baseline", "ratio", "ratio_low", "ratio_high", "verdict",
                                       "instructions_per_particle", "instruction_ratio"])


class PairedTimes(unittest.TestCase):
    def test_of_too_few_launches_or_pairs_are_refused(self):
        for launches, message in (([], "^0 launches"), ([[[1.0, 1.1]] * 3], "^1 launches"), ([[[1.0, 1.1]] * 3, [[1.0, 1.1]]], "^2 launches, the shortest of 1 pairs")):
            with self.assertRaisesRegex(ConfigError, message):
                paired_times.compare(launches)


class Folder(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def read(self, history):
        history.to_csv(self.folder / "history.csv", index=False)
        return bench_dashboard.read_history(self.folder / "history.csv", "a machine, 2 cores", COMMITS[0], COMMITS)


class Marks(Folder):
    """FALSE_ALARMS is one page in a hundred for errors that are normal; the threshold of 2 % makes it rarer."""

    pages = 4

    def test_a_slowdown_of_five_per_cent_is_marked_on_its_commit_and_nothing_else(self):
        for seed in range(self.pages):
            times = [c for c in bench_dashboard.find_changes(self.read(made_up(PLANTED, seed))) if c["time"]]
            self.assertEqual([(c["kernel"], c["commit"]) for c in times], [("particle_to_grid", COMMITS[9])], f"seed {seed}")
            self.assertAlmostEqual(times[0]["time"].ratio, 1.05, delta=0.01)  # 0.5 % for the layout of each of 6 commits, and of the 9 before
            self.assertAlmostEqual(times[0]["instructions"].ratio, 1.04)

    def test_a_history_without_a_change_has_no_mark(self):
        for seed in range(self.pages):
            self.assertEqual(bench_dashboard.find_changes(self.read(made_up((), 100 + seed))), [], f"seed {seed}")

    def test_two_changes_of_one_kernel_are_both_marked(self):
        ratio = np.array([1.0, 1.0, 1.0, 1.06, 1.06, 1.06, 0.98, 0.98, 0.98])
        found = change_points.changes(ratio, ratio * 0.985, ratio * 1.015)
        self.assertEqual([c.place for c in found], [3, 6])
        for change, true in zip(found, (1.06, 0.98 / 1.06)):
            self.assertTrue(change.low < true < change.high)

    def test_a_change_below_the_threshold_is_not_marked_however_sure(self):
        ratio = np.where(np.arange(20) < 10, 1.0, 1.015)
        self.assertEqual(change_points.changes(ratio, ratio * 0.999, ratio * 1.001), [])

    def test_one_or_no_measurement_has_no_change(self):
        self.assertEqual(change_points.changes([1.3], [1.2], [1.4]), [])
        self.assertEqual(change_points.changes([], [], []), [])

    def test_instructions_that_were_not_counted_are_passed_over(self):
        found = change_points.instruction_changes([1.0, math.nan, 1.0, math.nan, 1.02])
        self.assertEqual([(c.place, round(c.ratio, 6)) for c in found], [(4, 1.02)])


class Page(Folder):
    def measured(self):
        """What bench_mpm writes, in short."""
        entry = {"run_type": "aggregate", "aggregate_name": "median", "ns": 20.0, "M/s": 50.0, "bytes": 210.0, "flops": 590.0, "of_stream": 0.7, "of_fma": 0.3,
                 "stream_GB/s": 14.0, "fma_GFLOP/s": 88.0, "particles": 64e3}
        names = [f"particle_to_grid/jittered_block:{n}/{size}/threads:1/iterations:4/repeats:9/manual_time" for n in (1, 8, 27) for size in ("64k", "512k")]
        benchmarks = [{"name": name + "_median", "run_name": name, **entry} for name in names]
        benchmarks.append({"name": "x", "run_name": "step/reference/512k/threads:1/iterations:4/repeats:9/manual_time", **entry, "memory_bytes": 271.0})
        benchmarks.append({"name": "ceilings/threads:1", "run_name": "ceilings/threads:1", "run_type": "iteration", "stream_GB/s": 14.0, "fma_GFLOP/s": 88.0})
        context = {"num_cpus": 2, "caches": [{"level": 1, "type": "Data", "size": 32768}], "compiler": "GCC 12", "date": "2026-01-01", "load_avg": [0.1]}
        return {"context": context, "benchmarks": benchmarks}

    def test_names_the_commit_its_title_and_needs_no_other_file(self):
        page = self.folder / "index.html"
        titles = {COMMITS[9]: "Work on <two> cells twice", COMMITS[3]: "A comment"}
        bench_dashboard.write_dashboard(page, [("processor", "a machine")], self.read(made_up(PLANTED, 0)), titles, self.measured())
        text = page.read_text(encoding="utf-8")
        table = text[text.index("Marked changes</h2>"):text.index("Kernels by commit</h2>")]
        self.assertIn("Work on &lt;two&gt; cells twice", table)
        self.assertNotIn("A comment", table)
        self.assertIn("1 slower, 0 faster", text)
        for part in ("Roofline", "Problem size", "Particles a cell", "Memory", "Machine", "14.0 GB/s, 88 GFLOP/s", "271"):
            self.assertIn(part, text)
        self.assertEqual(text.count("data-kernel="), len(KERNELS))
        for outside in ('src="', "<link", "@import", 'href="http'):
            self.assertNotIn(outside, text)

    def test_only_what_one_machine_measured_against_one_baseline(self):
        history = made_up((), 0)
        other = history.assign(machine="another", ratio=2.0)
        rows = self.read(pd.concat([history, other, history.assign(baseline=COMMITS[5], ratio=3.0)]))
        self.assertEqual(len(rows), len(history))
        self.assertLess(rows.ratio.max(), 1.5)

    def test_an_empty_history_is_an_error(self):
        with self.assertRaisesRegex(InputError, "nothing that"):
            self.read(made_up((), 0).assign(machine="another"))


class GoogleBenchmark(Folder):
    def test_what_is_written_is_read_again(self):
        history = self.read(made_up(PLANTED, 0))
        paths = google_benchmark.write(history, self.folder)
        self.assertEqual(len(paths), len(COMMITS))
        again = pd.concat([google_benchmark.history_rows(google_benchmark.load(path)) for path in paths], ignore_index=True)
        columns = ["commit", "kernel", "machine", "baseline", "date", "ns_per_particle", *google_benchmark.COUNTERS]
        pd.testing.assert_frame_equal(again[columns], history[columns])

    def test_has_what_the_tools_of_google_benchmark_ask_for(self):
        data = json.loads(pathlib.Path(google_benchmark.write(self.read(made_up((), 0)), self.folder)[0]).read_text(encoding="utf-8"))
        self.assertLessEqual({"date", "host_name", "num_cpus", "mhz_per_cpu", "caches", "library_build_type"}, data["context"].keys())
        for benchmark in data["benchmarks"]:
            self.assertLessEqual({"name", "run_name", "run_type", "iterations", "real_time", "cpu_time", "time_unit"}, benchmark.keys())

    def test_ratios_of_another_tool_follow_from_the_repetitions(self):
        def file(commit, times):
            return {"context": {"commit": commit, "host_name": "h", "date": "d"},
                    "benchmarks": [{"name": "k", "run_name": "k", "run_type": "iteration", "cpu_time": t, "real_time": 9.0, "time_unit": "us"} for t in times]}
        row = google_benchmark.history_rows(file("b", [1.10, 1.11, 1.09]), file("a", [1.0, 1.01, 0.99])).iloc[0]
        self.assertEqual((row.commit, row.baseline, row.kernel, row.ns_per_particle), ("b", "a", "k", 1100.0))
        self.assertTrue(row.ratio_low < 1.10 < row.ratio_high < 1.25)
        alone = google_benchmark.history_rows(file("b", [1.1]), file("a", [1.0])).iloc[0]
        self.assertTrue(math.isnan(alone.ratio_low))

    def test_another_file_is_refused(self):
        for text, what in (("{}", "not what Google Benchmark writes"), ("no", "is not JSON")):
            (self.folder / "x.json").write_text(text, encoding="utf-8")
            with self.assertRaisesRegex(InputError, what):
                google_benchmark.load(self.folder / "x.json")
        with self.assertRaisesRegex(InputError, "cannot read"):
            google_benchmark.load(self.folder / "none.json")
        aggregate = {"name": "step_mean", "run_name": "step", "run_type": "aggregate", "aggregate_name": "mean", "cpu_time": 1.0}
        for benchmarks in ([], [aggregate], [{"name": "step", "run_type": "iteration", "error_occurred": True}]):
            (self.folder / "x.json").write_text(json.dumps({"context": {}, "benchmarks": benchmarks}), encoding="utf-8")
            with self.assertRaisesRegex(InputError, "holds no time of a repetition.*--benchmark_report_aggregates_only"):
                google_benchmark.load(self.folder / "x.json")


if __name__ == "__main__":
    sys.exit(unittest.main())
