"""The semi-empirical equations stand in C++ (impact/semi_empirical.cpp) and in Python (mpmtools.equations): one result for both."""

import io
import os
import unittest

import numpy as np
import pandas as pd

from mpmtools import equations
from mpmtools.program import run_program


@unittest.skipUnless("MPM" in os.environ, "needs the program: set MPM to its path (ctest does)")
class Equations(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        _, text, _ = run_program("predict", "--csv", "--froude", "0.3,1,3,7", "--critical-state-slope", "0,0.4,1.5", "--cohesion-beta", "0,0.3",
                                 "--flow-height", "1.75,4", "--obstacle-width", "0.5,1.75,6")
        cls.table = pd.read_csv(io.StringIO(text))

    def test_are_those_of_mpm_predict(self):
        t = self.table
        friction, height, f = t.effective_friction, t.flow_height_m, equations.width_factor(t.obstacle_width_m / t.flow_height_m)
        expected = {
            "froude_number": equations.froude_number(t.velocity_m_s, height),
            "velocity_m_s": equations.flow_velocity(t.froude_number, height),
            "effective_friction": equations.effective_friction(t.critical_state_slope, t.cohesion_beta),
            "friction_angle_deg": np.degrees(equations.friction_angle(friction.where(friction <= 3.0))),
            "bernoulli_m": height * equations.bernoulli_height(t.froude_number),
            "width_factor": f,
        }
        for name, coefficients in (("runup", equations.PUBLISHED_RUNUP), ("pressure_height", equations.PUBLISHED_PRESSURE_HEIGHT)):
            expected[f"{name}_m"] = height * equations.relative_height(friction, t.froude_number, coefficients)
            expected[f"{name}_magnification"] = equations.magnification_factor(friction, coefficients)
            expected[f"{name}_dissipation"] = equations.dissipation_factor(friction, coefficients)
        for kind, dissipation in (("loose", equations.LAMBDA_LOOSE), ("dense", equations.LAMBDA_DENSE)):
            expected[f"guideline_{kind}_m"] = height + equations.guideline_runup(t.velocity_m_s, dissipation, f)
        self.assertEqual(len(t), 144)
        for column, values in expected.items():
            with self.subTest(column):
                np.testing.assert_allclose(t[column], values, rtol=1e-13)  # round-off


if __name__ == "__main__":
    unittest.main()
