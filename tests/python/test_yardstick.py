"""The distance of a rule of mast friction to the paper: zero for data that have the paper's scatter, and larger where a sentence fails."""

import unittest

import numpy as np
import pandas as pd
from analysis import yardstick
from study_samples import paper_grid, study_run


def runs_with_errors(runup_error, pressure_error, xis=(5.0, 0.5), rule=lambda friction: 0.2):
    """The paper's sets with heights off the published equations: error of the logarithm, alternating in sign over the sets, by run."""
    rows, rng = [], np.random.default_rng(4)
    for xi in xis:
        for flow in paper_grid().itertuples():
            run = study_run(flow.froude_number, flow.critical_state_slope, flow.cohesion_beta, xi,
                            obstacle_friction=float(rule(flow.effective_friction)))
            run["runup"] *= np.exp(runup_error(run) * rng.standard_normal())
            run["pressure_height"] *= np.exp(pressure_error(run) * rng.standard_normal())
            rows.append(run)
    return pd.DataFrame(rows)


def as_the_paper(run):
    """Errors in the middle of what Appendix A3 says: larger above M' 1.5, in fast flow and for xi = 0.5."""
    if run["effective_friction"] == 0.0:
        return 0.02
    fast, soft = run["froude_number"] > 2.9, run["hardening_xi"] < 1.0
    return 0.09 * (1.4 if fast else 0.9) * (1.3 if soft else 1.0) * (1.6 if run["effective_friction"] > 1.5 else 0.75)


class Distance(unittest.TestCase):
    def test_is_small_for_the_papers_scatter_and_grows_both_ways(self):
        distance = {factor: yardstick.judge(runs_with_errors(lambda run: factor * as_the_paper(run), lambda run: 0.06 * factor))[0]["distance"]
                    for factor in (0.3, 1.0, 3.0)}
        self.assertLess(distance[1.0], 1.0)
        self.assertGreater(distance[0.3], 2.0 * distance[1.0])  # less scatter than the paper's own is no better agreement
        self.assertGreater(distance[3.0], 4.0 * distance[1.0])

    def test_does_not_look_at_the_coefficients(self):
        runs = runs_with_errors(as_the_paper, lambda run: 0.06)
        higher = runs.assign(runup=1.0 + 1.3 * (runs.runup - 1.0))  # another k_r and kappa_r
        first, second = (yardstick.judge(of)[0] for of in (runs, higher))
        self.assertGreater(second["k_r"], 1.15 * first["k_r"])
        self.assertLess(abs(second["distance"] - first["distance"]), 0.5)

    def test_finds_the_sentence_that_fails(self):
        def upside_down(run):  # stiff snow better than intermediate snow
            return 0.02 if run["effective_friction"] > 1.5 else 0.15

        _, rows = yardstick.judge(runs_with_errors(upside_down, lambda run: 0.06))
        of = rows.set_index("statement").deviation
        self.assertGreater(of["accuracy is best for intermediate effective internal friction"], 2.0)
        self.assertGreater(of["M' = 0.4 to 1.5, where RMSLE remains at or below 10 %"], 1.0)
        self.assertEqual(of["for M' >= 0.4, NRMSE remains below 10 %"], 0.0)

    def test_of_the_fluid_decides_on_agreement_and_not_on_the_distance(self):
        runs = runs_with_errors(as_the_paper, lambda run: 0.06)
        low = runs.assign(runup=runs.runup.where(runs.effective_friction > 0.0, 0.75 * runs.runup))
        (good, _), (bad, _) = yardstick.judge(runs), yardstick.judge(low)
        self.assertEqual(good["distance"], bad["distance"])
        self.assertLess(good["fluid_rmsle"], 0.05)
        self.assertGreater(bad["fluid_rmsle"], 0.2)
        self.assertEqual(bad["agrees"], 0)


class Bands(unittest.TestCase):
    def test_deviation_is_none_inside_and_one_a_unit_outside(self):
        self.assertEqual(yardstick.deviation([0.11, 0.14], (0.10, 0.15), 0.02), 0.0)
        self.assertAlmostEqual(yardstick.deviation([0.17, 0.17], (0.10, 0.15), 0.02), 1.0)
        self.assertAlmostEqual(yardstick.deviation([0.08, 0.17], (0.10, 0.15), 0.02), 1.0)
        self.assertEqual(yardstick.deviation([0.3, 0.12], (0.10, 0.15), 0.02, spared=1), 0.0)  # 'mostly'

    def test_units_of_scores_are_three_standard_errors(self):
        self.assertAlmostEqual(yardstick._score_unit(yardstick.RUNUP, "rmsle"), 0.020, places=3)  # the 2 points of the study's aims
        self.assertAlmostEqual(yardstick._score_unit(yardstick.PRESSURE_HEIGHT, "nrmse"), 0.010, places=3)
        self.assertAlmostEqual(yardstick._score_unit(yardstick.PRESSURE_HEIGHT, "fraction_25"), 3.0 / 189.0)


class RowsOfARule(unittest.TestCase):
    def setUp(self):
        constant = runs_with_errors(as_the_paper, lambda run: 0.06)
        half = runs_with_errors(as_the_paper, lambda run: 0.06, rule=lambda friction: 0.5 * yardstick.tan_friction(friction))
        own = runs_with_errors(as_the_paper, lambda run: 0.06, rule=lambda friction: min(0.2, yardstick.tan_friction(friction)))
        self.constant, self.runs = constant, pd.concat([constant, half, own[own.effective_friction < 0.41]], ignore_index=True)

    def test_are_those_of_its_own_friction(self):
        plain, smaller, half = (yardstick.rows_of(rule, self.runs) for rule in yardstick.rules(0.2))
        self.assertTrue(np.isclose(plain.obstacle_friction, 0.2).all())
        loose = smaller[smaller.effective_friction < 0.41]
        self.assertLess(loose.obstacle_friction.max(), 0.2)
        self.assertTrue(np.isclose(smaller.obstacle_friction[smaller.effective_friction > 0.41], 0.2).all())
        self.assertTrue(np.isclose(half.obstacle_friction, 0.5 * yardstick.tan_friction(half.effective_friction)).all())
        self.assertEqual(len(plain), len(half))

    def test_of_slow_loose_snow_may_be_those_of_the_half(self):
        slow_loose = (self.constant.froude_number <= 1.0) & (self.constant.effective_friction < 0.81)
        without = pd.concat([self.constant[~slow_loose], self.runs.iloc[len(self.constant):]], ignore_index=True)
        found = yardstick.rows_of(yardstick.rules(0.2)[0], without)
        self.assertEqual(len(found), len(yardstick.rows_of(yardstick.rules(0.2)[0], self.runs)))
        reused = ~np.isclose(found.obstacle_friction, 0.2)
        self.assertEqual(found.froude_number[reused].max(), 1.0)
        self.assertLess(found.effective_friction[reused].max(), 0.81)


class Yardstick(unittest.TestCase):
    def test_orders_rules_and_tells_a_tie(self):
        runs = pd.concat([runs_with_errors(as_the_paper, lambda run: 0.06),
                          runs_with_errors(lambda run: 0.02, lambda run: 0.02, rule=lambda friction: 0.5 * yardstick.tan_friction(friction))])
        summary, statements = yardstick.yardstick([yardstick.rules(0.2)[0], yardstick.rules(0.2)[2]], runs)
        self.assertEqual(summary.rule.tolist(), ["0.2", "half of tan phi'"])
        self.assertEqual((summary.behind[0], summary.behind_error[0]), (0.0, 0.0))
        self.assertGreater(summary.behind[1], summary.behind_error[1])
        self.assertEqual(statements.groupby("rule").size().tolist(), [19, 19])  # eight scores, eleven sentences


if __name__ == "__main__":
    unittest.main()
