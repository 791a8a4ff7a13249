#!/usr/bin/python3
"""A case goes to other solvers and back: export, the solver in numpy and the plain one, grade; then with errors planted, and with files missing.

usage: other_solvers.py MPM_VALIDATE PLAIN_MPM
"""

import csv
import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest

import h5py
import numpy as np

SOLVER = pathlib.Path(__file__).resolve().parent.parent / "validation" / "foreign" / "numpy_mpm.py"
CASE = "sliding_block"  # three runs of 1024 particles
VALIDATE, PLAIN = "", ""


def validate(*arguments):
    return subprocess.run([VALIDATE, *map(str, arguments)], capture_output=True, text=True, check=False)


def solving(solver, exported, results, *runs):
    program = [sys.executable, str(solver)] if str(solver).endswith(".py") else [str(solver)]
    return subprocess.Popen([*program, str(exported), str(results), *runs], stderr=subprocess.PIPE, text=True)


class OtherSolvers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.folder = tempfile.TemporaryDirectory()
        root = pathlib.Path(cls.folder.name)
        cls.exported, cls.solved, cls.plain, cls.report = root / "exported", root / "solved", root / "plain", root / "report"
        done = validate("export", CASE, "--out", cls.exported)
        assert done.returncode == 0, done.stderr
        cls.case = json.loads((cls.exported / "case.json").read_text(encoding="utf-8"))
        for process in [solving(SOLVER, cls.exported, cls.solved, "slope-30"), solving(PLAIN, cls.exported, cls.plain)]:
            message = process.communicate()[1]
            assert process.returncode == 0, message
        for run in ("thrown", "slope-10"):  # a minute in numpy
            shutil.copytree(cls.plain / run, cls.solved / run)

    @classmethod
    def tearDownClass(cls):
        cls.folder.cleanup()

    def copy_of_results(self):
        copy = pathlib.Path(tempfile.mkdtemp(dir=self.folder.name)) / "results"
        shutil.copytree(self.solved, copy)
        return copy

    def grade(self, results, *more):
        return validate("grade", CASE, "--results", results, "--out", self.report, *more)

    def test_every_case_that_is_marked_can_be_exported(self):
        marked = [line.split()[0] for line in validate("list").stdout.splitlines() if line.endswith("[export]")]
        self.assertIn("elastic_wave", marked)
        for case in marked:  # the checks are asked of a solver that moves nothing
            with self.subTest(case=case), tempfile.TemporaryDirectory() as folder:
                done = validate("export", case, "--out", pathlib.Path(folder) / "exported")
                self.assertEqual(done.returncode, 0, done.stderr)

    def test_the_description_is_complete(self):
        self.assertEqual(self.case["case"], CASE)
        self.assertEqual([run["id"] for run in self.case["runs"]], ["thrown", "slope-30", "slope-10"])
        run = self.case["runs"][0]
        self.assertEqual(run["material"]["model"], "hencky_elastic")
        self.assertIn("tau = K tr(eps) I", run["material"]["law"])
        self.assertEqual(run["boundaries"][0]["friction"], 0.4)
        self.assertIn("Coulomb", run["boundaries"][0]["rule"])
        self.assertTrue(all(a < b for a, b in zip(run["results"]["times_s"], run["results"]["times_s"][1:])))

    def test_both_files_of_particles_hold_the_same_numbers(self):
        folder = self.exported / "thrown"
        with open(folder / "particles.csv", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        with h5py.File(folder / "particles.h5") as file:
            self.assertEqual(set(file), set(rows[0]))
            for name in file:
                np.testing.assert_array_equal(file[name][()], [float(row[name]) for row in rows])
        self.assertEqual(len(rows), self.case["runs"][0]["particles"]["count"])

    def test_the_solver_in_numpy_passes(self):
        done = self.grade(self.solved)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        results = json.loads((self.report / "results.json").read_text(encoding="utf-8"))
        self.assertEqual(results["solver"], "numpy_mpm")
        self.assertEqual((results["passed"], results["failed"]), (5, 0))
        self.assertIn("Validation of numpy_mpm", (self.report / "index.html").read_text(encoding="utf-8"))

    def test_an_error_in_the_solver_fails_a_check(self):
        text = SOLVER.read_text(encoding="utf-8")
        right = 'boundary["friction"] * np.maximum(push, 0.0)'
        self.assertEqual(text.count(right), 1)
        results = self.copy_of_results()
        wrong = results.parent / "wrong.py"
        wrong.write_text(text.replace(right, "0.99 * " + right), encoding="utf-8")
        process = solving(wrong, self.exported, results, "slope-30")
        message = process.communicate()[1]
        self.assertEqual(process.returncode, 0, message)
        done = self.grade(results)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        failed = [line for line in done.stdout.splitlines() if "FAILED" in line]
        self.assertTrue(any("thrown down a slope of 30°: distance" in line for line in failed), done.stdout)

    def test_the_plain_solver_passes(self):  # its states are CSV files
        done = self.grade(self.plain)
        self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
        results = json.loads((self.report / "results.json").read_text(encoding="utf-8"))
        self.assertEqual((results["solver"], results["passed"], results["failed"]), ("plain_mpm", 5, 0))

    def failures_of_plain_solver(self, right, wrong):
        """Checks that fail if the plain solver is given another case.toml for the slope of 30 degrees."""
        exported = pathlib.Path(tempfile.mkdtemp(dir=self.folder.name)) / "exported"
        shutil.copytree(self.exported, exported)
        results = exported.parent / "results"
        shutil.copytree(self.plain, results)
        text = (exported / "slope-30" / "case.toml").read_text(encoding="utf-8")
        self.assertEqual(text.count(right), 1)
        (exported / "slope-30" / "case.toml").write_text(text.replace(right, wrong), encoding="utf-8")
        process = solving(PLAIN, exported, results, "slope-30")
        message = process.communicate()[1]
        self.assertEqual(process.returncode, 0, message)
        done = self.grade(results)
        self.assertEqual(done.returncode, 1, done.stdout + done.stderr)
        return [line for line in done.stdout.splitlines() if "FAILED" in line]

    def test_one_per_cent_of_gravity_fails_a_check(self):
        failed = self.failures_of_plain_solver("gravity_m_s2 = 9.81", "gravity_m_s2 = 9.9081")
        self.assertTrue(any("thrown down a slope of 30°: distance" in line for line in failed), failed)

    def test_one_per_cent_of_friction_fails_a_check_of_the_plain_solver(self):
        failed = self.failures_of_plain_solver("friction = 0.4\n", "friction = 0.396\n")
        self.assertTrue(any("thrown down a slope of 30°: distance" in line for line in failed), failed)

    def test_at_least_ten_cases_can_be_exported(self):
        listed = validate("list").stdout.splitlines()
        self.assertGreaterEqual(sum("[export]" in line for line in listed), 10, "\n".join(listed))

    def test_own_results_come_back_unchanged(self):
        root = pathlib.Path(tempfile.mkdtemp(dir=self.folder.name))
        self.assertEqual(validate("export", "free_flight", "--out", root / "solved", "--solve", "--threads", "1").returncode, 0)
        self.assertEqual(validate("grade", "free_flight", "--results", root / "solved", "--out", root / "graded").returncode, 0)
        self.assertEqual(validate("run", "--case", "free_flight", "--out", root / "run", "--threads", "1").returncode, 0)
        graded, run = (json.loads((root / name / "results.json").read_text(encoding="utf-8"))["cases"][0]["checks"] for name in ("graded", "run"))
        own_scheme = [k for k in run if "AFLIP" in k["quantity"]]  # not asked of other solvers
        self.assertEqual(len(own_scheme), 1)
        self.assertEqual([(k["quantity"], k["value"], k["tolerance"]) for k in graded],
                         [(k["quantity"], k["value"], k["tolerance"]) for k in run if k not in own_scheme])

    def test_a_missing_file_is_named(self):
        results = self.copy_of_results()
        (results / "thrown" / "forces.csv").unlink()
        (results / "slope-30" / "states.h5").unlink()
        done = self.grade(results)
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("thrown/forces.csv: missing", done.stderr)
        self.assertIn("slope-30: neither states/0001.csv nor group 0001 of states.h5", done.stderr)

    def test_numbers_that_are_not_finite_fail_the_checks_that_use_them_and_the_case(self):
        results = self.copy_of_results()
        file = results / "thrown" / "forces.csv"
        rows = [line.split(",") for line in file.read_text(encoding="utf-8").splitlines()]
        file.write_text("".join(",".join(row[:-1] + ["nan" if i else row[-1]]) + "\n" for i, row in enumerate(rows)), encoding="utf-8")
        done = self.grade(results)
        self.assertEqual(done.returncode, 1, done.stderr)
        self.assertTrue(any("friction over" in line and "FAILED" in line for line in done.stdout.splitlines()), done.stdout)
        self.assertIn("numbers of the results are not finite", done.stdout)

    def test_a_missing_column_is_named(self):
        results = self.copy_of_results()
        with h5py.File(results / "slope-30" / "states.h5", "a") as file:
            del file["0001"]["vx_m_s"]
        done = self.grade(results)
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertRegex(done.stderr, r"states.h5, group 0001: columns missing: vx_m_s")

    def test_a_missing_state_is_named(self):
        results = self.copy_of_results()
        with h5py.File(results / "slope-30" / "states.h5", "a") as file:
            del file["0033"]
        done = self.grade(results)
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertIn("group 0033 of states.h5", done.stderr)

    def test_results_of_another_level_are_refused(self):
        results = self.copy_of_results()
        done = self.grade(results, "--level", "standard")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("level quick", done.stderr)

    def test_results_without_the_description_of_their_case_are_refused(self):
        results = self.copy_of_results()
        (results / "case.json").unlink()
        done = self.grade(results)
        self.assertEqual(done.returncode, 4, done.stderr)
        self.assertRegex(done.stderr, r"case.json: missing; copy")

    def test_the_description_has_the_checks_with_their_references(self):
        self.assertEqual(self.grade(self.solved).returncode, 0)
        graded = json.loads((self.report / "results.json").read_text(encoding="utf-8"))["cases"][0]["checks"]
        self.assertEqual(len(self.case["checks"]), len(graded))
        known = [check for check in self.case["checks"] if check["reference"] is not None]
        self.assertGreaterEqual(len(known), 3)
        for check in self.case["checks"]:
            [same] = [other for other in graded if other["quantity"] == check["quantity"]]
            self.assertEqual((check["unit"], check["measure"]), (same["unit"], same["measure"]))
            for number in ("reference", "tolerance"):
                if check[number] is not None:
                    self.assertAlmostEqual(check[number], same[number], delta=1e-12 * abs(same[number]), msg=check["quantity"])

    def test_a_level_that_is_none_is_answered_in_words(self):
        done = validate("run", "--level", "fast")
        self.assertEqual(done.returncode, 2)
        self.assertIn("'fast' is none of full, quick, standard", done.stderr)
        self.assertNotRegex(done.stderr, r"->|[{}]")

    def test_a_case_without_set_ups_is_refused(self):
        done = validate("export", "stress_paths", "--out", self.report / "none")
        self.assertEqual(done.returncode, 2, done.stderr)
        self.assertIn("cannot be exported", done.stderr)


if __name__ == "__main__":
    VALIDATE, PLAIN = sys.argv.pop(1), sys.argv.pop(1)
    unittest.main(verbosity=2)
