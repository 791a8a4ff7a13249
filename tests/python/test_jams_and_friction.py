"""The rule for jammed runs, and the comparison and calibration of the mast's friction."""

import unittest

import numpy as np
import pandas as pd

from mpmtools import equations
from mpmtools.errors import InputError
from mpmtools.study.friction_choice import (computed_heights, friction_calibration, friction_rules, half_friction, interpolation_errors,
                                            on_common_points, rules_of, scan_tables, splits, with_friction)
from mpmtools.study.jams import LIMITS, jam_coefficients, jam_indices, without_jams
from mpmtools.study.regression import RUNUP
from study_samples import InFolder, grid_of_runs, study_run, study_runs

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


class Friction(InFolder):
    def setUp(self):
        """Run-ups that meet the published equation with a friction of min(0.3, half), and fall by exp(-2 mu)."""
        super().setUp()
        self.right = grid_of_runs((5.0,))
        self.half = half_friction(self.right.effective_friction)
        self.computed = computed_heights(self.campaign(0.15), self.campaign(self.half))
        self.points = with_friction(self.computed, lambda half: half)

    def campaign(self, friction):
        return self.right.assign(obstacle_friction=friction,
                                 runup=self.right.runup * np.exp(-2.0 * (friction - np.minimum(0.3, self.half))))

    def test_half_is_that_of_the_program(self):
        """M = 1.2, beta = 0.3: obstacle_friction of the committed sensitivities."""
        self.assertAlmostEqual(float(half_friction(equations.effective_friction(1.2, 0.3))), 0.464936, delta=1e-6)

    def test_points_with_one_friction_are_left_out(self):
        computed = computed_heights(self.campaign(0.15), self.campaign(self.half).iloc[5:])
        self.assertEqual(len(computed), 2 * (len(self.right) - 5))

    def test_rules_are_the_campaigns_at_their_ends(self):
        smaller, constant, ratio = (on_common_points(self.computed, rules_of(0.15))[name].runup
                                    for name in ("the smaller of 0.15 and the half", "0.15", "half of tan phi'"))
        weak = half_friction(self.points.effective_friction) <= 0.15
        np.testing.assert_allclose(constant, self.campaign(0.15).runup, rtol=1e-12)
        np.testing.assert_allclose(ratio, self.campaign(self.half).runup, rtol=1e-12)
        np.testing.assert_allclose(smaller, np.where(weak, ratio, constant), rtol=1e-12)

    def test_heights_between_are_interpolated_in_the_logarithm(self):
        # The heights obey exp(-2 mu), so that the interpolation is exact.
        found = with_friction(self.computed, lambda half: min(0.3, half))
        np.testing.assert_allclose(found.runup, self.right.runup, rtol=1e-12)

    def test_nothing_is_extrapolated(self):
        found = with_friction(self.computed, lambda half: 0.1).runup
        beyond = np.minimum(0.15, self.half) > 0.1
        self.assertTrue(0 < beyond.sum() < len(found))
        self.assertEqual(np.isnan(found).tolist(), beyond.tolist())
        with self.assertRaisesRegex(InputError, "no flow and snow was computed with every friction of these rules: 0.9"):
            on_common_points(self.computed, rules_of(0.9))

    def test_calibration_finds_the_rule_behind_the_data_on_either_half(self):
        table = friction_calibration(self.computed)
        self.assertEqual(table.points.tolist(), ["all"] * 4 + ["without the stiffest"] * 4)
        np.testing.assert_allclose(table.c, 0.3)
        np.testing.assert_allclose(table.rmsle_judging, 0.0, atol=1e-12)
        self.assertTrue((table.rmsle_judging_half > 0.01).all())
        kept = (self.points.effective_friction < 2.2).sum()
        self.assertTrue(kept < len(self.points))
        self.assertEqual((table.runs_calibrating + table.runs_judging).tolist(), [len(self.points)] * 4 + [kept] * 4)

    def test_halves_share_no_material_and_no_froude_number(self):
        points = self.points
        for (name, first), column in zip(splits(points).items(), ("effective_friction", "froude_number")):
            self.assertFalse(set(points[column][first]) & set(points[column][~first]), name)

    def test_rules_are_fitted_on_the_same_rows(self):
        table = friction_rules(self.computed, rules_of(0.15))
        self.assertEqual(table.runs.tolist(), [112, 105] * 3)
        k = table[table.points == "all"].set_index("rule").k_r
        self.assertGreater(k["0.15"], RUNUP.published.k)  # too little friction for stiff snow
        self.assertLess(k["half of tan phi'"], RUNUP.published.k)

    def test_interpolation_is_compared_with_runs_of_friction_alone(self):
        point = self.points[(half_friction(self.points.effective_friction) > 0.4) & (self.points.froude_number == 3.0)].iloc[0]
        computed = 1.75 * float(point.runup * np.exp(-2.0 * (0.2 - half_friction(point.effective_friction)))) / 1.1
        header = "name,froude_number,critical_state_slope,cohesion_beta,hardening_xi,obstacle_friction,flow_height_m,runup_mean_m,cell_size_m\n"
        row = f"3,{point.critical_state_slope},{point.cohesion_beta},5,0.2,1.75,{computed},0.35\n"
        path = self.write("results.csv", header + "fr3_mu0.2," + row + "fr3_cfl0.2," + row)
        table = interpolation_errors(self.computed, path)
        self.assertEqual(len(table), 1)
        self.assertAlmostEqual(table.ratio[0], 1.1, delta=1e-9)


class Scan(InFolder):
    HEADER = ("name,status,froude_number,critical_state_slope,cohesion_beta,hardening_xi,effective_friction,flow_height_m,obstacle_friction,"
              "runup_mean_m,pressure_height_mean_m\n")

    def scan(self, name, right, frictions, xi=5):
        """The path of a table of runs whose run-ups meet the published equation with the friction `right(half)`, and fall by exp(-2 mu) from there."""
        runs = grid_of_runs((5.0,))
        self.runs = runs = runs[runs.effective_friction < 1.5]
        half = half_friction(runs.effective_friction)
        rows = []
        for friction in (*frictions, half):
            fall = np.exp(-2.0 * (friction - right(half)))
            rows += [f"x,done,{r.froude_number},{r.critical_state_slope},{r.cohesion_beta},{xi},{r.effective_friction},1.75,{mu},{1.75 * r.runup * f},"
                     f"{1.75 * r.pressure_height}" for r, mu, f in zip(runs.itertuples(), friction + 0.0 * runs.runup, fall + 0.0 * runs.runup)]
        return self.write(name, self.HEADER + "\n".join(rows) + "\n")

    def test_of_frictions_finds_the_one_coefficient_behind_the_data(self):
        tables = scan_tables([self.scan("results.csv", lambda half: 0.15, (0.0, 0.15, 0.3))])
        rules = tables["friction_scan_rules"].set_index("rule")
        self.assertEqual(list(rules.index[:6]), ["0", "0.15", "0.3", "half of tan phi'", "the smaller of 0.15 and the half",
                                                 "the smaller of 0.3 and the half"])
        limit, one_for_all, share = rules.index[6:]
        self.assertEqual(one_for_all, "best: 0.15 for all snow")
        self.assertAlmostEqual(rules.runup_rmsle[one_for_all], 0.0, delta=1e-9)
        self.assertRegex(limit, r"^best: the smaller of 0\.\d+ and the half$")
        self.assertRegex(share, r"^best: 0\.\d+ times tan phi'$")
        self.assertAlmostEqual(rules.k_r["0.15"], RUNUP.published.k, delta=1e-6)
        self.assertTrue((rules.runs == len(self.runs)).all())
        calibrated = tables["friction_scan_calibration"].groupby("rule").c
        np.testing.assert_allclose(calibrated.get_group("c for all snow"), 0.15)
        self.assertEqual(len(calibrated.get_group("the smaller of c and the half")), 4)
        scan = tables["friction_scan"]
        weak = scan[np.isclose(scan.obstacle_friction, 0.3)]
        np.testing.assert_allclose(weak.runup_over_half, np.exp(-2.0 * (0.3 - weak.half)), rtol=1e-9)
        np.testing.assert_allclose(scan.pressure_height_over_half, 1.0, rtol=1e-9)

    def test_of_two_tables_finds_the_share_behind_the_data_and_splits_by_xi(self):
        share = lambda half: 0.35 / 0.5 * half
        files = [self.scan(f"xi{xi}.csv", share, frictions, xi) for xi, frictions in ((5, (0.0, 0.15, 0.3)), (0.5, (0.0, 0.2, 0.3)))]
        table = scan_tables(files)["friction_scan_calibration"]
        found = table[table.rule == "c times tan phi'"]
        self.assertEqual(list(found.split.unique()), ["every other M'", "Fr 0.1 and 1 and 3 and 7, Fr 0.3 and 2 and 5", "xi 0.5, xi 5"])
        np.testing.assert_allclose(found.c, 0.35)
        np.testing.assert_allclose(found.rmsle_judging, 0.0, atol=1e-9)
        np.testing.assert_allclose(table.constant, 0.3)  # the one above 0 that both tables have
        self.assertEqual(list(table.points.unique()), ["all"])  # each point lacks one friction of the other table, as if it were not steady
        self.assertTrue((table.runs_calibrating + table.runs_judging == 2 * len(self.runs)).all())

    def test_points_with_every_friction_are_judged_for_themselves_too(self):
        right = lambda half: np.minimum(0.15, half)
        whole, some = self.scan("xi5.csv", right, (0.0, 0.1, 0.15, 0.2, 0.3)), self.scan("xi0.5.csv", right, (0.2, 0.3), 0.5)
        tables = scan_tables([whole, some])
        rules = tables["friction_scan_rules"]
        self.assertEqual(rules.points.tolist(), ["every friction"] * 13 + ["all"] * 8)
        self.assertEqual(rules.runs.tolist(), [len(self.runs)] * 13 + [2 * len(self.runs)] * 8)
        self.assertEqual(rules.rule[:6].tolist(), ["0", "0.1", "0.15", "0.2", "0.3", "half of tan phi'"])
        self.assertEqual(rules.rule[[10, 13, 14]].tolist(), ["best: the smaller of 0.15 and the half", "0.2", "0.3"])
        calibrated = tables["friction_scan_calibration"]
        found = calibrated[(calibrated.points == "every friction") & (calibrated.rule == "the smaller of c and the half")]
        np.testing.assert_allclose(found.c, 0.15)
        self.assertTrue((calibrated.constant[calibrated.points == "all"] == 0.2).all())

    def test_of_two_runs_with_one_friction_the_first_counts(self):
        first = self.scan("first.csv", lambda half: 0.15, (0.0, 0.15, 0.3))
        again = self.scan("again.csv", lambda half: 0.3, (0.15,))
        of_first, of_both = scan_tables([first]), scan_tables([first, again])
        for name, table in of_first.items():
            self.assertTrue(table.equals(of_both[name]), name)

    def test_without_a_friction_at_most_points_is_refused(self):
        with self.assertRaisesRegex(InputError, "no friction above 0 was computed at nine in ten of the points"):
            scan_tables([self.scan("results.csv", lambda half: 0.15, (0.0,))])

    def test_of_one_friction_is_refused(self):
        path = self.write("results.csv", "name,status,froude_number,critical_state_slope,cohesion_beta,hardening_xi,flow_height_m,obstacle_friction,"
                          "runup_mean_m,pressure_height_mean_m\na,done,3,0.4,0,5,1.75,0.15,7,3\nb,done,5,0.4,0,5,1.75,0.15,14,3\n")
        with self.assertRaisesRegex(InputError, "no flow and snow was computed with two frictions of the mast"):
            scan_tables([path])


if __name__ == "__main__":
    unittest.main()
