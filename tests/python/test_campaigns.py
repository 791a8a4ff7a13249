"""Reproduction and prediction side by side, on made-up runs whose ratios are known."""

import unittest

import numpy as np
import pandas as pd

from mpmtools import equations
from analysis.campaigns import campaign_scores, paired_rows, paired_summary, side_by_side
from mpmtools.fit.regression import EQUATIONS
from study_samples import grid_of_runs, study_run, study_runs


def with_measurements(runs):
    return runs.assign(force_n=1e5, obstacle_friction=0.2, runup_numerical_uncertainty=0.1, pressure_height_numerical_uncertainty=0.05)


def intervals():
    """In place of coefficient_intervals of the reproduction, which side_by_side hands on: the published coefficients."""
    return pd.DataFrame([{"fitting_set": name, "parameter": parameter, "value": value} for name in ("narrow", "wide") for equation in EQUATIONS
                         for parameter, (value, *_) in equation.published_estimates.items()])


def reproduction():
    return with_measurements(grid_of_runs())


class PairedRows(unittest.TestCase):
    def test_hold_the_set_ups_of_both_and_their_ratios(self):
        theirs = reproduction()
        ours = theirs[(theirs.hardening_xi == 5.0) & (theirs.froude_number == 3.0)]
        ours = ours.assign(runup=1.1 * ours.runup, force_n=8e4)
        ours = pd.concat([ours, with_measurements(study_runs(study_run(3.0, 0.9, 0.0, 5.0)))])  # which the other does not have
        rows = paired_rows(theirs, ours)
        self.assertEqual(len(rows), 16)
        np.testing.assert_allclose(rows.runup_ratio, 1.1)
        np.testing.assert_allclose(rows.pressure_height_ratio, 1.0)
        np.testing.assert_allclose(rows.force_n_ratio, 0.8)
        np.testing.assert_allclose(rows.runup_numerical_uncertainty, 0.1)

    def test_leave_out_masts_of_another_width(self):
        wide = with_measurements(study_runs(study_run(3.0, 0.4, 0.0, 5.0, obstacle_width_m=3.5)))
        self.assertEqual(len(paired_rows(reproduction(), wide)), 0)

    def test_leave_out_runs_whose_masts_differ_in_friction(self):
        theirs = reproduction()
        ours = theirs.assign(obstacle_friction=np.where(theirs.hardening_xi == 5.0, 0.2 + 1e-9, 0.3))
        rows = paired_rows(theirs, ours)
        self.assertEqual(len(rows), (theirs.hardening_xi == 5.0).sum())
        self.assertEqual(set(rows.hardening_xi), {5.0})
        self.assertNotIn("obstacle_friction", rows)
        self.assertEqual(len(paired_rows(theirs, ours.assign(obstacle_friction=np.nan))), len(theirs))  # a table that does not name it

    def test_are_summed_up_by_geometric_mean_and_spread(self):
        theirs = reproduction()
        ours = theirs[(theirs.hardening_xi == 5.0) & (theirs.froude_number >= 5.0) & (theirs.cohesion_beta == 0.0)].copy()
        ours["runup"] *= np.where(ours.froude_number == 5.0, 1.25, 0.8)
        table = paired_summary(paired_rows(theirs, ours)).set_index(["group", "quantity"])
        of_all = table.loc[("all", "run-up")]
        self.assertEqual(of_all.pairs, 8)
        self.assertAlmostEqual(of_all.ratio, 1.0, delta=1e-12)
        self.assertAlmostEqual(of_all.spread, np.log(1.25) * np.sqrt(8 / 7), delta=1e-12)
        self.assertAlmostEqual(table.loc[("Fr 7", "run-up")].ratio, 0.8, delta=1e-12)
        self.assertAlmostEqual(table.loc[("Fr 7", "run-up")].highest, 0.8, delta=1e-12)

    def test_without_a_common_set_up_are_empty_and_so_is_their_summary(self):
        ours = with_measurements(study_runs(study_run(3.0, 0.9, 0.0, 5.0)))
        self.assertEqual(len(paired_summary(paired_rows(reproduction(), ours))), 0)


class SideBySide(unittest.TestCase):
    def test_fits_both_campaigns_on_the_sets_that_both_have(self):
        theirs = reproduction()
        other = equations.HeightCoefficients(1.2, 1.4, np.inf)
        ours = theirs[(theirs.hardening_xi == 5.0) & (theirs.froude_number != 7.0)].copy()
        ours["runup"] = equations.relative_height(ours.effective_friction, ours.froude_number, other)
        self.assertEqual(len(ours), 96)
        table = side_by_side(theirs, ours, intervals()).set_index(["campaign", "fitting_set", "parameter"])
        for campaign, k, rows in (("reproduction", 0.9468, 224), ("reproduction, paired", 0.9468, 96), ("prediction, paired", 1.2, 96),
                                  ("prediction", 1.2, 96)):
            for fitting_set in ("narrow", "wide"):
                found = table.loc[(campaign, fitting_set, "k_r")]
                self.assertAlmostEqual(found.value, k, delta=1e-6)  # heights obey the equation exactly
                self.assertEqual(found.rows, rows)
                self.assertAlmostEqual(found.published, 0.9468, delta=1e-12)

    def test_scores_the_published_equations_on_each_campaign(self):
        theirs = reproduction()
        ours = theirs[theirs.hardening_xi == 5.0].copy()
        ours["runup"] *= 1.1
        scores = campaign_scores(theirs, ours).set_index(["campaign", "fitting_set", "equation"])
        self.assertEqual(len(scores), 16)  # four parts, two sets, two equations
        for campaign, runs, rmsle in (("reproduction", 224, 0.0), ("reproduction, paired", 112, 0.0), ("prediction, paired", 112, np.log(1.1)),
                                      ("prediction", 112, np.log(1.1))):
            found = scores.loc[(campaign, "narrow", "runup")]
            self.assertEqual(found.runs, runs)
            self.assertAlmostEqual(found.rmsle, rmsle, delta=1e-12)

    def test_gives_no_coefficients_of_one_froude_number(self):
        theirs = reproduction()
        ours = theirs[theirs.froude_number == 3.0]
        table = side_by_side(theirs, ours, intervals())
        self.assertTrue(table[table.campaign != "reproduction"].value.isna().all())
        self.assertTrue(np.isfinite(table[table.campaign == "reproduction"].value).all())
        self.assertEqual(table[table.campaign == "prediction"].rows.unique().tolist(), [32])


if __name__ == "__main__":
    unittest.main()
