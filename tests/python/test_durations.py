"""Runs cut off earlier: heights of a pile whose growth is known, and coefficients from them; and the tables that are kept."""

import unittest

import numpy as np
import pandas as pd

from mpmtools.equations import PUBLISHED_RUNUP, relative_height
from mpmtools.study.durations import coefficients_by_duration, cut_heights
from mpmtools.study.runs import read_study_table
from mpmtools.tables import read_series
from study_samples import SOURCE, InFolder, grid_of_runs

HEIGHT = 1.75


def growing(seconds, late):
    """A pile that reaches H + (late - H) t/(t + 20 s)."""
    times = np.arange(0.0, seconds + 0.05, 0.1)
    runup = HEIGHT * (1.0 + (late - 1.0) * times / (times + 20.0))
    return pd.DataFrame({"time_s": times, "runup_m": runup, "pressure_height_m": 0.9 * runup}).to_csv(index=False)


class CutHeights(InFolder):
    def test_are_means_of_the_last_third_of_both_durations(self):
        rows = "".join(f"fr{froude},done,{froude},0.8,0.3,5,1.1,{HEIGHT},3.5,3.1\n" for froude in (0.3, 3, 0.1))
        self.write("results.csv", "name,status,froude_number,critical_state_slope,cohesion_beta,hardening_xi,effective_friction,flow_height_m,"
                   "runup_mean_m,pressure_height_mean_m\n" + rows)
        for name, seconds in (("fr0.3", 90.0), ("fr3", 90.0), ("fr0.1", 50.0)):
            self.write(f"{name}/series.csv", growing(seconds, 3.0))
        table = cut_heights(self.folder / "results.csv")
        self.assertEqual(table.froude_number.tolist(), [0.3])  # Fr 3 is fast, and the run at Fr 0.1 is no longer than 60 s
        row = table.iloc[0]
        self.assertEqual((row.shorter_s, row.whole_s), (30.0, 90.0))
        for name, times in (("shorter", np.arange(20.0, 30.05, 0.1)), ("whole", np.arange(60.0, 90.05, 0.1))):
            self.assertAlmostEqual(row[f"runup_{name}"], 1.0 + 2.0 * np.mean(times / (times + 20.0)), 9)
        self.assertAlmostEqual(row.runup_ratio, row.runup_shorter / row.runup_whole, 12)
        self.assertAlmostEqual(row.pressure_height_ratio, row.runup_ratio, 12)

    def test_give_coefficients_of_either_duration(self):
        runs = grid_of_runs()
        slow = runs[runs.froude_number <= 0.3]
        cut = slow.assign(runup_whole=slow.runup, pressure_height_whole=slow.pressure_height, pressure_height_shorter=slow.pressure_height,
                          runup_shorter=relative_height(slow.effective_friction, slow.froude_number, PUBLISHED_RUNUP._replace(k=0.8)))
        found = coefficients_by_duration(runs, cut).set_index(["duration", "fitting_set", "parameter"]).value
        self.assertAlmostEqual(found["whole", "narrow", "k_r"], PUBLISHED_RUNUP.k, 6)
        self.assertLess(found["shorter", "narrow", "k_r"], 0.9)
        self.assertAlmostEqual(found["shorter", "narrow", "k_p"], found["whole", "narrow", "k_p"], 9)


class KeptTables(unittest.TestCase):
    def test_coefficients_are_found_again_from_the_heights_and_the_rows(self):
        study = SOURCE / "validation" / "study"
        heights = read_series(study / "evidence" / "durations" / "heights.csv")
        runs = read_study_table([str(study / "results" / "prediction" / "w5.csv")]).runs
        found = coefficients_by_duration(runs, heights[heights.campaign == "prediction"])
        kept = read_series(study / "evidence" / "durations" / "coefficients.csv")
        self.assertEqual(found[["duration", "fitting_set", "parameter", "runs"]].values.tolist(),
                         kept[["duration", "fitting_set", "parameter", "runs"]].values.tolist())
        for column in ("value", "standard_error"):
            np.testing.assert_allclose(found[column], kept[column], rtol=1e-5)


if __name__ == "__main__":
    unittest.main()
