"""Reading tables of runs: columns, filters, reasons, what is refused."""

import unittest

import numpy as np

from mpmtools import equations
from mpmtools.errors import ConfigError, InputError
from mpmtools.fit.runs import RowFilter, read_study_table
from mpmtools.tables import csv_text, number_text, read_series, read_table
from study_samples import InFolder

TABLE = """\
# plan: quick
# machine: two cores
run,conveyor.froude_number,material.critical_state_slope,cohesion_beta,hardening_xi,flow_height_m,obstacle.width_m,cell_size_m,steady,status,\
runup_mean_m,runup_standard_error_m,runup_peak_m,pressure_height_mean_m
a,1,0.4,0.15,5,1.75,1.75,0.25,true,done,3.5,0.35,7,2.625
b,3,0.4,0.15,0.5,1.75,3.5,0.5,true,done,7,0.7,8.75,
c,5,0.8,0,5,1.75,1.75,0.25,false,done,nan,nan,9,nan
d,7,0.8,0,5,1.75,1.75,0.25,,unstable,,,,
"""


class StudyTables(InFolder):
    def read(self, text, *conditions):
        return read_study_table([self.write("results.csv", text)], [RowFilter(c) for c in conditions])

    def test_heights_are_over_the_flow_height_and_inputs_are_found_by_the_end_of_their_name(self):
        table = self.read(TABLE)
        self.assertEqual((len(table.runs), table.rows), (2, 4))
        a, b = table.runs.iloc[0], table.runs.iloc[1]
        self.assertEqual(a.folder, str(self.folder / "a"))
        self.assertEqual(a.froude_number, 1.0)
        self.assertEqual(a.effective_friction, equations.effective_friction(0.4, 0.15))
        self.assertEqual(a.velocity_m_s, equations.flow_velocity(1.0, 1.75))
        self.assertEqual((a.runup, a.runup_peak, a.pressure_height), (2.0, 4.0, 1.5))
        self.assertAlmostEqual(a.runup_standard_error, 0.2, delta=1e-15)
        self.assertTrue(np.isnan(a.pressure_height_standard_error))  # no such column
        self.assertTrue(a.at_reference_width)
        self.assertFalse(b.at_reference_width)
        self.assertEqual(b.relative_width, 2.0)
        self.assertTrue(np.isnan(b.pressure_height))
        self.assertEqual(table.provenance, ["plan: quick", "machine: two cores"])

    def test_rows_without_a_mean_are_counted_by_reason(self):
        table = self.read(TABLE, "hardening_xi=5")
        self.assertEqual(table.left_out, {"filter hardening_xi=5": 1, "no steady span": 1, "status: unstable": 1})
        self.assertEqual(len(table.runs), 1)

    def test_of_several_filters_the_first_that_drops_a_row_is_the_reason(self):
        table = self.read(TABLE, "hardening_xi=5", "cell_size_m=0.25", "status=done")
        self.assertEqual(table.left_out, {"filter hardening_xi=5": 1, "no steady span": 1, "filter status=done": 1})

    def test_say_what_varies_and_is_not_in_the_equations(self):
        self.assertIn("cell_size_m varies (0.25, 0.5)", " ".join(self.read(TABLE).cautions))
        self.assertEqual(self.read(TABLE, "cell_size_m=0.25").cautions, [])

    def test_any_key_of_the_case_may_vary_and_an_empty_cell_is_a_value(self):
        head = ("name,run,status,precision,froude_number,velocity_m_s,critical_state_slope,cohesion_beta,hardening_xi,effective_friction,flow_height_m,"
                "conveyor_width_m,{},output.duration_s,runup_mean_m,pressure_height_mean_m,force_mean_n.x,cause\n")
        row = "{0},runs/{0},done,{1},{0},{0},0.4,0,5,0.4,2,14,{2},{0},4,3,{0},\n"

        def said(key, *cells, precision=("single", "single")):
            cautions = self.read(head.format(key) + "".join(row.format(i + 1, precision[i], cell) for i, cell in enumerate(cells))).cautions
            return [text.partition(", which")[0] for text in cautions]

        self.assertEqual(said("numerics.contact", "surface", "nodal"), ["numerics.contact varies (nodal, surface)"])
        self.assertEqual(said("numerics.shock_viscosity", "0.0", ""), ["numerics.shock_viscosity varies (0.0, not given)"])
        self.assertEqual(said("conveyor.front_angle_deg", "60", "60.0"), [])
        self.assertEqual(said("obstacle.base_m", "10", "9"), ["obstacle.base_m varies (9, 10)"])
        self.assertEqual(said("numerics.cfl", "1", "1", precision=("single", "double")), ["precision varies (double, single)"])
        self.assertEqual(said("numerics.precision", "single", "double", precision=("single", "double")), ["numerics.precision varies (double, single)"])
        self.assertEqual(said("arm.height_m", *"12345678", precision=["single"] * 8), ["arm.height_m varies (1, 2, 3, 4, 5, 6, ...)"])

    def test_a_key_that_only_one_of_two_tables_has_varies(self):
        head = "froude_number,effective_friction,hardening_xi,flow_height_m,{}runup_mean_m,pressure_height_mean_m\n"
        files = [self.write("nodal.csv", head.format("numerics.contact,") + "1,0.4,5,2,nodal,4,3\n"), self.write("other.csv", head.format("") + "3,0.4,5,2,4,3\n")]
        self.assertIn("numerics.contact varies (not given, nodal)", read_study_table(files).cautions[0])

    def test_finest_keeps_one_run_of_a_set_up_that_on_the_finest_grid(self):
        head = "froude_number,critical_state_slope,cohesion_beta,hardening_xi,flow_height_m,cell_size_m,status,runup_mean_m,pressure_height_mean_m\n"
        coarse = self.write("w5.csv", head + "".join(f"{froude},0.4,0,5,2,0.35,done,{runup},3\n" for froude, runup in ((1, 4), (2, ""), (3, 6), (5, 8), (7, 9))))
        fine = self.write("w7.csv", head + "2,0.4,0,5,2,0.25,done,5,3\n3,0.4,0,5,2,0.25,done,7,3\n5,0.4,0,5,2,0.25,done,,\n7,0.4,0,5,2,0.25,running,,\n")
        table = read_study_table([coarse, fine], finest=True)
        found = table.runs.set_index("froude_number")
        self.assertEqual(found.runup.to_dict(), {1.0: 2.0, 2.0: 2.5, 3.0: 3.5, 7.0: 4.5})  # at Fr 5 the finer run is not steady: none counts
        self.assertEqual(found.cell_size_m.to_dict(), {1.0: 0.35, 2.0: 0.25, 3.0: 0.25, 7.0: 0.35})
        self.assertEqual(table.left_out["the same set-up is there on a finer grid"], 3)
        self.assertEqual(sorted(table.coarser.froude_number), [3.0, 5.0])  # that at Fr 2 is not steady
        self.assertEqual(table.cautions, [])
        self.assertEqual(len(read_study_table([coarse, fine]).runs), 6)
        with self.assertRaisesRegex(ConfigError, "finest grid: .*cell_size_m"):
            read_study_table([self.write("x.csv", "froude_number,effective_friction,hardening_xi,flow_height_m,runup_mean_m,pressure_height_mean_m\n"
                                         "1,0.4,5,2,4,3\n")], finest=True)

    def test_friction_of_the_mast_that_follows_the_snows_own_is_one_choice(self):
        head = ("froude_number,effective_friction,hardening_xi,flow_height_m,obstacle_friction,obstacle_friction_ratio,runup_mean_m,"
                "pressure_height_mean_m\n")
        self.assertEqual(self.read(head + "1,0,5,2,0,nan,4,3\n1,0.4,5,2,0.095,0.5,4,3\n3,0.8,5,2,0.189,0.50000000000000011,4,3\n").cautions, [])
        self.assertEqual(len(self.read(head + "1,0,5,2,0,nan,4,3\n1,0.4,5,2,0.095,0.5,4,3\n3,0.8,5,2,0.15,0.397,4,3\n").cautions), 1)

    def test_take_velocity_and_effective_friction_in_place_of_froude_number_and_rheology(self):
        table = self.read("velocity_m_s,effective_friction,hardening_xi,flow_height_m,runup_mean_m,pressure_height_mean_m\n6,0.5,5,2,4,3\n")
        run = table.runs.iloc[0]
        self.assertEqual(run.froude_number, equations.froude_number(6.0, 2.0))
        self.assertEqual(run.effective_friction, 0.5)
        self.assertTrue(np.isnan(run.critical_state_slope))
        self.assertTrue(run.at_reference_width)  # no width in the table
        self.assertEqual((run.folder, table.provenance), ("", []))

    def test_an_empty_input_leaves_its_row_out(self):
        head = "froude_number,critical_state_slope,cohesion_beta,hardening_xi,flow_height_m,runup_mean_m,pressure_height_mean_m\n"
        self.assertEqual(self.read(head + "1,0.4,0,5,2,4,3\n1,,0,5,2,4,3\n").left_out, {"an input is missing": 1})

    def test_say_which_programs_computed_the_runs(self):
        table = self.read("version,commit,froude_number,effective_friction,hardening_xi,flow_height_m,runup_mean_m,pressure_height_mean_m\n"
                          "0.1.0,abc,1,0.5,5,2,4,3\n0.1.0,def,3,0.5,5,2,4,3\n0.1.0,abc,5,0.5,5,2,nan,nan\n,,7,0.5,5,2,nan,nan\n")
        self.assertEqual(table.provenance, ["2 runs by version 0.1.0, commit abc", "1 run by version 0.1.0, commit def"])

    def test_say_how_a_campaign_was_computed(self):
        self.write("runs.csv", 'name,threads,wall_time_s,instruction_set,compiler\na,1,1800,AVX2,"gcc, 12"\nb,1,5400,AVX2,"gcc, 12"\nc,,,,\n')
        table = self.read(TABLE)
        self.assertEqual(table.provenance[2:], ["2 runs with 1 thread(s) a run, AVX2, gcc, 12", "2.0 h of wall time, summed over the runs"])
        self.assertEqual(table.files, [str(self.folder / "results.csv")])

    def test_of_several_files_are_put_together(self):
        files = [self.write("one.csv", TABLE), self.write("two.csv", TABLE.replace(",3.5,0.35", ",3.6,0.35").replace(",7,0.7,", ",7.1,0.7,"))]
        self.assertEqual(len(read_study_table(files).runs), 4)

    def test_the_same_table_given_twice_is_refused(self):
        path = self.write("results.csv", TABLE)
        for again in (path, str(self.folder / "." / "results.csv")):
            with self.assertRaisesRegex(ConfigError, "given twice"):
                read_study_table([path, again])

    def test_a_row_that_another_table_holds_too_counts_once(self):
        table = read_study_table([self.write("one.csv", TABLE), self.write("copy.csv", TABLE)])
        self.assertEqual(len(table.runs), 2)
        self.assertEqual(table.left_out["the same row as one before"], 4)

    def test_a_row_that_stands_twice_in_one_table_counts_once(self):
        first_two = "".join(TABLE.splitlines(keepends=True)[3:5])
        table = self.read(TABLE + first_two)
        self.assertEqual((table.rows, len(table.runs)), (6, 2))
        self.assertEqual(table.left_out["the same row as one before"], 2)

    def test_refuse_what_they_cannot_read(self):
        with self.assertRaisesRegex(InputError, "no column 'hardening_xi', .*'critical_state_slope', 'cohesion_beta'; there are: run, "):
            self.read("run,runup_mean_m\na,1\n")
        with self.assertRaisesRegex(ConfigError, r"no column 'hardening' \(did you mean 'hardening_xi'\?\); there are: run, "):
            self.read(TABLE, "hardening=1")
        with self.assertRaisesRegex(ConfigError, "'done' in the table is no number"):
            self.read(TABLE, "status<3")
        with self.assertRaisesRegex(InputError, "may be a.froude_number or b.froude_number"):
            self.read("a.froude_number,b.froude_number,effective_friction,hardening_xi,flow_height_m,runup_mean_m,pressure_height_mean_m\n")
        with self.assertRaisesRegex(ConfigError, "beta must be at least 0 and less than 1, not 1.2"):
            self.read(TABLE.replace("3,0.4,0.15", "3,0.4,1.2"))


class Tables(InFolder):
    def test_messages_name_file_and_line(self):
        for text, message in (("", "no header line"), ("a,a\n", ":1: column 'a' is named twice"), ("a,\n", ":1: column 2 has no name"),
                              ("# c\na,b\n1,2\n3\n", ":4: 1 cell where the header names 2"), ('a,b\n1,"2\n', ":2: ")):
            with self.assertRaisesRegex(InputError, message, msg=text):
                read_table(self.write("t.csv", text))
        with self.assertRaisesRegex(InputError, "cannot read .*none.csv.*: No such file"):
            read_table(str(self.folder / "none.csv"))

    def test_a_cell_that_is_no_number_is_named_with_its_line(self):
        with self.assertRaisesRegex(InputError, ":4: column 'froude_number' holds 'x'; a number is needed"):
            text = TABLE.replace("conveyor.froude_number", "froude_number").replace("a,1,", "a,x,")
            read_study_table([self.write("t.csv", text)])

    def test_a_mean_height_that_is_none_is_named_with_its_line(self):
        head = "velocity_m_s,effective_friction,hardening_xi,flow_height_m,runup_mean_m,pressure_height_mean_m\n6,0.5,5,2,4,3\n"
        for heights, message in (("inf,3", ":3: column 'runup_mean_m' holds inf"), ("4,-1", ":3: column 'pressure_height_mean_m' holds -1")):
            with self.assertRaisesRegex(InputError, message):
                read_study_table([self.write("t.csv", head + f"6,0.6,5,2,{heights}\n")])

    def test_numbers_are_written_as_short_as_they_read_back(self):
        self.assertEqual([number_text(x) for x in (5.0, 0.1, -0.0, 1e-20, 1 / 3, 1e22)], ["5", "0.1", "0", "1e-20", "0.3333333333333333", "1e+22"])
        table = read_series(self.write("t.csv", "a,b\n1,nan\n0.30000000000000004,2\n"))
        self.assertEqual(csv_text(table), "a,b\n1,nan\n0.30000000000000004,2\n")

    def test_a_last_line_that_was_cut_off_is_dropped(self):
        self.assertEqual(read_series(self.write("series.csv", "time_s,runup_m\n0,1\n1,2\n2,")).time_s.tolist(), [0, 1])


class Filters(unittest.TestCase):
    def test_compare_numbers_as_numbers_and_text_as_text(self):
        for text, cell, kept in (("x=0.5,5", "5.0", True), ("x = 0.5, 5", "0.5", True), ("x=0.5,5", "1.5", False), ("x!=0.5,5", "5", False),
                                 ("x<=3", "3", True), ("x<3", "3", False), ("x>2.5", "3", True), ("x>=3", "2.9", False), ("x>=3", "", False),
                                 ("transfer=apic", "apic", True)):
            self.assertEqual(RowFilter(text).keeps(cell), kept, (text, cell))
        self.assertEqual(RowFilter("transfer=apic").column, "transfer")

    def test_refuse_what_is_no_condition(self):
        for text in ("", "x", "=3", "x==3", "x<a", "x<1,2", "x=>3"):
            with self.assertRaises(ConfigError, msg=text):
                RowFilter(text)


if __name__ == "__main__":
    unittest.main()
