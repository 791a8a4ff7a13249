"""How long a high run-up lasts, and the committed series of it."""

import math
import unittest

import numpy as np

from mpmtools.errors import ConfigError
from mpmtools.study.collapse import plateaus
from mpmtools.tables import read_series
from study_samples import SOURCE

EVIDENCE = SOURCE / "validation" / "study" / "evidence" / "collapse"
TIMES = np.arange(0.0, 45.0, 0.02)


class Plateaus(unittest.TestCase):
    def test_a_run_up_that_falls_has_two(self):
        wave = 0.3 * np.sin(7.0 * TIMES)
        found = plateaus(TIMES, np.where(TIMES < 17.0, 14.0, 6.0) + wave)
        self.assertAlmostEqual(found.highest, 14.0, delta=0.05)
        self.assertAlmostEqual(found.late, 6.0, delta=0.01)
        self.assertAlmostEqual(found.fell_s, 18.0, delta=0.1)  # when half of the running mean is on the lower one

    def test_a_run_up_that_stays_has_one(self):
        found = plateaus(TIMES, 6.0 + 2.0 * np.exp(-TIMES) + 0.5 * np.sin(3.0 * TIMES))
        self.assertTrue(math.isnan(found.fell_s))
        self.assertAlmostEqual(found.late, 6.0, delta=0.05)

    def test_a_short_series_is_refused(self):
        with self.assertRaisesRegex(ConfigError, "more than 17 s"):
            plateaus(TIMES[:800], np.ones(800))


class Committed(unittest.TestCase):
    def test_table_is_found_again_from_the_series(self):
        series, table = read_series(EVIDENCE / "series.csv"), read_series(EVIDENCE / "plateaus.csv")
        self.assertEqual(len(table), series.run.nunique())
        for row in table.itertuples():
            of = series[series.run == row.run]
            found = plateaus(of.time_s, of.runup_m / 1.75)
            self.assertAlmostEqual(found.highest, row.highest_runup, delta=6e-4)
            self.assertAlmostEqual(found.late, row.late_runup, delta=6e-4)
            self.assertEqual(math.isnan(found.fell_s), math.isnan(row.fell_s), row.run)
            if not math.isnan(found.fell_s):
                self.assertAlmostEqual(found.fell_s, row.fell_s, delta=1e-9)


if __name__ == "__main__":
    unittest.main()
