#!/usr/bin/python3
"""The program accepts every plan of validation/study; nothing is computed.

usage: study_plans.py MPM
"""

import csv
import pathlib
import subprocess
import sys
import tempfile
import tomllib
import unittest

STUDY = pathlib.Path(__file__).resolve().parent.parent / "validation" / "study"
MPM = ""


def stored_rows(plan):
    """Finished runs in the tables of stored results of a plan."""
    with open(plan, "rb") as file:
        tables = tomllib.load(file).get("stored_results", [])
    rows = []
    for table in tables:
        with open(plan.parent / table, newline="", encoding="utf-8") as file:
            rows += [row for row in csv.DictReader(file) if row["status"] == "done"]
    return rows


class StudyPlans(unittest.TestCase):
    def test_are_accepted(self):
        plans = [path for path in sorted(STUDY.rglob("*.toml")) if path.name != "base.toml"]
        self.assertGreaterEqual(len(plans), 17)
        with tempfile.TemporaryDirectory() as folder:
            for plan in plans:
                with self.subTest(plan=str(plan.relative_to(STUDY))):
                    done = subprocess.run([MPM, "campaign", "status", plan, "--out", pathlib.Path(folder) / "campaign"], capture_output=True,
                                          text=True, check=False)
                    self.assertEqual(done.returncode, 0, done.stderr)
                    self.assertRegex(done.stdout, r": \d+ runs? in ")
                    self.assertIn(f" {len(stored_rows(plan))} done, 0 running, 0 failed, ", done.stdout)
                    self.assertNotIn("stored results left out", done.stdout)  # the hash of a published case stays the same

    def test_bases_are_cases(self):
        for base in (STUDY / "base.toml", STUDY / "prediction" / "base.toml"):
            done = subprocess.run([MPM, "check", base], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    MPM = sys.argv.pop(1)
    unittest.main()
