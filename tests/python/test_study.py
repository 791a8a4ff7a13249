"""The evaluations of the study: fitting sets, guideline, decomposition, histories, widths, compaction."""

import json
import unittest

from in_folder import sealed_h5
import numpy as np
import pandas as pd

from mpmtools import equations
from mpmtools.fit.fits import NARROW, WIDE, coefficients_csv, fit_set, fits_json, scores_csv
from analysis.guideline import guideline_correspondence
from analysis.histories import envelopes, height_choices, sections
from mpmtools.fit.regression import PRESSURE_HEIGHT, RUNUP
from analysis.rheology import compaction_losses, compaction_summary, decomposition, head_behind_shock, spreads
from mpmtools.fit.runs import StudyTable
from analysis.width import width_factors
from study_samples import InFolder, grid_of_runs, study_run, study_runs


class FittingSets(unittest.TestCase):
    def test_are_those_of_the_paper(self):
        xis = pd.DataFrame({"hardening_xi": [0.05, 0.15, 0.5, 1.5, 5.0, 15.0]})
        self.assertEqual(xis.hardening_xi[NARROW.holds(xis)].tolist(), [0.5, 1.5, 5.0])
        self.assertEqual(xis.hardening_xi[WIDE.holds(xis)].tolist(), [0.15, 0.5, 1.5, 5.0, 15.0])

    def test_recover_the_equation_from_their_runs_and_score_the_others(self):
        runs = grid_of_runs((0.05, 0.5, 5.0))
        runs.loc[runs.hardening_xi == 0.05, "runup"] *= 1.2  # outside the set: must not touch the fit
        runs = pd.concat([runs, study_runs(study_run(3.0, 0.4, 0.0, 5.0, obstacle_width_m=3.5, runup=50.0),  # nor a mast of another width
                                           study_run(3.0, 0.4, 0.0, 5.0, pressure_height=np.nan))], ignore_index=True)
        runup, pressure = fit_set(RUNUP, NARROW, runs), fit_set(PRESSURE_HEIGHT, NARROW, runs)
        self.assertAlmostEqual(runup.fit.coefficients.k, RUNUP.published.k, delta=1e-9)
        self.assertEqual((runup.runs, runup.other_width, runup.without_height), (225, 1, 0))
        self.assertEqual((pressure.runs, pressure.without_height), (224, 1))

        def row(coefficients, xi, group, at=np.nan):
            s = runup.scores
            found = s[(s.coefficients == coefficients) & (s.group == group) & (s.hardening_xi.isna() if xi is None else s.hardening_xi == xi)]
            return (found if np.isnan(at) else found[found["at"] == at]).iloc[0]

        for source in ("fitted", "published"):
            self.assertAlmostEqual(row(source, None, "").rmsle, 0.0, delta=1e-8)
            self.assertEqual(row(source, None, "froude_number", 3.0).runs, 33)
            self.assertAlmostEqual(row(source, 0.05, "").rmsle, np.log(1.2), delta=1e-8)
            self.assertAlmostEqual(row(source, 0.05, "froude_number", 3.0).bias, 1.2, delta=1e-8)
            self.assertEqual(row(source, 5.0, "effective_friction", 0.0).runs, 28)
            self.assertEqual(row(source, None, "hardening_xi", 0.5).runs, 112)

    def test_say_why_they_cannot_be_fitted(self):
        s = fit_set(RUNUP, NARROW, study_runs(study_run(1.0, 0.4, 0.0, 5.0), study_run(3.0, 0.4, 0.0, 5.0)))
        self.assertIsNone(s.fit)
        self.assertIn("2 runs are left", s.why_not)
        self.assertFalse(s.scores.empty)  # the published equation can be judged all the same

    def test_are_written_as_tables_and_as_json(self):
        runs = grid_of_runs()
        fits = [fit_set(equation, NARROW, runs) for equation in (RUNUP, PRESSURE_HEIGHT)]
        self.assertEqual(coefficients_csv(fits).count("\n"), 1 + 2 + 3)
        self.assertIn("pressure_height,narrow,Fr_sat,1.53", coefficients_csv(fits))
        self.assertIn("runup,narrow,published,,froude_number,0.1,32,", scores_csv(fits))
        found = json.loads(fits_json(fits, StudyTable(runs, len(runs) + 3, {"no steady span": 3})))
        self.assertEqual(found["left_out"], [{"reason": "no steady span", "rows": 3}])
        self.assertAlmostEqual(found["fits"][1]["coefficients"][1]["value"], 1.538, delta=1e-6)
        self.assertEqual(found["fits"][0]["published_scores_on_its_own_data"]["rmsle"], 0.130)
        self.assertIsNone(found["fits"][0]["published_scores_on_its_own_data"]["r2"])

class Guideline(unittest.TestCase):
    def test_is_met_by_the_rheology_that_dissipates_as_much(self):
        # h/H = 1 + Fr^2/2 exp(-1.2 M'): at M' = ln(1.5/f)/1.2 it is the guideline of lambda = 1.5, without error.
        f = equations.width_factor(1.0)
        runs = [study_run(froude, 0.15 * i, 0.0, 5.0, runup=100.0 if froude == 2.0 else 1.0 + 0.5 * froude**2 * np.exp(-0.18 * i))
                for i in range(13) for froude in (2.0, 3.0, 5.0, 7.0)]  # Fr 2 is below the range: must not matter
        runs.append(study_run(3.0, 5.0, 0.0, 5.0))  # a rheology without Fr 5 and 7
        g = guideline_correspondence(study_runs(*runs))
        self.assertEqual((len(g.minima), len(g.curves), len(g.notes)), (2, 26, 1))
        self.assertIn("1 value of M' lacks a run", g.notes[0])
        loose, exact = g.minima.iloc[0], np.log(1.5 / f) / 1.2  # 0.659
        self.assertEqual(loose["lambda"], 1.5)
        self.assertTrue(loose.neighbour_below < exact < loose.neighbour_above)
        self.assertAlmostEqual(loose.minimum_at, exact, delta=0.075 + 1e-12)  # half the spacing
        self.assertAlmostEqual(loose.parabola_at, exact, delta=0.04)  # |x| near its kink is no parabola: a quarter of the spacing
        curve = g.curves[g.curves["lambda"] == 1.5].reset_index()
        three = curve[(curve.rmsle.argmin() - 1):(curve.rmsle.argmin() + 2)]
        a, b, _ = np.polyfit(three.effective_friction, three.rmsle, 2)
        self.assertAlmostEqual(loose.parabola_at, -b / (2.0 * a), delta=1e-9)
        self.assertEqual(loose.inside, 0.45 <= loose.parabola_at <= 0.65)
        self.assertAlmostEqual(g.minima.parabola_at[1], np.log(3.0 / f) / 1.2, delta=0.04)
        self.assertEqual(g.minima.inside[1], 1)
        self.assertEqual((g.curves.normalised.min(), g.curves.normalised.max()), (0.0, 1.0))
        # The distance itself, by hand, at M' = 0 and lambda = 1.5.
        froude = np.array([3.0, 5.0, 7.0])
        by_hand = np.log((1.0 + 0.5 * froude**2) / (1.0 + 0.5 * froude**2 * f / 1.5))
        self.assertAlmostEqual(g.curves.rmsle[0], np.sqrt(np.mean(by_hand**2)), delta=1e-12)

    def test_has_no_parabola_at_an_end_of_the_curve(self):
        g = guideline_correspondence(study_runs(*(study_run(froude, m, 0.0, 5.0) for m in (0.0, 0.1, 0.2) for froude in (3.0, 5.0))))
        self.assertEqual((len(g.minima), g.minima.minimum_at[0], g.minima.inside[0]), (2, 0.2, 0))
        self.assertTrue(np.isnan(g.minima.parabola_at[0]) and np.isnan(g.minima.neighbour_above[0]))

    def test_says_what_is_missing(self):
        g = guideline_correspondence(study_runs(study_run(1.0, 0.4, 0.0, 5.0)))
        self.assertTrue(g.minima.empty)
        self.assertEqual(g.notes, ["no run with 3 <= Fr <= 7 and w = H"])


class Rheology(unittest.TestCase):
    def test_decomposition_adds_one_property_at_a_time(self):
        runs = grid_of_runs()
        runs = runs[~((runs.froude_number == 5.0) & (runs.critical_state_slope == 0.8) & (runs.cohesion_beta == 0.0))]
        table = decomposition(runs, (0.8, 0.3, 0.5))
        self.assertEqual(len(table), 7 * 4)
        for row in table.itertuples():
            self.assertEqual(row.bernoulli, 1.0 + 0.5 * row.froude_number**2)
            if row.froude_number == 5.0 and row.link == 1:
                self.assertTrue(np.isnan(row.runup))
                continue
            run = study_run(row.froude_number, row.critical_state_slope, row.cohesion_beta, row.hardening_xi)
            self.assertEqual((row.runup, row.pressure_height), (run["runup"], run["pressure_height"]))
        chain = table[["critical_state_slope", "cohesion_beta", "hardening_xi"]].head(4).to_numpy().tolist()
        self.assertEqual(chain, [[0, 0, 5], [0.8, 0, 5], [0.8, 0.3, 5], [0.8, 0.3, 0.5]])

    def test_spreads_are_the_extremes_of_the_steady_means(self):
        runs = study_runs(study_run(1.0, 0.4, 0.0, 5.0, runup=2.0), study_run(1.0, 0.8, 0.0, 5.0, runup=5.0, pressure_height=np.nan),
                          study_run(1.0, 1.2, 0.0, 5.0, runup=9.0, obstacle_width_m=3.5), study_run(3.0, 0.4, 0.0, 5.0))
        s = spreads(runs)
        self.assertEqual(len(s), 2)
        self.assertEqual(s.iloc[0, :5].tolist(), [1.0, 2, 2.0, 5.0, 2.5])  # froude, runs, low, high, ratio
        self.assertEqual((s.pressure_height_low[0], s.pressure_height_high[0]), (runs.pressure_height[0],) * 2)

    def test_head_behind_a_shock_obeys_the_jump_conditions(self):
        self.assertEqual(head_behind_shock(1.0), 1.0)
        density, v = 300.0, 12.0
        for chi in (1.05, 1.5, 2.0, 4.0):
            behind = v / chi  # mass
            pressure = density * v**2 - chi * density * behind**2  # momentum
            head = 0.5 * v**2
            self.assertAlmostEqual(head_behind_shock(chi), (pressure / (chi * density) + 0.5 * behind**2) / head, delta=1e-14)
            self.assertAlmostEqual(1.0 - head_behind_shock(chi), 0.5 * pressure * (1.0 - 1.0 / chi) / density / head, delta=1e-14)  # plastic work

    def test_compaction_compares_with_the_least_compressible_snow_of_the_same_flow_and_strength(self):
        def run(froude, slope, beta, xi, chi, part, **changes):
            return study_run(froude, slope, beta, xi, compaction=chi, runup=1.0 + part * 0.5 * froude**2, **changes)

        runs = study_runs(
            run(5.0, 0.0, 0.0, 5.0, 1.1, head_behind_shock(1.1)), run(5.0, 0.0, 0.0, 0.05, 3.0, head_behind_shock(3.0)),
            run(5.0, 0.0, 0.0, 0.5, 1.4, head_behind_shock(1.4)), run(7.0, 0.8, 0.3, 5.0, 1.2, 0.4), run(7.0, 0.8, 0.3, 0.5, 2.0, 0.2),
            run(2.0, 0.8, 0.3, 5.0, 1.0, 0.4), run(2.0, 0.8, 0.3, 0.5, 1.0, 0.1),  # slow: in the table, not in the summary
            run(3.0, 0.8, 0.0, 0.5, 1.3, 0.4),  # alone
            run(5.0, 0.0, 0.0, 0.15, np.nan, 0.4), run(5.0, 0.0, 0.0, 15.0, 1.0, 9.0, obstacle_width_m=3.5))
        losses = compaction_losses(runs).reset_index()
        self.assertEqual(len(losses), 4)
        first = losses.iloc[0]
        self.assertEqual((first.hardening_xi, first.stiff_compaction), (0.05, 1.1))
        self.assertAlmostEqual(first["head"], head_behind_shock(3.0) / head_behind_shock(1.1), delta=1e-14)
        self.assertAlmostEqual(first.behind_shock, first["head"], delta=1e-14)
        high = 12.5 * head_behind_shock(1.1)
        self.assertAlmostEqual(first.head_standard_error, first["head"] * np.hypot(0.02 / (first["head"] * high), 0.02 / high), delta=1e-14)
        self.assertAlmostEqual(losses["head"][2], 0.5, delta=1e-14)
        summary = compaction_summary(losses)
        self.assertEqual((summary.cohesive.tolist(), summary.runs.tolist()), ([0, 1, 0, 0, 1], [2, 1, 1, 1, 1]))  # whole, then each xi
        self.assertEqual(summary.hardening_xi.fillna(0.0).tolist(), [0.0, 0.0, 0.05, 0.5, 0.5])
        self.assertAlmostEqual(summary.rms_without_loss[3], 1.0 - head_behind_shock(1.4) / head_behind_shock(1.1), delta=1e-14)
        self.assertAlmostEqual(summary.rms_without_loss[1], 0.5, delta=1e-14)
        self.assertAlmostEqual(summary.rms[0], 0.0, delta=1e-14)
        self.assertAlmostEqual(summary.mean_head[1], 0.5, delta=1e-14)
        self.assertAlmostEqual(summary.rms[1], abs(0.5 - head_behind_shock(2.0) / head_behind_shock(1.2)), delta=1e-14)


class Widths(unittest.TestCase):
    def test_factors_are_ratios_to_the_run_of_reference_width(self):
        one = study_run(3.0, 0.5, 0.15, 0.5)
        one["runup_standard_error"] = 0.04 * one["runup"]
        self.assertTrue(width_factors(study_runs(one)).empty)
        wide = study_run(3.0, 0.5, 0.15, 0.5, obstacle_width_m=3.5, runup=1.1 * one["runup"], runup_standard_error=0.033 * one["runup"])
        factors = width_factors(study_runs(one, wide, study_run(5.0, 0.5, 0.15, 0.5)))  # Fr = 5 has one width only
        self.assertEqual(len(factors), 2)
        self.assertEqual((factors.runup_factor[0], factors.runup_standard_error[0]), (1.0, 0.0))
        self.assertAlmostEqual(factors.runup_factor[1], 1.1, delta=1e-14)
        self.assertAlmostEqual(factors.runup_standard_error[1], 1.1 * 0.05, delta=1e-14)
        self.assertEqual((factors.relative_width[1], factors.guideline[1]), (2.0, equations.rescaled_width_factor(2.0)))


class Histories(InFolder):
    def run_with_series(self, name, rows, froude=1.0):
        self.write(f"{name}/series.csv", f"time_s,runup_m,pressure_height_m\n{rows}")
        return study_run(froude, 0.4, 0.0, 5.0, folder=str(self.folder / name), flow_height_m=2.0, obstacle_width_m=2.0, runup_peak=4.5,
                         pressure_height_peak=2.5)

    def test_envelopes_are_the_lowest_and_highest_of_the_runs_that_reach_so_far(self):
        e = envelopes(study_runs(self.run_with_series("a", "0,2,nan\n1,4,2\n2,6,3\n3,8,4\n"), self.run_with_series("b", "0,6,2\n2,10,6\n"),
                                 study_run(1.0, 0.4, 0.0, 5.0), self.run_with_series("c", "0,100,100\n", 5.0)))
        e = e[e.froude_number == 1.0]
        self.assertEqual(e.time_s.tolist(), [0, 1, 2, 3])
        self.assertEqual((e.all_runs.tolist(), e.runs.tolist()), ([2] * 4, [2, 2, 2, 1]))
        self.assertEqual((e.runup_low[0], e.runup_high[0]), (1.0, 3.0))
        self.assertEqual(e.pressure_height_low[0], 1.0)  # undefined in the other run
        self.assertEqual(e.runup_high[1], 4.0)  # between the samples of b
        self.assertEqual((e.pressure_height_low[1], e.pressure_height_high[1]), (1.0, 2.0))
        self.assertEqual(e.runup_low[3], 4.0)

    def test_height_choices_take_the_steady_interval_the_last_third_and_the_peak_of_the_same_runs(self):
        run = self.run_with_series("a", "0,2,nan\n1,9,2\n2,4,3\n3,4,nan\n4,6,3\n5,5,4\n6,7,5\n")
        choices = height_choices(study_runs(run, study_run(1.0, 0.8, 0.0, 5.0)))
        self.assertEqual(list(choices), ["steady span", "last third", "peak"])
        self.assertEqual([len(c) for c in choices.values()], [1, 1, 1])
        heights = [(c.runup.iat[0], c.pressure_height.iat[0]) for c in choices.values()]
        # Last third: the samples at 4, 5 and 6 s, over H = 2 m.
        self.assertEqual(heights, [(run["runup"], run["pressure_height"]), (3.0, 2.0), (4.5, 2.5)])
        self.assertEqual(height_choices(study_runs(study_run(1.0, 0.8, 0.0, 5.0))), {})

    def test_sections_hold_the_particles_of_the_measuring_strip(self):
        (self.folder / "fast").mkdir()
        self.write("fast/profile.csv", "z_m,pressure_pa,smoothed_pressure_pa,force_per_height_n_m\n0.1,5,4,3\n0.3,2,1,0\n")
        with sealed_h5(self.folder / "fast" / "final.h5", "w") as file:
            # Near the axis; outside the strip of 3/7 w = 0.75 m; too far upstream (6 H = 10.5 m).
            file["position_m"] = [[-1.0, 0.7, 0.5], [-1.0, 0.8, 0.5], [-10.6, 0.0, 0.5]]
            file["kirchhoff_stress_pa"] = [[-200.0] + [0.0] * 5] * 3
            file["volume_ratio"], file["reference_volume_m3"] = [2.0] * 3, [0.004] * 3
        fast = study_run(5.0, 0.8, 0.3, 0.5, folder=str(self.folder / "fast"))
        tables, missing = sections(study_runs(fast), (0.8, 0.3, 0.5))
        self.assertEqual(tables["section_fast"].to_numpy().tolist(), [[-1.0, 0.5, -100.0]])  # Cauchy: over J
        self.assertAlmostEqual(tables["sections"].particle_spacing_m[0], 0.2, delta=1e-12)  # cube root of 2 x 0.004
        self.assertEqual(tables["section_profile_fast"].columns.tolist(), ["z_m", "pressure_pa", "smoothed_pressure_pa"])
        self.assertEqual(missing, ["no run with Fr = 0.1, M = 0.8, beta = 0.3, xi = 0.5"])
        _, missing = sections(study_runs({**fast, "folder": ""}), (0.8, 0.3, 0.5))
        self.assertIn("did not keep its last state", missing[1])


if __name__ == "__main__":
    unittest.main()
