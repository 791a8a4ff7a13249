"""The rule for jammed runs."""

import unittest

import numpy as np
import pandas as pd

from analysis.jams import LIMITS, jam_coefficients, jam_indices, without_jams
from study_samples import grid_of_runs, study_run, study_runs

HYDROSTATIC = 0.5 * 300.0 * 9.81 * 1.75**3  # N, on a mast of 1.75 m in 1.75 m of snow


def with_force(runs, static):
    """Runs whose static force is as given, in hydrostatic forces."""
    momentum = 300.0 * runs.velocity_m_s**2 * 1.75**2
    return runs.assign(force_n=momentum + static * HYDROSTATIC, density_kg_m3=300.0)


class Jams(unittest.TestCase):
    def snow(self, *static, froude=(1.0, 3.0, 5.0, 7.0), slope=1.2, beta=0.45):
        return with_force(study_runs(*(study_run(f, slope, beta, 5.0) for f in froude)), np.array(static))

    def test_static_force_is_what_the_momentum_leaves(self):
        table = jam_indices(self.snow(80.0, 58.0, 40.0, 50.0))
        np.testing.assert_allclose(table.static_force, [80.0, 58.0, 40.0, 50.0], rtol=1e-12)
        np.testing.assert_allclose(table.fast_static_force, 40.0)  # the least of Fr 5 and 7
        np.testing.assert_allclose(table.jam_index[:2], [2.0, 1.45], rtol=1e-12)
        self.assertEqual(table.jammed.tolist(), [1, 0, 0, 0])
        self.assertEqual(table.force_depends_on_window.tolist(), [1, 1, 0, 0])

    def test_fast_runs_are_no_jams(self):
        self.assertEqual(jam_indices(self.snow(40.0, 40.0, 40.0, 400.0)).jammed.sum(), 0)

    def test_weak_snow_is_not_judged_by_a_quotient_of_small_forces(self):
        self.assertEqual(jam_indices(self.snow(12.0, 9.0, 2.0, -5.0)).jammed.sum(), 0)

    def test_without_a_fast_run_nothing_is_left_out(self):
        table = jam_indices(self.snow(300.0, 200.0, froude=(1.0, 3.0)))
        self.assertTrue(table.jam_index.isna().all())
        self.assertEqual(table.jammed.sum(), 0)

    def test_each_snow_has_a_reference_of_its_own(self):
        runs = pd.concat([self.snow(300.0, 150.0, 140.0, 150.0), self.snow(60.0, 50.0, 50.0, 50.0, slope=0.8)], ignore_index=True)
        self.assertEqual(jam_indices(runs).jammed.tolist(), [1, 0, 0, 0, 0, 0, 0, 0])
        self.assertEqual(without_jams(runs).index.tolist(), [1, 2, 3, 4, 5, 6, 7])

    def test_coefficients_return_to_the_equation_without_them(self):
        runs = grid_of_runs()
        stiff = (runs.effective_friction > 2.2) & (runs.froude_number == 1.0)
        runs = with_force(runs, np.where(stiff, 200.0, 60.0))
        runs.loc[stiff, ["runup", "pressure_height"]] *= 1.5
        table = jam_coefficients(runs)
        self.assertEqual(len(table), 2 * len(LIMITS))
        rule, all_runs = (table[table.limit == limit].iloc[0] for limit in (1.5, np.inf))
        self.assertEqual((rule.left_out, all_runs.left_out), (2, 0))
        self.assertAlmostEqual(rule.k_p, 0.5277, delta=1e-6)
        self.assertGreater(all_runs.k_p, 0.54)


if __name__ == "__main__":
    unittest.main()
