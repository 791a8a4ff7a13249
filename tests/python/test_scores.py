"""Scores of Appendix A3.1, levels, batch means."""

import unittest

import numpy as np
from scipy import signal

from analysis.statistics import estimate_mean, ratio_of_means
from mpmtools.errors import ConfigError
from mpmtools.scores import compute_scores, levels, scores_by_group

ROUND_OFF = 1e-14  # a handful of operations on numbers of order 1


class Scores(unittest.TestCase):
    def test_match_values_computed_by_hand(self):
        # y = 1, 2, 4 and f = 1, 4, 4: residual sum 4, mean 7/3, total 14/3; in logarithms (unit ln 2): residual 1, mean 1, total 2.
        s = compute_scores([1, 2, 4], [1, 4, 4])
        expected = {"r2": 1 - 4 / (14 / 3), "r2_log": 0.5, "nrmse": np.sqrt(4 / 3) / (7 / 3), "rmsle": np.log(2) / np.sqrt(3),
                    "bias": 0.5 ** (1 / 3), "fraction_10": 2 / 3, "fraction_25": 2 / 3}
        for name, value in expected.items():
            self.assertAlmostEqual(s[name], value, delta=ROUND_OFF, msg=name)

    def test_of_perfect_predictions_are_one_and_zero(self):
        s = compute_scores([1.5, 2.5, 7.0], [1.5, 2.5, 7.0])
        self.assertEqual(s.tolist(), [1, 1, 0, 0, 1, 1, 1])

    def test_of_predicting_the_mean_have_no_determination(self):
        self.assertAlmostEqual(compute_scores([1, 2, 3], [2, 2, 2]).r2, 0.0, delta=ROUND_OFF)

    def test_bias_is_above_one_for_predictions_that_are_too_low(self):
        self.assertAlmostEqual(compute_scores([2, 4, 6], [1, 2, 3]).bias, 2.0, delta=ROUND_OFF)

    def test_fractions_are_relative_to_the_simulated_value_and_inclusive(self):
        # Differences 1/8, 1/4 and 1/2 of y, exact in binary; 25 % counts as within 25 %.
        s = compute_scores([8, 8, 8, 8], [8, 9, 6, 12])
        self.assertEqual((s.fraction_10, s.fraction_25), (0.25, 0.75))

    def test_do_not_depend_on_the_unit(self):
        y, f = np.array([1, 2, 4, 3]), np.array([1.1, 1.7, 4.4, 3.2])
        np.testing.assert_allclose(compute_scores(100 * y, 100 * f), compute_scores(y, f), rtol=10 * ROUND_OFF)

    def test_determination_of_equal_values_is_not_a_number(self):
        s = compute_scores([0.1, 0.1, 0.1], [0.1, 0.2, 0.1])
        self.assertTrue(np.isnan(s.r2) and np.isnan(s.r2_log))
        self.assertGreater(s.rmsle, 0)

    def test_refuse_what_they_are_not_defined_for(self):
        for y, f in (([], []), ([1.0], [1.0, 2.0]), *(pair for bad in (0.0, -1.0, np.nan, np.inf) for pair in (([bad], [1.0]), ([1.0], [bad])))):
            with self.assertRaises(ConfigError, msg=(y, f)):
                compute_scores(y, f)

    def test_by_group_are_those_of_the_rows_of_each_group_by_rising_value(self):
        groups = scores_by_group([3, 1, 3, 1 + 5e-7, 0], [1, 2, 4, 3, 7], [2, 2, 4, 4, 7])
        self.assertEqual(groups["at"].tolist(), [0, 1, 3])
        self.assertEqual(groups.runs.tolist(), [1, 2, 2])
        self.assertEqual(groups.rmsle[0], 0)
        self.assertEqual(groups.nrmse[1], compute_scores([2, 3], [2, 4]).nrmse)
        self.assertEqual(groups.rmsle[2], compute_scores([1, 4], [2, 4]).rmsle)
        with self.assertRaises(ConfigError):
            scores_by_group([2, 3], [1, 2, 4], [2, 2, 4])

    def test_levels_join_what_differs_by_rounding(self):
        self.assertEqual(levels([0.1 + 0.2, 0.3, 5.0, 5.000002, 5.1]).tolist(), [0.3, 0.3, 5.0, 5.0, 5.1])


class BatchMeans(unittest.TestCase):
    def test_few_samples_have_a_mean_without_error(self):
        mean, error = estimate_mean([1.0, np.nan, 3.0])
        self.assertEqual(mean, 2.0)
        self.assertTrue(np.isnan(error))
        self.assertTrue(np.isnan(estimate_mean([np.nan]).mean))

    def test_error_of_correlated_samples_is_that_of_their_long_time_variance(self):
        # AR(1): the standard error of the mean is sigma / sqrt(n) sqrt((1 + a) / (1 - a)).
        random, a, n = np.random.default_rng(5), 0.8, 20000
        errors, means = [], []
        for _ in range(40):
            mean, error = estimate_mean(signal.lfilter([1.0], [1.0, -a], random.normal(size=n)))
            means.append(mean)
            errors.append(error)
        exact = 1.0 / (1.0 - a) / np.sqrt(n)
        # 20 batches: an error is known to 1/sqrt(38) = 16 %, the mean of 40 of them to 2.6 %; four of those.
        self.assertAlmostEqual(np.mean(errors) / exact, 1.0, delta=0.11)
        self.assertAlmostEqual(np.std(means) / exact, 1.0, delta=0.45)  # 40 means: 1/sqrt(78) = 11 %, four of them

    def test_ratio_of_means_propagates_both_errors(self):
        ratio, error = ratio_of_means(3.0, 0.09, 2.0, 0.08)
        self.assertEqual(ratio, 1.5)
        self.assertAlmostEqual(error, 1.5 * 0.05, delta=ROUND_OFF)


if __name__ == "__main__":
    unittest.main()
