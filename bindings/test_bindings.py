#!/usr/bin/python3
"""The Python module libmpm against exact results and against the command: test_bindings.py FOLDER_OF_THE_MODULE"""

import csv
import io
import os
import pathlib
import subprocess
import sys
import unittest

import numpy as np

SOURCE = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [sys.argv.pop(1), str(SOURCE / "python")]
import libmpm  # noqa: E402  (after its path)
from mpmtools import equations  # noqa: E402

BLOCK = """
[material]
critical_state_slope = 0.4
cohesion_beta = 0.3
hardening_xi = 5.0
[[body]]
min_m = [0.0, 0.0, 0.0]
max_m = [1.0, 1.0, 0.5]
velocity_m_s = [0.0, 0.0, -4.0]
[[wall]]
point_m = [0.0, 0.0, 0.0]
normal = [0.0, 0.0, 1.0]
contact = "separable"
friction = 0.3
[domain]
min_m = [-5.0, -5.0, -5.0]
max_m = [5.0, 5.0, 5.0]
[numerics]
cell_size_m = 0.125
[output]
duration_s = 1.0
"""
PATH = """
[material]
critical_state_slope = 0.8
cohesion_beta = 0.3
hardening_xi = 0.5
[path]
steps_per_segment = 50
segments = [ { d_eps_v = -0.2 } ]
"""


class Predictions(unittest.TestCase):
    def test_are_those_of_mpmtools_for_numbers_and_arrays(self):
        slopes, betas = np.array([0.0, 0.4, 1.2]), np.array([0.0, 0.15, 0.45])
        friction = libmpm.effective_friction(slopes, betas)
        np.testing.assert_allclose(friction, equations.effective_friction(slopes, betas), rtol=1e-15)
        froude = 3.0 / np.sqrt(equations.STANDARD_GRAVITY * 1.75)
        expected = 1.75 * equations.relative_height(friction, froude, equations.PUBLISHED_RUNUP)
        np.testing.assert_allclose(libmpm.predicted_runup(friction, 3.0, 1.75), expected, rtol=1e-14)
        self.assertIsInstance(libmpm.bernoulli_height(3.0, 1.75), float)

    def test_out_of_range_are_errors(self):
        with self.assertRaisesRegex(libmpm.ConfigError, "1"):
            libmpm.effective_friction(0.4, 1.0)
        self.assertTrue(issubclass(libmpm.ConfigError, libmpm.MpmError))


class PointPaths(unittest.TestCase):
    def test_follow_the_exact_isotropic_compression(self):
        path = libmpm.point_path(PATH)
        bulk, xi, first = 1.0e6 / (3.0 * 0.8), 0.5, 1.0e4
        begin = np.arcsinh(first / bulk) / xi
        pressure, compaction = path["p_pa"][-1], -path["eps_v_plastic"][-1]
        self.assertEqual(len(path["step"]), 51)
        self.assertEqual(path["kirchhoff_stress_pa"].shape, (51, 6))
        self.assertAlmostEqual(np.sinh(xi * compaction) + compaction, 0.2 + begin, delta=1e-12)  # the exact solution
        self.assertAlmostEqual(pressure, bulk * np.sinh(xi * compaction), delta=1e-9 * pressure)

    def test_are_changed_and_judged_by_key(self):
        self.assertEqual(len(libmpm.point_path(PATH, ["path.steps_per_segment=7"])["step"]), 8)
        with self.assertRaisesRegex(libmpm.ConfigError, r"path:\d+:\d+: \[material\].*cohesion_bet.*did you mean cohesion_beta"):
            libmpm.point_path(PATH.replace("cohesion_beta", "cohesion_bet"))

    @unittest.skipUnless("MPM" in os.environ, "needs the program: set MPM to its path")
    def test_are_those_of_the_command_to_the_last_digit(self):
        file = SOURCE / "examples" / "paths" / "compression_then_shear.toml"
        rows = list(csv.DictReader(io.StringIO(subprocess.run([os.environ["MPM"], "point", file], capture_output=True, text=True, check=True).stdout)))
        path = libmpm.point_path(file.read_text(encoding="utf-8"))
        for name in rows[0]:
            self.assertEqual([float(row[name]) for row in rows], path[name].tolist(), name)


class Simulations(unittest.TestCase):
    def test_balance_momentum_to_round_off(self):
        simulation = libmpm.Simulation(BLOCK)

        def momentum():
            particles = simulation.particles()
            return 300.0 * float(np.sum(particles["reference_volume_m3"] * particles["velocity_m_s"][:, 2]))

        mass = 300.0 * 0.5
        self.assertAlmostEqual(momentum(), -4.0 * mass, delta=1e-9)
        history = simulation.advance(0.1)
        self.assertEqual(simulation.time, 0.1)
        self.assertEqual(history["force_n"].shape, (simulation.steps, 1, 3))
        floor = float(np.sum(history["force_n"][:, 0, 2] * history["dt_s"]))  # of the snow on the floor: downwards
        self.assertAlmostEqual(momentum(), -4.0 * mass - 9.81 * mass * 0.1 - floor, delta=1e-9 * 4.0 * mass)
        self.assertLess(history["force_n"][:, 0, 2].min(), 0.0)

    def test_step_by_step_is_the_same_as_at_once(self):
        one, other = libmpm.Simulation(BLOCK), libmpm.Simulation(BLOCK)
        history = one.advance(0.02)
        for dt in history["dt_s"]:
            other.step(float(dt))
        self.assertEqual(one.steps, other.steps)
        for name, values in one.particles().items():
            self.assertEqual(values.tobytes(), other.particles()[name].tobytes(), name)

    def test_have_the_same_bits_on_any_number_of_threads(self):
        found = []
        for threads in (1, 2):
            libmpm.set_threads(threads)
            simulation = libmpm.Simulation(BLOCK, ["numerics.cell_size_m=0.0625"])
            simulation.advance(0.01)
            found.append(simulation.particles()["position_m"].tobytes())
        self.assertEqual(found[0], found[1])

    def test_fly_freely_on_the_discrete_parabola(self):
        simulation = libmpm.Simulation(BLOCK, ["wall[0].point_m=[0,0,-4]"])
        before = simulation.particles()["position_m"].mean(axis=0)
        for _ in range(20):
            simulation.step(1e-4)
        moved = simulation.particles()["position_m"].mean(axis=0) - before
        t = 20 * 1e-4
        self.assertAlmostEqual(moved[2], -4.0 * t - 9.81 * t * (t + 1e-4) / 2.0, delta=1e-13)

    def test_know_their_case_and_obstacle(self):
        text = (SOURCE / "examples" / "avalanche_fr3.toml").read_text(encoding="utf-8")
        simulation = libmpm.Simulation(text, ["numerics.cell_size_m=0.875", "conveyor.width_m=8.75"])
        self.assertEqual(simulation.obstacle, simulation.boundary_count - 1)
        self.assertIn("cell_size_m = 0.875", simulation.case_text)
        self.assertIsNone(libmpm.Simulation(BLOCK).obstacle)
        history = simulation.advance(0.05)
        self.assertGreater(history["force_n"][:, simulation.obstacle, 0].max(), 0.0)

    def test_say_what_is_wrong(self):
        simulation = libmpm.Simulation(BLOCK)
        simulation.step()
        with self.assertRaisesRegex(libmpm.ConfigError, "is before the present one"):
            simulation.advance(0.0)
        with self.assertRaisesRegex(libmpm.ConfigError, "give a time step above 0"):
            simulation.step(0.0)
        with self.assertRaises(libmpm.UnstableError):
            for _ in range(200):
                simulation.step(0.05)


if __name__ == "__main__":
    unittest.main(verbosity=2)
