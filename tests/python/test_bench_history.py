"""`run_benchmarks --history` and `--read` from end to end: a repository of empty commits, programs that answer like bench_paired, of which one became slower."""

import csv
import importlib.machinery
import importlib.util
import json
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest
from unittest import mock

ROOT = pathlib.Path(__file__).resolve().parents[2]
FAKE = """#!{python}
import random, sys
slower = {slower}
if sys.argv[1] == "--list":
    print("particle_to_grid\\nsort")
    sys.exit()
for line in sys.stdin:
    time = 20.0 * (1.05 if slower and sys.argv[1] == "particle_to_grid" else 1.0)
    print(time * random.lognormvariate(0.0, 0.01), flush=True)
"""


def load():
    loader = importlib.machinery.SourceFileLoader("run_benchmarks", str(ROOT / "benchmarks" / "run_benchmarks"))
    module = importlib.util.module_from_spec(importlib.util.spec_from_loader(loader.name, loader))
    loader.exec_module(module)
    return module


class History(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)
        self.commits = []
        self.git("init", "-q")
        for number in range(5):
            self.git("-c", "user.name=n", "-c", "user.email=e", "commit", "-q", "--allow-empty", "-m", f"Change {number}")
            self.commits.append(self.git("rev-parse", "HEAD"))
        self.tool = load()
        self.built = []
        sys.modules["bench_trees"].ROOT = self.tool.ROOT = self.folder
        self.tool.OUT, self.tool.HISTORY = self.folder / "out", self.folder / "history.csv"
        self.addCleanup(sys.modules.pop, "bench_trees")
        self.tool.Tree = self.tree
        self.tool.instructions = lambda program, kernel, particles: 525.0 if "slow" in str(program) and kernel == "particle_to_grid" else 500.0

    def git(self, *arguments):
        return subprocess.run(["git", "-C", str(self.folder), *arguments], check=True, capture_output=True, text=True).stdout.strip()

    def tree(self, commit, _):
        """In place of a copy and a build. From commit 3 on P2G is 5 % slower; commit 1 does not build."""
        number = self.commits.index(commit)

        def build(_kind):
            self.built.append(number)
            if number == 1:
                raise self.tool.Failure("does not build")
            program = self.folder / ("slow" if number >= 3 else "fast")
            program.write_text(FAKE.format(python=sys.executable, slower=number >= 3), encoding="utf-8")
            program.chmod(0o755)
            return program
        return mock.Mock(label=commit[:12], build=build)

    def run_tool(self, *arguments):
        with mock.patch.object(sys, "argv", ["run_benchmarks", *arguments]), mock.patch("builtins.print") as output:
            code = self.tool.main()
        return code, "\n".join(" ".join(map(str, call.args)) for call in output.call_args_list)

    def history(self):
        with open(self.tool.HISTORY, newline="", encoding="utf-8") as file:
            return list(csv.DictReader(file))

    def test_marks_the_commit_that_became_slower_and_goes_on_after_one_that_does_not_build(self):
        options = ["--commits", *self.commits, "--launches", "4", "--pairs", "12", "--particles", "100000"]
        code, text = self.run_tool(*options)
        self.assertEqual(code, 1)
        self.assertIn(f"not measured: {self.commits[1][:12]}", text)
        marks = [line for line in text.splitlines() if "% time" in line]
        self.assertEqual(len(marks), 1, text)
        self.assertRegex(marks[0], rf"{self.commits[3][:12]}  particle_to_grid: \+[45]\.\d % time  Change 3")
        self.assertEqual({row["commit"] for row in self.history()}, {c[:12] for i, c in enumerate(self.commits) if i != 1})
        page = (self.folder / "out" / "index.html").read_text(encoding="utf-8")
        self.assertIn("Change 3", page[:page.index("Kernels by commit</h2>")])
        data = json.loads((self.folder / "out" / "history" / f"{self.commits[4][:12]}.json").read_text(encoding="utf-8"))
        self.assertEqual([b["name"] for b in data["benchmarks"]], ["particle_to_grid", "sort"])

        rows = len(self.history())  # a second time: only what is missing
        self.built.clear()
        self.run_tool(*options)
        self.assertEqual(len(self.history()), rows)
        self.assertEqual(set(self.built), {0, 1})

    def test_a_gate_judges_by_instructions_alone(self):
        def gate(current, *arguments):
            return self.run_tool("--baseline", self.commits[0], "--current", self.commits[current], "--gate", *arguments, "--no-history", "--launches", "2",
                                 "--pairs", "4", "--particles", "1000")
        for current, limit, code, message in ((3, [], 3, "particle_to_grid: +5.0 % instructions; 2 % are allowed"), (3, ["6"], 0, "no kernel takes more than 6 %"),
                                              (2, [], 0, "no kernel takes more than 2 %")):
            with self.subTest(current=current, limit=limit):
                found, text = gate(current, *limit)
                self.assertEqual(found, code, text)
                self.assertIn(message, text)
        self.assertEqual(gate(3, "2", "--no-instructions")[0], 2)

    def test_the_heading_of_a_comparison_names_baseline_and_current(self):
        options = mock.Mock(no_instructions=True, kernel=None, core=None, launches=2, pairs=12, particles=1000)
        baseline, current = (self.tree(self.commits[n], "") for n in (0, 3))
        with mock.patch("builtins.print") as output:
            self.tool.measure(options, baseline, current)
        text = "\n".join(" ".join(map(str, call.args)) for call in output.call_args_list)
        self.assertIn(f"baseline {self.commits[0][:12]}, current {self.commits[3][:12]};", text)
        row = next(line.split() for line in text.splitlines() if line.startswith("particle_to_grid "))
        self.assertLess(float(row[1]), float(row[2]), text)  # the current tree is the slower one
        self.assertGreater(float(row[3]), 1.0, text)

    def test_a_build_is_announced_before_it_starts(self):
        trees = sys.modules["bench_trees"]
        tree = trees.Tree.__new__(trees.Tree)
        tree.name, tree.label, tree.source, tree.own_benchmarks = "baseline", "abc", self.folder / "source", None
        order = []
        with mock.patch.object(trees, "WORK", self.folder), mock.patch.object(trees, "say", order.append), \
                mock.patch.object(trees, "run", lambda command, **_: order.append(command[0])):
            tree.build("native")
            (self.folder / "baseline" / "native").mkdir(parents=True)
            (self.folder / "baseline" / "native" / "CMakeCache.txt").write_text(f"CMAKE_HOME_DIRECTORY:INTERNAL={tree.source}\n", encoding="utf-8")
            tree.build("native")
        self.assertEqual(order, ["build of abc (native); the first build takes some minutes", "cmake", "cmake", "build of abc (native)", "cmake", "cmake"])

    def test_the_readme_states_no_number_of_benchmarks(self):
        text = (ROOT / "benchmarks" / "README.md").read_text(encoding="utf-8")
        self.assertEqual(re.findall(r"\b\d+ benchmarks\b", text), [])  # --benchmark_list_tests lists them; a number here would become wrong

    def test_reads_what_other_tools_wrote(self):
        def file(name, commit, times):
            data = {"context": {"commit": commit, "host_name": "a machine, 4 cores", "date": f"2026-01-0{len(commit)}"},
                    "benchmarks": [{"name": "k", "run_name": "k", "run_type": "iteration", "cpu_time": t, "real_time": t, "time_unit": "ns"} for t in times]}
            (self.folder / name).write_text(json.dumps(data), encoding="utf-8")
            return str(self.folder / name)
        times = [1.0 + 1e-3 * (i % 3) for i in range(9)]
        code, text = self.run_tool("--read", file("a.json", "a", times), file("b.json", "bb", times), file("c.json", "ccc", [1.2 * t for t in times]))
        self.assertEqual((code, [row["commit"] for row in self.history()]), (0, ["a", "bb", "ccc"]))
        self.assertIn("ccc  k: +20.0 % time", text)

    def test_says_what_is_wrong(self):
        for arguments, code, message in ((["--commits", self.commits[0]], 2, "at least two commits"), (["--read", "none.json"], 1, "cannot read 'none.json'"),
                                         (["--commits", *self.commits[3:], "--kernel", "p2g"], 2, "no kernel p2g")):
            found, text = self.run_tool(*arguments)
            self.assertEqual(found, code)
            self.assertIn(message, text)


if __name__ == "__main__":
    sys.exit(unittest.main())
