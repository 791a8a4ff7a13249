"""The same set-ups on two grids."""

import unittest

import numpy as np
import pandas as pd

from analysis.refinement import FINEST_ALONE, HEIGHTS, WITH_COARSER, coefficients_with_coarser, refined_kinds, refined_rows, refinement_tables
from study_samples import grid_of_runs


class Refinement(unittest.TestCase):
    def test_refined_rows_are_the_set_ups_on_two_grids(self):
        runs = grid_of_runs((5.0,)).assign(cell_size_m=0.35, force_n=100.0, obstacle_friction=0.2)
        fast = runs[runs.froude_number > 2.5]
        table = refined_rows(pd.concat([fast.assign(cell_size_m=0.25, force_n=110.0, runup=1.2 * fast.runup), runs], ignore_index=True))
        self.assertEqual(len(table), len(fast))
        np.testing.assert_allclose(table[["runup_ratio", "pressure_height_ratio", "force_n_ratio"]].to_numpy(), [[1.2, 1.0, 1.1]] * len(fast))
        self.assertEqual((table.cell_size_m_fine.unique().tolist(), table.cell_size_m_coarse.unique().tolist()), ([0.25], [0.35]))
        summary = refinement_tables(pd.concat([fast.assign(cell_size_m=0.25), runs]))["refined_summary"]
        self.assertEqual(summary[summary.group == "all"].pairs.tolist(), [len(fast)] * 3)
        other_friction = fast.assign(cell_size_m=0.25, force_n=110.0, obstacle_friction=np.where(fast.froude_number > 6.0, 0.3, 0.2))
        table = refined_rows(pd.concat([other_friction, runs], ignore_index=True))
        self.assertEqual(sorted(table.froude_number.unique()), [3.0, 5.0])  # Fr 7 has another friction on each grid
        longer = fast.assign(cell_size_m=0.25, force_n=110.0, planned_duration_s=np.where(fast.froude_number > 6.0, 30.0, 10.0))
        table = refined_rows(pd.concat([longer, runs.assign(planned_duration_s=10.0)], ignore_index=True))
        self.assertEqual(sorted(table.froude_number.unique()), [3.0, 5.0])  # nor a run of another duration

    def test_coefficients_of_both_grids_rest_on_the_set_ups_that_both_have(self):
        runs = grid_of_runs((5.0,)).assign(cell_size_m=0.25, force_n=1.0, obstacle_friction=0.2)
        coarse = runs.assign(cell_size_m=0.35, runup=0.8 * runs.runup)
        alone = runs[runs.froude_number < 0.99].assign(cell_size_m=0.35, froude_number=0.5, runup=9.0)  # on one grid: must not count
        table = refinement_tables(pd.concat([coarse, runs, alone], ignore_index=True))["refined_coefficients"].set_index(["fitting_set", "grid"])
        self.assertEqual(table.runs.tolist(), [len(runs)] * 4)
        self.assertAlmostEqual(table.k_r["narrow", "fine"], 0.9473, delta=1e-3)
        self.assertAlmostEqual(table.runup_rmsle["narrow", "fine"], 0.0, delta=1e-9)
        self.assertAlmostEqual(table.runup_rmsle["narrow", "coarse"], -np.log(0.8), delta=1e-9)
        self.assertAlmostEqual(table.k_p["narrow", "coarse"], table.k_p["narrow", "fine"], 9)
        fast = pd.concat([coarse, runs[runs.froude_number > 1.9]], ignore_index=True)  # beyond the saturation of the pressure height
        table = refinement_tables(fast)["refined_coefficients"]
        self.assertTrue(table[["k_p", "Fr_sat", "kappa_p"]].isna().all().all())
        self.assertTrue(table[["k_r", "kappa_r", "pressure_height_nrmse"]].notna().all().all())

    def test_coarser_runs_stand_in_where_the_finest_grid_has_no_steady_mean(self):
        runs = grid_of_runs((5.0,)).assign(cell_size_m=0.25)
        lost = (runs.froude_number > 6.0) & (runs.effective_friction > 1.0)
        coarser = runs.assign(cell_size_m=0.35, runup=0.5 * runs.runup)
        table = coefficients_with_coarser(runs[~lost], coarser).set_index(["rows", "fitting_set"])
        self.assertGreater(lost.sum(), 0)
        self.assertEqual(table.runs[FINEST_ALONE].tolist(), [(~lost).sum()] * 2)
        self.assertEqual(table.runs[WITH_COARSER].tolist(), [len(runs)] * 2)
        self.assertAlmostEqual(table.runup_rmsle[FINEST_ALONE, "narrow"], 0.0, delta=1e-9)
        self.assertAlmostEqual(table.runup_rmsle[WITH_COARSER, "narrow"], np.log(2.0) * np.sqrt(lost.mean()), delta=1e-9)

    def test_kinds_of_snow_count_their_sets_and_pairs_and_what_the_coarse_runs_said(self):
        runs = grid_of_runs((5.0, 0.5)).assign(cell_size_m=0.35, force_n=100.0, obstacle_friction=0.2, runup_standard_error=0.0)
        coarse = runs.assign(runup_numerical_uncertainty=0.1 * runs.runup)
        stiff = runs.effective_friction > 1.5
        fine = runs.assign(cell_size_m=0.25, runup=np.where(stiff, 1.2, 1.05) * runs.runup)[runs.froude_number > 0.99]
        both = pd.concat([fine, coarse], ignore_index=True)
        table = refined_kinds(both, refined_rows(both)).set_index(["kind", "quantity"])
        self.assertEqual(set(table.speeds), {"from Fr 1 on"})  # no slow pair
        sticky = (runs.hardening_xi < 0.6) & (runs.cohesion_beta > 0.0) & (runs.critical_state_slope > 0.0) & ~stiff
        fluid = runs.critical_state_slope == 0.0
        for kind, holds, ratio in (("stiff snow, M' > 1.5", stiff, 1.2), ("fluid", fluid, 1.05), ("cohesive snow of xi <= 0.5", sticky, 1.05),
                                   ("other snow", ~(stiff | fluid | sticky), 1.05)):
            row = table.loc[kind, "run-up"]
            number = (holds & (runs.froude_number > 0.99)).sum()
            self.assertGreater(number, 0)
            self.assertEqual((row.sets, row.fine, row.pairs), (number,) * 3)
            np.testing.assert_allclose([row.ratio, row.lowest, row.highest], ratio)
            self.assertEqual(row.covered, 0 if ratio > 1.1 else number)
            self.assertTrue(np.isnan(table.loc[kind, "force"].covered))

    def test_two_standard_errors_count_as_covered_and_nothing_stated_is_not_judged(self):
        for height in HEIGHTS:
            runs = grid_of_runs((5.0,)).assign(**{"cell_size_m": 0.35, "force_n": 100.0, "obstacle_friction": 0.2, f"{height}_standard_error": 0.05})
            fine = runs.assign(**{"cell_size_m": 0.25, height: runs[height] + 0.2})
            for stated, expected in ((0.05, 0.0), (0.06, 1.0), (np.nan, np.nan)):  # 2 sqrt(2) 0.05 = 0.141
                rows = refined_rows(pd.concat([fine, runs.assign(**{f"{height}_numerical_uncertainty": stated})], ignore_index=True))
                np.testing.assert_array_equal(rows[f"{height}_covered"], expected)


if __name__ == "__main__":
    unittest.main()
