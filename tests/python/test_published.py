"""What the printed statistics of the paper say about the runs behind them."""

import unittest

import numpy as np

from analysis.fits import LINEAR_RUNUP
from analysis.published import paper_designs, possible_runs, published_errors, published_variances
from mpmtools.fit.regression import PRESSURE_HEIGHT, RUNUP, fit_heights
from mpmtools.equations import relative_height


class PublishedErrors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.table = published_errors().set_index(["equation", "residuals", "design", "parameter"]).sort_index()

    def needed(self, equation, residuals, design):
        return self.table.loc[equation, residuals, design].needed_residual

    def spread(self, *which):
        needed = self.needed(*which)
        return needed.max() / needed.min()

    def test_are_tried_for_both_sets_with_and_without_the_fluid(self):
        self.assertEqual({name: len(design) for name, design in paper_designs().items()},
                         {"narrow": 245, "narrow without the fluid": 189, "wide": 259, "wide without the fluid": 203})

    def test_of_the_run_up_do_not_follow_from_a_logarithmic_fit(self):
        narrow = self.table.loc["runup", "log(h/H)", "narrow"]
        self.assertAlmostEqual(narrow.relative_standard_error["k_r"], 0.0246, delta=5e-5)
        self.assertAlmostEqual(narrow.relative_standard_error["kappa_r"], 0.0210, delta=5e-5)
        self.assertEqual(narrow.published_relative_standard_error["k_r"], 0.0457)
        for design in paper_designs():
            self.assertGreater(self.spread("runup", "log(h/H)", design), 2.0)

    def test_of_the_run_up_need_nearly_one_residual_of_a_linear_fit(self):
        for design in paper_designs():
            self.assertLess(self.spread("runup", "h/H", design), 1.1)

    def test_of_the_pressure_height_follow_from_its_scatter_without_the_fluid(self):
        """0.12 H is what the printed NRMSE gives."""
        for design in ("narrow", "wide"):
            needed = self.needed("pressure_height", "h/H", f"{design} without the fluid")
            np.testing.assert_allclose(needed, 0.12, rtol=0.07)
            self.assertGreater(self.spread("pressure_height", "h/H", design), 3.5)

    def test_are_those_of_a_fit_to_data_with_that_scatter(self):
        """Of any one sample they differ by its residuals' projection."""
        for equation, scatter in ((RUNUP, 0.13), (LINEAR_RUNUP, 0.7), (PRESSURE_HEIGHT, 0.12)):
            samples = paper_designs()["narrow without the fluid"]
            heights = relative_height(samples.effective_friction, samples.froude_number, equation.published)
            noise = np.random.default_rng(5).normal(0.0, scatter, len(samples))
            fit = fit_heights(equation, samples.assign(relative_height=heights * np.exp(noise) if equation.logarithmic else np.maximum(heights + noise, 0.1)))
            of = self.table.loc[equation.name, equation.residuals, "narrow without the fluid"]
            for name, estimate in fit.estimates.items():
                expected = of.published_relative_standard_error[name] / of.needed_residual[name] * scatter
                self.assertAlmostEqual(estimate.relative_error / expected, 1.0, delta=0.2, msg=f"{equation.residuals} {name}")


class PublishedScores(unittest.TestCase):
    def test_fit_a_design_without_the_fluid_better(self):
        table = published_variances().set_index(["equation", "design"])
        ratio = table.design_variance / table.published_variance
        for equation, with_fluid, without in (("runup", 1.97, 1.02), ("pressure_height", 2.19, 1.35)):
            self.assertAlmostEqual(ratio[equation, "narrow"], with_fluid, delta=0.01)
            self.assertAlmostEqual(ratio[equation, "narrow without the fluid"], without, delta=0.01)

    def test_allow_few_numbers_of_runs(self):
        self.assertEqual(possible_runs(371), [169, 196, 297, 338, 365])


if __name__ == "__main__":
    unittest.main()
