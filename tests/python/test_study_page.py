"""The page of the study: from made-up campaigns, and what it shows of the evidence."""

import contextlib
import io
import unittest
import unittest.mock

from analysis import evidence_figures, extension_figures, study, summary, tables
from analysis.__main__ import main
from analysis.page import Study, drawn_of_each
from mpmtools.errors import ConfigError
from mpmtools.tables import read_series, read_table
from study_samples import InFolder, few_draws, synthetic_table


class StudyFolder(InFolder):
    def study(self, *arguments):
        """(exit code, stdout, stderr) of `python3 -m analysis`."""
        out, err = io.StringIO(), io.StringIO()
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err), few_draws():
            code = main([str(argument) for argument in arguments])
        return code, out.getvalue(), err.getvalue()

    def write_study(self, name, *files, **compared):
        with few_draws():
            tables.write_study(files, self.folder / name, **compared)
        return Study(self.folder / name)


class Page(StudyFolder):
    def test_holds_the_numbers_and_every_figure_of_a_campaign(self):
        table = self.write("campaign/results.csv", synthetic_table(0.08))
        self.write("campaign/plan.toml", 'title = "A small plan"\n')
        self.write("campaign/runs/r1/series.csv", "time_s,runup_m,pressure_height_m\n0,0,nan\n1,3.5,1.75\n2,7,3.5\n")
        code, out, err = self.study("page", table, "--out", self.folder / "out")
        self.assertEqual(code, 0, err)
        self.assertIn("guideline lambda = 1.5, xi = 5", out)
        self.assertIn("xi = 0.5 did not keep its last state", out)

        def study(name):
            return read_series(self.folder / "out" / "campaign" / f"{name}.csv")

        self.assertEqual(len(study("points")), 330)
        self.assertEqual(len(study("decomposition")), 28)  # 7 Froude numbers, 4 links
        self.assertEqual(len(study("guideline_minima")), 6)  # 2 lambdas, 3 xis
        self.assertEqual(len(study("height_curves")), 7 * 121)
        self.assertEqual(len(study("width_factors")), 0)
        self.assertEqual(study("envelopes").runup_high.tolist(), [0.0, 2.0, 4.0])
        self.assertEqual(study("height_choices").height.tolist(), ["steady span", "last third", "peak"])
        self.assertEqual(len(study("compaction")), 0)  # the table does not hold how dense the snow became
        for name in ("coefficients", "scores", "factor_curves", "effective_friction", "guideline", "sections", "spreads"):
            read_table(str(self.folder / "out" / "campaign" / f"{name}.csv"))
        # Every figure is there or says what it lacks, and the page needs no other file.
        page = (self.folder / "out" / "index.html").read_text(encoding="utf-8")
        for part in ("tableA1", "tableA2", "fig1", "fig3", "fig4", "fig5", "fig6", "fig7", "fig8", "fig9", "fig10", "figS1", "figA2", "figA3",
                     "figA4", "figA5", "compaction", "height-choices"):
            self.assertIn(f'id="{part}"', page)
        for text in ("no table of the width study", "Fr = 5: no time histories", "plan: synthetic", "plan: A small plan"):
            self.assertIn(text, page)
        self.assertNotIn('src="http', page)

    def test_gives_campaigns_of_one_name_folders_of_their_own(self):
        files = [self.write(f"{place}/camp/results.csv", "") for place in ("a", "b")]
        with unittest.mock.patch.object(study, "write_study", return_value=([], [])) as written:
            folders, _, _ = study.evaluate_own(files, "two")
        self.assertEqual(folders, ["two/camp", "two/camp_2"])
        self.assertEqual([call.args for call in written.call_args_list], [([file], folder) for file, folder in zip(files, folders)])

    def test_without_a_table_is_refused(self):
        code, _, err = self.study("page", self.folder / "none", "--out", self.folder / "out")
        self.assertEqual(code, 4)
        self.assertIn("no table", err)


class Comparison(StudyFolder):
    def test_with_a_coarser_grid(self):
        fine, coarse = self.write("fine/results.csv", synthetic_table(0.08)), self.write("coarse/results.csv", synthetic_table(0.05, cell_size=0.35))
        study = self.write_study("fine", fine, coarser_files=[coarse])
        rows = study.table("refined_rows")
        self.assertEqual((len(rows), set(rows.cell_size_m_fine), set(rows.cell_size_m_coarse)), (330, {0.25}, {0.35}))
        self.assertEqual(len(study.table("points")), 330)  # the coarse rows do not count
        (draw,) = (draw for _, _, draw, _ in evidence_figures.OF_EACH_STUDY)
        drawn = drawn_of_each([study, self.write_study("one", coarse)], draw)
        self.assertEqual((len(drawn.pictures), len(drawn.tables), drawn.missing), (2, 1, []))
        self.assertEqual({len(row) for row in drawn.tables[0]["rows"]}, {len(drawn.tables[0]["head"])})
        with self.assertRaisesRegex(ConfigError, "no set-up of the study is there on a coarser grid"):
            self.write_study("wrong", coarse, coarser_files=[fine])
        bare = self.write("bare/results.csv", synthetic_table(0.05, cell_size=0.35).replace("cell_size_m", "notes"))
        for study, other, which in ((fine, bare, "given with it"), (bare, coarse, "of the study")):
            with self.assertRaisesRegex(ConfigError, f"in the table {which} not every run has its cell size"):
                self.write_study("wrong", study, coarser_files=[other])

    def test_with_the_accurate_solver_draws_every_section_and_heads_the_page(self):
        table = self.write("ours/results.csv", synthetic_table(0.08))
        study = self.write_study("ours", table, prediction_files=[self.write("theirs/results.csv", synthetic_table(0.05))])
        for identity, _, draw, _ in evidence_figures.SECTIONS:
            drawn = draw(study)
            self.assertEqual(bool(drawn.missing), identity in ("grids", "mast-friction", "jams"), identity)
            for table in drawn.tables:
                self.assertEqual({len(row) for row in table["rows"]}, {len(table["head"])}, table["title"])
        rows = summary.matrix([study])["rows"]
        self.assertEqual([row[0] for row in rows], ["paper", "ours, both sets", "prediction, narrow", "prediction, wide"])
        self.assertRegex(rows[1][2], r"^0\.8\d\d \(0\.\d\d to 0\.\d\d\)$")  # the coefficient of the made-up heights


class Without(StudyFolder):
    def test_tables_every_section_says_what_is_missing(self):
        self.write("old/fit.json", '{"fits": []}')
        study = Study(self.folder / "old")
        for identity, _, draw, _ in evidence_figures.SECTIONS:
            self.assertEqual(len(draw(study).missing), 1, identity)
        for identity, _, draw, _ in extension_figures.SECTIONS:
            self.assertEqual(len(draw(str(self.folder)).missing), 1, identity)
        self.assertIsNone(summary.headline([study]))
        self.assertIsNone(summary.matrix([study]))


if __name__ == "__main__":
    unittest.main()
