"""The plans of the study, as the program expands them: the expansion is the same as ever, every plan names its numerics, reproduction and
prediction differ in nothing else, and the full ones hold the paper's 371 sets."""

import csv
import functools
import itertools
import json
import os
import tempfile
import tomllib
import unittest

import numpy as np
import pandas as pd

from mpmtools import Campaign
from mpmtools.equations import effective_friction, friction_angle
from analysis import yardstick
from analysis.grids import UNCONVERGED
from analysis.loads import ARM_LENGTH
from mpmtools.fit.runs import POINT
from mpmtools.program import run_program
from study_samples import BETAS, FROUDE, SLOPES, SOURCE

STUDY = SOURCE / "validation" / "study"
FINER_PREDICTION = STUDY / "prediction" / "w7.toml"
REPRODUCTION = {"numerics.contact": "nodal", "numerics.transfer": "apic", "numerics.shock_viscosity": 0}
PREDICTION = {"numerics.contact": "surface", "numerics.transfer": "aflip", "numerics.relaxation_cells": 5, "numerics.shock_viscosity": 10}
INPUTS = ("conveyor.froude_number", "material.critical_state_slope", "material.cohesion_beta", "material.hardening_xi")
RUNS = {  # of each plan
    "extensions/arms": 45, "extensions/fronts": 108, "extensions/height": 24, "extensions/shapes": 160, "prediction/grids": 48, "prediction/settled": 12, "prediction/time_step": 54, "prediction/w5": 371,
    "prediction/w7": 371, "quick": 12, "reproduction/friction": 177, "reproduction/placement_rules": 12, "reproduction/friction_rules": 520, "reproduction/full": 371,
    "reproduction/sections": 2, "reproduction/strip": 20, "reproduction/transfer": 45, "reproduction/transfer_rules": 12, "reproduction/w5": 371,
    "reproduction/windows": 72, "sensitivity": 99, "width": 24}


def setUpModule():
    if "MPM" not in os.environ:
        raise unittest.SkipTest("needs the program: set MPM to its path (ctest does)")


def plans():
    return [path for path in sorted(STUDY.rglob("*.toml")) if path.parent.name != "common" and path != STUDY / "base.toml"]


@functools.cache
def expansion(path):
    return Campaign(path).expansion()


def accurate(path):
    """Whether a plan is of the accurate solver."""
    return path.parent.name in ("prediction", "extensions") or path.stem == "width"


def base_of(path):
    """Keys of the plan's base, as dotted names."""
    return {f"{section}.{key}": value for section, keys in expansion(path)["base"].items() if isinstance(keys, dict) for key, value in keys.items()}


def runs_of(path):
    """The keys of every run in the order of the plan."""
    return [{**base_of(path), **run["settings"]} for run in expansion(path)["runs"]]


def inputs_of(path):
    return [tuple(run[key] for key in INPUTS) for run in runs_of(path)]


def stored_rows(path):
    """Finished runs in the tables of stored results of a plan."""
    rows = []
    for table in tomllib.loads(path.read_text("utf-8")).get("stored_results", []):
        with open(path.parent / table, newline="", encoding="utf-8") as file:
            rows += [row for row in csv.DictReader(file) if row["status"] == "done"]
    return rows


class Expansion(unittest.TestCase):
    def test_has_as_many_runs_as_before_lists_and_includes(self):
        self.assertEqual({str(path.relative_to(STUDY).with_suffix("")): len(expansion(path)["runs"]) for path in plans()}, RUNS)

    def test_has_the_cases_of_all_stored_results(self):
        for path in plans():
            if path.stem in ("friction", "friction_rules"):  # share their rows
                continue
            runs = {run["case_hash"] for run in expansion(path)["runs"] if run["stored"]}
            self.assertEqual(runs, {row["case_hash"] for row in stored_rows(path)}, path)
            self.assertEqual(expansion(path)["unused_rows"], 0, path)


class Numerics(unittest.TestCase):
    def test_are_named_by_every_plan_and_not_left_to_defaults(self):
        for path in plans():
            wanted = PREDICTION if accurate(path) else REPRODUCTION
            if path.stem == "transfer_rules":
                wanted = REPRODUCTION | {"numerics.transfer": "aflip"}
            varied = {key for key in wanted if len({run.get(key) for run in runs_of(path)}) > 1}
            for run in runs_of(path):
                self.assertEqual({key: wanted[key] if key in varied else run.get(key) for key in wanted}, wanted, path)
                if run["numerics.transfer"] == "flip":
                    self.assertIn("numerics.flip_ratio", run, path)

    def test_take_means_while_the_papers_runup_is_steady(self):
        for path in plans():
            self.assertEqual({run.get("measurement.steady_by") for run in runs_of(path)}, {"runup"}, path)

    def test_of_the_reproduction_have_no_viscosity_of_shocks_which_its_rows_do_not_have(self):
        for path in plans():
            if not accurate(path):
                self.assertEqual({run.get("numerics.shock_viscosity") for run in runs_of(path)}, {0}, path)

    def test_of_the_two_campaigns_are_all_that_differs_between_them_but_for_friction_and_time_step(self):
        reproduction, prediction = ({tuple(run[key] for key in INPUTS): run for run in runs_of(STUDY / folder / "w5.toml")}
                                    for folder in ("reproduction", "prediction"))
        differing = {key for inputs, run in reproduction.items() for key in {*run, *prediction[inputs]} if run.get(key) != prediction[inputs].get(key)}
        self.assertEqual(differing, {*PREDICTION, "numerics.cfl", "obstacle.friction"})

    def test_of_the_strip_are_those_of_the_reproduction(self):
        base, strip = (base_of(STUDY / "reproduction" / name) for name in ("full.toml", "strip.toml"))
        for key in ("obstacle.width_m", "obstacle.depth_m", "obstacle.friction_ratio", "conveyor.flow_height_m", "conveyor.lattice",
                    "conveyor.mirror_y", "measurement.steady_by", "numerics.particles_per_cell", "numerics.contact", "numerics.transfer", "numerics.shock_viscosity"):
            self.assertEqual(strip[key], base[key], key)


class FullCampaigns(unittest.TestCase):
    reproduction = [STUDY / "reproduction" / "full.toml", STUDY / "reproduction" / "w5.toml"]
    paths = [*reproduction, STUDY / "prediction" / "w5.toml", FINER_PREDICTION]

    def test_hold_the_papers_371_sets(self):
        for path in self.paths:
            inputs = inputs_of(path)
            self.assertEqual((len(inputs), len(set(inputs))), (371, 371), path)
            for froude, slope, beta, xi in itertools.product(FROUDE, SLOPES, BETAS, (5, 0.5, 0.05)):
                self.assertIn((froude, slope, beta, xi), inputs, path)
            for froude in FROUDE:
                self.assertGreaterEqual(sum(f == froude for f, *_ in inputs), 48, path)  # Sect. 2.2

    def test_hold_the_same_sets(self):
        for path in self.paths[1:]:
            self.assertEqual(sorted(inputs_of(path)), sorted(inputs_of(self.paths[0])), path)

    def test_of_the_reproduction_have_the_friction_that_fits_their_grid(self):
        """At 0.25 m half of tan phi'; at w/5 no more than 0.2, but for M' 2.30."""
        for path in self.reproduction:
            for run in runs_of(path):
                half = 0.5 * np.tan(friction_angle(effective_friction(run["material.critical_state_slope"], run["material.cohesion_beta"])))
                limited = path.name == "w5.toml" and 0.2 < half < 0.7
                self.assertEqual(run.get("obstacle.friction"), 0.2 if limited else None, run)
                self.assertEqual(run["obstacle.friction_ratio"], 0.5)  # used where no friction is given

    def test_follow_fluids_at_critical_speed_to_the_end(self):
        """At Fr 1 fluids with contact on nodes settle late (evidence/stop_when_steady)."""
        for path in (*self.reproduction, STUDY / "prediction" / "w5.toml"):
            stops = {run["output.stop_when_steady"] for run in runs_of(path) if run["conveyor.froude_number"] == 1}
            self.assertEqual(stops, {0}, path)

    def test_take_at_least_the_papers_durations(self):
        longest = {0.1: 120, 0.3: 110, 1: 36.7, 2: 7.5, 3: 7.5, 5: 10, 7: 10}  # Table 2
        for path in self.paths:
            for run in runs_of(path):
                self.assertGreaterEqual(run["output.duration_s"], longest[run["conveyor.froude_number"]], path)

    def test_begin_with_what_the_fits_rest_on(self):
        """The first third fits both equations: all thirteen M', both xi, five Froude numbers; the fluids with beta > 0 come last."""
        for path in self.paths[:-1]:  # of the finer prediction the next test
            inputs = inputs_of(path)
            first, last = inputs[:130], inputs[-63:]
            self.assertEqual({xi for *_, xi in first}, {5, 0.5})
            self.assertEqual(len({(m, b) for _, m, b, _ in first}), 13)
            self.assertEqual({f for f, *_ in first}, {1, 2, 3, 5, 7})
            self.assertTrue(all(m == 0 and b > 0 for _, m, b, _ in last), path)

    def test_of_the_finer_prediction_begins_with_what_is_not_converged_at_w5(self):
        first = pd.DataFrame(inputs_of(FINER_PREDICTION)[:68], columns=["froude_number", "critical_state_slope", "cohesion_beta", "hardening_xi"])
        first["effective_friction"] = [effective_friction(m, b) for m, b in zip(first.critical_state_slope, first.cohesion_beta)]
        self.assertTrue(np.any([holds(first) for holds in UNCONVERGED.values()], axis=0).all())
        self.assertEqual(len(first.drop_duplicates()), 68)


class OpenQuestions(unittest.TestCase):
    def test_friction_has_every_rule_at_every_set_of_the_narrow_fit(self):
        """In the plan, or as a row of the reproduction (yardstick.rows_of)."""
        computed = [*runs_of(STUDY / "reproduction" / "friction_rules.toml"), *runs_of(STUDY / "reproduction" / "full.toml")]
        runs = pd.DataFrame([tuple(run[key] for key in INPUTS) for run in computed], columns=POINT).astype(float)
        runs["effective_friction"] = effective_friction(runs.critical_state_slope, runs.cohesion_beta)
        share = [run["obstacle.friction_ratio"] * np.tan(friction_angle(m)) for run, m in zip(computed, runs.effective_friction)]
        runs["obstacle_friction"] = [run.get("obstacle.friction", ratio) for run, ratio in zip(computed, share)]
        runs["at_reference_width"] = True
        for rule in yardstick.rules(*yardstick.CONSTANTS):
            chosen = yardstick.rows_of(rule, runs)
            self.assertEqual((chosen.effective_friction > 0.0).sum(), yardstick.PAPER_RUNS, rule.name)
            fluid = chosen[(chosen.effective_friction == 0.0) & (chosen.cohesion_beta == 0.0)]
            self.assertEqual(fluid.froude_number.nunique(), len(FROUDE), rule.name)

    def test_transfers_are_compared_at_a_dozen_points(self):
        runs = runs_of(STUDY / "reproduction" / "transfer.toml")
        points = {transfer: {tuple(run[key] for key in INPUTS) for run in runs if run["numerics.transfer"] == transfer}
                  for transfer in ("apic", "flip", "aflip")}
        self.assertEqual(points["apic"], points["flip"])
        self.assertEqual(points["apic"], points["aflip"])
        self.assertEqual(len(points["apic"]), 12)
        aligned = {tuple(run[key] for key in INPUTS) for run in runs if run["conveyor.lattice"] == "aligned"}
        self.assertEqual(aligned, {point for point in points["apic"] if point[INPUTS.index("conveyor.froude_number")] <= 1})
        self.assertEqual({run.get("numerics.flip_ratio") for run in runs}, {None, 0.95})

    def test_transfer_and_placement_are_judged_at_that_dozen_each_with_one_change(self):
        dozen = {tuple(run[key] for key in INPUTS) for run in runs_of(STUDY / "reproduction" / "transfer.toml")}
        point = (*INPUTS, "obstacle.friction")
        rules = {tuple(run[key] for key in point): run for run in runs_of(STUDY / "reproduction" / "friction_rules.toml") if "obstacle.friction" in run}
        for name, change in (("transfer_rules", "numerics.transfer"), ("placement_rules", "conveyor.lattice")):
            runs = runs_of(STUDY / "reproduction" / f"{name}.toml")
            self.assertEqual({tuple(run[key] for key in INPUTS) for run in runs}, dozen)
            pairs = [(run, rules[key]) for run in runs if (key := tuple(run[key] for key in point)) in rules]
            self.assertGreaterEqual(len(pairs), 8)  # slow loose snow is taken from the reproduction
            for run, base in pairs:
                self.assertEqual({key for key in {*run, *base} if run.get(key) != base.get(key)}, {change}, run)

    def test_points_on_three_grids_have_one_window_of_whole_cells(self):
        runs = runs_of(STUDY / "prediction" / "grids.toml")
        points = {size: {tuple(run[key] for key in INPUTS) for run in runs if run["numerics.cell_size_m"] == size} for size in (0.35, 0.25, 0.175)}
        self.assertEqual(len(points[0.35]), 16)
        self.assertTrue(all(of_size == points[0.35] for of_size in points.values()))
        self.assertGreaterEqual(len({froude for froude, *_ in points[0.35]}), 5)
        for run in runs:
            width = run.get("conveyor.width_m", 12 * 1.75)  # xi = 5: 12 mast widths; a mirror plane halves it
            for length in (run["conveyor.upstream_length_m"], run["conveyor.downstream_length_m"], width / 2):
                cells = length / run["numerics.cell_size_m"]
                self.assertAlmostEqual(cells, round(cells), 9, run)

    def test_windows_grow_twice_and_the_strip_holds_the_same_snow(self):
        windows = runs_of(STUDY / "reproduction" / "windows.toml")
        self.assertEqual({run["conveyor.upstream_length_m"] for run in windows}, {8.4, 16.8, 33.6})
        runs = runs_of(STUDY / "reproduction" / "strip.toml")
        self.assertEqual({(run["conveyor.froude_number"], run["output.duration_s"]) for run in runs}, {(1, 36.7), (0.3, 55), (0.3, 110), (0.1, 60), (0.1, 120)})
        strips = {tuple(run[key] for key in INPUTS) for run in runs}
        self.assertLessEqual({tuple(run[key] for key in INPUTS) for run in windows}, strips)
        self.assertEqual({slope for _, slope, *_ in strips}, {0, 0.4, 1.2})  # and a fluid and loose snow
        self.assertEqual({run["conveyor.sidewall_contact"] for run in windows if "conveyor.sidewall_contact" in run}, {"slip", "coulomb"})


class Costs(unittest.TestCase):
    def test_are_those_that_the_program_expects(self):
        """Of plans without a run; a row in stored results costs nothing."""
        for row in pd.read_csv(STUDY / "rows" / "costs.csv", comment="#").itertuples():
            with tempfile.TemporaryDirectory() as folder:
                status = json.loads(run_program("campaign", "status", str(STUDY / f"{row.key}.toml"), "--jobs", "1", "--json", "--out", folder)[1])
            self.assertEqual(status["to_do"], row.runs, row.key)
            self.assertAlmostEqual(status["time_left_s"] / 3600.0, row.core_hours, delta=0.1 + 0.1 * row.core_hours, msg=row.key)


class Extensions(unittest.TestCase):
    def test_have_the_points_of_the_three_results(self):
        for name, friction, froude in (("shapes", {0.4, 0.59, 1.2, 1.42}, {0.3, 1, 3, 5, 7}), ("fronts", {0.4, 0.59, 1.2}, {1, 3, 5}),
                                       ("arms", {0.4, 0.59, 1.2}, {3, 5, 7})):
            runs = runs_of(STUDY / "extensions" / f"{name}.toml")
            found = {round(float(effective_friction(run["material.critical_state_slope"], run["material.cohesion_beta"])), 2) for run in runs}
            self.assertEqual((found, {run["conveyor.froude_number"] for run in runs}), (friction, froude), name)

    def test_shapes_have_one_width_across_the_flow(self):
        for run in runs_of(STUDY / "extensions" / "shapes.toml"):
            turn = np.radians(run.get("obstacle.rotation_deg", 0.0))
            across = run["obstacle.width_m"] * np.cos(turn) + (run["obstacle.depth_m"] * np.sin(turn) if turn else 0.0)
            self.assertAlmostEqual(across, 1.75, 9)
            self.assertEqual(run.get("conveyor.mirror_y", True), run.get("obstacle.rotation_deg", 0) in (0, 45))

    def test_arms_are_half_a_flow_depth_thick(self):
        for run in runs_of(STUDY / "extensions" / "arms.toml"):
            self.assertAlmostEqual(run["arm.height_m"] - run["arm.base_m"], 0.5 * 1.75, 9)
            self.assertEqual(run["arm.length_m"], ARM_LENGTH)


if __name__ == "__main__":
    unittest.main()
