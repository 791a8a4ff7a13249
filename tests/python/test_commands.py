"""`python3 -m mpmtools fit` and `study` as a user runs them."""

import json
import os
import re
import subprocess
import sys
import unittest

import numpy as np

from mpmtools.equations import HeightCoefficients, effective_friction, relative_height
from mpmtools.tables import read_series, read_table
from study_samples import BETAS, FROUDE, SLOPES, SOURCE, InFolder

TRUTH = {"runup": HeightCoefficients(0.8, 1.4), "pressure_height": HeightCoefficients(0.6, 1.1, 1.7)}
HEAD = ("name,run,status,froude_number,critical_state_slope,cohesion_beta,hardening_xi,flow_height_m,obstacle_width_m,cell_size_m,steady,"
        "runup_mean_m,runup_standard_error_m,runup_peak_m,pressure_height_mean_m\n")


def synthetic_table(scatter, cell_size=0.25):
    """A campaign's table on the paper's grid: heights by Eqs. 7 to 10 with known coefficients and a reproducible scatter."""
    lines, i = ["# plan: synthetic\n", HEAD], 0
    for xi in (0.05, 0.5, 5.0):
        for froude in FROUDE:
            for slope in SLOPES:
                for beta in BETAS:
                    i += 1
                    friction, noise = effective_friction(slope, beta), np.exp(scatter * np.sin(7.0 * i))
                    inputs = f"r{i},runs/r{i},done,{froude},{slope},{beta},{xi},1.75,1.75,{cell_size}"
                    heights = [1.75 * relative_height(friction, froude, TRUTH[name]) * noise for name in ("runup", "pressure_height")]
                    if i % 50 == 0:  # one in fifty has no steady interval
                        lines.append(f"{inputs},0,nan,nan,9,nan\n")
                    else:
                        lines.append(f"{inputs},1,{heights[0]!r},0.02,9,{heights[1]!r}\n")
    return "".join(lines)


class Fit(InFolder):
    def table(self, scatter=0.08):
        return self.write("results.csv", synthetic_table(scatter))

    def test_recovers_the_coefficients_of_a_synthetic_table(self):
        code, out, err = self.command("fit", self.table(0.0), "--json")
        self.assertEqual((code, err), (0, ""))
        found = json.loads(out)
        self.assertEqual((found["rows"], found["runs"]), (336, 330))
        self.assertEqual(found["left_out"], [{"reason": "no steady span", "rows": 6}])
        self.assertEqual(len(found["fits"]), 4)  # two sets of two equations
        for fit in found["fits"]:
            truth = TRUTH[fit["equation"]]
            for c in fit["coefficients"]:
                value = {"F": truth.saturation_froude, "k_": truth.k, "ka": truth.kappa}[c["parameter"][:1 if c["parameter"][0] == "F" else 2]]
                self.assertAlmostEqual(c["value"], value, delta=1e-8, msg=c["parameter"])
            self.assertAlmostEqual(fit["scores_of_fitted"]["rmsle"], 0.0, delta=1e-8)
            self.assertGreater(fit["scores_of_published"]["rmsle"], 0.01)

    def test_prints_the_layout_of_the_papers_tables(self):
        code, out, _ = self.command("fit", self.table(), "--breakdown")
        self.assertEqual(code, 0)
        for part in ("k_r (-)", "kappa_r (-)", "k_p (-)", "Fr_sat (-)", "kappa_p (-)", "rel. std. error", "t-statistic", "p-value", "R2_log",
                     "NRMSE", "RMSLE", "Bias_x", "Frac_10", "Frac_25", "set 'narrow'", "set 'wide'", "left out: 6 (no steady span)", "0.9468",
                     "1.5745", "0.5277", "1.3072", "1.5380", "froude_number", "effective_friction", "hardening_xi", "no run in between"):
            self.assertIn(part, out)

    def test_names_a_full_disk(self):
        with open("/dev/full", "w", encoding="utf-8") as full:
            done = subprocess.run([sys.executable, "-m", "mpmtools", "fit", self.table()], env={**os.environ, "PYTHONPATH": str(SOURCE / "python")},
                                  stdout=full, stderr=subprocess.PIPE, text=True, check=False)
        self.assertEqual((done.returncode, done.stderr), (4, "mpmtools fit: [Errno 28] No space left on device\n"))

    def test_writes_its_tables_as_csv(self):
        self.assertEqual(self.command("fit", self.table(), "--csv", "coefficients")[1].count("\n"), 1 + 2 * (2 + 3))
        s = read_series(self.write("scores.csv", self.command("fit", self.table(), "--csv", "scores")[1]))
        s = s[(s.equation == "runup") & (s.fitting_set == "narrow") & (s.coefficients == "fitted") & s.hardening_xi.isna()]
        # The groups' squared errors make up those of the whole: RMSLE^2 n summed over the Froude numbers.
        squares = s.runs * s.rmsle**2
        whole, parts = squares[s.group.isna()].sum(), squares[s.group == "froude_number"].sum()
        self.assertGreater(whole, 0.0)
        self.assertAlmostEqual(parts / whole, 1.0, delta=1e-12)

    def test_filters_choose_rows(self):
        code, out, _ = self.command("fit", self.table(), "--filter", "hardening_xi=5", "--filter", "froude_number<=5", "--json")
        self.assertEqual(code, 0)
        found = json.loads(out)
        without_mean = sum(part["rows"] for part in found["left_out"] if part["reason"] == "no steady span")
        self.assertEqual(found["fits"][0]["runs"] + without_mean, 96)  # 6 Froude numbers, 16 rheologies

    def test_says_what_is_wrong(self):
        table = self.table()
        short = self.write("short.csv", "run,runup_mean_m\na,1\n")
        for arguments, code, message in (
                ([self.folder / "no_such.csv"], 4, "No such file"),
                ([table, table], 2, "given twice"),
                ([table, "--filter", "hardening_xi"], 2, "a condition is"),
                ([table, "--filter", "hardening=5"], 2, "did you mean 'hardening_xi'"),
                ([table, "--csv", "nonsense"], 2, "invalid choice"),
                ([table, "--csv", "scores", "--json"], 2, "not allowed with"),
                ([table, "--filter", "hardening_xi=9"], 2, "336 filter hardening_xi=9"),
                ([table, "--filter", "critical_state_slope=0"], 2, "k needs runs with M' > 0"),
                ([short], 4, "critical_state_slope"), ([], 2, "required")):
            found, _, err = self.command("fit", *arguments)
            self.assertEqual(found, code, (arguments, err))
            self.assertIn(message, err)


class Study(InFolder):
    def test_writes_the_numbers_and_the_page_of_every_figure(self):
        table = self.write("campaign/results.csv", synthetic_table(0.08))
        self.write("campaign/plan.toml", 'title = "A small plan"\n')
        self.write("campaign/runs/r1/series.csv", "time_s,runup_m,pressure_height_m\n0,0,nan\n1,3.5,1.75\n2,7,3.5\n")
        code, out, err = self.command("study", table, "--out", self.folder / "out", "--note", "a note")
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
        for text in ("no table of the width study", "Fr = 5: no time histories", "plan: synthetic", "plan: A small plan", "a note"):
            self.assertIn(text, page)
        self.assertNotIn('src="http', page)

    def test_draws_what_was_evaluated_before_and_the_runs_beyond_the_paper(self):
        results = SOURCE / "validation" / "study"
        code, _, err = self.command("study", *(results / "results" / name for name in ("reproduction_w7", "reproduction_w5", "prediction")),
                                    "--out", self.folder, "--extensions", results / "extensions")
        self.assertEqual(code, 0, err)
        page = (self.folder / "index.html").read_text(encoding="utf-8")
        self.assertEqual(re.findall(r"prediction: (\d+) runs", page), ["364"])
        self.assertNotIn("Missing here", page.split('id="figA2"')[0])  # the committed tables hold every figure
        self.assertEqual(page.count("Drawn from the reproduction at w/5."), 1)  # the grids; all else is of the first study
        for part in ("mast-height", "shapes", "shear", "surge"):
            self.assertIn(f'id="{part}"', page)
        self.assertEqual(os.listdir(self.folder), ["index.html"])

    def test_tables_of_one_name_get_folders_of_their_own_and_join_makes_one_study(self):
        one = self.write("a/camp/results.csv", synthetic_table(0.08))
        two = self.write("b/camp/results.csv", synthetic_table(0.05))
        self.assertEqual(self.command("study", one, two, "--out", self.folder / "two", "--no-page")[0], 0)
        self.assertEqual(sorted(os.listdir(self.folder / "two")), ["camp", "camp_2"])
        self.assertEqual(self.command("study", one, two, "--join", "--out", self.folder / "one", "--no-page")[0], 0)
        self.assertEqual(len(read_series(self.folder / "one" / "camp" / "points.csv")), 660)
        self.assertEqual(self.command("study", one, two, "--join", "--name", "both", "--out", self.folder / "one", "--no-page")[0], 0)
        self.assertEqual(len(read_series(self.folder / "one" / "both" / "points.csv")), 660)

    def test_compares_the_first_study_with_the_same_sets_on_a_coarser_grid(self):
        fine, coarse = self.write("fine/results.csv", synthetic_table(0.08)), self.write("coarse/results.csv", synthetic_table(0.05, cell_size=0.35))
        self.assertEqual(self.command("study", fine, "--coarser", coarse, "--out", self.folder, "--no-page")[0], 0)
        rows = read_series(self.folder / "fine" / "refined_rows.csv")
        self.assertEqual((len(rows), set(rows.cell_size_m_fine), set(rows.cell_size_m_coarse)), (330, {0.25}, {0.35}))
        self.assertEqual(len(read_series(self.folder / "fine" / "points.csv")), 330)  # the coarse rows do not count
        code, _, err = self.command("study", coarse, "--coarser", fine, "--out", self.folder, "--no-page")
        self.assertEqual(code, 2)
        self.assertIn("no set-up of the study is there on a coarser grid", err)
        bare = self.write("bare/results.csv", synthetic_table(0.05, cell_size=0.35).replace("cell_size_m", "notes"))
        for study, other, which in ((fine, bare, "given with it"), (bare, coarse, "of the study")):
            code, _, err = self.command("study", study, "--coarser", other, "--out", self.folder, "--no-page")
            self.assertEqual(code, 2)
            self.assertIn(f"in the table {which} not every run has its cell size", err)

    def test_says_what_is_wrong(self):
        table = self.write("results.csv", synthetic_table(0.08))
        for arguments, code, message in (([self.folder / "none"], 4, "no table"), ([table, "--decomposition", "1,2"], 2, "three numbers"),
                                         ([table, "--name", "both"], 2, "--join"), ([table, "--replace"], 2, "--join"),
                                         ([table, "--width", self.folder / "none.csv"], 4, "cannot read"),
                                         ([table, "--sensitivity", table], 4, "no column 'effective_friction'")):
            found, _, err = self.command("study", *arguments, "--out", self.folder / "out", "--no-page")
            self.assertEqual(found, code, (arguments, err))
            self.assertIn(message, err)


class Module(unittest.TestCase):
    def test_help_names_every_command(self):
        environment = {**os.environ, "PYTHONPATH": str(SOURCE / "python")}
        out = subprocess.run([sys.executable, "-m", "mpmtools", "--help"], env=environment, check=True, capture_output=True, text=True).stdout
        for name in ("fit", "study", "plot", "render"):
            self.assertRegex(out, rf"(?m)^    {name} ")
        bare = subprocess.run([sys.executable, "-S", "-I", "-c", f"import sys; sys.path.insert(0, {str(SOURCE / 'python')!r}); "
                               "from mpmtools.__main__ import main; sys.exit(main(['fit', 'results.csv']))"], capture_output=True, text=True, check=False)
        self.assertEqual(bare.returncode, 5)  # a Python without Debian's packages
        self.assertRegex(bare.stderr, f"^mpmtools: No module named '\\w+', for {sys.executable}; install [^\\n]*\n$")
        unknown = subprocess.run([sys.executable, "-m", "mpmtools", "fti"], env=environment, capture_output=True, text=True, check=False)
        self.assertEqual(unknown.returncode, 2)


if __name__ == "__main__":
    unittest.main()
