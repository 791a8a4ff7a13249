"""One choice changed at a time, against the base."""

import unittest

import numpy as np

from mpmtools.errors import InputError
from analysis.sensitivity import sensitivities
from study_samples import InFolder

HEAD = ("name,status,froude_number,critical_state_slope,cohesion_beta,hardening_xi,effective_friction,obstacle_width_m,obstacle_friction,"
        "obstacle_friction_ratio,cell_size_m,output.duration_s,numerics.slope_deg,runup_mean_m,runup_standard_error_m,"
        "pressure_height_mean_m,pressure_height_standard_error_m,force_mean_n.x,force_standard_error_n.x,predicted_runup_m,"
        "predicted_pressure_height_m\n")
# Two kinds of snow and a fluid. The base: friction 0.5 tan phi', dx 0.35, no slope.
ROWS = """\
a,done,3,0.4,0,5,0.4,1.75,0.095,0.5,0.35,9,0,6,0.3,3,0.06,100,2,6,3
a_mu,done,3,0.4,0,5,0.4,1.75,0.15,0.7894,0.35,9,0,5.4,0.27,3.3,0.066,110,2.2,6,3
a_mur,done,3,0.4,0,5,0.4,1.75,0.0475,0.25,0.35,9,0,6.6,0.3,nan,nan,100,2,6,3
a_slope,done,3,0.4,0,5,0.4,1.75,0.095,0.5,0.35,12,30,6.3,0.3,3,0.06,100,2,6,3
b,done,5,0.8,0,5,0.8,1.75,0.1887,0.5000000000000001,0.35,10,0,8,0.4,4,0.1,200,4,10,4
b_mu,done,5,0.8,0,5,0.8,1.75,0.15,0.3975,0.35,10,0,8.8,0.4,4,0.1,190,4,10,4
b_mur,done,5,0.8,0,5,0.8,1.75,0.09435,0.25,0.35,10,0,10,0.4,4,0.1,180,4,10,4
b_dx,done,5,0.8,0,5,0.8,1.75,0.1887,0.5,0.25,10,0,8.4,0.4,4,0.1,200,4,10,4
b_none,done,5,0.8,0,5,0.8,1.75,0.1887,0.5,0.5,10,0,nan,nan,nan,nan,nan,nan,10,4
water,done,3,0,0,5,0,1.75,0,nan,0.35,9,0,9,0.3,3,0.06,100,2,9,3
water_mu,done,3,0,0,5,0,1.75,0.15,inf,0.35,9,0,7.2,0.3,3,0.06,100,2,9,3
alone,done,1,0.4,0,5,0.4,1.75,0.15,0.7894,0.35,9,0,3,0.1,2,0.1,50,1,3,2
later,to do,1,0.4,0,5,0.4,1.75,0.15,0.7894,0.35,9,0,nan,nan,nan,nan,nan,nan,3,2
"""


class Sensitivities(InFolder):
    def setUp(self):
        super().setUp()
        self.study = sensitivities(self.write("results.csv", HEAD + ROWS))

    def summary(self, choice, value):
        s = self.study.summaries
        return s[(s.choice == choice) & (s.value == value)].iloc[0]

    def test_compare_each_run_with_the_base_at_its_point(self):
        runs = self.study.runs
        self.assertEqual(len(runs), 10)
        mu = runs.iloc[1]
        self.assertEqual((mu.choice, mu.value), ("obstacle_friction", "0.15"))
        for name, value in (("runup_to_base", 0.9), ("pressure_height_to_base", 1.1), ("force_to_base", 1.1), ("runup_to_published", 0.9)):
            self.assertAlmostEqual(mu[name], value, delta=1e-15, msg=name)
        self.assertAlmostEqual(mu.runup_standard_error, 0.9 * np.hypot(0.05, 0.05), delta=1e-15)
        self.assertEqual(runs.choice.iloc[0], "")  # the base
        self.assertEqual(runs.choice.iloc[4], "")  # its ratio carries a rounding error
        self.assertEqual(runs.choice.iloc[3], "numerics.slope_deg")  # the duration is no choice

    def test_describe_friction_by_what_its_rows_have_in_common(self):
        mu = self.summary("obstacle_friction", "0.15")
        self.assertEqual(mu.points, 3)
        self.assertAlmostEqual(mu.runup, np.cbrt(0.9 * 1.1 * 0.8), delta=1e-14)
        self.assertAlmostEqual(mu.runup_low, 0.8, delta=1e-15)
        self.assertAlmostEqual(mu.runup_high, 1.1, delta=1e-15)
        self.assertAlmostEqual(mu.runup_rmsle, np.sqrt(np.mean(np.log([0.9, 0.88, 0.8]) ** 2)), delta=1e-14)
        self.assertAlmostEqual(mu.base_runup_rmsle, np.sqrt(np.log(0.8) ** 2 / 3.0), delta=1e-14)
        ratio = self.summary("obstacle_friction_ratio", "0.25")
        self.assertEqual(ratio.points, 2)
        self.assertEqual(ratio.pressure_height, 1.0)  # of the one that has a pressure height
        self.assertEqual(self.summary("", "").points, 3)  # among them the fluid, which has no friction to take a part of

    def test_take_the_width_of_the_belt_for_a_choice_where_it_is_not_that_of_the_hardening(self):
        def row(name, xi, width, runup):
            return f"{name},done,3,0.4,0,{xi},0.4,1.75,0.095,0.5,0.35,9,0,{runup},0.3,3,0.06,100,2,6,3,{width}\n"

        rows = row("wide", 5, 42, 6.6) + row("a", 5, 21, 6) + row("a_again", 5, 21, 6) + row("b", 0.5, 15.75, 5)
        study = sensitivities(self.write("widths.csv", HEAD.rstrip() + ",conveyor_width_m\n" + rows))
        self.assertEqual(study.runs.choice.tolist(), ["conveyor_width_m", "", "", ""])
        self.assertEqual(study.runs.value[0], "42")
        self.assertAlmostEqual(study.runs.runup_to_base[0], 1.1, delta=1e-15)

    def test_say_what_could_not_be_compared(self):
        self.assertIn("b_none: no steady mean", self.study.notes[0])
        self.assertIn("alone: no run of the base", self.study.notes[1])
        self.assertEqual(self.study.notes[2], "1 run that is not done")
        with self.assertRaises(InputError):
            sensitivities(self.write("short.csv", "name,status,froude_number\na,done,1\n"))


if __name__ == "__main__":
    unittest.main()
