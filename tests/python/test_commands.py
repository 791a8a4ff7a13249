"""`python3 -m mpmtools fit` as a user runs it."""

import json
import os
import re
import subprocess
import sys
import unittest

from mpmtools.__main__ import parser, with_negative_values
from mpmtools.tables import read_series
from study_samples import SOURCE, TRUTH, InFolder, synthetic_table

needs_program = unittest.skipUnless("MPM" in os.environ, "needs the program: set MPM to its path (ctest does)")

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


class Module(unittest.TestCase):
    def test_takes_values_that_begin_with_a_minus(self):
        read = [parser().parse_args(with_negative_values(["import-avaframe", "d", *at, "--force"])) for at in (["--at", "-100000,-51950"], ["--at=-100000,-51950"])]
        self.assertEqual([(options.at, options.force) for options in read], [("-100000,-51950", True)] * 2)
        self.assertEqual(parser().parse_args(with_negative_values(["film", "d", "--time", "-1e-3"])).time, -0.001)
        self.assertEqual(parser().parse_args(with_negative_values(["plot", "d", "--times", "-.5,2"])).times, "-.5,2")
        for words in (["fit", "t.csv", "--filter", "-x"], ["--help"], ["plot", "d", "--out", "--times", "1"], ["plot", "--", "-1"]):
            self.assertEqual(with_negative_values(words), words)

    def test_help_names_every_command(self):
        environment = {**os.environ, "PYTHONPATH": str(SOURCE / "python")}
        out = subprocess.run([sys.executable, "-m", "mpmtools", "--help"], env=environment, check=True, capture_output=True, text=True).stdout
        for name in ("fit", "plot", "render"):
            self.assertRegex(out, rf"(?m)^    {name} ")
        bare = subprocess.run([sys.executable, "-S", "-I", "-c", f"import sys; sys.path.insert(0, {str(SOURCE / 'python')!r}); "
                               "from mpmtools.__main__ import main; sys.exit(main(['fit', 'results.csv']))"], capture_output=True, text=True, check=False)
        self.assertEqual(bare.returncode, 5)  # a Python without Debian's packages
        self.assertRegex(bare.stderr, f"^mpmtools: No module named '\\w+', for {sys.executable}; install [^\\n]*\n$")
        unknown = subprocess.run([sys.executable, "-m", "mpmtools", "fti"], env=environment, capture_output=True, text=True, check=False)
        self.assertEqual(unknown.returncode, 2)


@needs_program
class Pages(unittest.TestCase):
    """What docs/ says of the program's commands."""

    def help_of(self, command):
        done = subprocess.run([os.environ["MPM"], *command.split(), "--help"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, f"mpm {command}: {done.stderr}")
        return done.stdout

    def test_list_every_command_by_its_name(self):
        text = (SOURCE / "docs" / "commands.md").read_text(encoding="utf-8").partition("<!-- generated: commands -->")[2].partition("<!-- /generated")[0]
        found = re.findall(r"^\| \[?`mpm ((?:[a-z]+ )*[a-z]+)((?: [A-Z][\w.]*)*)`", text, flags=re.MULTILINE)
        self.assertEqual(len(found), len(text.strip().splitlines()) - 2)
        for command, arguments in found:
            usage = re.search(r"^Usage: mpm (.*)$", self.help_of(command), flags=re.MULTILINE)[1].replace(" [OPTIONS]", "")
            self.assertTrue(usage.startswith(command), f"mpm {command}")
            self.assertEqual(len(usage.removeprefix(command).split()), len(arguments.split()), f"mpm {command}{arguments}")

    def test_list_options_that_the_command_has(self):
        for page, before, command in (("commands.md", "## `mpm run`", "run"), ("grid-studies.md", "## Options", "converge"),
                                      ("campaigns.md", "| option of `mpm campaign run`", "campaign run")):
            table = (SOURCE / "docs" / page).read_text(encoding="utf-8").partition(before)[2].partition("|---|")[2].partition("\n\n")[0]
            names = re.findall(r"^\|.*?(?= \| )", table, flags=re.MULTILINE)
            options = re.findall(r"`(--[a-z-]+)", " ".join(names))
            self.assertGreater(len(options), 4, page)
            known = re.findall(r"(?<![\w-])--[a-z-]+", self.help_of(command))
            self.assertEqual([option for option in options if option not in known], [], f"docs/{page}: options of mpm {command}")


if __name__ == "__main__":
    unittest.main()
