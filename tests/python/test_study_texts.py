"""The generated tables in the study's texts: validation/study/fill_tables.py."""

import subprocess
import sys
import unittest

from study_samples import SOURCE

sys.path.insert(0, str(SOURCE / "docs"))
from generate import filled  # noqa: E402

SCRIPT = SOURCE / "validation" / "study" / "fill_tables.py"
PAGE = "text\n\n<!-- generated: heights -->\n\nold\n\n<!-- /generated -->\nmore\n"


def run(*arguments):
    return subprocess.run([sys.executable, SCRIPT, *arguments], capture_output=True, text=True, check=False)


class StudyTexts(unittest.TestCase):
    def test_hold_the_numbers_of_the_results(self):
        done = run("--check")
        self.assertEqual((done.returncode, done.stderr), (0, ""))

    def test_other_words_are_refused(self):
        done = run("--chek")
        self.assertEqual(done.returncode, 1)
        self.assertIn("usage: fill_tables.py", done.stderr)

    def test_only_what_is_between_the_markers_changes(self):
        self.assertEqual(filled("a.md", PAGE, {"heights": "new"}), PAGE.replace("old", "new"))

    def test_a_section_that_a_text_lacks_is_named(self):
        with self.assertRaisesRegex(SystemExit, "a.md has 0 sections 'forces'"):
            filled("a.md", PAGE, {"forces": "new"})


if __name__ == "__main__":
    unittest.main()
