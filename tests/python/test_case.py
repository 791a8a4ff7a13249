"""Cases: read, changed, written; and, with the program (environment variable MPM), checked and run."""

import os
import pathlib
import tomllib
import unittest
import unittest.mock

import numpy as np

from mpmtools import Campaign, Case, ConfigError, InputError, MpmError, Run, compare, study_grids
from mpmtools.program import find_program
from mpmtools.toml_text import toml_text
from study_samples import SOURCE, InFolder

EXAMPLES = SOURCE / "examples"
SMALL = {"numerics.cell_size_m": 0.875, "conveyor.width_m": 8.75, "output.duration_s": 0.2}  # a run of a tenth of a second
needs_program = unittest.skipUnless("MPM" in os.environ, "needs the program: set MPM to its path (ctest does)")


class TomlText(unittest.TestCase):
    def test_reads_back_as_what_it_was(self):
        tables = {"title": 'a "b" \\ \n é', "n": 3, "x": 0.1, "tiny": 1e-300, "on": True, "inf": float("inf"), "empty": [], "list": [1.0, 2.5],
                  "numpy": np.float64(0.25), "count": np.int64(7), "a": {"b": 1, "c": {"d": 2}}, "wall": [{"p": [0, 0, 1]}, {"p": [1, 0, 0]}],
                  "odd key": {"numerics.cell_size_m": 1}}
        self.assertEqual(tomllib.loads(toml_text(tables)), tables)

    def test_writes_every_example_as_it_was_read(self):
        for path in EXAMPLES.rglob("*.toml"):
            tables = tomllib.loads(path.read_text(encoding="utf-8"))
            self.assertEqual(tomllib.loads(toml_text(tables)), tables, path)

    def test_writes_arrays_of_numpy_as_lists(self):
        arrays = {"offset": np.zeros(3), "one": np.array([0.5]), "rows": np.array([[1, 2], [3, 4]]), "words": np.array(["a", "b"]), "mixed": [np.float32(0.5), np.array([])],
                  "on": np.bool_(True), "number": np.array(2.0)}
        self.assertEqual(tomllib.loads(toml_text(arrays)), {"offset": [0.0, 0.0, 0.0], "one": [0.5], "rows": [[1, 2], [3, 4]], "words": ["a", "b"],
                                                            "mixed": [0.5, []], "on": True, "number": 2.0})

    def test_names_a_value_that_no_case_holds(self):
        with self.assertRaisesRegex(ConfigError, "obstacle.width_m = None"):
            toml_text({"obstacle": {"width_m": None}})


class Cases(InFolder):
    def test_give_and_change_keys_by_name(self):
        case = Case.read(EXAMPLES / "column_collapse.toml")
        other = case.changed({"numerics.cell_size_m": 0.5, "body[0].velocity_m_s": [1.0, 0.0, 0.0], "new.table": 1, "title": None})
        self.assertEqual((other["numerics.cell_size_m"], other["body[0].velocity_m_s"], other["new.table"]), (0.5, [1.0, 0.0, 0.0], 1))
        self.assertNotIn("title", other)
        self.assertNotEqual(case, other)
        self.assertNotIn("new", case)  # the first one is as it was
        self.assertEqual(case.get("numerics.nothing", 7), 7)
        self.assertEqual(Case({}).changed({key: value for key, value in case.items() if "[" not in key}),
                         case.changed({name: None for name in ("body", "wall")}))  # all keys, by their names
        self.assertTrue({"title", "body[0].min_m", "numerics.cell_size_m"} <= set(case) and "body" in case and len(case) == len(dict(case)))
        with self.assertRaisesRegex(KeyError, "the case does not give it"):
            case["body[9].min_m"]

    def test_hold_lists_in_place_of_arrays(self):
        case = Case.read(EXAMPLES / "column_collapse.toml")
        lists, arrays = (case.changed({"numerics.grid_offset_cells": of([0.0, 0.25, 0.0]), "body[0]": {"velocity_m_s": of([1.0, 0.0, 0.0])}}) for of in (list, np.array))
        self.assertEqual(arrays, lists)
        self.assertEqual(Case(arrays.tables), Case({**arrays.tables, "numerics": {**arrays["numerics"], "grid_offset_cells": np.array([0.0, 0.25, 0.0])}}))
        self.assertEqual((arrays["numerics.grid_offset_cells"], arrays["body[0].velocity_m_s"]), ([0.0, 0.25, 0.0], [1.0, 0.0, 0.0]))

    @needs_program
    def test_are_checked_with_arrays(self):
        case = Case.read(EXAMPLES / "avalanche_fr3.toml").changed({"numerics.grid_offset_cells": np.array([0.25, 0.0, 0.0])})
        self.assertEqual(case.check().case["numerics.grid_offset_cells"], [0.25, 0.0, 0.0])

    def test_reject_names_that_are_none(self):
        case = Case.read(EXAMPLES / "column_collapse.toml")
        for name, message in (("body[9].min_m", r"the case has \d \[\[body\]\]"), ("title.x", "'title' is no table"), ("a..b", "no name of a key")):
            with self.assertRaisesRegex(ConfigError, message):
                case.changed({name: 1})

    def test_written_elsewhere_keep_their_files(self):
        (self.folder / "a").mkdir()
        (self.folder / "a" / "flow.csv").write_text("time_s,depth_m,velocity_m_s\n", encoding="utf-8")
        (self.folder / "a" / "case.toml").write_text('[conveyor]\ninflow_csv = "flow.csv"\n', encoding="utf-8")
        case = Case.read(self.folder / "a" / "case.toml")
        moved = Case.read(case.write(self.folder / "b" / "case.toml"))
        self.assertEqual(pathlib.Path(moved["conveyor.inflow_csv"]), (self.folder / "a" / "flow.csv").resolve())
        self.assertEqual(Case.read(case.write(self.folder / "a" / "again.toml"))["conveyor.inflow_csv"], "flow.csv")

    def test_name_a_file_that_cannot_be_read(self):
        (self.folder / "no.toml").write_text("a = = 1", encoding="utf-8")
        for name, message in (("none.toml", "cannot read .*none.toml"), ("no.toml", "no.toml: Invalid value")):
            with self.assertRaisesRegex(InputError, message):
                Case.read(self.folder / name)


class Program(unittest.TestCase):
    def test_that_is_not_where_the_environment_says_is_named(self):
        before = os.environ.get("MPM")
        os.environ["MPM"] = "/nowhere/mpm"
        try:
            with self.assertRaisesRegex(InputError, "MPM=/nowhere/mpm: there is no program"):
                find_program()
        finally:
            os.environ.pop("MPM") if before is None else os.environ.update(MPM=before)


@needs_program
class CasesInTheProgram(InFolder):
    def setUp(self):
        super().setUp()
        self.case = Case.read(EXAMPLES / "avalanche_fr3.toml").changed(SMALL)

    def test_are_checked_with_cost_warnings_and_defaults(self):
        check = self.case.check()
        self.assertEqual(check.case["numerics.transfer"], "aflip")
        self.assertTrue(any("2 cells across the obstacle" in text for text in check.warnings), check.warnings)
        self.assertTrue({"particles", "steps", "time_step_s", "memory_gb", "disk_gb", "time_s", "wave_speed_m_s"} <= set(check.cost))
        self.assertGreaterEqual(check.cost["steps"], 0.2 / check.cost["time_step_s"])
        self.assertIn("particles", str(check))

    def test_with_wrong_keys_say_what_is_wrong_and_how_to_mend_it(self):
        with self.assertRaisesRegex(ConfigError, r"^case: \[numerics\] unknown key cell_siz_m; did you mean cell_size_m\?$"):
            self.case.changed({"numerics.cell_siz_m": 1}).check()
        with self.assertRaisesRegex(ConfigError, r"width_m = -1 is out of range"):
            self.case.changed({"obstacle.width_m": -1}).run(self.folder / "run", progress=False)

    def test_run_with_progress_to_a_run_that_reads_back(self):
        seen = []
        run = self.case.run(self.folder / "run", threads=1, progress=seen.append)
        self.assertEqual((seen[-1].fraction, seen[-1].time_s, seen[-1].duration_s), (1.0, 0.2, 0.2))
        self.assertEqual(run.results["duration_s"], 0.2)
        self.assertEqual(run.series.index[-1], 0.2)
        self.assertEqual(Case.read(self.folder / "run" / "case.toml")["numerics.cell_size_m"], 0.875)
        with self.assertRaisesRegex(MpmError, "--force"):
            self.case.run(self.folder / "run", threads=1, progress=False)
        longer = self.case.changed({"output.duration_s": 0.3}).run(self.folder / "run", threads=1, resume=True, progress=False)
        self.assertEqual(longer.results["duration_s"], 0.3)

    def test_run_where_there_are_no_terminals(self):
        seen = []
        with unittest.mock.patch("pty.openpty", side_effect=OSError("out of pty devices")):
            self.case.run(self.folder / "run", threads=1, progress=seen.append)
        self.assertEqual(seen[-1].fraction, 1.0)

    def test_that_name_files_run_elsewhere(self):
        self.write("flow.csv", "time_s,depth_m,velocity_m_s\n0,1.75,12\n1,1.75,10\n")
        case = Case(self.case.tables, self.folder).changed({"conveyor.inflow_csv": "flow.csv", "conveyor.froude_number": None})
        run = case.run(self.folder / "run", threads=1, progress=False)
        self.assertEqual(Case.read(self.folder / "run" / "case.toml")["conveyor.inflow[1].velocity_m_s"], 10.0)
        self.assertEqual(run.results["duration_s"], 0.2)

    def test_compare_as_the_program_does(self):
        a = self.case.run(self.folder / "a", threads=1, progress=False)
        b = self.case.changed({"obstacle.width_m": 2.625}).run(self.folder / "b", threads=1, progress=False)
        same = compare(a, a)
        self.assertEqual(set(same.verdict), {"identical"})
        table = compare(a, self.folder / "b", tolerance=1e-6)
        self.assertEqual(table.verdict["force_peak_n"], "DIFFERS")
        row = table.loc["force_peak_n"]
        self.assertEqual((row.a, row.b), (a.results["force_peak_n"], b.results["force_peak_n"]))
        self.assertEqual(row.difference, row.b - row.a)
        with self.assertRaisesRegex(ConfigError, "nothing could be judged"):
            compare(a, b)
        with self.assertRaisesRegex(InputError, "does not exist"):
            compare(a, self.folder / "nothing")

    def test_compare_names_the_columns_by_which_two_steady_intervals_were_found(self):
        for name, by in (("a", "runup"), ("b", "runup_p99")):
            self.case.changed({"measurement.steady_by": by}).run(self.folder / name, threads=1, progress=False)
        table = compare(self.folder / "a", self.folder / "b")
        self.assertEqual(table.iloc[0].tolist()[:2] + [table.verdict.iloc[0]], ['"runup_m"', '"runup_p99_m"', "DIFFERS"])
        self.assertEqual((table.index.name, table.index[0], table.verdict["force_peak_n"]), ("quantity", "steady_column", "identical"))

    def test_make_a_grid_study(self):
        study = study_grids(self.case, [1.25, 0.875], ["force_peak_n"], self.folder / "grids", threads=1, progress=False)
        self.assertEqual(study.table.cell_size_m.tolist(), [1.25, 0.875])
        self.assertEqual([run.results["force_peak_n"] for run in study.runs], study.metric("force_peak_n")["value"])
        for kind in (KeyError, MpmError):
            with self.assertRaisesRegex(kind, "^'runup_mean_m' was not studied; there are: force_peak_n$"):
                study.metric("runup_mean_m")

    def test_make_a_campaign(self):
        self.case.write(self.folder / "base.toml")
        self.write("plan.toml", 'base = "base.toml"\n[parameters]\n"material.critical_state_slope" = [0.4, 0.8]\n')
        campaign = Campaign(self.folder / "plan.toml", out=self.folder / "out")
        expansion = campaign.expansion()
        self.assertEqual([run["settings"] for run in expansion["runs"]], [{"material.critical_state_slope": slope} for slope in (0.4, 0.8)])
        self.assertEqual(expansion["base"], Case.read(self.folder / "base.toml").tables)
        self.assertFalse((self.folder / "out").exists())
        self.assertTrue(campaign.run(jobs=1))
        self.assertEqual(campaign.table.status.tolist(), ["done", "done"])
        self.assertEqual(campaign.table.case_hash.tolist(), [run["case_hash"] for run in expansion["runs"]])
        runs = Campaign(self.folder / "out").runs
        self.assertEqual([run.case["material"]["critical_state_slope"] for run in runs.values()], [0.4, 0.8])
        self.assertIsInstance(next(iter(runs.values())), Run)
        status = campaign.status()
        self.assertEqual((status.done, status.running, status.failed, status.to_do), (2, 0, 0, 0))
        self.assertEqual(status.runs.state.to_dict(), dict.fromkeys(campaign.table.name, "done"))
        self.assertEqual(status.runs.progress.tolist(), [1.0, 1.0])
        first, second = (pathlib.Path(run.folder) for run in runs.values())
        (first / "results.json").write_bytes((second / "results.json").read_bytes())
        with self.assertRaisesRegex(InputError, "does not hold the finished run of the case with hash .*campaign status"):
            campaign.runs
        with self.assertRaisesRegex(InputError, "series.csv: it does not match its checksum"):
            Run(first).series
        with self.assertRaisesRegex(InputError, "no such plan"):
            Campaign(self.folder / "none.toml")

    def test_have_a_schema_that_accepts_the_examples_and_rejects_misspelled_keys(self):
        import jsonschema

        from mpmtools.json_schema import case_schema

        validator = jsonschema.Draft7Validator(case_schema())
        examples = [path for path in EXAMPLES.glob("*.toml")]
        self.assertGreater(len(examples), 8)
        for path in examples:
            self.assertEqual([e.message for e in validator.iter_errors(Case.read(path).tables)], [], path)
        for change, message in (({"numerics.cell_siz_m": 1}, "'cell_siz_m' was unexpected"), ({"obstacle.width_m": -1}, "less than the minimum"),
                                ({"numerics.transfer": "pic"}, "is not one of"), ({"output.duration_s": None}, "required property"),
                                ({"arm.length_m": 4.0, "arm.depth_m": 1.0, "arm.base_m": 2.0}, "'height_m' is a required property"),
                                ({"output": None}, "'output' is a required property"), ({"material.poisson_ratio": 0.5}, "greater than or equal"),
                                ({"conveyor.mirror_y": "yes"}, "not of type 'boolean'"), ({"domain.min_m": [0, 0]}, "too short")):
            errors = [e.message for e in validator.iter_errors(self.case.changed(change).tables)]
            self.assertTrue(len(errors) == 1 and message in errors[0], f"{change}: {errors}")


if __name__ == "__main__":
    unittest.main()
