"""Three grids: the rules of `mpm converge`, on values with a known order, and a table of points."""

import pathlib
import tempfile
import unittest

import numpy as np
import pandas as pd

from mpmtools.errors import InputError
from analysis.grids import QUANTITIES, coefficients_without_unconverged, grid_summary, grid_table, late_means, limit_of
from study_samples import grid_of_runs

SIZES = (0.35, 0.25, 0.175)


class LimitOfThreeGrids(unittest.TestCase):
    def test_finds_the_order_that_made_the_values(self):
        for order in (0.6, 1.0, 1.4):
            values = [2.0 + 3.0 * h**order for h in SIZES]
            found = limit_of(SIZES, values)
            self.assertAlmostEqual(found.order, order, 9)
            self.assertAlmostEqual(found.uncertainty, 1.25 * 3.0 * SIZES[2] ** order, 9)  # 1.25 times the distance to the limit

    def test_agrees_with_mpm_converge(self):
        """The example of docs/grid-studies.md: order 1.50, uncertainty 0.86975."""
        found = limit_of((1.75 / 3, 1.75 / 5, 1.75 / 7), (5.5759, 6.8974, 7.3528))
        self.assertAlmostEqual(found.order, 1.50, 2)
        self.assertAlmostEqual(found.uncertainty, 0.86975, 3)

    def test_of_a_high_order_is_no_smaller_than_the_range(self):
        values = [2.0 + 3.0 * h**4 for h in SIZES]
        found = limit_of(SIZES, values)
        self.assertAlmostEqual(found.order, 4.0, 6)
        self.assertGreaterEqual(found.uncertainty, 1.25 * (max(values) - min(values)))

    def test_without_an_order_is_three_times_the_range(self):
        for values in ((1.0, 1.1, 1.05), (1.0, 1.1, 1.3), (1.0, 1.0, 1.0), (1.0, 1.1, 1.1)):
            found = limit_of(SIZES, values)
            self.assertTrue(np.isnan(found.order), values)
            self.assertAlmostEqual(found.uncertainty, 3.0 * (max(values) - min(values)), 12)


def runs(points, stated=0.1, error=0.01):
    """Runs on three grids; each height and force is its limit times 1 + slope times the cell size."""
    rows = []
    for froude, slope in points:
        for size in SIZES:
            row = {"name": f"fr{froude}_dx{size}", "status": "done", "froude_number": froude, "critical_state_slope": 0.4, "cohesion_beta": 0.0,
                   "hardening_xi": 5.0, "cell_size_m": size}
            for mean, standard_error, uncertainty in QUANTITIES.values():
                value = 4.0 * (1.0 + slope * size)
                row.update({mean: value, standard_error: error * value, uncertainty: stated * value})
            rows.append(row)
    return pd.DataFrame(rows)


class Grids(unittest.TestCase):
    def table(self, frame):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = pathlib.Path(folder.name) / "results.csv"
        frame.to_csv(path, index=False)
        return grid_table(path)

    def test_compare_each_point_with_its_finest_grid(self):
        found = self.table(runs([(3, 0.2), (1, -0.2)]))
        self.assertEqual(len(found), 6)
        first = found.iloc[0]
        self.assertAlmostEqual(first.coarse_over_fine, (1 + 0.2 * 0.35) / (1 + 0.2 * 0.175), 12)
        self.assertAlmostEqual(first.middle_over_fine, (1 + 0.2 * 0.25) / (1 + 0.2 * 0.175), 12)
        self.assertAlmostEqual(first.ratio_standard_error, first.coarse_over_fine * 0.01 * np.sqrt(2.0), 12)  # both means are known to 1 %
        self.assertAlmostEqual(first.order, 1.0, 6)
        self.assertAlmostEqual(first.fine_uncertainty, 1.25 * 0.2 * 0.175 / (1 + 0.2 * 0.175), 9)
        summary = grid_summary(found).set_index("quantity").loc["run-up"]
        self.assertEqual((summary.points, summary.covered, summary.with_order), (2, 2, 2))
        self.assertLess(summary.coarse_lowest, 1.0)
        self.assertGreater(summary.coarse_highest, 1.0)

    def test_tell_where_the_stated_uncertainty_is_too_small(self):
        self.assertEqual(self.table(runs([(3, 2.0)], stated=0.1)).covered.tolist(), [0, 0, 0])
        self.assertEqual(self.table(runs([(3, 2.0)], stated=0.3)).covered.tolist(), [1, 1, 1])
        self.assertEqual(self.table(runs([(3, 2.0)], stated=0.1, error=0.1)).covered.tolist(), [1, 1, 1])  # within the statistics

    def test_leave_out_points_without_three_steady_runs(self):
        frame = runs([(3, 0.2), (1, 0.2), (5, 0.2)])
        frame.loc[1, "status"] = "to do"
        frame.loc[4, "runup_mean_m"] = np.nan
        found = self.table(frame)
        self.assertEqual(found.groupby("froude_number").quantity.count().to_dict(), {1.0: 2, 5.0: 3})
        self.assertTrue(self.table(frame.iloc[:2]).empty)

    def test_late_means_are_those_of_the_last_third_of_every_run_with_a_folder(self):
        folder = tempfile.TemporaryDirectory()
        self.addCleanup(folder.cleanup)
        path = pathlib.Path(folder.name) / "results.csv"
        runs([(3, 0.2)]).assign(flow_height_m=2.0).to_csv(path, index=False)
        run = path.parent / "runs" / "fr3_dx0.25"
        run.mkdir(parents=True)
        time = np.arange(0.0, 9.05, 0.1)
        pd.DataFrame({"time_s": time, "runup_m": time, "pressure_height_m": 4.0, "force_x_n": 7.0}).to_csv(run / "series.csv", index=False)
        found = late_means(path)
        self.assertEqual(found.cell_size_m.tolist(), [0.25])
        self.assertAlmostEqual(found.runup[0], 7.5 / 2.0, 9)  # mean of 6 to 9, over H
        self.assertEqual((found.pressure_height[0], found.force_n[0]), (2.0, 7.0))

    def test_coefficients_return_to_the_equation_without_the_snow_that_is_not_converged(self):
        runs = grid_of_runs((0.5, 1.5, 5.0))
        fluid = runs.critical_state_slope == 0.0
        sticky = (runs.hardening_xi == 0.5) & (runs.cohesion_beta > 0.0) & ~fluid
        stiff = runs.effective_friction > 1.5
        runs.loc[sticky | fluid | stiff, ["runup", "pressure_height"]] *= 0.8
        table = coefficients_without_unconverged(runs)
        narrow = table[table.fitting_set == "narrow"]
        self.assertEqual(narrow.without.tolist(), ["", "fluid", "stiff snow, M' > 1.5", "cohesive snow of xi <= 0.5",
                                                   "all that is not converged at w/5", "snow of M' > 2.2 below Fr 1", "the sets that we chose (xi = 1.5 and 0.15)"])
        slow_stiff = (runs.effective_friction > 2.2) & (runs.froude_number < 0.99)
        chosen = runs.hardening_xi.isin([1.5, 0.15])
        self.assertGreater(min(slow_stiff.sum(), chosen.sum()), 0)
        self.assertGreater((sticky & stiff).sum(), 0)  # a run of two kinds is left out once
        all_three = (sticky | fluid | stiff).sum()
        self.assertEqual(narrow.left_out.tolist(), [0, fluid.sum(), stiff.sum(), sticky.sum(), all_three, slow_stiff.sum(), chosen.sum()])
        self.assertAlmostEqual(narrow.k_p.iloc[4], 0.5277, delta=1e-4)
        self.assertAlmostEqual(narrow.runup_rmsle.iloc[4], 0.0, delta=1e-9)
        self.assertTrue((narrow.runup_rmsle.iloc[:4] > 0.05).all())

    def test_need_their_columns(self):
        with self.assertRaisesRegex(InputError, "runup_standard_error_m"):
            self.table(runs([(3, 0.2)]).drop(columns="runup_standard_error_m"))


if __name__ == "__main__":
    unittest.main()
