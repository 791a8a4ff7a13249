#!/usr/bin/python3
"""The tutorials run as a user runs them, and do what they say.

usage: tutorials.py MPM [TEST...]
beside MPM: mpm-validate, bench_paired; in ../python: the module libmpm (./run python)

A tutorial whose program or module was not built is skipped.
"""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

SOURCE = pathlib.Path(__file__).resolve().parent.parent
TUTORIALS = SOURCE / "examples" / "tutorials"
MPM = ""


def run(name, *arguments, modules=SOURCE / "python"):
    """Standard output; every failure of a tutorial is one of its test. @param modules  folder of the Python modules"""
    environment = {**os.environ, "MPM": MPM, "PYTHONPATH": str(modules)}
    done = subprocess.run([sys.executable, str(TUTORIALS / name), *map(str, arguments)], capture_output=True, text=True, env=environment, check=False)
    assert done.returncode == 0, f"{name}: exit code {done.returncode}\n{done.stdout}\n{done.stderr}"
    return done.stdout


class Tutorials(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.folder = pathlib.Path(folder.name)

    def test_a_first_mast(self):
        reported = run("a_first_mast.py", self.folder)
        self.assertIn("3 cells across the obstacle", reported)  # the advice that the text speaks of
        self.assertRegex(reported, r"runup_p99_mean_m: [\d.]+ ± [\d.]+ \(statistics\) ± [\d.]+ \(grid\) m")
        self.assertRegex(reported, r"force_mean_n\.x .*(DIFFERS|agrees)")
        for name in ("first_mast.png", "side_view.png"):
            self.assertTrue((self.folder / name).read_bytes().startswith(b"\x89PNG"))
        self.assertIn(b"<VTKFile", (self.folder / "last.vtp").read_bytes()[:200])

    def test_verify_your_solver(self):
        reported = run("verify_your_solver.py", self.folder)  # it asserts that the right solver passes and the wrong one fails
        self.assertRegex(reported, r"7 passed, 0 failed")
        self.assertRegex(reported, r"\n[1-6] passed, [1-6] failed")
        self.assertTrue((self.folder / "report" / "index.html").exists())

    def test_is_my_kernel_slower(self):
        bench = pathlib.Path(MPM).with_name("bench_paired")
        reported = run("is_my_kernel_slower.py", *([bench, bench, "particle_to_grid"] if bench.exists() else []))
        verdicts = dict(re.findall(r"^(.+): [\d.]+ times .*: (slower|faster|no change)$", reported, flags=re.MULTILINE))
        self.assertEqual(verdicts["add_at -> bincount"], "faster")  # by a factor of twenty or more
        self.assertIn("bincount -> bincount_and_more", verdicts)  # 6 % to 12 % slower: a busy machine may hide it
        self.assertIn("bincount -> bincount", verdicts)
        if bench.exists():
            self.assertIn("particle_to_grid", verdicts)

    def test_how_fine_must_my_grid_be(self):
        reported = run("how_fine_must_my_grid_be.py", self.folder)
        self.assertRegex(reported, r"force_mean_n.x: \d+ % with 5 cells across the mast(; 5 % need about \d+ cells|: too coarse to say)")
        for cells in re.findall(r"need about (\d+) cells", reported):
            self.assertLessEqual(int(cells), 20)
        self.assertTrue((self.folder / "grids.png").read_bytes().startswith(b"\x89PNG"))

    def test_the_library_in_python(self):
        modules = pathlib.Path(MPM).parent.parent / "python"
        if not list(modules.glob("libmpm.*.so")):
            self.skipTest(f"needs the module libmpm in {modules}: ./run python builds it and runs this test")
        # It asserts the critical state and the balance of momentum.
        reported = run("the_library_in_python.py", self.folder, modules=modules)
        self.assertEqual(re.findall(r"q/p = ([\d.]+) at the end", reported), ["0.800"] * 3)
        self.assertRegex(reported, r"6481 particles[^\n]*\n\d+ steps, force on the floor between .* kN, weight 4.6 kN")
        for name in ("point_path.png", "predictions.png", "column.png"):
            self.assertTrue((self.folder / name).read_bytes().startswith(b"\x89PNG"))

    def test_the_library_in_python_says_where_the_module_is_missing(self):
        environment = {name: value for name, value in os.environ.items() if name != "PYTHONPATH"}
        script = [sys.executable, str(TUTORIALS / "the_library_in_python.py"), str(self.folder)]
        done = subprocess.run(script, capture_output=True, text=True, env=environment, check=False)
        self.assertEqual(done.returncode, 1)
        self.assertIn("build it with ./run python, and set PYTHONPATH=build/python/python", done.stderr)

    def test_are_listed_and_open_as_notebooks(self):
        page = (TUTORIALS / "README.md").read_text(encoding="utf-8")
        scripts = sorted(path.name for path in TUTORIALS.glob("*.py"))
        self.assertEqual(sorted(set(re.findall(r"\]\((\w+\.py)\)", page))), scripts)
        for name in scripts:
            text = (TUTORIALS / name).read_text(encoding="utf-8")
            self.assertRegex(text, r"^#!.*\n# %% \[markdown\]\n# # ", name)
            cells = re.split(r"^# %%.*\n", text, flags=re.MULTILINE)[1:]
            self.assertGreater(len(cells), 6, name)


if __name__ == "__main__":
    MPM = os.path.abspath(sys.argv.pop(1))
    unittest.main(verbosity=2)
