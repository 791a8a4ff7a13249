#!/usr/bin/python3
"""The program accepts every plan of validation/study; nothing is computed.

usage: study_plans.py MPM
"""

import pathlib
import subprocess
import sys
import tempfile
import unittest

STUDY = pathlib.Path(__file__).resolve().parent.parent / "validation" / "study"
MPM = ""


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
                    self.assertIn(" 0 done, 0 running, 0 failed, ", done.stdout)

    def test_bases_are_cases(self):
        for base in (STUDY / "base.toml", STUDY / "prediction" / "base.toml"):
            done = subprocess.run([MPM, "check", base], capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stderr)


if __name__ == "__main__":
    MPM = sys.argv.pop(1)
    unittest.main()
