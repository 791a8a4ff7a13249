"""How far coefficients depend on which runs there are: refits, bootstrap, jackknife, profiles, influence."""

import unittest

import numpy as np
import pandas as pd

from mpmtools.equations import HeightCoefficients, relative_height
from mpmtools.fit.regression import PRESSURE_HEIGHT, RUNUP, fit_heights
from analysis.resampling import refit
from analysis.uncertainty import (bootstrap, coefficient_intervals, influence, jackknife_error, leave_one_out, leave_out,
                                        profile_intervals, runup_parts)
from study_samples import exact_samples, grid_of_runs, scattered_samples

EQUATIONS = (RUNUP, PRESSURE_HEIGHT)


def estimates(equation, samples):
    return np.array([e.value for e in fit_heights(equation, samples, with_profile=False).estimates.values()])


class Refits(unittest.TestCase):
    def test_are_those_of_the_regression_on_repeated_rows(self):
        weights = np.random.default_rng(3).integers(0, 4, size=(6, 112))
        for equation in EQUATIONS:
            samples = scattered_samples(equation.published)
            for row, found in zip(weights, refit(equation, samples, weights)):
                repeated = samples.loc[samples.index.repeat(row)].reset_index(drop=True)
                # Two searches of one minimum: kappa by golden section, where the sum of squares is flat to the root of epsilon.
                np.testing.assert_allclose(found, estimates(equation, repeated), rtol=1e-6)

    def test_are_exact_on_exact_data(self):
        for equation in EQUATIONS:
            published = [value for value, *_ in equation.published_estimates.values()]
            np.testing.assert_allclose(refit(equation, exact_samples(equation.published), np.ones((1, 112)))[0], published, rtol=1e-6)

    def test_find_no_saturation_where_there_is_none(self):
        samples = exact_samples(PRESSURE_HEIGHT.published._replace(saturation_froude=np.inf))
        k, froude, kappa = refit(PRESSURE_HEIGHT, samples, np.ones((1, 112)))[0]
        self.assertEqual(froude, np.inf)
        np.testing.assert_allclose([k, kappa], PRESSURE_HEIGHT.published[:2], rtol=1e-6)

    def test_of_what_determines_nothing_are_not_numbers(self):
        for equation in EQUATIONS:
            samples = exact_samples(equation.published)
            fluid, one_speed = samples.effective_friction == 0.0, samples.froude_number == 3.0
            self.assertTrue(np.isnan(refit(equation, samples, np.array([fluid, one_speed], float))).all())


class Bootstrap(unittest.TestCase):
    def test_of_materials_does_not_shrink_when_every_run_is_repeated(self):
        """Repeating rows narrows a standard error by the root of two and says nothing new; the draw of materials knows."""
        samples = scattered_samples(RUNUP.published)
        twice = pd.concat([samples, samples], ignore_index=True)
        once, repeated = (fit_heights(RUNUP, s).estimates["k_r"].standard_error for s in (samples, twice))
        self.assertAlmostEqual(repeated / once, np.sqrt(110.0 / 222.0), delta=1e-6)  # degrees of freedom
        np.testing.assert_allclose(bootstrap(RUNUP, twice, "effective_friction", 50), bootstrap(RUNUP, samples, "effective_friction", 50),
                                   rtol=1e-6)  # the sum of squares is flat to the root of epsilon

    def test_is_the_same_every_time_and_another_for_another_seed(self):
        samples = scattered_samples(RUNUP.published)
        first, again, other = (bootstrap(RUNUP, samples, "froude_number", 20, seed) for seed in (1, 1, 2))
        np.testing.assert_array_equal(first, again)
        self.assertFalse(np.allclose(first, other))

    def test_leaves_out_draws_whose_snow_is_all_saturated(self):
        samples = scattered_samples(PRESSURE_HEIGHT.published)
        found = bootstrap(PRESSURE_HEIGHT, samples, "froude_number", 1000)
        # Fr 2 to 7 only: (4/7)^7 of the draws, 2 %; and draws of one Froude number.
        share = np.isnan(found[:, 0]).mean()
        self.assertTrue(0.008 < share < 0.035, share)


class LeavingOut(unittest.TestCase):
    def test_takes_whole_groups(self):
        samples = scattered_samples(RUNUP.published)
        values, found = leave_out(RUNUP, samples, "froude_number")
        self.assertEqual(values.tolist(), [0.1, 0.3, 1.0, 2.0, 3.0, 5.0, 7.0])
        np.testing.assert_allclose(found[2], estimates(RUNUP, samples[samples.froude_number != 1.0]), rtol=1e-6)

    def test_jackknife_of_a_mean_is_its_standard_error(self):
        x = np.array([1.0, 4.0, 2.0, 7.0])
        without = [(x.sum() - value) / 3.0 for value in x]
        self.assertAlmostEqual(jackknife_error(without), np.std(x, ddof=1) / 2.0, delta=1e-12)

    def test_shows_the_run_that_decides(self):
        runs = grid_of_runs((5.0,))
        odd = runs.index[(runs.froude_number == 1.0) & (runs.effective_friction > 2.2)][0]
        runs.loc[odd, ["runup", "pressure_height"]] *= 1.6
        table = influence(runs)
        for name in ("runup", "pressure_height"):
            top = table[table.equation == name].sort_values("k_change", key=np.abs).iloc[-1]
            self.assertEqual((top.froude_number, round(top.effective_friction, 2)), (1.0, 2.3))
            self.assertGreater(top.residual, 0.0)
            self.assertLess(top.k_change, -1.0)  # without it k falls back
        left = leave_one_out(runs)
        self.assertEqual(len(left), 2 * (13 + 7) * 2)  # materials and Froude numbers; two equations; two sets
        without = left[(left.equation == "runup") & (left.left_out == "material") & (left["at"] > 2.2) & (left.fitting_set == "narrow")].iloc[0]
        self.assertAlmostEqual(without.k, RUNUP.published.k, delta=1e-6)


class Parts(unittest.TestCase):
    def test_find_that_stiff_snow_piles_up_less(self):
        runs = grid_of_runs((5.0,))
        heights = runs.runup - (0.947 - 0.7) * runs.effective_friction * (runs.effective_friction > 0.9)
        table = runup_parts(runs.assign(runup=heights))
        narrow = table[table.fitting_set == "narrow"].set_index("part")
        self.assertEqual(narrow.runs.to_dict(), {"all": 112, "M' < 0.9": 63, "M' > 0.9": 49, "Fr < 0.5": 32, "Fr > 0.5": 80,
                                                  "all, residuals of h/H": 112})
        self.assertAlmostEqual(narrow.k_r["M' < 0.9"], RUNUP.published.k, delta=1e-6)
        self.assertAlmostEqual(narrow.k_r["M' > 0.9"], RUNUP.published.k - 0.247, delta=1e-6)
        self.assertLess(narrow.k_r["M' > 0.9"], narrow.k_r["all"])
        self.assertGreater(narrow.kappa_r_standard_error["Fr < 0.5"], 20 * narrow.kappa_r_standard_error["Fr > 0.5"])  # slow runs do not fix it
        self.assertTrue(runup_parts(runs[runs.effective_friction < 0.45]).empty)  # two values of M': nothing to fit

    def test_with_residuals_of_the_height_follow_the_high_runs(self):
        runs = grid_of_runs((5.0,))
        fast = runs.froude_number > 6.0
        table = runup_parts(runs.assign(runup=runs.runup * np.where(fast, 1.1, 1.0))).set_index(["fitting_set", "part"])
        self.assertLess(table.kappa_r["narrow", "all, residuals of h/H"], table.kappa_r["narrow", "all"])
        self.assertAlmostEqual(runup_parts(runs).set_index(["fitting_set", "part"]).k_r["narrow", "all, residuals of h/H"], RUNUP.published.k, delta=1e-6)

    def test_leave_out_what_has_too_few_materials(self):
        runs = grid_of_runs((5.0,))
        few = runs[(runs.effective_friction < 0.9) | (runs.effective_friction > 2.2)]
        self.assertNotIn("M' > 0.9", set(runup_parts(few).part))
        slow = runs[(runs.froude_number == 0.1) & runs.effective_friction.isin(runs.effective_friction.unique()[:4])]
        far = slow.assign(froude_number=1e-9, runup=1.0 + 0.9 * slow.effective_friction)  # no head: nothing tells kappa_r
        self.assertTrue(runup_parts(far).empty)


class Intervals(unittest.TestCase):
    def test_by_the_profile_are_those_of_the_standard_errors_where_the_equation_is_nearly_linear(self):
        for equation in EQUATIONS:
            samples = exact_samples(equation.published)
            samples["relative_height"] *= np.exp(0.001 * np.sin(7.0 * (np.arange(112) + 1.0)))
            fit = fit_heights(equation, samples)
            for name, (low, high) in profile_intervals(fit, samples).items():
                half = 1.66 * fit.estimates[name].standard_error  # t of 90 % and about 110 degrees of freedom
                self.assertAlmostEqual((high - low) / (2.0 * half), 1.0, delta=0.01, msg=name)

    def test_by_the_profile_are_not_given_where_the_fit_is_beyond_the_bounds_of_the_search(self):
        friction, froude = (of.ravel() for of in np.meshgrid([1.42, 1.53, 1.76], [0.1, 0.2, 0.3]))
        gain = HeightCoefficients(0.37, -1.8, 0.14)  # slow runs alone: no velocity head is lost, but gained
        height = relative_height(friction, froude, gain) + 1e-3 * np.sin(7.0 * np.arange(9))
        samples = pd.DataFrame({"effective_friction": friction, "froude_number": froude, "relative_height": height})
        fit = fit_heights(PRESSURE_HEIGHT, samples, with_profile=False)
        self.assertAlmostEqual(fit.coefficients.kappa, -1.8, delta=0.2)
        self.assertTrue(np.isnan(profile_intervals(fit, samples)["k_p"]).all())

    def test_hold_the_value_and_are_complete(self):
        table = coefficient_intervals(grid_of_runs().assign(runup=lambda r: r.runup * (1.0 + 0.1 * np.sin(r.index.to_numpy()))))
        self.assertEqual(table.parameter.tolist(), 2 * ["k_r", "kappa_r", "k_p", "Fr_sat", "kappa_p"])
        self.assertEqual(set(table.materials), {13})
        noisy = table[table.equation == "runup"]
        for kind in ("standard_error", "profile", "material", "froude"):
            self.assertTrue(((noisy[f"{kind}_from"] < noisy.value) & (noisy.value < noisy[f"{kind}_to"])).all(), kind)
        exact = table[table.equation == "pressure_height"]
        np.testing.assert_allclose(exact.material_from, exact.published, rtol=1e-6)
        np.testing.assert_allclose(exact.material_to, exact.published, rtol=1e-6)


if __name__ == "__main__":
    unittest.main()
