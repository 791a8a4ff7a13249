"""Factors of the loads beyond the paper, from small made-up rows whose factors are known."""

import unittest

import numpy as np
import pandas as pd

from analysis import loads, texts
from in_folder import InFolder

H = 2.0


def row(froude, friction, force, **more):
    """A run with a moment of 1.5 m times the force, errors of 1 % and numerical uncertainties of 4 % of the values."""
    values = {"force": force, "moment": 1.5 * force, "runup": 3.0 * H, "pressure_height": 2.0 * H}
    found = {"status": "done", "steady": 1, "froude_number": froude, "effective_friction": friction, "flow_height_m": H, "velocity_m_s": 10.0,
             "obstacle_width_m": 1.75, "obstacle.shape": "box", "obstacle.depth_m": 1.75, "force_mean_n.z": -0.2 * force, "force_standard_error_n.z": 0.01 * force,
             "force_filtered_peak_n": 1.6 * force, "overturning_moment_filtered_peak_n_m": 2.0 * 1.5 * force}
    for quantity, columns in loads.VALUES.items():
        found |= dict(zip(columns, (values[quantity], 0.01 * values[quantity], 0.04 * values[quantity])))
    return found | more


def factor_of(table, **conditions):
    of = table[np.logical_and.reduce([table[key] == value for key, value in conditions.items()])]
    assert len(of) == 1, of
    return of.iloc[0]


class Factors(InFolder):
    def rows_of(self, *rows):
        path = self.folder / "rows.csv"
        pd.DataFrame(rows).to_csv(path, index=False)
        return loads.read_rows(path)

    def test_of_shapes_are_over_the_square_in_the_same_flow(self):
        table = loads.shape_factors(self.rows_of(
            row(3, 0.4, 100e3), row(3, 0.4, 70e3, **{"obstacle.shape": "cylinder"}), row(3, 0.4, 80e3, **{"obstacle.rotation_deg": 15.0}),
            row(3, 0.4, 60e3, **{"obstacle.shape": "wedge", "obstacle.depth_m": 0.875}), row(5, 0.4, 300e3),
            row(5, 0.4, 240e3, **{"obstacle.shape": "cylinder"}), row(7, 0.4, 1.0, **{"obstacle.shape": "cylinder"})))
        self.assertEqual(set(table["name"]), {"square", "cylinder", "square_15", "wedge_45"})
        self.assertEqual(set(table.froude_number), {3.0, 5.0}, "no square at Fr 7")
        found = factor_of(table, name="cylinder", quantity="force", froude_number=3.0)
        self.assertAlmostEqual(found.factor, 0.7)
        self.assertAlmostEqual(found.uncertainty, 0.7 * np.sqrt(2.0 * (0.02**2 + 0.04**2)))
        square = factor_of(table, name="square", quantity="force", froude_number=3.0)
        self.assertEqual((square.factor, square.uncertainty), (1.0, 0.0))
        self.assertAlmostEqual(factor_of(table, name="square_15", quantity="moment", froude_number=3.0).factor, 0.8)
        self.assertAlmostEqual(factor_of(table, name="wedge_45", quantity="runup", froude_number=3.0).factor, 1.0)

    def test_of_fronts_are_the_peak_over_the_mean_and_the_arm_over_the_flow_height(self):
        table = loads.front_factors(self.rows_of(row(3, 0.4, 100e3), row(3, 0.4, 90e3, **{"conveyor.inflow_slip_ratio": 0.4, "conveyor.front_angle_deg": 20.0})))
        self.assertEqual(set(table["name"]), {"front_90_slip_1", "front_20_slip_0.4"})
        self.assertAlmostEqual(factor_of(table, name="front_20_slip_0.4", quantity="peak_force").factor, 1.6)
        self.assertAlmostEqual(factor_of(table, name="front_90_slip_1", quantity="peak_moment").factor, 2.0)
        self.assertAlmostEqual(factor_of(table, name="front_90_slip_1", quantity="lever_arm").factor, 1.5 / H)

    def test_of_sheared_inflow_are_over_the_plug_behind_the_same_front(self):
        sheared = {"conveyor.inflow_slip_ratio": 0.4}
        table = loads.front_factors(self.rows_of(
            row(3, 0.4, 100e3), row(3, 0.4, 120e3, **sheared), row(3, 0.4, 150e3, **{"conveyor.front_angle_deg": 20.0}),
            row(5, 0.4, 1.0, **sheared), row(3, 0.4, 180e3, **sheared, **{"conveyor.front_angle_deg": 20.0})))
        for name, factor in (("front_90_slip_0.4", 1.2), ("front_20_slip_0.4", 1.2)):
            found = factor_of(table, name=name, quantity="force_over_plug")
            self.assertAlmostEqual(found.factor, factor)
            self.assertAlmostEqual(found.uncertainty, factor * np.sqrt(2.0 * (0.02**2 + 0.04**2)))
        plug = factor_of(table, name="front_90_slip_1", quantity="runup_over_plug")
        self.assertEqual((plug.factor, plug.uncertainty), (1.0, 0.0))
        self.assertFalse((table[table.froude_number == 5.0].quantity == "force_over_plug").any(), "no plug at Fr 5")

    def test_of_arms_are_over_the_head_on_their_front(self):
        head = 0.5 * 300.0 * 100.0 * (5.25 - 1.75) * 1.0
        on_arm = {"arm.base_m": H, "arm.height_m": H + 1.0, "arm_force_mean_n.x": 0.4 * head, "arm_force_standard_error_n.x": 0.01 * head,
                  "arm_force_mean_n.z": -0.1 * head, "arm_force_standard_error_n.z": 0.002 * head,
                  "arm_force_filtered_peak_n": 0.9 * head, "arm_force_z_filtered_peak_n": 0.3 * head}
        table = loads.arm_factors(self.rows_of(row(3, 0.4, 50e3, **on_arm)))
        for quantity, factor, uncertainty in (("drag", 0.4, 0.02), ("lift", -0.1, 0.004), ("peak_drag", 0.9, np.nan), ("peak_lift", 0.3, np.nan)):
            found = factor_of(table, name="base_1", quantity=quantity)
            self.assertAlmostEqual(found.factor, factor)
            np.testing.assert_allclose(found.uncertainty, uncertainty)

    def test_leave_out_runs_without_a_steady_mean_and_are_nan_uncertain_where_the_grid_is(self):
        unknown = {column: np.nan for *_, column in loads.VALUES.values()}
        table = loads.shape_factors(self.rows_of(row(3, 0.4, 100e3, **unknown), row(3, 0.4, 70e3, **{"obstacle.shape": "cylinder"}),
                                                 row(3, 0.4, 1.0, steady=0, **{"obstacle.rotation_deg": 45.0})))
        self.assertEqual(set(table["name"]), {"square", "cylinder"})
        self.assertTrue(np.isnan(factor_of(table, name="cylinder", quantity="force").uncertainty))


class Tables(unittest.TestCase):
    table = pd.DataFrame([{"kind": "shape", "name": "cylinder", "quantity": "force", "froude_number": froude, "effective_friction": m,
                           "factor": 0.6 + 0.1 * np.log(froude) + 0.2 * m, "uncertainty": 0.1} for froude in (0.3, 3.0, 7.0) for m in (0.4, 1.2)])

    def test_for_mpm_design_are_those_of_the_rows(self):
        made = texts.rounded(loads.load_factors())
        self.assertEqual(texts.differences(made, texts.kept_tables()["load_factors"]), [], "./run study --write")
        made.loc[0, "factor"] *= 1.01
        self.assertRegex(texts.differences(made, texts.kept_tables()["load_factors"])[0], f"factor of '{made.key[0]}' is .*, the rows give")
        self.assertIn(f"# {loads.provenance()}\n", texts.place_of("load_factors").read_text())

    def test_over_snow_has_the_mean_and_range_over_the_friction(self):
        found = loads.over_snow(self.table).set_index("key")
        self.assertAlmostEqual(found.loc["shape cylinder force 3", "factor"], 0.6 + 0.1 * np.log(3.0) + 0.16)
        self.assertAlmostEqual(found.loc["shape cylinder force 3", "factor_high"] - found.loc["shape cylinder force 3", "factor_low"], 0.16)

    def test_on_the_page_have_mean_and_range_and_the_largest_uncertainty(self):
        flows = [{"froude_number": froude, "effective_friction": m} for froude in (1.0, 3.0) for m in (0.4, 1.2)]
        table = pd.DataFrame([{"kind": kind, "name": name, "quantity": quantity, **flow, "factor": 0.625 + 0.25 * flow["effective_friction"], "uncertainty": 0.1}
                              for kind, name, quantity in (("shape", "square_45", "force"), ("front", "front_90_slip_0", "peak_force"),
                                                           ("front", "front_20_slip_0", "peak_force"), ("arm", "base_1.5", "drag")) for flow in flows])
        values = texts.Values({"load_factors": table.assign(key=range(len(table))), "load_factors_over_snow": loads.over_snow(table)})
        both = "0.82 (0.72 to 0.93) | 0.82 (0.72 to 0.93)"
        self.assertIn(f"| square 45, wedge 45 | {both} |", values.block("shape_factors"))
        self.assertIn("| 1.5 H | 0.82 (0.72 to 0.93) |", values.block("arms"))
        peaks = values.block("peaks")
        self.assertIn("| slip | front of 90° | front of 45° | front of 20° |", peaks)
        self.assertIn("| 0 | 0.82, 0.82, – | –, –, – | 0.82, 0.82, – |", peaks)
        self.assertEqual(values.loads_spread("front", "peak_force"), "−12 to +12 %")
        self.assertAlmostEqual(values.loads_uncertainty("front", "peak_force"), 0.1 / 0.725)


if __name__ == "__main__":
    unittest.main()
