#!/usr/bin/python3
"""The parts of the documentation site that are programs: how pages are put together, how links are checked, figures of the theory."""

import json
import pathlib
import subprocess
import sys
import unittest

SOURCE = pathlib.Path(__file__).resolve().parent.parent
SITE = SOURCE / "docs" / "site"
sys.path[:0] = [str(SITE), str(SOURCE / "docs"), str(SOURCE / "tests" / "python"), str(SOURCE / "python")]
import assemble  # noqa: E402  (after its path)
import check_site  # noqa: E402
import pictures  # noqa: E402
from in_folder import InFolder  # noqa: E402


class Links(InFolder):
    def test_that_lead_somewhere_are_silent(self):
        self.write("index.html", '<a href="sub/b.html#here">b</a><a href="https://example.org/">out</a><img src="p.png"><video src="f.webm"></video><a href="#top">t</a><p id="top">')
        self.write("sub/b.html", '<h2 id="here">b</h2><a href="../index.html">back</a>')
        self.write("p.png", "")
        self.assertEqual(list(check_site.problems(self.folder, set())), ["index.html: f.webm: there is no such file"])
        self.write("f.webm", "")
        self.assertEqual(list(check_site.problems(self.folder, set())), [])

    def test_that_lead_nowhere_are_named(self):
        self.write("index.html", '<a href="no.html">x</a><a href="index.html#no">y</a><script src="https://cdn.example/x.js"></script>'
                                 '<link rel="stylesheet" href="a.css"><a href="/root.html">z</a>')
        self.write("a.css", "@import url(//fonts.example/f.css); p { background: url('no.png') }")
        found = "\n".join(check_site.problems(self.folder, set()))
        for text in ("no.html: there is no such file", "index.html#no: the page has no such anchor", "loads https://cdn.example/x.js from a network",
                     "a.css: loads //fonts.example/f.css from a network", "a.css: no.png: there is no such file", "/root.html begins at the root"):
            self.assertIn(text, found)

    def test_of_an_empty_folder_are_a_problem(self):
        self.assertEqual(len(list(check_site.problems(self.folder, set()))), 1)


class Pages(InFolder):
    def test_are_all_there_with_what_they_link_to(self):
        done = subprocess.run([sys.executable, SITE / "assemble.py", self.folder / "out"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)
        out = self.folder / "out"
        for name in ("README.md", "docs/cases.md", "validation/cases/plate_in_jet/README.md", "index.md", "docs/images/theory/step.svg",
                     "examples/avalanche_fr3.toml", "docs/images/avalanche_fr3.webm", "libmpm/material/cam_clay.hpp"):
            self.assertTrue((out / name).exists(), name)
        index = (out / "index.md").read_text(encoding="utf-8")
        for script in (SOURCE / "examples" / "tutorials").glob("*.py"):
            page = (out / "examples" / "tutorials" / script.name).with_suffix(".md").read_text(encoding="utf-8")
            self.assertTrue(page.startswith("# "), script.name)
            self.assertIn(f"({script.name})", page)
            self.assertIn(f"examples/tutorials/{script.stem}\n", index)
        first = (out / "examples" / "tutorials" / "a_first_mast.md").read_text(encoding="utf-8")
        self.assertIn("```python\ncheck = case.check()", first)
        self.assertIn("tutorials/side_view.png)", first)

    def test_links_to_folders_go_to_their_readme(self):
        page = pathlib.Path("docs/page.md")
        text = "[case](../validation/cases/vortex) and [code](../libmpm/core) and `[no](../validation)`\n```\n[no](../validation)\n```\n"
        changed = assemble.with_links(page, text, self.folder)
        self.assertTrue(changed.startswith("[case](../validation/cases/vortex/README.md) and code and "), changed)
        self.assertIn("```\n[no](../validation)\n```", changed)


class Pictures(unittest.TestCase):
    def test_and_quoted_numbers_are_those_of_todays_examples(self):
        entries = json.loads(pictures.LIST.read_text(encoding="utf-8"))
        self.assertEqual(list(pictures.problems(entries)), [])

    def test_that_are_older_than_their_inputs_and_numbers_that_differ_are_named(self):
        entries = json.loads(pictures.LIST.read_text(encoding="utf-8"))
        made = entries[0]["made"]
        made["checksums"]["examples/avalanche_fr3.toml"] = "of another one"
        made["numbers"]["runup_p99_mean_m"] += 0.2
        del entries[-1]
        found = "\n".join(pictures.problems(entries))
        self.assertIn("examples/avalanche_fr3.toml is not that of the pictures avalanche_fr3_heights.png", found)
        self.assertRegex(found, r"README.md: `runup_p99_mean_m` is [\d.]+, not [\d.]+")
        self.assertIn("docs/images/tutorials/column.png: no command makes it", found)


class Theory(InFolder):
    def test_figures_are_those_that_the_script_draws(self):
        subprocess.run([sys.executable, SOURCE / "docs" / "theory" / "draw.py", self.folder], check=True)
        stored = {path.name: path.read_bytes() for path in (SOURCE / "docs" / "images" / "theory").glob("*.svg")}
        drawn = {path.name: path.read_bytes() for path in self.folder.glob("*.svg")}
        self.assertEqual(set(stored), set(drawn))
        for name, data in drawn.items():
            self.assertEqual(data, stored[name], f"{name}: draw it again with docs/theory/draw.py")


if __name__ == "__main__":
    unittest.main(verbosity=2)
