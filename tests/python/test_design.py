"""The page of `mpm design`: uncertainty, oscillator, loads, tables and the page itself."""

import base64
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
import scipy.signal

from mpmtools.checksums import checksum
from mpmtools.design import comparison, figures, page
from mpmtools.design.ensemble import Ensemble
from mpmtools.design.loads import Loads, moving_mean
from mpmtools.design.oscillator import equivalent_static_force, shock_response_spectrum
from mpmtools.design.results import Results
from mpmtools.design.uncertainty import combined, grid_estimate, observed_order
from mpmtools.design.vibration import cantilever_mode
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
        text = (SOURCE / "validation" / "cases" / "avalanche_convergence" / "README.md").read_text(encoding="utf-8").split("## Measured")[1]
        head, _, *rows = [[cell.strip() for cell in line.strip("|").split("|")] for line in text.splitlines() if line.startswith("|")][:5]
        cells_of = [int(name.removeprefix("w/")) for name in head[1:]]
        self.assertEqual(([row[0] for row in rows], cells_of[-1]), (["force, kN", "highest particle / H", "pressure height / H"], 12))
        for quantity, *numbers in rows:
            values = dict(zip(cells_of, map(float, numbers)))
            for cells in ((3, 5), (3, 5, 7)):
                band = grid_estimate([1.0 / n for n in cells], [values[n] for n in cells]).uncertainty
                for finer in (n for n in values if n > cells[-1]):
                    self.assertLessEqual(abs(values[finer] - values[cells[-1]]), band, f"{quantity}, {cells} against {finer}")

    def test_are_unknown_where_the_finest_grid_has_no_value(self):
        self.assertTrue(math.isnan(grid_estimate([0.4, 0.2], [1.0, math.nan]).uncertainty))

    def test_add_to_the_statistical_error_as_root_of_the_sum_of_squares(self):
        self.assertAlmostEqual(combined(3.0, 2.0), 5.0)
        self.assertAlmostEqual(combined(3.0, math.nan), 3.0)
        self.assertTrue(math.isnan(combined(math.nan, math.nan)))


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
        np.testing.assert_allclose(moving_mean([[0, 1], [2, 3], [4, 5]], 3)[1], [2, 3])


CASE = """\
title = "Design: {name}"
[material]
density_kg_m3 = 300.0
[conveyor]
velocity_m_s = 9.81
flow_height_m = 2.0
mirror_y = true
[obstacle]
shape = "box"
width_m = 1.0
depth_m = 1.0
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
            "snows": [{"name": name, "critical_state_slope": 0.5, "cohesion_beta": 0.0, "hardening_xi": 5.0, "effective_friction": m, "source": ""}
                      for name, m in (("soft", 0.5), ("firm", 1.0))],
            "grids": [{"cells": n, "cell_size_m": h} for n, h in zip((3, 5, 11), self.SIZES)],
            "duration_s": 8.0, "particle_steps": 1e6, "runs": self.runs,
            "advice": [{"rule": "mach_number", "text": "Mach number v/c_P = 0.7: too high; stiffen", "snows": ["firm"]}]}
        self.write("design_plan.json", json.dumps(self.plan))

    def make_run(self, name, size, force, final):
        folder = f"runs/{name}"
        (self.folder / folder).mkdir(parents=True)
        self.write(f"{folder}/case.toml", CASE.format(name=name, size=size))
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

    def test_take_the_shape_at_the_load_of_the_site_file(self):
        mode = {**self.plan["modes"][0], "shape_at_load": 0.5}
        np.testing.assert_allclose(self.loads().generalised_force(mode, 1, 12.0), 0.5 * self.loads().force)

    def test_have_a_drag_coefficient_over_width_and_depth(self):
        self.assertAlmostEqual(self.loads().values["drag_coefficient"].value, 1.1e5 / (0.5 * 300 * 9.81**2 * 1.0 * 2.0))

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
        self.assertAlmostEqual(entry.total, math.hypot(12500, 1000), delta=1.0)

    def test_take_the_known_uncertainty_where_the_grids_agree(self):
        entry = Results(Ensemble(self.folder)).table[0]["pressure_height_mean_m"]
        self.assertEqual((entry.gci, entry.grid), (0.0, 0.1))
        self.assertIn("known", entry.note)
        self.assertNotIn("known", entry.method)

    def test_range_from_the_least_minus_to_the_greatest_plus_its_uncertainty(self):
        results = Results(Ensemble(self.folder))
        soft, firm = (row["force_mean_n"] for row in results.table)
        r = results.ranges["force_mean_n"]
        self.assertAlmostEqual(r.low, soft.value - soft.total)
        self.assertAlmostEqual(r.high, firm.value + firm.total)

    def test_design_with_the_largest_upper_value(self):
        ensemble = Ensemble(self.folder)
        key, force = Results(ensemble).design_force()
        self.assertIn(key, ("force_with_vibration_n", "force_first_impact_n"))  # the blow of 0.6 s; the mode feels 3 % of it
        self.assertEqual(force, Results(ensemble).ranges[key].high)

    def test_tell_what_the_first_impact_adds(self):
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        key, force = results.design_force(steady_only=True)
        self.assertIn(key, ("force_steady_peak_n", "force_with_vibration_steady_n"))
        self.assertLess(force, results.design_force()[1])

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
        what, value, why = page.design_rows(ensemble, results)[-1]
        self.assertIn("run-up", what)
        splash = results.ranges["runup_peak_m"]
        self.assertGreater(splash.high, max(6.0, results.ranges["runup_p99_mean_m"].high))
        self.assertEqual(value, page.upward(splash.high) + " m")
        self.assertIn("first splash: 6.00 m on the finest grid", why)

    def test_do_not_determine_a_run_up_whose_uncertainty_is_more_than_a_third_of_it(self):
        for run in self.runs:
            path = self.folder / "runs" / run["name"] / "results.json"
            path.write_text(json.dumps({**json.loads(path.read_text()), "runup_numerical_uncertainty_m": 2.5}))
        ensemble = Ensemble(self.folder)
        _, value, why = page.design_rows(ensemble, Results(ensemble))[-1]
        self.assertIn("not determined (6.0 ± 3.1 m)", value)
        self.assertIn("finest_cells = 15", why)

    def test_name_quantities_whose_grids_are_too_coarse_and_the_grid_to_plan(self):
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        self.assertFalse(any("too coarse" in text for text, _ in page.advice_rows(ensemble, results)))
        for row in results.table:
            row["moment_mean_n_m"] = row["moment_mean_n_m"]._replace(grid=0.5 * row["moment_mean_n_m"].value)
        self.assertTrue(any("mean moment 50 %" in text and "finest_cells = 15" in text for text, _ in page.advice_rows(ensemble, results)))

    def test_offer_the_greatest_pressure_height_and_name_the_others(self):
        ensemble = Ensemble(self.folder)
        what, value, why = page.design_rows(ensemble, Results(ensemble))[2]
        self.assertEqual(value, "6.00 m")  # 3 H; the simulation has 3.0 m
        for part in ("3 H", "simulation", "equations", "They differ because"):
            self.assertIn(part, why)

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
        with self.assertRaisesRegex(InputError, "firm_w5/case.toml: it was altered"):
            Ensemble(self.folder)

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

    def test_give_the_equations_for_each_snow_and_say_what_they_were_fitted_to(self):
        rows = comparison.equation_rows(self.plan)
        self.assertAlmostEqual(rows[0]["runup_m"], 2.0 * (1 + 0.9468 * 0.5) + 0.5 * 9.81 * math.exp(-1.5745 * 0.5), places=6)
        self.assertEqual(comparison.equation_remarks(self.plan), ["w/H = 0.50 (fitted: 1)"])

    def test_say_to_which_mast_the_known_uncertainties_belong(self):
        self.assertIn("This mast (w/H = 0.50)", comparison.known_uncertainty_remark(self.plan))
        square = {**self.plan, "mast": {**self.plan["mast"], "width_m": 2.0}}
        self.assertEqual(comparison.known_uncertainty_remark(square), "")
        self.assertIn("(round)", comparison.known_uncertainty_remark({**square, "mast": {**square["mast"], "shape": "cylinder"}}))


class Beams(DesignFolder):
    """The modes against a beam of finite elements, and the line load against the headlines."""

    def test_have_the_frequencies_and_shares_of_the_textbook(self):
        first, second = cantilever_mode(1), cantilever_mode(2)
        self.assertAlmostEqual(first.wave_number, 1.8751041, delta=1e-7)  # Blevins, Formulas for natural frequency and mode shape
        self.assertAlmostEqual(second.wave_number, 4.6940911, delta=1e-7)
        z = (np.arange(20000) + 0.5) / 20000
        for mode in (first, second):
            phi = mode.shape(z)
            self.assertAlmostEqual(mode.force_share, phi.mean() / np.mean(phi**2), delta=1e-4)
            self.assertAlmostEqual(mode.moment_share, np.mean(z * phi) / np.mean(phi**2), delta=1e-4)
        self.assertAlmostEqual(float(first.shape(1.0)), 1.0)

    def test_add_to_force_and_moment_what_ten_modes_of_finite_elements_add(self):
        height, damping = 12.0, 0.02
        for frequency in (0.7, 1.0, 1.8):
            loads = Loads(Run(self.folder / "runs" / "soft_w11"))
            z, step, _ = loads.line_load
            time = loads.time
            rise = np.clip(time / 0.1, 0, 1)
            force = 1e5 * rise**2 * (3 - 2 * rise) * (1 + 0.3 * np.exp(-2 * time))
            shape = np.maximum(1 - z / 3.0, 0.0)
            loads.line_load = (z, step, force[:, None] * shape / (step * shape.sum()))
            arm = shape @ z / shape.sum()
            loads.force, loads.moment = force, arm * force
            loads.smooth_force, loads.smooth_moment = moving_mean(force, loads.rows), arm * moving_mean(force, loads.rows)
            plan = {**self.plan, "modes": [{"frequency_hz": frequency, "damping_ratio": damping, "shape_at_load": None}]}
            found = loads.with_vibration(plan)
            shear, moment = beam_reactions(z, step * loads.line_load[2], loads.interval, height, frequency, damping)
            self.assertAlmostEqual(np.max(found["force"]) / np.max(shear), 1.0, delta=0.03)
            self.assertAlmostEqual(np.max(found["moment"]) / np.max(moment), 1.0, delta=0.03)
            self.assertGreater(np.max(moment) / np.max(loads.moment), 1.1, "the masses of the mast matter")

    def test_carry_a_line_load_whose_integral_and_moment_are_the_headlines(self):
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        page.write_tables(ensemble, results, figures.spectra(ensemble, results.finest))
        table, design = pd.read_csv(self.folder / "line_load.csv"), page.design_json(ensemble, results)
        pieces, middle = table.z_to_m - table.z_from_m, 0.5 * (table.z_to_m + table.z_from_m)
        expected = {name: [design["quantities"][f"{kind}_{name}_{unit}"]["range"]["high"] for kind, unit in (("force", "n"), ("moment", "n_m"))]
                    for name in ("mean", "steady_peak", "first_impact")}
        expected["with_vibration"] = [design["design_force_n"], design["design_moment_n_m"]]
        for name, (force, moment) in expected.items():
            load = 1e3 * table[f"{name}_kn_m"]
            self.assertAlmostEqual(sum(load * pieces) / force, 1.0, delta=0.01)
            self.assertAlmostEqual(sum(load * pieces * middle) / moment, 1.0, delta=0.01)

    def test_have_headlines_that_follow_from_the_tables(self):
        ensemble = Ensemble(self.folder)
        results = Results(ensemble)
        page.write_tables(ensemble, results, figures.spectra(ensemble, results.finest))
        rows = page.design_rows(ensemble, results)
        table = pd.read_csv(self.folder / "design.csv").set_index("quantity")
        upper = {q: (rows.value + rows.uncertainty.fillna(0)).max() for q, rows in table.groupby(level=0)}
        force = max(v for q, v in upper.items() if q.startswith("force_") and "mean" not in q)
        moment = max(v for q, v in upper.items() if q.startswith("moment_") and "mean" not in q)
        self.assertAlmostEqual(float(rows[0][1].split(" kN")[0]) / (1e-3 * force), 1.0, delta=0.01)  # three digits, upwards
        self.assertAlmostEqual(float(rows[1][1].split(" kN")[0]) / (1e-3 * moment), 1.0, delta=0.01)


def beam_reactions(z, loads, interval, height, frequency, damping, elements=48, modes=10):
    """Shear and moment at the foot of a cantilever of Hermite elements over time: the load, and the inertia of its lowest modes.

    @param loads  N in the bin of each z, a row for each time
    """
    length, count = height / elements, 2 * (elements + 1)
    stiffness, mass = np.zeros((count, count)), np.zeros((count, count))
    k = np.array([[12, 6 * length, -12, 6 * length], [6 * length, 4 * length**2, -6 * length, 2 * length**2],
                  [-12, -6 * length, 12, -6 * length], [6 * length, 2 * length**2, -6 * length, 4 * length**2]]) / length**3
    m = length / 420 * np.array([[156, 22 * length, 54, -13 * length], [22 * length, 4 * length**2, 13 * length, -3 * length**2],
                                 [54, 13 * length, 156, -22 * length], [-13 * length, -3 * length**2, -22 * length, 4 * length**2]])
    for e in range(elements):
        at = slice(2 * e, 2 * e + 4)
        stiffness[at, at] += k
        mass[at, at] += m
    free = slice(2, count)
    squares, shapes = scipy.linalg.eigh(stiffness[free, free], mass[free, free], subset_by_index=[0, modes - 1])
    squares *= (2 * np.pi * frequency) ** 2 / squares[0]
    shift, turn = np.zeros(count), np.zeros(count)  # rigid motions of the foot
    shift[0::2], turn[0::2], turn[1::2] = 1.0, length * np.arange(elements + 1), 1.0
    shear, moment = loads.sum(axis=1), loads @ z
    for square, shape in zip(squares, shapes.T):
        whole = np.concatenate([[0.0, 0.0], shape])
        e = np.minimum((z / length).astype(int), elements - 1)
        s = z / length - e
        hermite = np.array([1 - 3 * s**2 + 2 * s**3, length * (s - 2 * s**2 + s**3), 3 * s**2 - 2 * s**3, length * (s**3 - s**2)])
        generalised = loads @ sum(hermite[i] * whole[2 * e + i] for i in range(4))
        omega = np.sqrt(square)
        system = scipy.signal.cont2discrete((np.array([[0, 1], [-square, -2 * damping * omega]]), np.array([[0], [1.0]]), np.eye(2), np.zeros((2, 1))),
                                            interval)
        _, states = scipy.signal.dlsim(system[:4] + (interval,), np.append(generalised, generalised[-1]))[:2]
        elastic = square * states[1:, 0]
        shear = shear + (mass @ shift) @ whole * (elastic - generalised)
        moment = moment + (mass @ turn) @ whole * (elastic - generalised)
    return shear, moment


class Pages(DesignFolder):
    def test_hold_everything_without_another_file_and_come_with_json_and_tables(self):
        path, lines = page.make_page(self.folder)
        text = open(path, encoding="utf-8").read()
        self.assertIn("Test &lt;mast&gt;", text)
        self.assertGreaterEqual(text.count("<figure>"), 8)
        self.assertNotIn("http://", text.replace("http://www.w3.org", ""))
        self.assertNotIn("nan", text.lower().replace("nanometre", "").split("base64,")[0])
        self.assertTrue(any(line.startswith("force downstream") for line in lines))
        design = json.loads((self.folder / "design.json").read_text())
        self.assertEqual(design["quantities"]["force_mean_n"]["snows"]["soft"]["by_grid"][0], 140000.0)
        self.assertEqual(len(pd.read_csv(self.folder / "design.csv")), 2 * 18)
        for printed in ("A. Name", "design_plan.json", "mpm 0 (abc)", "counter(page)"):
            self.assertIn(printed, text)
        self.assertEqual(len(pd.read_csv(self.folder / "loads_over_time.csv")), 2 * 800)
        self.assertIn("mean_highest_pa", pd.read_csv(self.folder / "pressure_over_height.csv"))
        self.assertIn("firm_n", pd.read_csv(self.folder / "shock_spectrum.csv"))

    def test_hold_the_advice_about_the_runs_and_say_that_the_mast_is_overtopped(self):
        plan = {**self.plan, "mast": {**self.plan["mast"], "height_m": 5.5}}
        self.write("design_plan.json", json.dumps(plan))
        with unittest.mock.patch("mpmtools.design.figures.view_3d", return_value=None):  # a few seconds
            path, lines = page.make_page(self.folder)
        text = open(path, encoding="utf-8").read()
        self.assertIn("Snow firm: Mach number v/c_P = 0.7: too high; stiffen.", text)
        self.assertIn("the first splash reaches 6.00 m, and the mast is 5.5 m high", text)
        self.assertNotIn("the steady mean of the run-up reaches", text)  # 4.9 m
        self.assertIn("warning: snow firm: Mach number v/c_P = 0.7: too high; stiffen", lines)
        advice = json.loads((self.folder / "design.json").read_text())["advice"]
        self.assertEqual([a["snows"] for a in advice], ["firm", "", ""])
        self.assertIn("computed drag coefficient is 3.8 to 4.6", advice[1]["text"])

    def test_rank_what_decides_and_scale_speed_density_and_depth(self):
        ensemble = Ensemble(self.folder)
        rows = page.sensitivity_table(ensemble, Results(ensemble))["rows"]
        self.assertEqual(rows[0][1:], ["-36 to +44 %", "-36 to +44 %"])  # speed, squared
        self.assertIn(["depth ± 20 %, scaling", "-20 to +20 %", "-36 to +44 %"], rows)
        self.assertIn(["snow: least to greatest of the site", "+0 to +20 %", "+0 to +20 %"], rows)  # the second is 1.2 times the first

    def test_call_equations_outside_their_range_extrapolated(self):
        ensemble = Ensemble(self.folder)
        self.assertIn("extrapolated", page.comparison_table(ensemble, Results(ensemble))["head"][2])

    def test_say_that_a_run_has_no_steady_interval(self):
        path = self.folder / "runs" / "soft_w11" / "results.json"
        results = json.loads(path.read_text())
        for key in results:
            if "mean" in key or "steady" in key:
                results[key] = None
        path.write_text(json.dumps(results))
        with unittest.mock.patch("mpmtools.design.figures.view_3d", return_value=None):  # a few seconds
            text = open(page.make_page(self.folder)[0], encoding="utf-8").read()
        self.assertIn("No steady interval, so no means, in: soft_w11", text)


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
        self.assertEqual((page.short(123456.0, 1e-3), page.short(1.2345), page.short(12.345), page.short(math.nan)), ("123", "1.23", "12.3", "–"))
        self.assertEqual((page.upward(123.01), page.upward(1.231), page.upward(12345.0)), ("124", "1.24", "12400"))
        self.assertEqual((page.error(0.1234), page.error(12.6), page.error(math.nan)), ("0.12", "13", "?"))


if __name__ == "__main__":
    unittest.main()
