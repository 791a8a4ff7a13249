"""Means of windows and of the strip over the same time."""

import pathlib
import tempfile
import unittest

import numpy as np
import pandas as pd

from analysis.windows import STRIP_LASTS, highest_means, window_means


class WindowMeans(unittest.TestCase):
    def setUp(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        self.path = pathlib.Path(folder.name) / "results.csv"

    def campaign(self, froude_numbers, conveyor='feed = "strip"\nsidewall_contact = "no_slip"\n', **columns):
        """Runs of 60 s whose run-up in m is the time in s, H = 2 m."""
        names = [f"fr{froude:g}" for froude in froude_numbers]
        pd.DataFrame({"name": names, "status": "done", "froude_number": froude_numbers, "effective_friction": 1.2, "flow_height_m": 2.0,
                      "conveyor_width_m": 21.0, "steady": 1, **columns}).to_csv(self.path, index=False)
        for name in names:
            run = self.path.parent / "runs" / name
            run.mkdir(parents=True)
            (run / "case.toml").write_text(f"[conveyor]\n{conveyor}[output]\nduration_s = 60.0\n", encoding="utf-8")
            time = np.arange(0.0, 60.01, 0.5)
            pd.DataFrame({"time_s": time, "runup_m": time, "pressure_height_m": 4.0, "force_x_n": 7.0}).to_csv(run / "series.csv", index=False)

    def test_over_the_last_third(self):
        self.campaign([0.1, 1.0], 'feed = "window"\nupstream_length_m = 8.4\ndownstream_length_m = 4.2\nsidewall_contact = "slip"\n')
        found = window_means(self.path)
        self.assertEqual(found.feed.tolist(), ["window, 8.4 m + 4.2 m"] * 2)
        self.assertEqual(found.sidewall_contact.tolist(), ["slip"] * 2)
        np.testing.assert_allclose(found[["from_s", "to_s", "runup", "pressure_height", "force_n"]], [[40.0, 60.0, 25.0, 2.0, 7.0]] * 2)

    def test_while_the_strip_lasts(self):
        self.campaign([1.0 + 1e-9, 0.3, 7.0])
        found = window_means(self.path, STRIP_LASTS)
        self.assertEqual(found.feed.tolist(), ["strip, 60 s"] * 2)  # none at Fr 7
        np.testing.assert_allclose(found[["from_s", "to_s", "runup"]], [[10.0, 22.0, 8.0], [16.0, 32.0, 12.0]])
        self.assertTrue((found.runup_standard_error > 0.0).all())

    def test_where_the_run_up_is_highest(self):
        self.campaign([0.1])
        series = self.path.parent / "runs" / "fr0.1" / "series.csv"
        time = np.arange(0.0, 60.01, 0.5)
        hill = np.where((time >= 20.0) & (time <= 30.0), 6.0, 2.0) + np.where(time == 50.0, 20.0, 0.0)  # a splash is higher, but short
        pd.DataFrame({"time_s": time, "runup_m": hill, "pressure_height_m": 4.0, "force_x_n": time}).to_csv(series, index=False)
        found = highest_means(self.path).iloc[0]
        self.assertEqual((found.from_s, found.to_s, found.runup, found.force_n), (20.0, 30.0, 3.0, 25.0))
        self.assertTrue(highest_means(self.path, 100.0).empty)  # the run is shorter

    def test_runs_without_a_folder_and_runs_that_are_not_done_are_left_out(self):
        self.campaign([0.1, 0.3, 1.0], status=["done", "failed", "done"])
        (self.path.parent / "runs" / "fr1" / "series.csv").unlink()
        self.assertEqual(window_means(self.path).froude_number.tolist(), [0.1])


if __name__ == "__main__":
    unittest.main()
