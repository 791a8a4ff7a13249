"""What the page shows of the evidence, from the tables kept in the repository and from a folder without them."""

import unittest

from mpmtools.figures import evidence_figures
from mpmtools.figures.study_page import Study, aim_table
from study_samples import SOURCE, InFolder

RESULTS = SOURCE / "validation" / "study" / "results"


class Evidence(InFolder):
    def test_heads_the_page_with_both_sets_of_every_campaign(self):
        rows = evidence_figures.headline([Study(RESULTS / "first_w5"), Study(RESULTS / "first_w7")])["rows"]
        self.assertEqual(len(rows), 20)  # two campaigns, two sets, five coefficients
        self.assertEqual(rows[0], ["first w5, narrow (244 runs, 13 M')", "k_r", "0.774", "0.74 to 0.83", "0.73 to 0.82", "0.762", "0.947", "no"])
        self.assertEqual([row[0] for row in rows[5:6]], ["first w5, wide (268 runs, 13 M')"])

    def test_sums_up_what_is_confirmed_what_differs_and_why_on_both_sets(self):
        studies = [Study(RESULTS / "reproduction_w5"), Study(RESULTS / "first_w7")]
        table = evidence_figures.matrix(studies)
        self.assertEqual(table["head"][:2], ["", "k_r"])
        self.assertEqual([row[:2] for row in table["rows"][:2]], [["paper", "0.947"], ["reproduction w5, narrow (237 runs, 13 M')", "0.847 (0.77 to 0.96)"]])
        self.assertEqual(table["rows"][-1][0], "first w7, both sets (60 runs, 5 M')")  # its two sets hold the same runs
        self.assertEqual([row[0].split(" (")[0] for row in table["rows"][1:3]], ["reproduction w5, narrow", "reproduction w5, wide"])
        self.assertEqual({len(row) for row in table["rows"]}, {len(table["head"])})
        short = evidence_figures.in_short(studies)
        self.assertTrue(any(text.startswith("reproduction w5, wide: Fr_sat 1.469 (1.538)") for text in short["differs"]))
        self.assertTrue(any(text.startswith("first w7, both sets: the intervals hold all five") for text in short["confirmed"]))
        self.assertIn("With cohesion: explained only in part", " ".join(short["why"]))
        self.assertIn("calibrated on one half of 30 points and judged on the other, 4 halves: the smaller of c and the half: c = 0.20 to 0.21, RMSLE",
                      " ".join(short["why"]))
        self.assertRegex(" ".join(short["differs"]), r"The accurate solver .* \d+ pairs of runs")

    def test_shows_the_prediction_once_also_where_another_study_was_compared_with_a_part_of_it(self):
        names = ("reproduction_w5", "calibrated_prediction", "prediction")
        columns = evidence_figures.headline_columns([Study(RESULTS / name) for name in names])
        self.assertEqual([c.name for c in columns], [f"{name.replace('_', ' ')}, {fitting_set}" for name in names for fitting_set in ("narrow", "wide")])
        compared = evidence_figures.headline_columns([Study(RESULTS / "reproduction_w5")])
        self.assertEqual([c.name for c in compared], ["reproduction w5, narrow", "reproduction w5, wide", "prediction, narrow", "prediction, wide"])

    def test_draws_every_section_from_the_kept_tables(self):
        study = Study(RESULTS / "reproduction_w5")
        for identity, _, draw, _ in evidence_figures.SECTIONS:
            drawn = draw(study)
            self.assertEqual(drawn.missing, [], identity)
            self.assertTrue(drawn.tables, identity)
            for table in drawn.tables:
                self.assertEqual({len(row) for row in table["rows"]}, {len(table["head"])}, table["title"])

    def test_compares_with_the_prediction_what_was_compared_although_another_campaign_is_the_first(self):
        short = evidence_figures.in_short([Study(RESULTS / "reproduction_w7"), Study(RESULTS / "reproduction_w5")])
        self.assertRegex(" ".join(short["differs"]), r"numerics \(reproduction w5\), 307 pairs of runs")
        self.assertIn("with the runs of M' < 0.9 alone k_r is 0.99, with those above 0.81", " ".join(short["why"]))

    def test_says_what_is_missing_without_them(self):
        self.write("old/fit.json", '{"fits": []}')
        study = Study(self.folder / "old")
        self.assertIsNone(evidence_figures.headline([study]))
        self.assertIsNone(evidence_figures.matrix([study]))
        self.assertIsNone(evidence_figures.in_short([study]))
        for identity, _, draw, _ in evidence_figures.SECTIONS:
            self.assertEqual(len(draw(study).missing), 1, identity)

    def test_aims_are_those_of_both_sets(self):
        aims = aim_table([Study(RESULTS / "first_w5")])
        self.assertEqual([s["name"] for s in aims["studies"]], ["first w5, narrow", "first w5, wide"])
        run_up = next(row for row in aims["rows"] if row["what"].startswith("run-up: RMSLE"))
        self.assertEqual([found["met"] for found in run_up["found"]], [True, False])


if __name__ == "__main__":
    unittest.main()
