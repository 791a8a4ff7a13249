"""What the printed statistics of the paper say about the runs behind them."""

import unittest

import numpy as np

from mpmtools.study.published import paper_designs, possible_runs, published_errors, published_variances
from mpmtools.study.regression import LINEAR_RUNUP, PRESSURE_HEIGHT, RUNUP, fit_heights
from mpmtools.equations import relative_height


class PublishedErrors(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.table = published_errors().set_index(["equation", "residuals", "design", "parameter"]).sort_index()

    def needed(self, equation, residuals, design):
        return self.table.loc[equation, residuals, design].needed_residual

    def test_of_the_run_up_do_not_follow_from_a_logarithmic_fit(self):
        full = self.table.loc["runup", "log(h/H)", "full"]
        self.assertEqual(full.runs.unique().tolist(), [336])  # 7 x 16 x 3
        self.assertAlmostEqual(full.relative_standard_error["k_r"], 0.0216, delta=5e-5)
        self.assertAlmostEqual(full.relative_standard_error["kappa_r"], 0.0180, delta=5e-5)
        self.assertEqual(full.published_relative_standard_error["k_r"], 0.0457)
        for design in paper_designs():
            self.assertGreater(self.needed("runup", "log(h/H)", design).agg(lambda x: x.max() / x.min()), 2.0)

    def test_of_the_run_up_follow_from_a_linear_fit(self):
        for design in ("narrow", "narrow without the fluid"):
            self.assertLess(self.needed("runup", "h/H", design).agg(lambda x: x.max() / x.min()), 1.1)

    def test_of_the_pressure_height_follow_from_its_scatter_without_the_fluid(self):
        for design in ("narrow", "full"):
            self.assertLess(self.needed("pressure_height", "h/H", f"{design} without the fluid").agg(lambda x: x.max() / x.min()), 1.15)
            self.assertGreater(self.needed("pressure_height", "h/H", design).agg(lambda x: x.max() / x.min()), 4.0)

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
        for equation, with_fluid, without in (("runup", 2.06, 1.02), ("pressure_height", 2.22, 1.28)):
            self.assertAlmostEqual(ratio[equation, "narrow"], with_fluid, delta=0.01)
            self.assertAlmostEqual(ratio[equation, "narrow without the fluid"], without, delta=0.01)

    def test_allow_few_numbers_of_runs(self):
        self.assertEqual(possible_runs(371, 150), [169, 196, 297, 338, 365])


if __name__ == "__main__":
    unittest.main()
