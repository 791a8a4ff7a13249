"""What the page shows of the evidence, from the tables kept in the repository and from a folder without them."""

import unittest

from mpmtools.figures import evidence_figures
from mpmtools.figures.study_page import Study, aim_table, drawn_of_each
from study_samples import SOURCE, InFolder

RESULTS = SOURCE / "validation" / "study" / "results"


class Evidence(InFolder):
    def test_draws_every_section_from_the_kept_tables(self):
        study = Study(RESULTS / "reproduction_w5")
        for identity, _, draw, _ in evidence_figures.SECTIONS:
            drawn = draw(study)
            self.assertEqual(drawn.missing, [], identity)
            self.assertTrue(drawn.tables, identity)
            for table in drawn.tables:
                self.assertEqual({len(row) for row in table["rows"]}, {len(table["head"])}, table["title"])

    def test_draws_what_a_finer_grid_changes_for_each_study_that_has_two_grids(self):
        two, one = (Study(RESULTS / name) for name in ("prediction", "reproduction_w5"))
        for _, _, draw, _ in evidence_figures.OF_EACH_STUDY:
            drawn = drawn_of_each([one, two], draw)
            self.assertEqual((len(drawn.pictures), len(drawn.tables), drawn.missing), (2, 1, []))
            self.assertTrue(all(picture.title.startswith("prediction: ") for picture in drawn.pictures))
            (table,) = drawn.tables
            self.assertEqual({len(row) for row in table["rows"]}, {len(table["head"])})
            self.assertEqual(table["rows"][0][3], "run-up")
            self.assertEqual(len(drawn_of_each([one], draw).missing), 1)

    def test_says_what_is_missing_without_them(self):
        self.write("old/fit.json", '{"fits": []}')
        study = Study(self.folder / "old")
        for identity, _, draw, _ in evidence_figures.SECTIONS:
            self.assertEqual(len(draw(study).missing), 1, identity)

    def test_aims_are_those_of_both_sets(self):
        aims = aim_table([Study(RESULTS / "first_w5")])
        self.assertEqual(aims["columns"], ["first at w/5, narrow", "first at w/5, wide"])
        (study,) = aims["studies"]
        (narrow, met_narrow, of_narrow), (wide, met_wide, of_wide) = study["counts"]["goals"]
        self.assertEqual((study["name"], narrow, of_narrow, wide, of_wide), ("first at w/5", "narrow", 9, "wide", 9))
        self.assertGreater(met_narrow, met_wide)
        self.assertFalse(study["all_met"])
        run_up = next(row for row in aims["groups"][0]["rows"] if row["what"].startswith("run-up: RMSLE"))
        self.assertEqual([found["met"] for found in run_up["found"]], [True, False])

    def test_stricter_aims_stand_beside_the_goals(self):
        aims = aim_table([Study(RESULTS / "reproduction_w7")])
        (study,) = aims["studies"]
        self.assertEqual(study["counts"]["goals"], [("narrow", 9, 9), ("wide", 9, 9)])
        self.assertFalse(study["all_met"])
        (narrow, met, of), (wide, _, _) = study["counts"]["stricter aims"]
        self.assertEqual((narrow, of, wide), ("narrow", 9, "wide"))
        self.assertLess(met, of)
        coefficient = next(row for row in aims["groups"][1]["rows"] if " k_r " in row["what"])
        self.assertEqual((coefficient["aim"], [found["met"] for found in coefficient["found"]]), ("within 10/15 %", [False, True]))


if __name__ == "__main__":
    unittest.main()
