"""Pages of docs/ agree with the sources and with the files of a run."""

import pathlib
import re
import unittest

import h5py
from in_folder import InFolder
from test_avaframe import needs_program

from mpmtools import Campaign, Case

ROOT = pathlib.Path(__file__).resolve().parents[2]
DEFINITION = re.compile(r'\b(\w*_format_version|FORMAT_VERSION) = (\d+)|"format_version"(?:: |, (?=\d+\}))(\d+)')


class Versions(unittest.TestCase):
    # File of the sources, constant there (None: a number that stands by itself): rows of the table in docs/versions.md. A checkpoint's is not promised.
    ROWS = {("libmpm/driver/case.hpp", "case_format_version"): ["case file", "`mpm schema --json`"],
            ("libmpm/campaign/site.hpp", "site_format_version"): ["site file of `mpm design`", "`design_plan.json`"],
            ("libmpm/campaign/plan.hpp", "plan_format_version"): ["plan of a campaign"],
            ("libmpm/campaign/folder.cpp", "attempts_format_version"): ["`attempts.json`"],
            ("libmpm/campaign/grid_study.cpp", "converge_format_version"): ["`converge.json`"],
            ("libmpm/driver/run_record.cpp", "results_format_version"): ["`results.json`"],
            ("libmpm/driver/checkpoint.hpp", "checkpoint_format_version"): [],
            ("libmpm/io/snapshot.cpp", "snapshot_format_version"): ["frames, `final.h5`"],
            ("validation/harness/exchange.hpp", "exchange_format_version"): ["exported validation cases"],
            ("validation/harness/results_json.cpp", None): ["`results.json` of `mpm-validate`"],
            ("python/mpmtools/design/ensemble.py", "FORMAT_VERSION"): ["`design_plan.json`"],
            ("python/mpmtools/design/data_files.py", None): ["`design.json`"]}

    def test_of_every_format_are_those_of_the_sources(self):
        found = {}
        for folder in ("libmpm", "app", "validation/harness", "python/mpmtools"):
            for path in sorted((ROOT / folder).rglob("*")):
                if path.suffix not in (".cpp", ".hpp", ".py"):
                    continue
                for name, number, literal in DEFINITION.findall(path.read_text(encoding="utf-8")):
                    found[str(path.relative_to(ROOT)), name or None] = number or literal
        self.assertEqual(set(found), set(self.ROWS))  # a new format needs a row of the page
        page = (ROOT / "docs" / "versions.md").read_text(encoding="utf-8")
        stated = {cells[0].strip(): cells[2].strip() for line in page.splitlines() if len(cells := line.strip("|").split("|")) == 3}
        for source, rows in self.ROWS.items():
            for row in rows:
                self.assertEqual(stated[row], found[source], row)


class CaseHash(InFolder):
    def test_leaves_out_the_keys_that_the_page_names(self):
        sources = "".join(path.read_text(encoding="utf-8") for path in (ROOT / "libmpm").rglob("*_spec.hpp")) + (ROOT / "libmpm/driver/case.hpp").read_text()
        declared = re.findall(r'\badd\("(\w+)"[^;]*no_effect_on_results', sources)
        page = (ROOT / "docs" / "results.md").read_text(encoding="utf-8")
        listed = re.search(r"Outside it are (.*?)\. Another", page, re.DOTALL)[1].replace('`feed = "strip"`', "")
        self.assertEqual(sorted(key.rpartition(".")[2] for key in re.findall(r"`([\w.]+)`", listed)), sorted([*declared, "duration_s"]))

    @needs_program
    def test_of_a_campaigns_run_depends_on_whether_frames_are_kept(self):
        def hash_of(line):
            plan = self.write("plan.toml", f'base = "{ROOT}/examples/avalanche_fr3.toml"\n{line}\n[[run]]\nname = "a"\n')
            return Campaign(plan).expansion()["runs"][0]["case_hash"]

        outside = ('keep = ["final", "checkpoint"]', *(f"[set]\n{key}" for key in (
            '"measurement.steady_by" = "runup"', '"output.duration_s" = 9', '"output.checkpoint_minutes" = 9', '"output.stop_when_steady" = 0.1')))
        self.assertEqual({hash_of(line) for line in outside}, {hash_of("")})
        self.assertNotEqual(hash_of('keep = ["frames"]'), hash_of(""))


@needs_program
class Arrays(InFolder):
    def test_of_frames_last_state_and_profiles_are_those_of_a_run(self):
        small = {"numerics.cell_size_m": 0.875, "conveyor.width_m": 8.75, "output.duration_s": 0.1}
        run = Case.read(ROOT / "examples" / "avalanche_fr3.toml").changed(small).run(self.folder / "run", threads=1, progress=False)
        page = (ROOT / "docs" / "results.md").read_text(encoding="utf-8")
        rows = [line.strip("|").split("|") for line in page.partition("## Arrays of a frame")[2].partition("\n## ")[0].splitlines() if line.startswith("| `")]
        arrays = [(set(re.findall(r"`(\w+)`", row[0])), row[1]) for row in rows if len(row) == 3]
        attributes = set().union(*(re.findall(r"`(\w+)`", row[0]) for row in rows if len(row) == 2))
        for state, word in ((run.frames[0], "frames"), (run.final, "final.h5")):
            self.assertEqual(set(state), set().union(*(names for names, where in arrays if word in where or "both" in where)))
            self.assertEqual(set(state.attributes), attributes)
        self.assertTrue(run.final.attributes["mirror_y"] == 1 and run.final["position_m"][:, 1].min() >= 0.0)
        of_profiles = next(line for line in page.splitlines() if line.startswith("| `profiles.h5`")).split("|")[2]
        with h5py.File(self.folder / "run" / "profiles.h5") as file:
            self.assertEqual(set(file), set(re.findall(r"`(\w+)`", of_profiles)))


if __name__ == "__main__":
    unittest.main()
