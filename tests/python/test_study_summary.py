"""The first screen of the study's page, from the tables kept in the repository."""

import unittest

from mpmtools.figures import study_summary
from mpmtools.figures.study_page import Study
from study_samples import SOURCE, InFolder

RESULTS = SOURCE / "validation" / "study" / "results"


def studies(*names):
    return [Study(RESULTS / name) for name in names]


class Summary(InFolder):
    def test_heads_the_page_with_both_sets_of_every_campaign(self):
        rows = study_summary.headline(studies("first_w5", "first_w7"))["rows"]
        self.assertEqual(len(rows), 20)  # two campaigns, two sets, five coefficients
        self.assertEqual(rows[0], ["first at w/5, narrow (244 runs, 13 M')", "k_r", "0.774", "0.74 to 0.83", "0.73 to 0.82", "0.762", "0.947", "no"])
        self.assertEqual([row[0] for row in rows[5:6]], ["first at w/5, wide (268 runs, 13 M')"])

    def test_lists_what_was_fitted_beside_the_paper(self):
        table = study_summary.matrix(studies("reproduction_w5", "first_w7"))
        self.assertEqual(table["head"][:3], ["", "runs", "k_r"])
        self.assertEqual([row[:3] for row in table["rows"][:2]], [["paper", "", "0.947"], ["reproduction at w/5, narrow", "237", "0.847 (0.77 to 0.96)"]])
        self.assertEqual(table["rows"][-1][:2], ["first at w/7, both sets", "60"])  # its two sets hold the same runs
        self.assertEqual([row[0] for row in table["rows"][1:3]], ["reproduction at w/5, narrow", "reproduction at w/5, wide"])
        self.assertEqual({len(row) for row in table["rows"]}, {len(table["head"])})

    def test_says_of_each_coefficient_which_intervals_hold_the_published_one(self):
        short = study_summary.in_short(studies("reproduction_w5", "first_w7"))
        self.assertTrue(any(text.startswith("Fr_sat (published 1.538) is outside the interval of the reproduction at w/5 (1.470) and the prediction (")
                            and text.endswith("; inside that of the first at w/7 (1.459).") for text in short["differs"]), short["differs"])
        self.assertIn("κ_p: the published 1.307 lies in the interval of every campaign, the widest 1.03 to 1.87.", short["confirmed"])

    def test_names_the_set_where_the_two_disagree(self):
        differs = study_summary.in_short(studies("reproduction_w7", "reproduction_w5", "calibrated_prediction", "prediction"))["differs"]
        text = next(text for text in differs if text.startswith("κ_r"))
        self.assertIn("outside the interval of the calibrated prediction, narrow set (1.483) and the prediction, narrow set (1.491)", text)
        self.assertIn("inside that of the reproduction at w/7 (1.564), the reproduction at w/5 (1.540), the calibrated prediction, wide set (1.546) and the prediction, wide set (1.553)", text)

    def test_scores_the_published_equations_on_the_first_campaign(self):
        form = study_summary.in_short(studies("reproduction_w7", "reproduction_w5"))["confirmed"][0]
        self.assertIn("(reproduction at w/7): RMSLE of the run-up 8.5 % (narrow) and 9.7 % (wide), paper 13.0 % on its own", form)
        self.assertIn("NRMSE of the pressure height 8.4 % (narrow) and 8.3 % (wide), paper 6.6 %", form)

    def test_tells_why(self):
        why = " ".join(study_summary.in_short(studies("reproduction_w5", "first_w7"))["why"])
        self.assertIn("With cohesion the shock comes closer than no loss for ξ = 0.05", why)
        self.assertIn("calibrated on one half of 30 points and judged on the other, 4 halves: the smaller of c and the half: c = 0.20 to 0.21, RMSLE", why)
        why = " ".join(study_summary.in_short(studies("reproduction_w7"))["why"])
        self.assertIn("On all 43 points they are up to 12.8 percentage points worse on the half that they have not seen.", why)
        self.assertIn("; 0.80 with half of tan φ'; 1.08 without friction, on the same 30 rows.", why)
        self.assertIn("a fit without the fluid (M = 0). Ours then has k_p 0.597, Fr_sat 1.567, κ_p 1.626, and an NRMSE of 7.0 %.", why)
        self.assertIn("the reproduction at w/7 has k_r 0.837 (-12 %), κ_r 1.522 (-3 %), k_p 0.531 (+1 %), Fr_sat 1.490 (-3 %), κ_p 1.322 (+1 %), an "
                      "RMSLE of 6.1 % and an NRMSE of 5.4 %.", why)
        self.assertIn("with the runs of M' < 0.9 alone k_r is 0.99, with those above 0.81", why)

    def test_compares_with_the_prediction_what_was_compared_although_another_campaign_is_the_first(self):
        short = study_summary.in_short(studies("first_w7", "reproduction_w5"))
        self.assertRegex(short["differs"][-1], r"The accurate solver .*\(reproduction at w/5\), 307 pairs of runs: run-up 1\.05 ")

    def test_shows_the_prediction_once_also_where_another_study_was_compared_with_a_part_of_it(self):
        columns = study_summary.headline_columns(studies("reproduction_w5", "calibrated_prediction", "prediction"))
        self.assertEqual([c.name for c in columns], [f"{name}, {fitting_set}" for name in ("reproduction at w/5", "calibrated prediction", "prediction")
                                                     for fitting_set in ("narrow", "wide")])
        compared = study_summary.headline_columns(studies("reproduction_w5"))
        self.assertEqual([c.name for c in compared], [f"{name}, {fitting_set}" for name in ("reproduction at w/5", "prediction")
                                                      for fitting_set in ("narrow", "wide")])

    def test_is_none_without_tables(self):
        self.write("old/fit.json", '{"fits": []}')
        old = [Study(self.folder / "old")]
        self.assertIsNone(study_summary.headline(old))
        self.assertIsNone(study_summary.matrix(old))
        self.assertIsNone(study_summary.in_short(old))


if __name__ == "__main__":
    unittest.main()
