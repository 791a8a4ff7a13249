"""The page of `mpm design`: uncertainty, oscillator, loads, tables and the page itself."""

import base64
import copy
import html
import json
import math
import re
import shutil
import subprocess
import unittest
import unittest.mock
import urllib.parse
import zlib

from in_folder import sealed_h5
import numpy as np
import pandas as pd
import scipy.linalg
import scipy.optimize
import scipy.signal

from mpmtools import equations
from mpmtools.checksums import checksum
from mpmtools.design import cautions, comparison, data_files, figures, headlines, page, page_tables, rounding, scaling, what_decides
from mpmtools.design.ensemble import Ensemble
from mpmtools.design.factors import CONDITIONS, FILE, factor_at, load_factors
from mpmtools.design.loads import Effect, Loads, moving_mean, rows_of
from mpmtools.design.oscillator import equivalent_static_force, shock_response_spectrum
from mpmtools.design.results import IMPACT_FORCES, STEADY_FORCES, Results, fitted_line
from mpmtools.design.uncertainty import batches_of, combined, grid_estimate, observed_order, statistical
from mpmtools.design.vibration import cantilever_modes
from mpmtools.errors import InputError
from mpmtools.run import Run
from study_samples import SOURCE, InFolder

BROWSER = shutil.which("chromium")


class GridUncertainties(unittest.TestCase):
    def test_have_the_order_of_celik_et_al_2008(self):
        # Table 1 of J. Fluids Eng. 130, 078001: 18,000, 8,000 and 4,500 cells in two dimensions; p = 1.53, limit 6.1685, GCI 2.2 %
        sizes, values = [1 / math.sqrt(n) for n in (4500, 8000, 18000)], [5.863, 5.972, 6.063]
        self.assertAlmostEqual(observed_order(sizes, values), 1.53, delta=0.01)  # printed with two decimals
        estimate = grid_estimate(sizes, values)
        self.assertAlmostEqual(estimate.limit, 6.1685, delta=5e-4)  # from the rounded values
        self.assertAlmostEqual(estimate.uncertainty / 6.063, 0.022, delta=5e-4)

    def test_find_the_order_of_a_power_law_at_any_ratios(self):
        for order in (0.7, 1.0, 1.9):
            sizes = [0.4, 0.25, 0.17]
            self.assertAlmostEqual(observed_order(sizes, [3.0 + h**order for h in sizes]), order, delta=1e-9)  # brentq's tolerance

    def test_take_the_range_of_the_values_where_there_is_no_credible_order(self):
        zigzag = grid_estimate([0.4, 0.2, 0.1], [1.0, 1.2, 1.1])
        self.assertTrue(math.isnan(zigzag.order))
        self.assertAlmostEqual(zigzag.uncertainty, 3 * 0.2)
        growing = grid_estimate([0.4, 0.2, 0.1], [1.0, 1.1, 1.3])
        self.assertLess(growing.order, 0.0)
        self.assertAlmostEqual(growing.uncertainty, 3 * 0.3)
        steep = grid_estimate([0.4, 0.2, 0.1], [1.0, 1.9, 1.91])
        self.assertGreater(steep.order, 2.0)
        self.assertAlmostEqual(steep.uncertainty, 1.25 * 0.91)
        close = grid_estimate([0.3, 0.24, 0.2], [1.0, 1.3, 1.4])
        self.assertGreater(close.order, 2.0)
        self.assertAlmostEqual(close.uncertainty, 3 * 0.1 / 0.2)  # what the two finest give; 1.25 times the range would be less

    def test_take_first_order_and_three_on_two_grids(self):
        self.assertAlmostEqual(grid_estimate([0.2, 0.1], [2.0, 2.1]).uncertainty, 0.3)

    def test_of_the_levels_cover_what_finer_grids_gave(self):
        # Square mast at Fr 3 with the default numerics, as its grid study measured them. Level quick has 3 and 5 cells, or 3, 5 and 7; the
        # finer grids, up to 12 cells, are the judges.
        text = (SOURCE / "validation" / "cases" / "avalanche_convergence" / "README.md").read_text(encoding="utf-8").split("## Values on the grids")[1]
        head, _, *rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if line.startswith("|")][:5]
        cells_of = [int(name.removeprefix("w/")) for name in head[1:]]
        self.assertEqual(([row[0] for row in rows], cells_of[-1]), (["force, kN", "run-up / H", "pressure height / H"], 12))
        for quantity, *numbers in rows:
            values = dict(zip(cells_of, map(float, numbers)))
            for cells in ((3, 5), (3, 5, 7)):
                band = grid_estimate([1.0 / n for n in cells], [values[n] for n in cells]).uncertainty
                for finer in (n for n in values if n > cells[-1]):
                    self.assertLessEqual(abs(values[finer] - values[cells[-1]]), band, f"{quantity}, {cells} against {finer}")

    def test_are_unknown_where_the_finest_grid_has_no_value(self):
        self.assertTrue(math.isnan(grid_estimate([0.4, 0.2], [1.0, math.nan]).uncertainty))

    def test_add_to_the_statistical_error_as_root_of_the_sum_of_squares(self):
        self.assertAlmostEqual(combined(3.0, 4.0), 5.0)
        self.assertAlmostEqual(combined(3.0, math.nan), 3.0)
        self.assertTrue(math.isnan(combined(math.nan, math.nan)))

    def test_take_students_t_of_the_batches(self):
        for effective, batches, t in ((457.0, 20, 2.093), (100.0, 20, 2.093), (99.0, 10, 2.262), (4.0, 5, 2.776), (math.nan, 5, 2.776)):  # tables of t, 97.5 %
            self.assertEqual(batches_of(effective), batches)
            self.assertAlmostEqual(statistical(10.0, effective), 10.0 * t, delta=0.005)
        rng, inside = np.random.default_rng(3), []
        for _ in range(4000):  # means of 5 batches about 0
            batches = rng.normal(size=5)
            inside.append(abs(batches.mean()) <= statistical(batches.std(ddof=1) / math.sqrt(5), 5.0))
        self.assertAlmostEqual(np.mean(inside), 0.95, delta=0.01)


class Oscillators(unittest.TestCase):
    def test_double_a_step_without_damping(self):
        step = np.full(2000, 5.0)  # 1 Hz, two periods
        response = equivalent_static_force(1e-3, step, 1.0, 0.0)
        time = 1e-3 * np.arange(1, 2001)
        np.testing.assert_allclose(response, 5.0 * (1.0 - np.cos(2 * np.pi * time)), atol=1e-9)  # exact for a constant force; rounding
        self.assertAlmostEqual(shock_response_spectrum(1e-3, step, [1.0], 0.0)[0], 10.0, delta=1e-4)  # the peak lies on a row

    def test_overshoot_a_step_by_exp_of_minus_pi_zeta_over_root(self):
        damping = 0.1
        peak = shock_response_spectrum(1e-3, np.ones(3000), [1.0], damping)[0]
        self.assertAlmostEqual(peak, 1 + math.exp(-math.pi * damping / math.sqrt(1 - damping**2)), delta=1e-5)  # rows of 1/1000 period

    def test_follow_a_slow_force_and_miss_a_short_one(self):
        ramp = np.linspace(0, 1, 4000)
        self.assertAlmostEqual(equivalent_static_force(1e-3, ramp, 20.0, 0.05)[-1], 1.0, delta=0.01)
        blow = np.zeros(4000)
        blow[:10] = 1.0  # 10 ms against 2 s: impulse response omega J
        self.assertAlmostEqual(shock_response_spectrum(1e-3, blow, [0.5], 0.0)[0], 2 * np.pi * 0.5 * 0.01, delta=1e-4)


class MovingMeans(unittest.TestCase):
    def test_count_nothing_before_the_first_row_and_end_with_the_last(self):
        np.testing.assert_allclose(moving_mean([3, 3, 6, 9, 12], 3), [2, 4, 6, 9, 10.5])
        np.testing.assert_allclose(moving_mean([4, 8, 16, 16, 12], 4), [7, 11, 13, 44 / 3, 14])
        self.assertEqual([rows_of(interval) for interval in (0.02, 0.01, 0.005, 0.3)], [5, 10, 20, 1])
        np.testing.assert_allclose(moving_mean([[0, 1], [2, 3], [4, 5]], 3)[1], [2, 3])


CASE = """\
title = "Design: {name}"
[material]
density_kg_m3 = 300.0
critical_state_slope = {slope}
cohesion_beta = 0.0
hardening_xi = 5.0
[conveyor]
velocity_m_s = 9.81
flow_height_m = 2.0
mirror_y = true
[obstacle]
shape = "box"
width_m = 1.0
depth_m = 1.0
height_m = 12.0
friction = 0.15
[numerics]
cell_size_m = {size}
particles_per_cell = 8
transfer = "apic"
gravity_m_s2 = 9.81
"""


class DesignFolder(InFolder):
    """Two snows on three grids whose force is 1e5 (1 + dx) N, 1.2 times that for the second snow; 8 s, steady from 3 s."""

    SIZES = (0.4, 0.2, 0.1)

    def setUp(self):
        super().setUp()
        self.runs = []
        for snow, factor in (("soft", 1.0), ("firm", 1.2)):
            for grid, size in enumerate(self.SIZES):
                name = f"{snow}_w{(3, 5, 11)[grid]}"
                self.runs.append({"name": name, "snow": int(snow == "firm"), "grid": grid, "case_hash": f"hash of {name}", "end_s": 8.0})
                self.make_run(name, size, 1e5 * factor * (1 + size), final=grid == 2)
        self.plan = {
            "format_version": 1, "title": "Test <mast>", "version": "0", "commit": "abc", "level": "quick",
            "flow": {"depth_m": 2.0, "velocity_m_s": 9.81, "froude_number": 9.81 / math.sqrt(19.62), "density_kg_m3": 300.0, "slope_deg": 0.0,
                     "gravity_m_s2": 9.81, "snow_class": None},
            "mast": {"shape": "box", "width_m": 1.0, "depth_m": 1.0, "height_m": 12.0, "friction": 0.15, "drag_coefficient": None},
            "modes": [{"frequency_hz": 1.0, "damping_ratio": 0.02, "shape_at_load": None}], "author": "A. Name", "project": "7", "numerics": {"contact": "nodal", "transfer": "apic"},
            "snows": [{"name": name, "critical_state_slope": slope, "cohesion_beta": 0.0, "hardening_xi": 5.0, "effective_friction": m, "source": ""}
                      for name, slope, m in (("soft", 0.5, 0.5), ("firm", 0.9, 1.0))],
            "grids": [{"cells": n, "cell_size_m": h} for n, h in zip((3, 5, 11), self.SIZES)],
            "duration_s": 8.0, "particle_steps": 1e6, "runs": self.runs,
            "advice": [{"rule": "mach_number", "text": "Mach number v/c_P = 0.7: too high; stiffen", "snows": ["firm"]}]}
        self.write("design_plan.json", json.dumps(self.plan))

    def drawn_page(self):
        """(the page, lines for the terminal), without its view in three dimensions, which takes a few seconds."""
        with unittest.mock.patch("mpmtools.design.figures.view_3d", return_value=None):
            path, lines = page.make_page(self.folder)
        return open(path, encoding="utf-8").read(), lines

    def change_cases(self, old, new):
        """Replaces a line in the cases of all runs."""
        for run in self.runs:
            path = self.folder / "runs" / run["name"] / "case.toml"
            self.assertEqual(path.read_text().count(f"{old}\n"), 1)
            path.write_text(path.read_text().replace(f"{old}\n", f"{new}\n"))

    def make_run(self, name, size, force, final):
        folder = f"runs/{name}"
        (self.folder / folder).mkdir(parents=True)
        self.write(f"{folder}/case.toml", CASE.format(name=name, size=size, slope=0.5 if name.startswith("soft") else 0.9))
        self.write(f"{folder}/obstacle.json", '{"outline_m": [[0, -0.5], [1, -0.5], [1, 0.5], [0, 0.5]], "top_m": null}')
        time = np.arange(801) * 0.01
        ripple = 1 + 0.1 * np.sin(2 * np.pi * time / 0.5) * (time > 3) + 1.0 * (np.abs(time - 0.5) < 0.3)
        pushed = force * ripple
        pushed[0] = np.nan
        series = pd.DataFrame({"time_s": time, "runup_m": 5 + (time < 2), "runup_p99_m": 4.0, "pressure_height_m": 3.0, "force_x_n": pushed, "force_y_n": 0.0,
                               "force_z_n": 0.1 * pushed, "moment_x_n_m": 0.0, "moment_y_n_m": 1.5 * pushed, "moment_z_n_m": 0.0})
        series.to_csv(self.folder / folder / "series.csv", index=False)
        z = np.arange(0.1, 10, 0.2)
        shape = np.where(z < 3, 1.0, 0.0) / 3.0
        with sealed_h5(self.folder / folder / "profiles.h5", "w") as file:
            file["time_s"], file["z_m"] = time, z
            file["force_x_per_height_n_m"] = np.nan_to_num(pushed)[:, None] * shape
            file["pressure_pa"] = np.nan_to_num(pushed)[:, None] * shape * 0.9
        results = {"case_hash": f"hash of {name}", "duration_s": 8.0, "steady": True, "steady_from_s": 3.0, "steady_to_s": 8.0, "runup_mean_m": 5.0 - size,
                   "runup_standard_error_m": 0.02, "runup_p99_mean_m": 4.0, "runup_p99_standard_error_m": 0.01, "runup_p99_numerical_uncertainty_m": 0.2,
                   "runup_numerical_uncertainty_m": 0.3, "pressure_height_mean_m": 3.0, "pressure_height_standard_error_m": 0.01,
                   "pressure_height_numerical_uncertainty_m": 0.1, "force_mean_n": [force, 0, 0], "force_standard_error_n": [500.0, 0, 0],
                   "force_x_numerical_uncertainty_n": 0.02 * force, "overturning_moment_axis_x_m": 0.5, "overturning_moment_mean_n_m": 1.55 * force,
                   "overturning_moment_standard_error_n_m": 700.0, "overturning_moment_numerical_uncertainty_n_m": None, "force_resultant_height_m": 1.5,
                   "wall_time_s": 60.0, "threads": 2}
        self.write(f"{folder}/results.json", json.dumps(results))
        if final:
            with sealed_h5(self.folder / folder / "final.h5", "w") as file:
                rng = np.random.default_rng(1)
                file.attrs["time_s"] = 8.0
                file["position_m"] = rng.uniform([-6, 0, 0], [3, 4, 2], (500, 3))
                file["velocity_m_s"] = rng.uniform(0, 9, (500, 3))
                file["volume_ratio"], file["reference_volume_m3"] = np.ones(500), np.full(500, 0.05**3)
                file["kirchhoff_stress_pa"] = -1e4 * np.ones((500, 6))


class LoadsOfARun(DesignFolder):
    def loads(self):
        return Loads(Run(self.folder / "runs" / "soft_w11"))

    def test_are_about_the_axis_of_the_mast(self):
        loads = self.loads()
        np.testing.assert_allclose(loads.moment, (1.5 + 0.5 * 0.1) * loads.force)  # M_y + x F_z

    def test_tell_first_impact_and_steady_peak_apart(self):
        values = self.loads().values
        force = 1.1e5
        self.assertAlmostEqual(values["force_first_impact_n"].value, 2 * force, delta=1.0)  # flat top of 0.6 s
        peak = force * (1 + 0.1 * np.mean(np.sin(2 * np.pi * (0.125 + 0.01 * np.arange(-5, 6)) / 0.5)))  # eleven rows about the crest
        self.assertAlmostEqual(values["force_steady_peak_n"].value, peak, delta=0.002 * force)  # the crest lies between two rows
        self.assertAlmostEqual(values["force_steady_peak_n"].known / values["force_steady_peak_n"].value, 0.02)

    def test_vibrate_by_the_part_of_the_load_that_each_mode_feels(self):
        loads, plan = self.loads(), {**self.plan, "mast": {**self.plan["mast"], "height_m": 12.0}}
        values = loads.vibration_values(plan)
        # A uniform load up to a quarter of the height: phi of the first mode is 1.758 zeta^2 near the ground, less its slope
        self.assertAlmostEqual(values["mode_1_hz_shape_at_load"].value, 0.034, delta=0.002)
        at_the_top = np.max(equivalent_static_force(loads.interval, loads.force, 1.0, 0.02))
        self.assertLess(values["force_with_vibration_n"].value, 0.8 * at_the_top)
        self.assertGreater(values["moment_with_vibration_n_m"].value, 1.1 * loads.values["moment_first_impact_n_m"].value)
        self.assertLess(values["force_with_vibration_steady_n"].value, values["force_with_vibration_n"].value)

    def test_vibrate_as_a_whole_where_the_height_of_the_mast_is_not_known(self):
        loads, plan = self.loads(), {**self.plan, "mast": {**self.plan["mast"], "height_m": None}}
        whole = np.max(equivalent_static_force(loads.interval, loads.force, 1.0, 0.02))
        self.assertAlmostEqual(loads.vibration_values(plan)["force_with_vibration_n"].value / whole, 1.0, delta=0.05)  # 0.1 s of smoothing

    def test_vibrate_alike_when_mast_and_load_are_scaled_together(self):
        loads, plan = self.loads(), {**self.plan, "mast": {**self.plan["mast"], "height_m": 18.0}}
        before, after = loads.with_vibration(self.plan), loads.scaled(2.0, 1.5, 1.0).with_vibration(plan)
        np.testing.assert_allclose(after["force"], 2.0 * before["force"])
        np.testing.assert_allclose(after["moment"], 3.0 * before["moment"])
        slower, mode = loads.scaled(1.0, 1.0, 2.0), {**self.plan["modes"][0], "frequency_hz": 0.5}
        factors = [of.with_vibration({**self.plan, "modes": modes})["modes"] for of, modes in ((loads, self.plan["modes"]), (slower, [mode]))]
        self.assertAlmostEqual(factors[1][0.5][1] / factors[0][1.0][1], 1.0, delta=0.02)  # the mean over 0.1 s is half as many rows

    def test_take_the_shape_at_the_load_of_the_site_file(self):
        mode = {**self.plan["modes"][0], "shape_at_load": 0.5}
        np.testing.assert_allclose(self.loads().generalised_force(mode, 1, self.plan["mast"]), 0.5 * self.loads().force)

    def test_have_a_drag_coefficient_over_width_and_depth(self):
        self.assertAlmostEqual(self.loads().values["drag_coefficient"].value, 1.1e5 / (0.5 * 300 * 9.81**2 * 1.0 * 2.0))

    def test_are_over_the_width_across_the_flow(self):
        drag, mean = self.loads().values["drag_coefficient"].value, self.loads().profiles["mean"]
        self.write("runs/soft_w11/obstacle.json", '{"outline_m": [[0, -1], [1, -1], [1, 1], [0, 1]], "top_m": null}')  # 1 m wide, 2 m deep, turned by 90 degrees
        self.assertAlmostEqual(self.loads().values["drag_coefficient"].value, 0.5 * drag)
        np.testing.assert_allclose(self.loads().profiles["mean"], 0.5 * mean)

    def test_have_profiles_whose_integral_is_the_force(self):
        profiles = self.loads().profiles
        self.assertAlmostEqual(0.2 * profiles["mean"].sum() / 1.1e5, 1.0, delta=0.01)  # the ripple's mean over ten periods
        self.assertAlmostEqual(profiles["first_impact"].max() / (2 * 1.1e5 / 3), 1.0, delta=1e-6)


class ResultsOfADesign(DesignFolder):
    def test_have_the_limit_of_the_grids_within_their_uncertainty(self):
        entry = Results(Ensemble(self.folder)).table[0]["force_mean_n"]
        self.assertAlmostEqual(entry.value, 1.1e5)
        self.assertAlmostEqual(entry.gci, 1.25 * 1e4, delta=1.0)  # first order: the limit is 1e5
        self.assertEqual(entry.grid, entry.gci)  # larger than the known 2 %
        self.assertAlmostEqual(entry.total, math.hypot(12500, 2.776 * 500), delta=1.0)  # effective samples not stated: Student's t of 5 batches

    def test_take_the_known_uncertainty_where_the_grids_agree(self):
        entry = Results(Ensemble(self.folder)).table[0]["pressure_height_mean_m"]
        self.assertEqual((entry.gci, entry.grid), (0.0, 0.1))
        self.assertIn("known", entry.note)
        self.assertNotIn("known", entry.method)

    def test_have_the_height_at_which_the_line_load_acts(self):
        results = Results(Ensemble(self.folder))
        low, high, loads, _ = results.line_loads(self.plan)
        centroid = loads["mean"] @ (0.5 * (low + high)) / loads["mean"].sum()
        self.assertAlmostEqual(results.table[1]["resultant_height_m"].value, 1.55)  # moment over force
        upper = results.ranges["moment_mean_n_m"].high / results.ranges["force_mean_n"].high
        self.assertAlmostEqual(centroid / upper, 1.0, delta=0.01)

    def test_range_from_the_least_minus_to_the_greatest_plus_its_uncertainty(self):
        results = Results(Ensemble(self.folder))
        soft, firm = (row["force_mean_n"] for row in results.table)
        r = results.ranges["force_mean_n"]
        self.assertAlmostEqual(r.low, soft.value - soft.total)
        self.assertAlmostEqual(r.high, firm.value + firm.total)

    def test_design_with_the_largest_upper_value(self):
        ensemble = Ensemble(self.folder)
        key, force = Results(ensemble).headline("force")
        self.assertIn(key, ("force_with_vibration_n", "force_first_impact_n"))  # the blow of 0.6 s; the mode feels 3 % of it
        self.assertEqual(force, Results(ensemble).ranges[key].high)

    def test_design_with_the_mean_where_its_uncertainty_is_greatest(self):
        for run in self.runs:
            path = self.folder / "runs" / run["name"] / "results.json"
            path.write_text(json.dumps({**json.loads(path.read_text()), "force_standard_error_n": [1e6, 0, 0], "overturning_moment_standard_error_n_m": 1e6}))
        results = Results(Ensemble(self.folder))
        self.assertEqual([results.headline("force")[0], results.headline("moment", steady_only=True)[0]], ["force_mean_n", "moment_mean_n_m"])
        self.assertEqual(results.snow_upper(1), (results.headline("force")[1], results.headline("moment")[1]))

    def test_tell_what_the_first_impact_adds(self):
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        key, force = results.headline("force", steady_only=True)
        self.assertIn(key, ("force_steady_peak_n", "force_with_vibration_steady_n"))
        self.assertLess(force, results.headline("force")[1])

    def test_end_the_run_up_at_bernoullis_bound(self):
        for run in self.runs:
            path = self.folder / "runs" / run["name"] / "results.json"
            path.write_text(json.dumps({**json.loads(path.read_text()), "runup_numerical_uncertainty_m": 4.0,
                                        "runup_p99_numerical_uncertainty_m": 4.0}))
        for key in ("runup_mean_m", "runup_p99_mean_m"):
            self.assertAlmostEqual(Results(Ensemble(self.folder)).ranges[key].high, 2.0 + 9.81 / 2)

    def test_state_the_greater_of_steady_run_up_and_first_splash_with_its_uncertainty(self):
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        what, value, why = headlines.design_rows(ensemble, results)[-1]
        self.assertIn("run-up", what)
        splash = results.ranges["runup_peak_m"]
        self.assertGreater(splash.high, max(6.0, results.ranges["runup_p99_mean_m"].high))
        self.assertEqual(value, rounding.upward(splash.high) + " m")
        self.assertIn("highest particle at any time: 6.00 m on the finest grid", why)

    def test_do_not_determine_a_run_up_whose_uncertainty_is_more_than_a_third_of_it(self):
        for run in self.runs:
            path = self.folder / "runs" / run["name"] / "results.json"
            path.write_text(json.dumps({**json.loads(path.read_text()), "runup_numerical_uncertainty_m": 2.5}))
        ensemble = Ensemble(self.folder)
        _, value, why = headlines.design_rows(ensemble, Results(ensemble))[-1]
        self.assertIn("not determined (6.0 ± 3.1 m)", value)
        self.assertIn("finest_cells = 15", why)
        self.assertRegex(why, "keep parts above [0-9.]+ m[.]")

    def test_give_no_height_above_which_parts_are_safe_from_a_pile_that_can_grow(self):
        path = self.folder / "runs" / "firm_w11" / "series.csv"
        series = pd.read_csv(path)
        series.assign(runup_m=3.0 + 0.4 * series.time_s, runup_p99_m=2.5 + 0.4 * series.time_s).to_csv(path, index=False)  # highest at the end, not in the splash
        ensemble = Ensemble(self.folder)
        _, value, why = headlines.design_rows(ensemble, Results(ensemble))[-1]
        self.assertTrue(value.startswith("not determined (still growing, "), value)
        self.assertRegex(why, "keep parts above [0-9.]+ m at least: the pile can become higher")
        self.assertIn("highest particle at any time: 6.20 m", why)
        self.assertNotIn("splash", why)

    def test_name_quantities_whose_grids_are_too_coarse_and_the_grid_to_plan(self):
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        self.assertFalse(any("too coarse" in text for text, _ in cautions.advice_rows(ensemble, results)))
        for row in results.table:
            row["moment_mean_n_m"] = row["moment_mean_n_m"]._replace(grid=0.5 * row["moment_mean_n_m"].value)
        self.assertTrue(any("mean moment 50 %" in text and "finest_cells = 15" in text for text, _ in cautions.advice_rows(ensemble, results)))
        key, force = results.headline("force")
        firm = results.table[1]
        firm[key] = firm[key]._replace(grid=0.6 * firm[key].value, total=0.6 * firm[key].value)
        results.ranges[key] = results.ranges[key]._replace(high=firm[key].upper)
        self.assertTrue(any("design force 60 %" in text for text, _ in cautions.advice_rows(ensemble, results)))
        self.assertRegex(headlines.design_rows(ensemble, results)[0][2], r"^upper value of: force.*, 2\d\d ± 1\d\d kN \(firm\)\.")

    def test_offer_the_greatest_pressure_height_and_name_the_others(self):
        ensemble = Ensemble(self.folder)
        what, value, why = headlines.design_rows(ensemble, Results(ensemble))[2]
        self.assertEqual(value, "6.00 m")  # 3 H; the simulation has 3.0 m
        for part in ("3 H", "simulation", "equations", "They differ because"):
            self.assertIn(part, why)

    def test_hold_the_headline_among_the_reactions_whichever_governs(self):
        ensemble = Ensemble(self.folder)
        for governing in STEADY_FORCES + IMPACT_FORCES:
            results = Results(ensemble)
            results.ranges[governing] = results.ranges[governing]._replace(high=1e7)
            self.assertEqual(results.headline("force"), (governing, 1e7))
            self.assertIn("10000 kN", [row[1] for row in page_tables.reaction_table(ensemble, results)["rows"]])

    def test_round_upper_values_alike_wherever_they_stand(self):
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        key, moment = results.headline("moment")
        results.ranges[key] = results.ranges[key]._replace(high=580100.0)  # 580 to the nearest, 581 rounded up
        at = [q.key for q in results.shown(self.plan)].index(key)
        self.assertTrue(page_tables.load_table(ensemble, results)["rows"][at][-1].endswith(" to 581"))
        self.assertEqual(headlines.design_rows(ensemble, results)[1][1], "581 kN m")
        self.assertEqual(page_tables.line_load_table(results, self.plan)["rows"][-1][-1], "581")
        self.assertIn("581 kN m", [row[2] for row in page_tables.reaction_table(ensemble, results)["rows"]])

    def test_warn_once_of_a_load_of_the_guideline_that_is_greater(self):
        plan = {**self.plan, "mast": {**self.plan["mast"], "drag_coefficient": 9.0}}
        self.write("design_plan.json", json.dumps(plan))
        ensemble = Ensemble(self.folder)
        greater = [text for text, _ in cautions.advice_rows(ensemble, Results(ensemble)) if "is greater than the computed one" in text]
        self.assertEqual(len(greater), 1)
        self.assertRegex(greater[0], r"a force of .* kN against .* and a moment of .* kN m against .* It reaches to 6.00 m")

    def test_explain_in_few_notes_how_the_grids_were_judged(self):
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        for snow, row in enumerate(results.table):  # orders differ from quantity to quantity
            row["force_mean_n"] = row["force_mean_n"]._replace(order=1.0 + 0.5 * snow)
        table = page_tables.grid_table(ensemble, results)
        at = table["head"].index("order")
        self.assertEqual([row[at] for row in table["rows"] if row[0].startswith("force downstream")], ["1.0", "1.5"])
        self.assertLess(len(table["notes"]), 5)
        self.assertFalse([note for note in table["notes"] if re.search("order -?[0-9]", note)])

    def test_name_runs_that_are_missing(self):
        (self.folder / "runs" / "firm_w5" / "results.json").unlink()
        with self.assertRaisesRegex(InputError, "^1 run is not finished, or of another site, first .*firm_w5"):
            Ensemble(self.folder)

    def test_refuse_runs_of_another_site_or_duration_and_what_mpm_post_wrote(self):
        path = self.folder / "runs" / "firm_w5" / "results.json"
        results = json.loads(path.read_text())
        for change in ({"case_hash": "another"}, {"duration_s": 7.0}, {"measured_from": "frames"}, {"duration_s": None}):
            path.write_text(json.dumps({**results, **change}))
            with self.assertRaisesRegex(InputError, "^1 run is not finished, or of another site, first .*firm_w5"):
                Ensemble(self.folder)
        path.write_text(json.dumps({**results, "duration_s": 7.0, "stopped_when_steady": True}))
        self.assertEqual(len(Ensemble(self.folder).runs), 2)

    def test_refuse_a_plan_that_does_not_name_its_cases(self):
        self.write("design_plan.json", json.dumps({**self.plan, "runs": [{k: r[k] for k in ("name", "snow", "grid")} for r in self.runs]}))
        with self.assertRaisesRegex(InputError, "mpm design SITE --page"):
            Ensemble(self.folder)

    def test_refuse_a_plan_or_a_case_that_was_altered(self):
        plan = json.dumps({**self.plan, "crc32": "0" * 8})
        self.write("design_plan.json", plan.replace("0" * 8, checksum(plan.encode())))
        self.assertEqual(len(Ensemble(self.folder).runs), 2)
        self.write("design_plan.json", (self.folder / "design_plan.json").read_text().replace("9.81", "9.71", 1))
        with self.assertRaisesRegex(InputError, "design_plan.json: it does not match its checksum; run `mpm design` again"):
            Ensemble(self.folder)
        self.write("design_plan.json", json.dumps(self.plan))
        case = self.folder / "runs" / "firm_w5" / "case.toml"
        case.write_text(case.read_text().replace("density_kg_m3 = 300", "density_kg_m3 = 900"))
        with self.assertRaisesRegex(InputError, "firm_w5/case.toml: it is not of the site: material.density_kg_m3 is 900.0, by the site 300.0; put back"):
            Ensemble(self.folder)

    def test_refuse_a_case_of_another_mast_flow_snow_or_grid(self):
        case = self.folder / "runs" / "firm_w5" / "case.toml"
        own = case.read_text()
        for old, new, difference in (
                ('shape = "box"', 'shape = "cylinder"', "obstacle.shape is cylinder, by the site box"), ("depth_m = 1.0", "depth_m = 2.0", "obstacle.depth_m is 2.0"),
                ("\nwidth_m = 1.0", "\nwidth_m = 1.1", "obstacle.width_m is 1.1"), ("height_m = 12.0\n", "", "obstacle.height_m is left out, by the site 12.0"),
                ("height_m = 12.0", "height_m = 1.5", "obstacle.height_m is 1.5"), ("friction = 0.15", "friction = 0.3", "obstacle.friction is 0.3, by the site 0.15"),
                ("friction = 0.15", "friction = 0.15\nrotation_deg = 45.0", "obstacle.rotation_deg is 45.0"),
                ("gravity_m_s2 = 9.81", "gravity_m_s2 = 20.0", "numerics.gravity_m_s2 is 20.0"), ("gravity_m_s2 = 9.81", "gravity_m_s2 = 9.81\nslope_deg = 20.0", "numerics.slope_deg is 20.0"),
                ("velocity_m_s = 9.81", "velocity_m_s = 20.0", "conveyor.velocity_m_s is 20.0"), ("flow_height_m = 2.0", "flow_height_m = 1.0", "conveyor.flow_height_m is 1.0"),
                ("critical_state_slope = 0.9", "critical_state_slope = 0.5", "material.critical_state_slope is 0.5, by the site 0.9"),
                ("hardening_xi = 5.0", "hardening_xi = 0.5", "material.hardening_xi is 0.5"), ("cell_size_m = 0.2", "cell_size_m = 0.3", "numerics.cell_size_m is 0.3"),
                ("[numerics]", "[arm]\nlength_m = 4.0\n[numerics]", "arm.length_m is 4.0, by the site left out")):
            self.assertEqual(own.count(old), 1, old)
            case.write_text(own.replace(old, new))
            with self.assertRaisesRegex(InputError, f"firm_w5/case.toml: it is not of the site: {difference}"):
                Ensemble(self.folder)
        case.write_text(own)
        self.assertEqual(len(Ensemble(self.folder).runs), 2)
        self.change_cases("height_m = 12.0", "")
        self.write("design_plan.json", json.dumps({**self.plan, "mast": {**self.plan["mast"], "height_m": None}}))
        self.assertEqual(len(Ensemble(self.folder).runs), 2)

    def test_name_a_folder_that_is_no_design(self):
        with self.assertRaisesRegex(InputError, "give the folder of `mpm design`"):
            Ensemble(self.folder / "runs")


class Comparisons(DesignFolder):
    def test_give_the_guideline_above_ground_with_both_width_factors(self):
        rows = comparison.guideline_rows(self.plan)
        head = 9.81**2 / (2 * 9.81)
        self.assertAlmostEqual(rows[0][1], 2.0 + head)
        self.assertAlmostEqual(rows[1][1], 2.0 + head / 1.5 * (1 - math.exp(-1.14 * 0.5)))
        self.assertAlmostEqual(rows[2][1], 2.0 + head / 1.5 * 0.7)

    def test_give_the_load_of_the_guideline_with_its_extents(self):
        rows = comparison.guideline_loads(self.plan)
        line = 2.0 * 0.5 * 300.0 * 9.81**2  # N/m, a box 1 m wide
        self.assertAlmostEqual(rows[0].force, 2.0 * line)
        self.assertAlmostEqual(rows[0].moment, 2.0 * line)  # at half of 2 m
        self.assertAlmostEqual(rows[1].force, line * (2.0 + 0.5 * (rows[1].extent - 2.0)))
        self.assertAlmostEqual((rows[2].extent, rows[2].force, rows[2].moment), (6.0, 6.0 * line, 18.0 * line))
        self.assertAlmostEqual(rows[3].force, 8.0 * 300.0 * 9.81 * 2.0)
        own = {**self.plan, "mast": {**self.plan["mast"], "drag_coefficient": 3.0}}
        self.assertAlmostEqual(comparison.guideline_loads(own)[0].force, 3.0 * line)

    def test_warn_where_the_drag_coefficient_leaves_the_quoted_range(self):
        self.assertEqual(comparison.drag_remark(self.plan, 1.2, 1.9), "")
        self.assertIn("above the 1 to 2", comparison.drag_remark(self.plan, 1.2, 3.3))
        self.assertIn("below the 1 to 2", comparison.drag_remark(self.plan, 0.7, 0.9))

    def test_compare_only_snow_that_may_be_wet_with_wet_avalanches(self):
        for snow_class, wet in ((None, True), ("warm_cohesive", True), ("cold_dense", False), ("loose", False)):
            plan = {**self.plan, "flow": {**self.plan["flow"], "snow_class": snow_class}}
            self.assertEqual("Wet avalanches" in comparison.drag_remark(plan, 1.2, 3.3), wet)
            self.assertEqual(any("slow wet snow" in row.what for row in comparison.guideline_loads(plan)), wet)

    def test_give_the_equations_for_each_snow_and_say_what_they_were_fitted_to(self):
        rows = comparison.equation_rows(self.plan)
        self.assertAlmostEqual(rows[0]["runup_m"], 2.0 * (1 + 0.9468 * 0.5) + 0.5 * 9.81 * math.exp(-1.5745 * 0.5), places=6)
        self.assertEqual(comparison.equation_remarks(self.plan), ["w/H = 0.50 (fitted: 1)"])

    def test_take_the_width_across_the_flow_of_a_turned_box(self):
        flow = {**self.plan["flow"], "depth_m": 1.0}
        plan = {**self.plan, "flow": flow}

        def said(width, depth, angle):
            turned = {**plan, "mast": {**plan["mast"], "width_m": width, "depth_m": depth, "angle_deg": angle}}
            return (comparison.guideline_rows(turned), comparison.guideline_loads(turned), comparison.equation_remarks(turned), comparison.known_uncertainty_remark(turned))

        for quarter in (90.0, -90.0):
            self.assertEqual(said(1.0, 2.0, quarter), said(2.0, 1.0, 0.0))
        self.assertEqual(said(1.0, 2.0, 90.0)[2], ["w/H = 2.00 (fitted: 1)"])
        *_, loads, remarks, known = said(1.0, 1.0, 45.0)
        self.assertAlmostEqual(loads[0].force / said(1.0, 1.0, 0.0)[1][0].force, math.sqrt(2.0))
        self.assertEqual(remarks, ["a mast that is no box with its face against the flow", "w/H = 1.41 (fitted: 1)"])
        self.assertIn("(turned, w/H = 1.41)", known)

    def test_say_to_which_mast_the_known_uncertainties_belong(self):
        self.assertIn("This mast (w/H = 0.50)", comparison.known_uncertainty_remark(self.plan))
        square = {**self.plan, "mast": {**self.plan["mast"], "width_m": 2.0}}
        self.assertEqual(comparison.known_uncertainty_remark(square), "")
        self.assertIn("(round)", comparison.known_uncertainty_remark({**square, "mast": {**square["mast"], "shape": "cylinder"}}))


MEASURED = ["force", "moment", "impact", "impact_moment"]


def pair_errors(runs):
    """Logarithms of what runs of the same snow at two Froude numbers have, over what the scaling gives from one to the other."""
    pairs = []
    for _, snow in runs.groupby(["critical_state_slope", "cohesion_beta", "hardening_xi"]):
        for a in snow.to_dict("records"):
            for b in snow.to_dict("records"):
                if a["froude_number"] < b["froude_number"]:
                    own = scaling.drag_coefficient(b["effective_friction"], b["froude_number"]) / scaling.drag_coefficient(a["effective_friction"], a["froude_number"])
                    pairs.append([a["froude_number"], b["froude_number"], *(math.log(b[q] / a[q] / own) for q in MEASURED)])
    return pd.DataFrame(pairs, columns=["slow", "fast", *MEASURED])


class Scaling(DesignFolder):
    """Loads of another avalanche from those that were computed, against the runs of the study."""

    @classmethod
    def setUpClass(cls):
        runs = pd.read_csv(SOURCE / "validation" / "study" / "rows" / "prediction_w5.csv", comment="#")
        runs = runs[runs.steady == 1]
        head = 0.5 * 300.0 * runs.velocity_m_s**2 * runs.obstacle_width_m * runs.flow_height_m
        runs = runs.assign(force=runs["force_mean_n.x"] / head, moment=runs.overturning_moment_mean_n_m / head, impact=runs.force_filtered_peak_n / head,
                           impact_moment=runs.overturning_moment_filtered_peak_n_m / head)
        fitted = runs.effective_friction.between(scaling.FITTED[0] - 1e-3, scaling.FITTED[1] + 1e-3)
        cls.study, cls.beyond = runs[fitted], runs[~fitted]

    def test_has_the_coefficients_that_fit_the_runs(self):
        def excess(p):
            c = np.exp(p[0] + p[1] * self.study.effective_friction) + np.exp(p[2] + p[3] * self.study.effective_friction) / self.study.froude_number**2
            return np.log(c / self.study.force)

        fit = scipy.optimize.least_squares(excess, [0.2, 0.3, 0.4, 1.9])
        np.testing.assert_allclose([*scaling.INERTIA, *scaling.WEIGHT], fit.x, atol=6e-4)  # written with three decimals
        self.assertLess(np.sqrt(np.mean(fit.fun**2)), 0.12)  # as the page states
        self.assertEqual(len(self.study), scaling.RUNS)  # as the page states

    def test_states_an_error_that_covers_every_group_of_runs(self):
        pairs = pair_errors(self.study)
        worst = dict.fromkeys((error for _, error in scaling.ERRORS), 0.0)
        for (slow, fast), group in pairs.groupby(["slow", "fast"]):
            rms = np.sqrt((group[MEASURED] ** 2).mean()).max()
            stated = scaling.scaling_error(slow, fast)
            worst[stated] = max(worst[stated], rms)
        for stated, rms in worst.items():
            self.assertLessEqual(rms, stated)
            self.assertGreater(rms, 0.8 * stated, "stated too large")

    def test_goes_on_beyond_the_fit_only_as_far_as_runs_allow(self):
        end = scaling.FITTED[1] * scaling.CONTINUED
        beyond = self.beyond[(self.beyond.effective_friction > end) & (self.beyond.effective_friction < 1.1 * end)]
        self.assertEqual(len(beyond), 17, "those of M' 1.76")
        pairs = pair_errors(beyond)
        pairs["stated"] = [scaling.scaling_error(slow, fast, end) for slow, fast in zip(pairs.slow, pairs.fast)]
        for stated, group in pairs.groupby("stated"):
            self.assertLessEqual(np.sqrt((group[MEASURED] ** 2).mean()).max(), stated)

    def test_gives_nothing_for_snow_beyond_the_fit_but_at_the_same_froude_number(self):
        computed = scaling.Avalanche(2.0, 10.0, 300.0)
        for friction, known in ((0.4, True), (1.62, True), (2.3, False), (0.3, False)):
            scaled = scaling.factors(computed, computed._replace(velocity=8.0), friction, 9.81)
            self.assertEqual([math.isfinite(scaled.force), math.isfinite(scaled.moment), math.isfinite(scaled.error)], [known] * 3)
            self.assertAlmostEqual(scaling.factors(computed, computed._replace(density=450.0), friction, 9.81).force, 1.5)
        ensemble = Ensemble(self.folder)
        ensemble.plan["snows"][1]["effective_friction"] = 2.3
        ensemble.plan["scenarios"] = [{"name": name, "depth_m": 2.0, "velocity_m_s": v, "density_kg_m3": density} for name, v, density in (
            ("slow", 8.0, 300.0), ("dense", self.plan["flow"]["velocity_m_s"], 450.0))]
        results = Results(ensemble)
        table = what_decides.scenario_table(ensemble, results)
        self.assertEqual([table["rows"][1][5:], table["rows"][2][-1]], [["–"] * 5, "none"])
        self.assertIn("Scenario slow: not scaled: firm M' 2.3 is beyond the fit (M' 0.4 to 1.53, continued to 1.68); compute it", table["note"])
        rows = what_decides.sensitivity_rows(ensemble, results)
        self.assertEqual([row[0] for row in rows if "scaling" in row[0]], ["density ± 20 %, scaling"])
        self.assertIn("Depth and speed are not scaled: firm M' 2.3", what_decides.ensemble_text(ensemble, results, rows))
        self.assertEqual(comparison.own_drag_source(ensemble.plan)[1::2], ("–", "beyond its M' 0.4 to 1.53: firm M' 2.3"))

    def test_is_exact_for_density_and_leaves_the_computed_avalanche_as_it_is(self):
        computed = scaling.Avalanche(2.0, 10.0, 300.0)
        self.assertEqual(scaling.factors(computed, computed, 0.8, 9.81), (1.0, 1.0, 1.0, 1.0, 0.0))
        self.assertEqual(scaling.factors(computed, computed._replace(density=450.0), 0.8, 9.81), (1.5, 1.5, 1.0, 1.0, 0.0))

    def test_lets_the_modes_feel_more_of_a_deeper_flow(self):
        for given in (None, 0.03):
            plan = {**self.plan, "modes": [{**self.plan["modes"][0], "shape_at_load": given}]}
            self.write("design_plan.json", json.dumps(plan))
            results = Results(Ensemble(self.folder))
            force, moment = results.scaled_upper(plan, 1, 2.0, 1.3, 1.0)  # as long, and higher
            self.assertGreater(force, 1.01 * 2.0 * results.snow_upper(1)[0])
            self.assertGreater(moment, 1.05 * 2.0 * 1.3 * results.snow_upper(1)[1])
            same = results.scaled_upper(plan, 1, 2.0, 1.0, 1.0)
            np.testing.assert_allclose(same, 2.0 * np.array(results.snow_upper(1)))
        nothing = {key: entry._replace(value=0.0) for key, entry in results.table[1].items()}
        results.table[1] = nothing
        self.assertTrue(np.isfinite(results.scaled_upper(plan, 1, 2.0, 1.3, 1.0)).all(), "no snow at the mast")

    def test_is_proportional_to_the_weight_in_slow_and_to_the_head_in_fast_flow(self):
        slow, fast = scaling.Avalanche(2.0, 0.1, 300.0), scaling.Avalanche(2.0, 200.0, 300.0)
        self.assertAlmostEqual(scaling.factors(slow, slow._replace(velocity=0.2), 0.8, 9.81).force, 1.0, delta=0.01)
        self.assertAlmostEqual(scaling.factors(slow, slow._replace(depth=4.0), 0.8, 9.81).moment, 8.0, delta=0.1)
        self.assertAlmostEqual(scaling.factors(fast, fast._replace(velocity=100.0), 0.8, 9.81).force, 0.25, delta=0.01)

    def test_of_the_site_is_what_its_runs_gave(self):
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        force, moment, error = scaling.scaled_loads(results, self.plan, scaling.avalanche_of(self.plan))
        self.assertEqual((force, moment, error), (results.headline("force")[1], results.headline("moment")[1], 0.0))

    def test_gives_scenarios_and_warns_of_a_greater_one(self):
        flow = self.plan["flow"]
        scenarios = [{"name": "denser", "depth_m": flow["depth_m"], "velocity_m_s": flow["velocity_m_s"], "density_kg_m3": 600.0},
                     {"name": "small", "depth_m": 1.0, "velocity_m_s": 8.0, "density_kg_m3": 300.0}]
        self.write("design_plan.json", json.dumps({**self.plan, "scenarios": scenarios}))
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        computed, denser, small = what_decides.scenario_rows(ensemble, results)
        self.assertAlmostEqual(denser[2] / computed[2], 2.0)
        self.assertLess(small[3], 0.5 * computed[3])
        self.assertEqual((denser[4], denser[5]), (0.0, computed[5]))
        text = " ".join(text for text, _ in cautions.advice_rows(ensemble, results))
        self.assertIn("Scenario denser gives more", text)
        self.assertNotIn("Scenario small", text)
        table = what_decides.scenario_table(ensemble, results)
        self.assertEqual((len(table["rows"]), table["note"]), (3, ""))
        self.assertEqual([row[-1] for row in table["rows"][:2]], ["none", "none"])

    def test_marks_scenarios_like_the_headlines(self):
        self.plan["scenarios"] = [{"name": "300", "depth_m": 2.2, "velocity_m_s": 10.0, "density_kg_m3": 300.0}]
        self.write("design_plan.json", json.dumps(self.plan))
        for error, steady in ((0.3, True), (2.5, True), (0.3, False)):
            for run in self.runs:
                path = self.folder / "runs" / run["name"] / "results.json"
                known = {**json.loads(path.read_text()), "runup_numerical_uncertainty_m": error}
                path.write_text(json.dumps(known if steady else {key: None if "mean" in key or "steady" in key else value for key, value in known.items()}))
            ensemble = Ensemble(self.folder)
            results = Results(ensemble)
            determined = not headlines.design_rows(ensemble, results)[-1][1].startswith("not determined")
            self.assertEqual(determined, (error, steady) == (0.3, True))
            for row in what_decides.scenario_table(ensemble, results)["rows"]:
                self.assertEqual((row[8] == "not determined", row[5].endswith(", not steady"), row[6].endswith(", not steady")), (not determined, not steady, not steady))
            self.assertEqual(data_files.design_json(ensemble, results)["scenarios"][0]["runup_is_determined"], determined)

    def test_has_no_error_and_no_loads_beyond_the_flows_of_the_fit(self):
        for before, after, error in ((3.0, 7.0, 0.22), (0.1, 7.0, 0.38), (7.0, 0.1, 0.38), (3.0, 7.1, math.nan), (0.09, 3.0, math.nan), (9.0, 9.0, 0.0), (9.0, 8.0, math.nan)):
            np.testing.assert_equal(scaling.scaling_error(before, after), error)
        speed = 285.0 * math.sqrt(19.62)
        scenarios = [{"name": name, "depth_m": 2.0, "velocity_m_s": v, "density_kg_m3": 300.0} for name, v in (("storm", speed), ("rest", 1e-9), ("faster", 12.0))]
        self.write("design_plan.json", json.dumps({**self.plan, "scenarios": scenarios}))
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        table = what_decides.scenario_table(ensemble, results)
        self.assertEqual([row[5:] for row in table["rows"][1:3]], [["–"] * 5] * 2)
        self.assertEqual(table["rows"][3][-1], "± 13 %")
        self.assertIn("Scenario storm, rest: no loads", table["note"])
        self.assertIn("fitted to Fr 0.1 to 7", table["note"])
        self.assertIn((table["note"], ""), cautions.advice_rows(ensemble, results))
        _, storm, rest, faster = data_files.design_json(ensemble, results)["scenarios"]
        self.assertEqual([(s["force_n"], s["moment_n_m"], s["scaling_error"], s["pressure_height_m"], s["runup_m"]) for s in (storm, rest)], [(None,) * 5] * 2)
        self.assertEqual(faster["scaling_error"], 0.13)
        text, _ = self.drawn_page()
        self.assertIn(table["note"], text)
        self.assertEqual(numbers_that_are_none(text), [])

    def test_says_where_ranges_and_the_site_are_beyond_the_flows_of_the_fit(self):
        for froude, beyond in ((3.0, False), (6.0, True), (7.5, True)):
            flow = {**self.plan["flow"], "froude_number": froude, "gravity_m_s2": 9.81 * (self.plan["flow"]["froude_number"] / froude) ** 2}
            ensemble = Ensemble(self.folder)
            ensemble.plan["flow"] = flow
            results = Results(ensemble)
            said = what_decides.ensemble_text(ensemble, results, what_decides.sensitivity_rows(ensemble, results))
            self.assertEqual("its error beyond is not known" in said, beyond, said)
            self.assertEqual(comparison.own_drag_source(ensemble.plan)[1] == "–", froude > 7.0)


class Factors(DesignFolder):
    table = pd.DataFrame([{"kind": "shape", "name": "cylinder", "quantity": "force", "froude_number": froude, "effective_friction": m,
                           "factor": 0.6 + 0.1 * np.log(froude) + 0.2 * m, "uncertainty": 0.1} for froude in (0.3, 3.0, 7.0) for m in (0.4, 1.2)])

    def test_is_linear_in_the_logarithm_of_the_froude_number_and_in_the_friction_of_the_snow(self):
        for froude, m in ((0.3, 0.4), (1.0, 0.9), (7.0, 1.2)):
            factor, uncertainty = factor_at(self.table, "shape", "cylinder", "force", froude, m)
            self.assertAlmostEqual(factor, 0.6 + 0.1 * np.log(froude) + 0.2 * m)
            self.assertAlmostEqual(uncertainty, 0.1)

    def test_outside_the_flows_of_the_table_is_refused(self):
        for froude, m, message in ((8.0, 0.4, "Fr = 8 is outside 0.3 to 7"), (3.0, 1.3, "M' = 1.3 is outside 0.4 to 1.2")):
            with self.assertRaisesRegex(InputError, message):
                factor_at(self.table, "shape", "cylinder", "force", froude, m)
        with self.assertRaisesRegex(InputError, "no factor of the moment for shape 'cylinder'"):
            factor_at(self.table, "shape", "cylinder", "moment", 3.0, 0.4)

    def test_beside_a_flow_that_the_table_lacks_are_refused(self):
        part = self.table[~((self.table.froude_number == 7.0) & (self.table.effective_friction == 1.2))]
        self.assertAlmostEqual(factor_at(part, "shape", "cylinder", "force", 5.0, 0.4)[0], 0.6 + 0.1 * np.log(5.0) + 0.08)
        with self.assertRaisesRegex(InputError, "lacks a flow beside it"):
            factor_at(part, "shape", "cylinder", "force", 5.0, 0.8)

    def arms(self, froude):
        """Drag coefficients M' and 2 M' for undersides at 1 and 2 H, the lift a quarter of them, the uncertainty of the first 0.1."""
        return pd.DataFrame([{"kind": "arm", "name": f"base_{base}", "quantity": quantity, "froude_number": froude, "effective_friction": m, "factor": base * share * m,
                              "uncertainty": uncertainty} for base in (1, 2) for quantity, share, uncertainty in (("drag", 1.0, 0.1), ("lift", 0.25, np.nan)) for m in (0.4, 1.2)])

    def test_of_arms_are_pressures_at_heights_for_the_snow_that_gives_most(self):
        ensemble, froude = Ensemble(self.folder), self.plan["flow"]["froude_number"]
        (heading, table, legend), = page_tables.factor_tables(ensemble, self.arms(froude * (1.0 + 1e-12)))
        self.assertEqual(heading, "Elements that protrude")
        head = 1e-3 * 0.5 * 300.0 * 9.81**2  # kPa; the firm snow has M' = 1
        self.assertEqual(table["rows"], [["2 m (1 H)", rounding.upward(1.1 * head), rounding.upward(0.25 * head)], ["4 m (2 H)", rounding.upward(2.1 * head), rounding.upward(0.5 * head)]])
        self.assertNotIn("Attention", legend)
        nothing = page_tables.factor_tables(ensemble, self.arms(froude).assign(factor=1e-6, uncertainty=np.nan))[0][1]["rows"]
        self.assertEqual(nothing[0][1:], ["0", "0"], "below 10 Pa")
        ensemble.plan["arm"] = {"base_m": 3.0}
        self.assertEqual(page_tables.factor_tables(ensemble, self.arms(froude)), [], "an arm of its own was computed")

    def test_outside_the_table_are_named_and_not_extrapolated(self):
        ensemble = Ensemble(self.folder)
        (_, table, legend), = page_tables.factor_tables(ensemble, self.arms(5.0))
        self.assertEqual(table["rows"], [])
        self.assertEqual(legend, "This flow is outside the table (Fr 5, M' 0.4 to 1.2).")
        ensemble.plan["snows"][1]["effective_friction"] = 1.5
        (_, table, legend), = page_tables.factor_tables(ensemble, self.arms(ensemble.plan["flow"]["froude_number"]))
        self.assertEqual(table["rows"][0][1], rounding.upward((0.5 + 0.1) * 1e-3 * 0.5 * 300.0 * 9.81**2), "the soft snow")
        self.assertIn("snow firm is outside the table", legend)

    def test_of_fronts_stand_beside_those_of_the_page(self):
        ensemble, froude = Ensemble(self.folder), self.plan["flow"]["froude_number"]
        table = pd.DataFrame([{"kind": "front", "name": "front_90_slip_1", "quantity": quantity, "froude_number": froude, "effective_friction": m, "factor": 1.5, "uncertainty": 0.0}
                              for quantity in ("peak_force", "lever_arm", "moment_over_plug", "runup_over_plug") for m in (0.4, 1.2)])
        (_, table, legend), = page_tables.factor_tables(ensemble, table, Results(ensemble))
        self.assertEqual(table["rows"], [["90°, slip 1", "1.5", "1.5", "1.5", "1.5"], ["this page: 90°, slip 1", "2", "0.775", "1", "1"]])  # twice the mean for 0.6 s; 1.55 m over 2 m
        self.assertIn("The runs have ξ = 5 and w = H = 1.75 m, w across the flow", legend)

    def test_come_from_runs_under_the_conditions_that_the_page_names(self):
        for name in ("shapes", "fronts", "arms"):
            rows = pd.read_csv(SOURCE / "validation" / "study" / "rows" / f"{name}.csv", comment="#")
            turned = rows["obstacle.rotation_deg"].fillna(0.0) if "obstacle.rotation_deg" in rows else pd.Series(0.0, rows.index)
            shapes = rows["obstacle.shape"].fillna("box") if "obstacle.shape" in rows else pd.Series("box", rows.index)
            for row, shape, angle in zip(rows.to_dict("records"), shapes, turned):
                width, _ = equations.across_flow(shape, row["obstacle_width_m"], row["obstacle_width_m"], angle)
                self.assertAlmostEqual(width, CONDITIONS["obstacle_width_m"], delta=1e-6)
                self.assertEqual((row["hardening_xi"], row["flow_height_m"]), (CONDITIONS["hardening_xi"], CONDITIONS["flow_height_m"]))

    def test_that_are_kept_say_where_they_come_from(self):
        self.assertRegex(FILE.read_text().splitlines()[0], r"^# made by ./run study --write from validation/study/rows/\w+\.csv \(commits [0-9a-f]+")
        self.assertEqual(list(load_factors().columns), ["key", "kind", "name", "quantity", "froude_number", "effective_friction", "factor", "uncertainty"])


class Arms(DesignFolder):
    """Each run with an arm from 3.6 to 4.4 m: a fifth of the run's force F at 4 m and 0.04 F upwards, and once more half of that from 0.9 to 1.1 s."""

    ARM = {"length_m": 4.0, "depth_m": 0.8, "base_m": 3.6, "height_m": 4.4}

    def setUp(self):
        super().setUp()
        for run in self.runs:
            self.give_arm(self.folder / "runs" / run["name"])
        self.plan["arm"] = self.ARM
        self.write("design_plan.json", json.dumps(self.plan))
        self.ensemble = Ensemble(self.folder)
        self.results = Results(self.ensemble)

    def give_arm(self, folder):
        with open(folder / "case.toml", "a", encoding="utf-8") as file:
            file.write("[arm]\n" + "".join(f"{key} = {value}\n" for key, value in self.ARM.items()))
        results, series = json.loads((folder / "results.json").read_text()), pd.read_csv(folder / "series.csv")
        force = results["force_mean_n"][0]
        along = 0.2 * force * (1.0 + 0.5 * (np.abs(series.time_s - 1.0) < 0.105))
        up = 0.2 * along
        parts = {"force_x_n": along, "force_y_n": 0.0, "force_z_n": up, "moment_x_n_m": 0.0, "moment_y_n_m": 4.0 * along - 0.5 * up, "moment_z_n_m": 0.0}
        series.assign(**{f"arm_{name}": values for name, values in parts.items()}).to_csv(folder / "series.csv", index=False)
        results |= {"arm_force_mean_n": [0.2 * force, 0, 0.04 * force], "arm_force_standard_error_n": [100.0, 0, 20.0],
                    "arm_moment_mean_n_m": [0, 0.78 * force, 0], "arm_moment_standard_error_n_m": [0, 400.0, 0]}
        (folder / "results.json").write_text(json.dumps(results))

    def test_load_the_foundation_once(self):
        entries, force = self.results.table[0], 1.1e5
        for key, value in (("force_first_impact_n", 2.2 * force), ("force_mean_n", 1.2 * force), ("mast_force_mean_n", force), ("arm_force_first_impact_n", 0.3 * force),
                           ("arm_lift_first_impact_n", 0.06 * force), ("moment_mean_n_m", (1.55 + 0.8) * force), ("mast_moment_mean_n_m", 1.55 * force),
                           ("moment_first_impact_n_m", (2 * 1.55 + 0.8) * force), ("arm_height_m", 4.0), ("drag_coefficient", force / (0.5 * 300 * 9.81**2 * 2.0))):
            self.assertAlmostEqual(entries[key].value / value, 1.0, delta=1e-6, msg=key)
        self.assertAlmostEqual(entries["force_mean_n"].standard_error, 600.0)
        self.assertAlmostEqual(entries["arm_force_mean_n"].known, 0.02 * 0.2 * force, msg="relatively that of the mast")
        reactions = page_tables.reaction_table(self.ensemble, self.results)["rows"]
        self.assertEqual(reactions[0][1], rounding.with_unit(rounding.upward(self.results.ranges["force_mean_n"].high, 1e-3), "kN"))
        self.assertEqual(reactions[2][3], "+9.24 to +31.7 kN")  # 6/10 of 0.14 F in the first row, F = 110 kN (soft); 0.24 F, F = 132 kN (firm)

    def test_have_headlines_of_their_own_that_follow_from_the_tables(self):
        data_files.write_tables(self.ensemble, self.results, figures.spectra(self.ensemble, self.results.finest))
        table = pd.read_csv(self.folder / "design.csv").set_index("quantity")
        rows = headlines.design_rows(self.ensemble, self.results)
        for (what, value, why), key in zip(rows[2:4], ("arm_force_first_impact_n", "arm_lift_first_impact_n")):
            self.assertTrue(what.startswith("arm (3.6 to 4.4 m above the ground)"), what)
            self.assertEqual(value, rounding.with_unit(rounding.upward((table.value + table.uncertainty)[key].max(), 1e-3), "kN"))
            self.assertIn("Steady mean: ", why)
        self.assertIn("The mean acts at 4 m. It is part of force and moment at the foundation, and of the vibration", rows[2][2])
        self.assertIn("arm included", rows[0][0])

    def test_are_designed_for_the_mean_where_its_uncertainty_is_greatest(self):
        self.results.ranges["arm_force_mean_n"] = self.results.ranges["arm_force_mean_n"]._replace(high=1e6)
        _, value, why = headlines.design_rows(self.ensemble, self.results)[2]
        self.assertEqual((value, why.count("teady mean")), ("1000 kN", 1))

    def test_act_with_the_line_load_on_the_mast(self):
        data_files.write_tables(self.ensemble, self.results, figures.spectra(self.ensemble, self.results.finest))
        line, arm = pd.read_csv(self.folder / "line_load.csv"), pd.read_csv(self.folder / "arm_load.csv").set_index("with_line_load")
        pieces, middle = line.z_to_m - line.z_from_m, 0.5 * (line.z_to_m + line.z_from_m)
        expected = {name: [self.results.ranges[f"{kind}_{name}_{unit}"].high for kind, unit in (("force", "n"), ("moment", "n_m"))]
                    for name in ("mean", "steady_peak", "first_impact")}
        expected["with_vibration"] = [self.results.headline("force")[1], self.results.headline("moment")[1]]
        self.assertEqual(list(arm.index), list(expected))
        for name, (force, moment) in expected.items():
            load, on_arm = 1e3 * line[f"{name}_kn_m"], 1e3 * arm.downstream_kn[name]
            self.assertAlmostEqual((sum(load * pieces) + on_arm) / force, 1.0, delta=0.01)
            self.assertAlmostEqual((sum(load * pieces * middle) + on_arm * arm.height_m[name]) / moment, 1.0, delta=0.01)
        self.assertAlmostEqual(arm.downstream_kn["mean"] / (1e-3 * expected["mean"][0]), 0.2 / 1.2, delta=1e-3)  # the series' ripple has a mean of its own
        self.assertAlmostEqual(arm.upper_downstream_kn["first_impact"], 1e-3 * self.results.ranges["arm_force_first_impact_n"].high, delta=0.01)
        shown = page_tables.line_load_table(self.results, self.plan)["rows"]
        self.assertEqual(shown[-3][0], "in addition on the arm")
        self.assertEqual(shown[-2][3], rounding.upward(expected["first_impact"][0], 1e-3))

    def test_carry_their_part_when_the_moment_is_greatest(self):
        later = self.results.finest[1]
        later.arm.force[100:111], later.arm.moment[100:111] = 5e5, 2e6  # long after the first impact on the mast
        later.force[100:111], later.moment[100:111] = 6e5, 2.2e6
        later.smooth_force, later.smooth_moment = (moving_mean(values, later.rows) for values in (later.force, later.moment))
        moment = self.results.ranges["moment_first_impact_n_m"].high
        force, at = self.results.arm_loads()["first_impact"]
        self.assertAlmostEqual(force * at / moment, 2.0 / 2.2, delta=1e-6)
        self.assertAlmostEqual(at, 4.0)

    def test_have_no_load_without_a_steady_interval_but_that_of_the_impact(self):
        for key in ("force_mean_n", "moment_mean_n_m", "force_steady_peak_n", "moment_steady_peak_n_m"):
            self.results.ranges[key] = self.results.ranges[key]._replace(high=math.nan)
        self.assertEqual(list(self.results.line_loads(self.plan)[3]), ["first_impact", "later_peak", "with_vibration"])

    def test_shake_the_mast_where_they_are(self):
        loads, mast = self.results.finest[0], self.plan["mast"]
        without = Loads(Run(self.folder / "runs" / "soft_w11"))
        without.has_arm = False
        for given in (None, 0.05):
            mode = {**self.plan["modes"][0], "shape_at_load": given}
            np.testing.assert_allclose(loads.generalised_force(mode, 1, mast) - without.generalised_force(mode, 1, mast),
                                       loads.arm.force * cantilever_modes()[0].shape(4.0 / 12.0))

    def test_are_above_the_ground_below_a_snow_cover(self):
        cover = Loads(Run(self.folder / "runs" / "soft_w11"), base=1.5)
        self.assertAlmostEqual(cover.arm_middle, 5.5)
        self.assertAlmostEqual(cover.values["arm_height_m"].value, 5.5)

    def test_are_on_the_page_in_place_of_factors(self):
        text, lines = self.drawn_page()
        self.assertIn("4 m from end to end, 0.8 m along the flow, from 3.6 to 4.4 m above the ground", text)
        self.assertIn("computed, without the arm, steady mean", text)
        self.assertNotIn("Elements that protrude", text)
        self.assertFalse(any("mast alone" in line for line in lines))
        design = json.loads((self.folder / "design.json").read_text())
        self.assertAlmostEqual(design["design_arm_force_n"], self.results.ranges["arm_force_first_impact_n"].high)
        self.assertIn("arm_force_x_n", pd.read_csv(self.folder / "loads_over_time.csv"))

    def test_of_another_site_are_refused(self):
        for arm in ({**self.ARM, "base_m": 3.5}, None):
            plan = {key: value for key, value in {**self.plan, "arm": arm}.items() if value is not None}
            self.write("design_plan.json", json.dumps(plan))
            with self.assertRaisesRegex(InputError, "it is not of the site: arm.(base_m is 3.6, by the site 3.5|length_m is 4.0, by the site left out)"):
                Ensemble(self.folder)


class SnowCovers(DesignFolder):
    def test_lift_heights_and_add_their_height_times_the_force_to_the_moment(self):
        bare = Results(Ensemble(self.folder))
        plan = {**self.plan, "flow": {**self.plan["flow"], "snow_cover_m": 1.5}}
        self.change_cases("height_m = 12.0", "height_m = 10.5")
        self.write("design_plan.json", json.dumps(plan))
        ensemble = Ensemble(self.folder)
        covered = Results(ensemble)
        for before, after in zip(bare.table, covered.table):
            for key in ("runup_p99_mean_m", "runup_peak_m", "pressure_height_mean_m", "resultant_height_m"):
                self.assertAlmostEqual(after[key].value, before[key].value + 1.5)
            for which in ("mean", "steady_peak", "first_impact"):
                force, moment = f"force_{which}_n", f"moment_{which}_n_m"
                self.assertEqual(after[force].value, before[force].value)
                self.assertAlmostEqual(after[moment].value / (before[moment].value + 1.5 * before[force].value), 1.0, delta=1e-9)
        data_files.write_tables(ensemble, covered, figures.spectra(ensemble, covered.finest))
        table = pd.read_csv(self.folder / "line_load.csv")
        self.assertEqual(table.mean_kn_m[table.z_to_m < 1.5].abs().max(), 0.0)
        pieces, middle = table.z_to_m - table.z_from_m, 0.5 * (table.z_to_m + table.z_from_m)
        self.assertAlmostEqual(sum(1e3 * table.mean_kn_m * pieces * middle) / covered.ranges["moment_mean_n_m"].high, 1.0, delta=0.01)
        rows, lifted = comparison.guideline_loads(self.plan), comparison.guideline_loads(plan)
        self.assertAlmostEqual(lifted[0].moment, rows[0].moment + 1.5 * rows[0].force)
        self.assertAlmostEqual(comparison.guideline_rows(plan)[0][1], comparison.guideline_rows(self.plan)[0][1] + 1.5)
        self.assertAlmostEqual(ensemble.bound, 2.0 + 9.81 / 2 + 1.5)


    def test_hide_neither_a_pile_that_grows_nor_coarse_grids(self):
        for run in self.runs:
            path = self.folder / "runs" / run["name"] / "results.json"
            path.write_text(json.dumps({**json.loads(path.read_text()), "runup_numerical_uncertainty_m": 2.5}))  # of 6 m, the first splash
        ensemble = Ensemble(self.folder)
        shares = dict((label, share) for label, share, _ in cautions.uncertainties(Results(ensemble)))
        for cover in (0.0, 5.0):
            raised = ensemble.raised(cover)
            results = Results(raised)
            self.assertIn("not determined (", headlines.run_up_row(raised, results)[0])
            for label, share, _ in cautions.uncertainties(results):
                if label in ("run-up", "pressure height"):
                    self.assertAlmostEqual(share, shares[label])
        path = self.folder / "runs" / "firm_w11" / "series.csv"
        series = pd.read_csv(path)
        series.assign(runup_p99_m=4.0 * (1.0 + 0.016 * (series.time_s - 5.5)), pressure_height_m=3.0 * (1.0 + 0.016 * (series.time_s - 5.5))).to_csv(path, index=False)
        bare, covered = (Results(Ensemble(self.folder).raised(cover)).finest[1].growth for cover in (0.0, 5.0))
        for name in ("run-up", "pressure height"):
            self.assertAlmostEqual(bare[name], 0.08, delta=0.001)  # over 5 s
            self.assertAlmostEqual(covered[name], bare[name])

    def test_of_a_metre_are_on_the_page_as_a_site_with_one_gives_them(self):
        text = page.cover_text(Ensemble(self.folder))
        plain = rounding.upward(Results(Ensemble(self.folder)).headline("moment")[1], 1e-3)
        self.change_cases("height_m = 12.0", "height_m = 11.0")
        self.write("design_plan.json", json.dumps({**self.plan, "flow": {**self.plan["flow"], "snow_cover_m": 1.0}}))
        ensemble = Ensemble(self.folder)
        covered = Results(ensemble)
        force, moment = (rounding.upward(covered.headline(load)[1], 1e-3) for load in ("force", "moment"))
        self.assertIn(f"are {force} kN and {moment} kN m, with the vibration", text)
        self.assertNotEqual(moment, plain)
        self.assertEqual(page.cover_text(ensemble), "")
        for change in ({"arm": {}}, {"modes": [{**self.plan["modes"][0], "shape_at_load": 0.1}]}):
            ensemble.base, ensemble.plan = 0.0, {**self.plan, **change}
            self.assertRegex(page.cover_text(ensemble), "lifts all loads, and [^0-9]*: compute it with")

    def test_of_a_metre_carry_the_marks_of_the_headlines(self):
        self.assertRegex(page.cover_text(Ensemble(self.folder)), "are [0-9]+ kN and [0-9]+ kN m, with")
        for run in ("firm_w3", "firm_w5", "firm_w11"):
            path = self.folder / "runs" / run / "results.json"
            results = json.loads(path.read_text())
            path.write_text(json.dumps({key: None if "mean" in key or "steady" in key else value for key, value in results.items()}))
        self.assertRegex(page.cover_text(Ensemble(self.folder)), "are at least [0-9]+ kN, not steady and at least [0-9]+ kN m, not steady, with")


class ObliqueFlows(DesignFolder):
    def test_give_lateral_force_and_torsion_about_the_masts_own_axis(self):
        for run in self.runs:
            path = self.folder / "runs" / run["name"] / "series.csv"
            series = pd.read_csv(path)
            series.force_y_n, series.moment_x_n_m, series.moment_z_n_m = -0.2 * series.force_x_n, 0.3 * series.force_x_n, 0.4 * series.force_x_n
            series.to_csv(path, index=False)
        self.change_cases("friction = 0.15", "friction = 0.15\nrotation_deg = 20.0")
        self.write("design_plan.json", json.dumps({**self.plan, "mast": {**self.plan["mast"], "angle_deg": 20.0}}))
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        impact = results.table[0]["force_first_impact_n"].value
        for key, factor in (("lateral_force", 0.2), ("lateral_moment", 0.3), ("torsion", 0.4 + 0.5 * 0.2)):  # M_z - x F_y
            self.assertAlmostEqual(results.table[0][f"{key}_first_impact"].value, factor * impact, delta=1.0)
        reactions = page_tables.reaction_table(ensemble, results)
        self.assertEqual(reactions["head"][-1], "torsion")
        self.assertEqual(reactions["rows"][2][4], rounding.with_unit(rounding.upward(results.ranges["lateral_force_first_impact"].high, 1e-3), "kN"))
        self.assertTrue(any("turned by 20°" in text for text, _ in cautions.advice_rows(ensemble, results)))


class Beams(DesignFolder):
    """The modes against a beam of finite elements, and the line load against the headlines."""

    def test_have_the_frequencies_and_shares_of_the_textbook(self):
        modes = cantilever_modes()
        wave_numbers = [1.8751041, 4.6940911, 7.8547574]  # Blevins, Formulas for natural frequency and mode shape
        np.testing.assert_allclose([m.frequency_ratio for m in modes[:3]], (np.array(wave_numbers) / wave_numbers[0]) ** 2, rtol=1e-6)
        np.testing.assert_allclose([m.force_share for m in modes[:2]], [1.5660, -0.8679], atol=1e-4)  # 2 x 0.7830, -2 x 0.4339
        self.assertAlmostEqual(float(modes[0].shape(1.0)), 1.0)

    def test_have_the_frequencies_of_a_massless_rod_with_its_mass_on_the_top(self):
        # f1 by sqrt(3 EI/(M h^3)) over that of the uniform rod alone, 1.8751^2 sqrt(EI/(m h^4)), M = 100 m h and 0.24 of the rod's mass
        light, heavy = cantilever_modes(1.0, 0.0), cantilever_modes(1.0, 100.0)
        self.assertAlmostEqual(heavy[0].force_share, 1.0, delta=0.01)
        self.assertGreater(heavy[1].frequency_ratio, 4.0 * light[1].frequency_ratio)

    def test_add_to_force_and_moment_what_ten_modes_of_finite_elements_add(self):
        # Masts of one width, tapered, and with a heavy top; the loads of a round pylon and of a square tower as runs gave them
        for computed, height, frequency in (("round_pylon", 14.0, 1.8), ("square_tower", 16.0, 1.2)):
            on_the_mast = computed_loads(SOURCE / "tests" / "python" / "data" / f"{computed}.csv", Loads(Run(self.folder / "runs" / "soft_w11")))
            z, step, line = on_the_mast.line_load
            for taper, top_mass in ((1.0, 0.0), (0.5, 0.0), (1.0, 0.5), (0.5, 1.0)):
                mast = {**self.plan["mast"], "height_m": height, "taper": taper, "top_mass_ratio": top_mass}
                loads = on_the_mast
                if taper == 0.5:  # with an arm, too
                    loads = copy.copy(on_the_mast)
                    loads.has_arm, loads.arm_middle, loads.arm = True, 0.4 * height, Effect(0.3 * loads.force, *[None] * 5)
                    loads.force, loads.moment = 1.3 * loads.force, loads.moment + loads.arm_middle * loads.arm.force
                    loads.smooth_force, loads.smooth_moment = loads.force, loads.moment
                every = np.column_stack([step * line, 0.3 * loads.mast.force * loads.has_arm])
                shear, moment, shapes = beam_reactions(np.append(z, 0.4 * height), every, loads.interval, height, frequency, 0.02, taper, top_mass)
                impact = line[np.argmax(line.sum(axis=1))]
                for given in (None, shapes[0][:-1] @ impact / impact.sum()):  # shape_at_load: at the load of the first impact, from a frame program
                    plan = {**self.plan, "mast": mast, "modes": [{"frequency_hz": frequency, "damping_ratio": 0.02, "shape_at_load": given}]}
                    found = loads.with_vibration(plan)
                    for name, exact in (("force", shear), ("moment", moment)):
                        self.assertAlmostEqual(np.max(found[name]) / np.max(exact), 1.0, delta=0.03, msg=f"{computed}, {mast}, {given}, {name}")

    def test_add_more_than_a_tenth_to_the_moment_of_a_sudden_load(self):
        loads = Loads(Run(self.folder / "runs" / "soft_w11"))
        found = loads.with_vibration({**self.plan, "modes": [{"frequency_hz": 1.0, "damping_ratio": 0.02, "shape_at_load": None}]})
        self.assertGreater(np.max(found["moment"]) / np.max(loads.smooth_moment), 1.1, "the masses of the mast matter")

    def test_beyond_the_ten_lowest_modes_are_left_out_with_a_warning(self):
        self.plan["modes"] = [{"frequency_hz": 12.0 - number, "damping_ratio": 0.02, "shape_at_load": None} for number in range(11)]
        self.write("design_plan.json", json.dumps(self.plan))
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        self.assertEqual([key for key in results.ranges if key.endswith("_amplification")], [f"mode_{11 - number}_hz_amplification" for number in range(10)])
        self.assertIn(("Of the 11 modes of the site file only the 10 lowest are taken", ""), cautions.advice_rows(ensemble, results))

    def test_carry_a_line_load_whose_integral_and_moment_are_the_headlines(self):
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        data_files.write_tables(ensemble, results, figures.spectra(ensemble, results.finest))
        table, design = pd.read_csv(self.folder / "line_load.csv"), data_files.design_json(ensemble, results)
        pieces, middle = table.z_to_m - table.z_from_m, 0.5 * (table.z_to_m + table.z_from_m)
        expected = {name: [design["quantities"][f"{kind}_{name}_{unit}"]["range"]["high"] for kind, unit in (("force", "n"), ("moment", "n_m"))]
                    for name in ("mean", "steady_peak", "first_impact")}
        expected["with_vibration"] = [design["design_force_n"], design["design_moment_n_m"]]
        for name, (force, moment) in expected.items():
            load = 1e3 * table[f"{name}_kn_m"]
            self.assertAlmostEqual(sum(load * pieces) / force, 1.0, delta=1e-5)  # of six digits each
            self.assertAlmostEqual(sum(load * pieces * middle) / moment, 1.0, delta=1e-5)

    def test_of_a_coarse_grid_carry_a_line_load_of_the_same_moment(self):
        z, edges = np.arange(0.2, 4.0, 0.4), np.arange(0.0, 5.0, 0.4)
        for stretch in (0.9, 1.1):
            profile = np.maximum(3.0 - z, 0.0)
            moment = stretch * 1e3 * (profile @ z) / profile.sum()
            line = fitted_line(z, profile, edges, 1e3, moment)
            self.assertAlmostEqual(0.4 * line.sum(), 1e3, delta=1e-6)
            self.assertAlmostEqual(0.4 * line @ (edges[:-1] + 0.2) / moment, 1.0, delta=1e-6)

    def test_have_headlines_that_follow_from_the_tables(self):
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        data_files.write_tables(ensemble, results, figures.spectra(ensemble, results.finest))
        rows = headlines.design_rows(ensemble, results)
        table = pd.read_csv(self.folder / "design.csv").set_index("quantity")
        upper = {q: (rows.value + rows.uncertainty.fillna(0)).max() for q, rows in table.groupby(level=0)}
        force, moment = (max(v for q, v in upper.items() if q.startswith(name)) for name in ("force_", "moment_"))
        self.assertAlmostEqual(float(rows[0][1].split(" kN")[0]) / (1e-3 * force), 1.0, delta=0.01)  # three digits, upwards
        self.assertAlmostEqual(float(rows[1][1].split(" kN")[0]) / (1e-3 * moment), 1.0, delta=0.01)


def computed_loads(path, loads):
    """Line load of a run (time in the first column, N/m at the heights of the head, a mean over 0.1 s) in place of that of other loads."""
    table = pd.read_csv(path, index_col=0, comment="#")
    z, time = table.columns.astype(float).to_numpy(), np.arange(0.002, table.index[-1], 0.002)
    line = np.array([np.interp(time, [0.0, *table.index], [0.0, *column]) for column in table.to_numpy().T]).T  # rows as steps would shake stiff modes
    step = z[1] - z[0]
    loads.interval, loads.time, loads.line_load = 0.002, time, (z, step, line)
    loads.rows, loads.force, loads.moment = 1, step * line.sum(axis=1), step * line @ z
    loads.mast = Effect(loads.force, *[None] * 5)
    loads.smooth_force, loads.smooth_moment, loads.steady = loads.force, loads.moment, np.zeros(len(time), bool)
    return loads


def beam_reactions(z, loads, interval, height, frequency, damping, taper, top_mass, elements=48, modes=10):
    """Shear and moment at the foot of a cantilever of Hermite elements over time: the load, and the inertia of its lowest modes; and the
    shapes of these at z, 1 at the top. @param loads  N in the bin of each z, a row for each time"""
    length, count = height / elements, 2 * (elements + 1)
    stiffness, mass = np.zeros((count, count)), np.zeros((count, count))
    k = np.array([[12, 6 * length, -12, 6 * length], [6 * length, 4 * length**2, -6 * length, 2 * length**2],
                  [-12, -6 * length, 12, -6 * length], [6 * length, 2 * length**2, -6 * length, 4 * length**2]]) / length**3
    m = length / 420 * np.array([[156, 22 * length, 54, -13 * length], [22 * length, 4 * length**2, 13 * length, -3 * length**2],
                                 [54, 13 * length, 156, -22 * length], [-13 * length, -3 * length**2, -22 * length, 4 * length**2]])
    widths = 1 + (taper - 1) * (np.arange(elements) + 0.5) / elements
    for e, width in enumerate(widths):
        at = slice(2 * e, 2 * e + 4)
        stiffness[at, at] += k * width**3
        mass[at, at] += m * width
    mass[-2, -2] += top_mass * length * widths.sum()
    free = slice(2, count)
    squares, shapes = scipy.linalg.eigh(stiffness[free, free], mass[free, free], subset_by_index=[0, modes - 1])
    squares *= (2 * np.pi * frequency) ** 2 / squares[0]
    shift, turn = np.zeros(count), np.zeros(count)  # rigid motions of the foot
    shift[0::2], turn[0::2], turn[1::2] = 1.0, length * np.arange(elements + 1), 1.0
    shear, moment, at_z = loads.sum(axis=1), loads @ z, []
    for square, shape in zip(squares, shapes.T):
        whole = np.concatenate([[0.0, 0.0], shape])
        e = np.minimum((z / length).astype(int), elements - 1)
        s = z / length - e
        hermite = np.array([1 - 3 * s**2 + 2 * s**3, length * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3, length * (s**3 - s**2)])
        at_z.append(sum(hermite[i] * whole[2 * e + i] for i in range(4)) / shape[-2])
        generalised = loads @ at_z[-1] * shape[-2]
        omega = np.sqrt(square)
        system = scipy.signal.cont2discrete((np.array([[0, 1], [-square, -2 * damping * omega]]), np.array([[0], [1.0]]), np.eye(2), np.zeros((2, 1))),
                                            interval)
        _, states = scipy.signal.dlsim(system[:4] + (interval,), np.append(generalised, generalised[-1]))[:2]
        elastic = square * states[1:, 0]
        shear = shear + (mass @ shift) @ whole * (elastic - generalised)
        moment = moment + (mass @ turn) @ whole * (elastic - generalised)
    return shear, moment, at_z


class Pages(DesignFolder):
    def test_hold_everything_without_another_file_and_come_with_json_and_tables(self):
        path, lines = page.make_page(self.folder)
        text = open(path, encoding="utf-8").read()
        self.assertIn("Test &lt;mast&gt;", text)
        self.assertGreaterEqual(text.count("<figure>"), 8)
        self.assertNotIn("http://", text.replace("http://www.w3.org", ""))
        self.assertEqual(numbers_that_are_none(text), [])
        self.assertTrue(any(line.startswith("force downstream") for line in lines))
        design = json.loads((self.folder / "design.json").read_text())
        self.assertEqual(design["quantities"]["force_mean_n"]["snows"]["soft"]["by_grid"][0], 140000.0)
        self.assertEqual(len(pd.read_csv(self.folder / "design.csv")), 2 * 20)
        for printed in ("A. Name", "design_plan.json", "mpm 0 (abc)", "counter(page)"):
            self.assertIn(printed, text)
        self.assertEqual(len(pd.read_csv(self.folder / "loads_over_time.csv")), 2 * 800)
        self.assertIn("mean_highest_pa", pd.read_csv(self.folder / "pressure_over_height.csv"))
        self.assertIn("firm_n", pd.read_csv(self.folder / "shock_spectrum.csv"))

    def test_hold_the_advice_about_the_runs_and_say_that_the_mast_is_overtopped(self):
        plan = {**self.plan, "mast": {**self.plan["mast"], "height_m": 5.5}, "flow": {**self.plan["flow"], "source": "path model, 300 years", "slope_deg": 30.0},
                "overrides": ["numerics.cfl=0.5"]}
        self.change_cases("height_m = 12.0", "height_m = 5.5")
        self.write("design_plan.json", json.dumps(plan))
        text, lines = self.drawn_page()
        self.assertIn("Snow firm: Mach number v/c_P = 0.7: too high; stiffen.", text)
        self.assertIn("Source: path model, 300 years.", text)
        self.assertIn("<code>numerics.cfl=0.5</code> in all runs", text)
        self.assertIn("A plumb mast leans upstream by 30°", text)
        self.assertIn("a horizontal part, 0.87 of it, and one downward, 0.50 of it", text)
        self.assertIn("the highest particle at any time reaches 6.00 m, and the mast is 5.5 m high", text)
        self.assertNotIn("the steady mean of the run-up reaches", text)  # 4.9 m
        self.assertIn("warning: snow firm: Mach number v/c_P = 0.7: too high; stiffen", lines)
        advice = json.loads((self.folder / "design.json").read_text())["advice"]
        self.assertEqual([a["snows"] for a in advice], ["firm", "", "", ""])
        self.assertIn("loads are those of the mast alone", advice[1]["text"])
        self.assertIn("computed drag coefficient is 3.8 to 4.6", advice[2]["text"])

    def test_take_no_more_than_all_of_a_load_off_for_the_grid(self):
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        key, _ = results.headline("moment")
        firm = results.table[1]
        firm[key] = firm[key]._replace(grid=1.5 * firm[key].value, total=1.5 * firm[key].value)
        results.ranges[key] = results.ranges[key]._replace(high=firm[key].upper)
        self.assertEqual(next(row[2][0] for row in what_decides.sensitivity_rows(ensemble, results) if row[0].startswith("grid")), -1.0)

    def test_rank_what_decides_and_scale_speed_density_and_depth(self):
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        rows = what_decides.sensitivity_rows(ensemble, results)
        self.assertEqual([row[2][0] - row[2][1] for row in rows], sorted(row[2][0] - row[2][1] for row in rows))
        effects = {what.partition(" ")[0]: changes for what, *changes in rows}
        ensemble.plan["modes"] = []  # another speed shakes the mast in other times
        effects["speed"] = next(row[1:] for row in what_decides.sensitivity_rows(ensemble, Results(ensemble)) if row[0].startswith("speed"))
        np.testing.assert_allclose(effects["density"], [(-0.2, 0.2), (-0.2, 0.2)], atol=1e-12)
        own = scaling.drag_coefficient(1.0, 1.2 * self.plan["flow"]["froude_number"]) / scaling.drag_coefficient(1.0, self.plan["flow"]["froude_number"])
        self.assertAlmostEqual(effects["speed"][0][1], 1.44 * own - 1.0, delta=1e-9)  # the firm snow, M' = 1, decides
        self.assertGreater(effects["depth"][1][1], effects["depth"][0][1], "the arm grows, too")
        self.assertAlmostEqual(effects["snow:"][0][0], 1.0 / 1.2 - 1.0, delta=0.01)  # the second is 1.2 times the first
        self.assertIn("27", what_decides.ensemble_text(ensemble, results, rows))

    def test_compare_snows_and_front_by_their_values_and_not_by_their_grids(self):
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        def compared():
            return [row[1:] for row in sorted(what_decides.sensitivity_rows(ensemble, results)) if row[0].startswith(("snow", "front"))]

        before = compared()
        results.table[0] = {key: entry._replace(total=entry.total + 0.2 * entry.value) for key, entry in results.table[0].items()}
        self.assertEqual((compared(), len(before)), (before, 2))

    def test_call_equations_outside_their_range_extrapolated(self):
        ensemble = Ensemble(self.folder)
        self.assertIn("extrapolated", page_tables.comparison_table(ensemble, Results(ensemble))["head"][2])

    def test_warn_of_a_steady_interval_that_begins_late(self):
        path = self.folder / "runs" / "firm_w11" / "results.json"
        for begin in (4.9, 6.0):  # the splash is back at 2 s: half of the time to the end, 8 s, has passed at 5 s
            path.write_text(json.dumps({**json.loads(path.read_text()), "steady_from_s": begin}))
            ensemble = Ensemble(self.folder)
            late = [row for row in cautions.advice_rows(ensemble, Results(ensemble)) if "steady interval is short" in row[0]]
            self.assertEqual([snows for _, snows in late], ["firm"] if begin > 5.0 else [])

    def advice_with_run_up(self, runup):
        """What the page says where the firm snow's run-up over time is this: (texts of the snow, headline of the run-up)."""
        path = self.folder / "runs" / "firm_w11" / "series.csv"
        series = pd.read_csv(path)
        series.assign(runup_p99_m=runup(series.time_s.to_numpy())).to_csv(path, index=False)
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        return [text for text, snows in cautions.advice_rows(ensemble, results) if snows == "firm"], headlines.design_rows(ensemble, results)[-1][1]

    def test_do_not_determine_a_run_up_that_still_rises_at_the_end(self):
        noise = np.random.default_rng(2).normal(0.0, 0.3, 801)
        for rise, grows in ((-0.4, False), (0.0, False), (0.04, False), (0.08, True)):  # over the mean of 5 m, from 3 to 8 s
            texts, headline = self.advice_with_run_up(lambda time: 5.0 * (1.0 + rise * (time - 5.5) / 5.0) + noise)
            self.assertEqual(any("still piles up" in text and "run-up 8 %" in text and "duration_s = 16.0" in text for text in texts), grows, texts)
            self.assertEqual(headline.startswith("not determined (still growing"), grows, headline)

    def test_mark_a_force_and_a_moment_that_still_rise_at_the_end(self):
        path = self.folder / "runs" / "firm_w11" / "series.csv"
        series = pd.read_csv(path)
        series.assign(force_x_n=series.force_x_n * (1.0 + 0.02 * series.time_s.clip(lower=3.0))).to_csv(path, index=False)
        ensemble = Ensemble(self.folder)
        force, moment = headlines.design_rows(ensemble, Results(ensemble))[:2]
        self.assertRegex(force[1], "^[0-9]+ kN, still growing$")
        self.assertIn("still piles up when the run ends (firm): give [plan] duration_s = 16.0", force[2])
        self.assertNotIn("still", moment[1])  # that of the series did not change

    def test_mark_what_ends_before_it_is_steady_and_take_its_peaks_until_the_end(self):
        self.without_means("firm_w11")
        path = self.folder / "runs" / "firm_w11" / "series.csv"
        series = pd.read_csv(path)
        series.assign(force_x_n=series.force_x_n + 1e6 * (series.time_s > 7.5)).to_csv(path, index=False)  # long after the splash
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        self.assertLess(results.table[1]["force_first_impact_n"].value, 1e6)
        self.assertGreater(results.ranges["force_later_peak_n"].high, 1e6)
        self.assertEqual(results.peaks[-1], "later_peak")
        self.assertGreaterEqual(results.headline("force")[1], results.ranges["force_later_peak_n"].high)
        self.assertIn("later_peak", results.line_loads(ensemble.plan)[2])
        self.assertIn("What comes before the flow is steady included", headlines.design_rows(ensemble, results)[0][2])
        force, moment, _, run_up = headlines.design_rows(ensemble, results)
        for row in (force, moment):
            self.assertRegex(row[1], "^at least .*, not steady$")  # without the known uncertainty, which is relative to the mean
            self.assertIn("The run ends before the flow is steady (firm): give [plan] duration_s = 16.0", row[2])
        self.assertTrue(results.table[1]["force_first_impact_n"].at_least)
        self.assertFalse(results.table[0]["force_first_impact_n"].at_least)
        self.assertFalse(results.table[1]["mode_1_hz_amplification"].at_least)
        self.assertTrue(run_up[1].startswith("not determined (not steady, "), run_up)
        self.assertTrue(any("before the flow is steady" in text for text, snows in cautions.advice_rows(ensemble, results) if snows == "firm"))

    def test_say_at_least_where_only_one_grid_has_a_value(self):
        for marked in (False, True):
            for run in ("firm_w3", "firm_w5") if marked else ():
                self.without_means(run)
            ensemble = Ensemble(self.folder)
            results = Results(ensemble)
            self.assertEqual(results.table[1]["force_mean_n"].at_least, marked)
            for what, value, why in headlines.design_rows(ensemble, results)[:2]:
                self.assertEqual((value.startswith("at least "), headlines.ONE_GRID in why), (marked, marked), what)
            self.assertEqual("at least" in headlines.design_rows(ensemble, results)[2][2], marked)  # the pressure height of the simulation
            rows = {row[0]: row for row in page_tables.load_table(ensemble, results)["rows"]}
            mean = rows["force downstream, steady mean (kN)"]
            self.assertEqual([cell.endswith(" *") for cell in mean[1:]], [False, marked, marked])
            self.assertEqual(page_tables.reaction_table(ensemble, results)["rows"][0][1].endswith("kN *"), marked)
            self.assertEqual(page_tables.line_load_table(results, ensemble.plan)["rows"][-2][1].endswith(" *"), marked)
            self.assertEqual("mean force at least" in cautions.accuracy(results), marked)
            self.assertEqual(data_files.design_json(ensemble, results)["quantities"]["force_mean_n"]["range"]["at_least"], marked)

    def test_ask_for_one_duration_the_longest(self):
        for advised, asked in ((14.0, "16.0"), (20.0, "20.0")):
            texts = [f"the flow travels 6 m in plan.duration_s = 3 s: take plan.duration_s = {advised:g} s", "take plan.duration_s = 1 s or more; means get better"]
            self.write("design_plan.json", json.dumps({**self.plan, "advice": [{"rule": "flow_passage", "text": text, "snows": ["soft", "firm"]} for text in texts]}))
            self.without_means("firm_w11")
            ensemble = Ensemble(self.folder)
            results = Results(ensemble)
            said = [text for text, _ in cautions.advice_rows(ensemble, results)] + [why for *_, why in headlines.design_rows(ensemble, results)]
            self.assertEqual(set(re.findall("(?:take plan.|give \\[plan\\] )duration_s = ([0-9]+[.][0-9]+)", " ".join(said))), {asked})

    def test_cover_every_row_of_a_run_by_their_peaks(self):
        self.assertEqual(Results(Ensemble(self.folder)).peaks, ("steady_peak", "first_impact"), "steady at once")
        for begin in (3.0, 6.0):
            for run in self.runs:
                path = self.folder / "runs" / run["name"] / "results.json"
                path.write_text(json.dumps({**json.loads(path.read_text()), "steady_from_s": begin}))
            for loads in Results(Ensemble(self.folder)).finest:
                self.assertTrue(np.logical_or.reduce(list(loads.during.values())).all())
                peaks = [loads.values[f"force_{which}_n"].value for which in loads.during]
                self.assertEqual(max(peaks), loads.smooth_force.max())

    def test_find_no_growth_in_waves(self):
        texts, _ = self.advice_with_run_up(lambda time: 5.0 - 1.3 * np.sin(2 * np.pi * time / 3.0))  # a line through the parts rises by 9 % of the mean
        self.assertFalse([text for text in texts if "still piles up" in text])

    def test_look_back_to_the_splash_where_the_steady_interval_begins_late(self):
        path = self.folder / "runs" / "firm_w11" / "results.json"
        path.write_text(json.dumps({**json.loads(path.read_text()), "steady_from_s": 6.5}))
        for grows in (True, False):  # to a pile, or down from a fountain
            texts, headline = self.advice_with_run_up(lambda time: 5.0 + (1 if grows else -1) * np.minimum(time - 4.25, 2.25))
            self.assertEqual(any("still piles up" in text and "since the splash" in text for text in texts), grows, texts)
            self.assertEqual("still growing" in headline, grows)

    def without_means(self, run):
        path = self.folder / "runs" / run / "results.json"
        results = json.loads(path.read_text())
        path.write_text(json.dumps({key: None if "mean" in key or "steady" in key else value for key, value in results.items()}))

    def test_speak_of_the_masts_masses_only_where_it_vibrates(self):
        for modes in (self.plan["modes"], []):
            self.write("design_plan.json", json.dumps({**self.plan, "modes": modes}))
            text, _ = self.drawn_page()
            self.assertEqual("force of the mast's masses in its first mode" in text, bool(modes))

    def test_say_that_means_of_sheared_flow_hold_for_no_first_impact(self):
        tables = page_tables.factor_tables(Ensemble(self.folder), load_factors())
        self.assertIn("they hold for no first impact", next(note for heading, _, note in tables if heading == "Other fronts and sheared flow"))

    def test_say_that_a_run_has_no_steady_interval(self):
        self.without_means("soft_w11")
        text, _ = self.drawn_page()
        self.assertIn("No steady interval, so no means, in: soft_w11 (8.00 s): give [plan] duration_s = 16.0.", text)
        self.assertEqual(numbers_that_are_none(text), [])

    def test_have_a_dash_for_every_number_that_is_not_known(self):
        for run in self.runs:
            self.without_means(run["name"])
        mode = {"frequency_hz": 1.0, "damping_ratio": 0.02, "shape_at_load": 0.0}
        self.write("design_plan.json", json.dumps({**self.plan, "modes": [mode, {**mode, "frequency_hz": 2.5, "shape_at_load": 0.5}]}))
        text, lines = self.drawn_page()
        self.assertEqual(numbers_that_are_none(text), [])
        self.assertEqual(numbers_that_are_none("\n".join(lines)), [])
        self.assertIn("(c_D over w H: –, upper –)", text)
        self.assertRegex(text, r'amplification of the modes[^>]*">–, \d\.\d\d<')
        self.assertNotIn("NaN", (self.folder / "design.json").read_text())


def numbers_that_are_none(text):
    """Where a page, or one of its drawings, prints a number that is none."""
    drawings = [base64.b64decode(data).decode() for data in re.findall(r"data:image/svg\+xml;base64,([^\"]+)", text)]
    return [part[max(0, match.start() - 40):match.end() + 40] for part in (re.sub(r"base64,[^\"]+", "", text), *drawings)
            for match in re.finditer(r"(?<![a-z])(nan|inf)(?![a-z])", part, flags=re.IGNORECASE)]


# What a page says of itself in a frame of some width: its pictures that are broken, and the elements that are wider than it.
PROBE = """<!doctype html><meta charset="utf-8"><body><iframe width="{width}" height="4000" style="border:0" srcdoc="{page}"></iframe><script>
document.querySelector("iframe").addEventListener("load", (event) => {{
  const page = event.target.contentDocument, root = page.documentElement;
  const images = [...page.images];
  const wide = [...page.querySelectorAll("body *")].filter((e) => e.getBoundingClientRect().right > root.clientWidth + 1);
  const said = {{ width: root.clientWidth, content: root.scrollWidth, images: images.length,
    broken: images.filter((i) => !i.complete || i.naturalWidth === 0).map((i) => i.alt), wide: wide.slice(0, 5).map((e) => e.outerHTML.slice(0, 120)) }};
  document.body.dataset.said = encodeURIComponent(JSON.stringify(said));
}});</script>"""


@unittest.skipUnless(BROWSER, "needs Debian's chromium")
class Browser(DesignFolder):
    """The page as a reader sees it, on a screen, on a telephone and on paper."""

    def setUp(self):
        super().setUp()
        self.page = page.make_page(self.folder)[0]
        with open(self.page, encoding="utf-8") as file:
            self.text = file.read()

    def browse(self, *arguments):
        done = subprocess.run([BROWSER, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-background-networking",
                               f"--user-data-dir={self.folder / 'profile'}", *arguments], capture_output=True, text=True, timeout=600, check=False)
        self.assertEqual(done.returncode, 0, done.stderr[-2000:])
        return done.stdout

    def test_shows_the_whole_page_at_any_width_with_every_picture(self):
        for width in (1280, 420):
            path = self.write(f"probe_{width}.html", PROBE.format(width=width, page=html.escape(self.text)))
            shown = self.browse("--window-size=1400,4200", "--virtual-time-budget=60000", "--dump-dom", f"file://{path}")
            said = re.search(r'data-said="([^"]+)"', shown)
            self.assertIsNotNone(said, shown[-500:])
            said = json.loads(urllib.parse.unquote(said[1]))
            self.assertTrue(width - 20 <= said["width"] <= width, said["width"])  # a scroll bar takes its part
            self.assertEqual((said["broken"], said["wide"]), ([], []))
            self.assertLessEqual(said["content"], said["width"], "the page is scrolled sideways")
            self.assertEqual(said["images"], self.text.count("<figure>"))

    def test_prints_with_every_figure(self):
        paper = self.folder / "design.pdf"
        self.browse("--no-pdf-header-footer", f"--print-to-pdf={paper}", f"file://{self.page}")
        rasters, lines = drawn(paper.read_bytes())
        vector = [base64.b64decode(data).decode() for data in re.findall(r'<img [^>]*src="data:image/svg\+xml;base64,([^"]+)"', self.text)]
        self.assertGreaterEqual(rasters, self.text.count('src="data:image/png'))
        self.assertGreater(len(vector), 4)
        expected = sum(len(re.findall(r"[LC] ", svg)) for svg in vector)  # straight lines and curves
        self.assertGreater(lines, expected, "the glyphs of the text come in addition")


def drawn(pdf):
    """Pictures and path operators (lines, curves) of a PDF whose streams are compressed or plain."""
    lines = 0
    for stream in re.findall(rb"stream\r?\n(.*?)\r?\nendstream", pdf, flags=re.DOTALL):
        try:
            stream = zlib.decompress(stream)
        except zlib.error:
            pass
        lines += len(re.findall(rb"[\d.] [lc]\b", stream))
    return len(re.findall(rb"/Subtype\s*/Image", pdf)), lines


class Numbers(unittest.TestCase):
    def test_have_three_digits_and_design_values_are_rounded_up(self):
        self.assertEqual((rounding.short(123456.0, 1e-3), rounding.short(1.2345), rounding.short(12.345), rounding.short(math.nan)), ("123", "1.23", "12.3", "–"))
        self.assertEqual((rounding.upward(123.01), rounding.upward(1.231), rounding.upward(12345.0)), ("124", "1.24", "12400"))
        for ends, text in (((-0.3411, 0.4211), "-0.342 to +0.422"), ((8.409, 31.61), "+8.40 to +31.7"), ((-31.61, -8.409), "-31.7 to -8.40"), ((0.0, 123.01), "0 to +124")):
            self.assertEqual(rounding.outward(*ends), text)

    def test_of_ranges_are_rounded_outwards(self):
        self.assertEqual([rounding.downward(value) for value in (6.7754, -6.7754, 0.0, 29.7, 1187.0, math.nan)], ["6.77", "-6.78", "0", "29.7", "1180", rounding.UNKNOWN])
        self.assertEqual(rounding.downward(29673.0, 1e-3), "29.6")

    def test_have_the_digits_of_their_uncertainty_which_is_never_zero(self):
        for value, uncertainty, text in ((123.4, 12.3, "123 ± 12"), (1.2345, 0.0567, "1.234 ± 0.057"), (1.6091, 1e-4, "1.609 ± 0.001"),
                                         (150.0, 0.0, "150.0 ± 0.1"), (0.01218, 0.00231, "0.0122 ± 0.0023"), (1119.0, 1674.0, "1100 ± 1700"), (7.0, 14.0, "7 ± 14"), (0.0, 0.0, "0.000 ± 0.001")):
            self.assertEqual(rounding.value_and_error(value, uncertainty), text)


if __name__ == "__main__":
    unittest.main()
