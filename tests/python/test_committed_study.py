"""The tables kept in validation/study/results are found again from the runs kept beside them.

They were written by the C++ evaluation that this package took over. What needs the folders of the runs, which are not kept
(envelopes, height choices, sections), is tested on small runs in test_study.py.
"""

import json
import pathlib
import tempfile
import unittest

import numpy as np
import pandas as pd

from mpmtools.equations import HeightCoefficients
from mpmtools.study.fits import INPUTS, NARROW, WIDE, height_samples, score_samples
from mpmtools.study.regression import EQUATIONS
from mpmtools.study.runs import read_study_table
from mpmtools.study.tables import write_study
from mpmtools.tables import read_series
from study_samples import SOURCE

STUDY = SOURCE / "validation" / "study"
RESULTS, EVIDENCE = STUDY / "results", STUDY / "evidence"
# Those that hold no fitted coefficient: only the order of sums differs.
UNFITTED = ("compaction", "compaction_curve", "compaction_summary", "decomposition", "effective_friction", "guideline", "guideline_minima",
            "sensitivity", "sensitivity_summary", "spreads", "width_factors")
FITTED = ("coefficients", "factor_curves", "height_curves", "points")
# The C++ stopped its search when the sum of squares no longer fell, at up to 1.4e-8 of a coefficient from the minimum.
COEFFICIENTS, SCORES, SUMS = 1e-6, 1e-9, 1e-12


class CommittedStudy(unittest.TestCase):
    name = "coarse"
    options = {"width_files": [EVIDENCE / "width" / "results.csv"], "section_files": [EVIDENCE / "sections" / "results.csv"],
               "sensitivity_file": EVIDENCE / "sensitivity" / "results.csv"}

    @classmethod
    def setUpClass(cls):
        folder = tempfile.TemporaryDirectory()
        cls.addClassCleanup(folder.cleanup)
        cls.folder = pathlib.Path(folder.name)
        write_study([str(RESULTS / cls.name / "results.csv")], folder.name, **cls.options)

    def both(self, table):
        return read_series(self.folder / f"{table}.csv"), read_series(RESULTS / self.name / f"{table}.csv")

    def assert_equal(self, found, committed, tolerance, what):
        self.assertEqual(list(found), list(committed), what)
        self.assertEqual(len(found), len(committed), what)
        for column in found:
            a, b = found[column], committed[column]
            if pd.api.types.is_numeric_dtype(b):
                np.testing.assert_allclose(a.astype(float), b, rtol=tolerance, atol=1e-300, err_msg=f"{what}: {column}")
            else:
                self.assertEqual(a.fillna("").tolist(), b.fillna("").tolist(), f"{what}: {column}")

    def test_numbers_without_a_fit_are_equal_to_round_off(self):
        for table in UNFITTED:
            if (RESULTS / self.name / f"{table}.csv").exists():
                self.assert_equal(*self.both(table), SUMS, table)

    def test_coefficients_are_equal(self):
        for table in FITTED:
            found, committed = self.both(table)
            if table == "coefficients":  # a p-value of 1e-150 takes hundreds of times the difference of t
                found["p_value"], committed["p_value"] = np.log(found.p_value), np.log(committed.p_value)
            self.assert_equal(found, committed, COEFFICIENTS, table)

    def test_scores_against_the_published_coefficients_are_equal(self):
        found, committed = (table[table.coefficients == "published"] for table in self.both("scores"))
        self.assert_equal(found, committed, SCORES, "scores")

    def test_scores_against_the_committed_coefficients_are_equal(self):
        runs = read_study_table([str(RESULTS / self.name / "results.csv")]).runs
        coefficients, committed = read_series(RESULTS / self.name / "coefficients.csv"), read_series(RESULTS / self.name / "scores.csv")
        for equation in EQUATIONS:
            for fitting_set in (NARROW, WIDE):
                values = coefficients[(coefficients.equation == equation.name) & (coefficients.fitting_set == fitting_set.name)]
                values = values.set_index("parameter")["value"]
                c = HeightCoefficients(values[equation.parameters[0]], values[equation.parameters[-1]], values.get("Fr_sat", np.inf))
                expected = committed[(committed.equation == equation.name) & (committed.fitting_set == fitting_set.name)
                                     & (committed.coefficients == "fitted") & committed.hardening_xi.isna()]
                found = score_samples(height_samples(equation, runs[fitting_set.holds(runs)]), c, [*INPUTS, "hardening_xi"])
                self.assert_equal(found, expected[list(found)].reset_index(drop=True), SCORES, f"{equation.name}, {fitting_set.name}")

    def test_scores_of_the_fits_are_equal_as_far_as_their_coefficients_are(self):
        """R^2 of a group may be near 0, and is then off by many times its coefficients' difference: absolute."""
        found, committed = self.both("scores")
        np.testing.assert_allclose(found.iloc[:, 7:], committed.iloc[:, 7:], rtol=0.0, atol=COEFFICIENTS)

    def test_the_sums_of_squares_of_the_whole_sets_are_not_above_the_committed_ones(self):
        found, committed = (table[(table.coefficients == "fitted") & table.hardening_xi.isna() & table.group.isna()]
                            for table in self.both("scores"))
        for a, b in zip(found.itertuples(), committed.itertuples()):
            score = "rmsle" if a.equation == "runup" else "nrmse"
            self.assertLessEqual(getattr(a, score), getattr(b, score) * (1.0 + 1e-14))
            self.assertAlmostEqual(getattr(a, score) / getattr(b, score), 1.0, delta=SCORES)

    def test_fit_json_holds_the_same(self):
        with open(self.folder / "fit.json", encoding="utf-8") as file:
            found = json.load(file)
        with open(RESULTS / self.name / "fit.json", encoding="utf-8") as file:
            committed = json.load(file)
        # Not the same: the program; the path of the table; what is not kept of the campaign, its runs.csv and rows that are not done.
        for key in ("evaluated_by", "files", "provenance", "rows", "left_out"):
            found.pop(key), committed.pop(key)
        self.assert_close(found, committed, "fit.json")

    def assert_close(self, a, b, where):
        if isinstance(b, dict):
            self.assertEqual(sorted(a), sorted(b), where)
            for key in b:
                if key == "p_value":
                    self.assertAlmostEqual(np.log(a[key]) / np.log(b[key]), 1.0, delta=COEFFICIENTS)
                else:
                    self.assert_close(a[key], b[key], f"{where}.{key}")
        elif isinstance(b, list):
            self.assertEqual(len(a), len(b), where)
            for i, (x, y) in enumerate(zip(a, b)):
                self.assert_close(x, y, f"{where}[{i}]")
        elif isinstance(b, float):
            np.testing.assert_allclose(a, b, rtol=COEFFICIENTS, err_msg=where)
        else:
            self.assertEqual(a, b, where)


class CommittedFineStudy(CommittedStudy):
    name = "fine"
    options = {}


if __name__ == "__main__":
    unittest.main()
