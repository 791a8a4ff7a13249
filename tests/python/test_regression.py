"""The two regressions: exact data, curve_fit, closed forms, Monte Carlo, global search."""

import unittest

import numpy as np
import pandas as pd
from scipy import optimize, stats

from mpmtools.equations import PUBLISHED_PRESSURE_HEIGHT, PUBLISHED_RUNUP, HeightCoefficients, relative_height
from mpmtools.errors import ConfigError
from mpmtools.fit.regression import PRESSURE_HEIGHT, RUNUP, fit_heights, two_sided_p_value, two_sided_quantile
from study_samples import exact_samples, scattered_samples


def fitted(equation, samples, **options):
    return fit_heights(equation, samples[["effective_friction", "froude_number", "relative_height"]], **options)


def samples_of(rows):
    return pd.DataFrame(rows, columns=["effective_friction", "froude_number", "relative_height"])


class Regression(unittest.TestCase):
    def test_recovers_the_runup_coefficients_from_exact_data(self):
        for c in (PUBLISHED_RUNUP, HeightCoefficients(0.2, 0.3), HeightCoefficients(2.0, 3.5)):
            fit = fitted(RUNUP, exact_samples(c))
            # The method stops at round-off; two digits for the conditioning, two more for safety.
            self.assertAlmostEqual(fit.coefficients.k, c.k, delta=1e-10)
            self.assertAlmostEqual(fit.coefficients.kappa, c.kappa, delta=1e-10)
            self.assertEqual(fit.coefficients.saturation_froude, np.inf)
            self.assertLess(fit.estimates["k_r"].standard_error, 1e-10)
            self.assertLess(fit.estimates["k_r"].p_value, 1e-100)

    def test_recovers_the_pressure_height_wherever_the_flow_saturates(self):
        # In every interval between the table's Froude numbers, below the first, and on one of them.
        for saturation in (0.2, 0.7, 1.538, 2.0, 2.5, 4.0, 6.9):
            c = HeightCoefficients(0.5277, 1.3072, saturation)
            fit = fitted(PRESSURE_HEIGHT, exact_samples(c))
            self.assertAlmostEqual(fit.coefficients.k, c.k, delta=1e-9, msg=saturation)
            self.assertAlmostEqual(fit.coefficients.kappa, c.kappa, delta=1e-8)  # at 0.2 the head it acts on is 2 % of the height
            self.assertAlmostEqual(fit.coefficients.saturation_froude, saturation, delta=1e-8)
            self.assertEqual(fit.degrees_of_freedom, fit.runs - 3)

    def test_finds_no_saturation_where_the_pressure_height_keeps_growing(self):
        fit = fitted(PRESSURE_HEIGHT, exact_samples(HeightCoefficients(0.5, 1.3)))
        self.assertEqual(fit.coefficients.saturation_froude, np.inf)
        self.assertAlmostEqual(fit.coefficients.kappa, 1.3, delta=1e-9)
        self.assertEqual(fit.degrees_of_freedom, fit.runs - 2)
        self.assertTrue(np.isnan(fit.estimates["Fr_sat"].standard_error))
        self.assertEqual(len(fit.cautions), 1)
        self.assertIn("no saturation", fit.cautions[0])

    def test_gives_what_curve_fit_gives(self):
        runup, pressure = scattered_samples(PUBLISHED_RUNUP), scattered_samples(PUBLISHED_PRESSURE_HEIGHT)
        cases = [(RUNUP, runup, lambda s, k, kappa: np.log(relative_height(s[0], s[1], HeightCoefficients(k, kappa))), PUBLISHED_RUNUP[:2]),
                 (PRESSURE_HEIGHT, pressure, lambda s, k, kappa, f: relative_height(s[0], s[1], HeightCoefficients(k, kappa, f)),
                  PUBLISHED_PRESSURE_HEIGHT)]
        for equation, samples, model, start in cases:
            inputs = samples[["effective_friction", "froude_number"]].to_numpy().T
            heights = np.log(samples.relative_height) if equation.logarithmic else samples.relative_height
            values, covariance = optimize.curve_fit(model, inputs, heights, p0=start, ftol=1e-15, xtol=1e-15, gtol=1e-15)
            fit = fitted(equation, samples)
            k, *saturation, kappa = fit.estimates.values()
            for e, value, variance in zip((k, kappa, *saturation), values, np.diag(covariance)):
                # The finite differences of curve_fit leave seven digits of the minimum and four of the errors.
                self.assertAlmostEqual(e.value / value, 1.0, delta=1e-7)
                self.assertAlmostEqual(e.standard_error / np.sqrt(variance), 1.0, delta=1e-4)
                p = 2.0 * stats.t.sf(value / np.sqrt(variance), len(samples) - len(values))
                self.assertAlmostEqual(np.log(e.p_value) / np.log(p), 1.0, delta=1e-4)

    def test_is_the_closed_form_where_the_equation_is_linear(self):
        # M' > 0 at Fr = 0 gives k alone: h/H - 1 = k M'. kappa takes up what the last run leaves: its residual is 0 for any k.
        m = 0.25 * np.arange(1, 9)
        h = 1.0 + 0.9 * m + 0.05 * np.sin(3.0 * np.arange(1, 9))
        k = np.sum(m * (h - 1.0)) / np.sum(m**2)
        residual = np.sum((h - 1.0 - k * m) ** 2)
        rows = [*zip(m, np.zeros(8), h), (0.5, 2.0, relative_height(0.5, 2.0, HeightCoefficients(0.9, 1.2)))]
        fit = fitted(PRESSURE_HEIGHT, samples_of(rows))
        self.assertEqual(fit.coefficients.saturation_froude, np.inf)  # only one Froude number above 0
        self.assertAlmostEqual(fit.estimates["k_p"].value, k, delta=1e-9)
        self.assertAlmostEqual(fit.estimates["k_p"].standard_error, np.sqrt(residual / 7.0 / np.sum(m**2)), delta=1e-9)  # 9 runs, 2 coefficients

    def test_standard_errors_are_the_scatter_of_the_estimates(self):
        random, trials, scatter = np.random.default_rng(20240607), 200, 0.05
        for equation in (RUNUP, PRESSURE_HEIGHT):
            exact = exact_samples(equation.published)
            found = []
            for _ in range(trials):
                noise = random.normal(0.0, scatter, len(exact))
                heights = exact.relative_height * np.exp(noise) if equation.logarithmic else exact.relative_height + noise
                found.append(fitted(equation, exact.assign(relative_height=heights), with_profile=False).estimates)
            for name in equation.parameters:
                values, errors = np.array([[e[name].value, e[name].standard_error] for e in found]).T
                truth = equation.published_estimates[name][0]
                # The standard deviation of 200 normal numbers is known to 1/sqrt(400) = 5 %: four of them. Their mean to 1/14: four again.
                self.assertAlmostEqual(np.mean(errors) / np.std(values, ddof=1), 1.0, delta=0.2, msg=name)
                self.assertAlmostEqual(np.mean(values), truth, delta=0.28 * np.std(values, ddof=1), msg=name)

    def test_the_interval_of_the_saturation_covers_the_truth_as_often_as_it_says(self):
        random, trials = np.random.default_rng(11), 50
        exact = exact_samples(PUBLISHED_PRESSURE_HEIGHT)
        covered = 0
        for _ in range(trials):
            samples = exact.assign(relative_height=exact.relative_height + random.normal(0.0, 0.05, len(exact)))
            low, high = fitted(PRESSURE_HEIGHT, samples).saturation_interval
            covered += low <= PUBLISHED_PRESSURE_HEIGHT.saturation_froude <= high
        self.assertAlmostEqual(covered / trials, 0.95, delta=0.124)  # four standard deviations of a fraction of 50

    def test_finds_the_lowest_of_all_minima_over_the_saturation(self):
        # Heights without any sense: the sum of squares has many minima. A blind scan of (kappa, Fr_sat) with k by linear least squares.
        random = np.random.default_rng(7)
        kappa, saturation = np.meshgrid(0.02 * np.arange(-40, 401), 0.01 * np.arange(401), indexing="ij")
        for trial in range(20):
            samples = samples_of([(m, f, random.uniform(1.0, 4.0)) for f in (0.5, 1.0, 2.0, 3.0, 4.0) for m in (0.0, 0.5, 1.5)])
            mm = my = yy = 0.0
            for m, f, h in samples.itertuples(index=False):
                y = h - 1.0 - 0.5 * np.minimum(f, saturation) ** 2 * np.exp(-kappa * m)
                mm, my, yy = mm + m * m, my + m * y, yy + y * y
            lowest = np.min(yy - my**2 / mm)
            fit = fitted(PRESSURE_HEIGHT, samples)
            self.assertLessEqual(fit.sum_of_squares, lowest * (1.0 + 1e-9), trial)
            self.assertGreaterEqual(fit.sum_of_squares, lowest * 0.98, trial)  # the scan's steps of 0.01 and 0.02

    def test_profile_is_lowest_at_the_fit_and_reaches_the_limit_at_the_interval(self):
        fit = fitted(PRESSURE_HEIGHT, scattered_samples(PUBLISHED_PRESSURE_HEIGHT))
        froude, sums = np.array(fit.saturation_profile).T
        low, high = fit.saturation_interval
        self.assertGreater(len(froude), 100)
        self.assertAlmostEqual(sums.min() / fit.sum_of_squares, 1.0, delta=1e-9)
        outside = (froude < low) | (froude > high)
        self.assertTrue((sums[outside] > fit.sum_of_squares * (1.0 + 3.9 / fit.degrees_of_freedom)).all())  # t^2 > 1.96^2
        self.assertTrue(low < fit.coefficients.saturation_froude < high)

    def test_says_when_the_error_of_the_saturation_is_not_trustworthy(self):
        near_a_kink = fitted(PRESSURE_HEIGHT, scattered_samples(HeightCoefficients(0.5277, 1.3072, 1.98)))
        self.assertIn("not trustworthy", " ".join(near_a_kink.cautions))
        sharp = fitted(PRESSURE_HEIGHT, exact_samples(PUBLISHED_PRESSURE_HEIGHT))
        self.assertNotIn("not trustworthy", " ".join(sharp.cautions))
        self.assertIn("no run in between", " ".join(sharp.cautions))

    def test_refuses_runs_that_do_not_determine_the_coefficients(self):
        fluid = samples_of([(0.0, f, 1.0 + 0.5 * f**2) for f in (0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 7.0)])
        with self.assertRaisesRegex(ConfigError, "k needs runs with M' > 0"):
            fitted(RUNUP, fluid)
        samples = exact_samples(PUBLISHED_RUNUP)
        for equation, runs in ((RUNUP, 2), (PRESSURE_HEIGHT, 3)):
            with self.assertRaisesRegex(ConfigError, f"{runs} runs are left"):
                fitted(equation, samples[:runs])
        slow = samples_of([(m, 0.1, 1.0 + 0.7 * m**0.8) for m in (0.2, 0.4, 0.8, 1.2, 1.6)])  # piles alone: no head to lose
        for equation in (RUNUP, PRESSURE_HEIGHT):
            with self.assertRaisesRegex(ConfigError, "the runs do not determine the coefficients"):
                fitted(equation, slow)
        for bad in ((0.5, 1.0, 0.0), (-0.1, 1.0, 2.0), (0.5, -1.0, 2.0), (0.5, 1.0, np.nan), (np.nan, 1.0, 2.0)):
            with self.assertRaises(ConfigError, msg=bad):
                fitted(RUNUP, pd.concat([samples, samples_of([bad])]))


class StudentsT(unittest.TestCase):
    def test_p_values_and_quantiles_are_those_of_the_closed_forms(self):
        for t in (0.0, 0.5, 1.0, 3.0, 20.0):
            # nu = 1: Cauchy; nu = 2: 1 - t / sqrt(2 + t^2)
            self.assertAlmostEqual(two_sided_p_value(t, 1), 1.0 - 2.0 / np.pi * np.arctan(t), delta=1e-14)
            self.assertAlmostEqual(two_sided_p_value(-t, 2), 1.0 - t / np.sqrt(2.0 + t * t), delta=1e-14)
        self.assertAlmostEqual(two_sided_quantile(0.05, 10), 2.2281388519649385, delta=1e-12)  # tables of Student's t
        self.assertAlmostEqual(two_sided_quantile(0.05, 1e9), 1.959963984540054, delta=1e-8)  # the normal distribution


if __name__ == "__main__":
    unittest.main()
