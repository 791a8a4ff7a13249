#!/usr/bin/python3
"""What a package holds beside the program, as packaging/generate.py makes it: packaging.py MPM"""

import json
import pathlib
import shutil
import subprocess
import sys
import tempfile
import unittest
import unittest.mock

SOURCE = pathlib.Path(__file__).resolve().parent.parent
sys.path[:0] = [str(SOURCE / "packaging"), str(SOURCE / "tests")]
import check_docs  # noqa: E402  (after its path)
import documents  # noqa: E402
import help_pages  # noqa: E402

MPM = ""


class Packaging(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.temporary = tempfile.TemporaryDirectory()
        cls.addClassCleanup(cls.temporary.cleanup)
        cls.out = pathlib.Path(cls.temporary.name)
        done = subprocess.run(["/usr/bin/python3", SOURCE / "packaging" / "generate.py", MPM, cls.out], capture_output=True, text=True, check=False)
        assert done.returncode == 0, done.stderr
        cls.commands = help_pages.commands(MPM)

    def test_every_command_has_a_man_page_that_man_reads_without_complaint(self):
        self.assertEqual({path.stem for path in (self.out / "man").iterdir()}, {"-".join(c.words) for c in self.commands})
        for command in self.commands:
            path = self.out / "man" / f"{'-'.join(command.words)}.1"
            page = path.read_text(encoding="utf-8")
            for heading in (".SH NAME", ".SH SYNOPSIS", '.SH "EXIT STATUS"', '.SH "SEE ALSO"'):
                self.assertIn(heading, page, path.name)
            for option in command.options:
                self.assertIn(option.replace("-", "\\-"), page, path.name)
            self.assertNotIn("on this machine (", page)  # what holds where the page was made
            shown = subprocess.run(["groff", "-man", "-Tutf8", "-ww", "-z", path], capture_output=True, text=True, check=False)
            self.assertEqual((shown.returncode, shown.stderr), (0, ""), path.name)

    def complete(self, line, folder=SOURCE / "examples"):
        """What bash offers for a line with the cursor at its end."""
        code = ('source "$1"; COMP_LINE=$2; COMP_POINT=${#2}; COMPREPLY=(); COMP_WORDBREAKS=$\' \\t\\n"\\\'><=;|&(:\'; _mpm; '
                'printf "%s\\n" "${COMPREPLY[@]}"')
        done = subprocess.run(["bash", "-u", "-c", code, "bash", self.out / "completion" / "mpm", line], capture_output=True, text=True,
                              check=True, cwd=folder)
        self.assertEqual(done.stderr, "")
        return done.stdout.split()

    def test_completion_offers_commands_options_files_keys_and_words(self):
        self.assertEqual(self.complete("mpm ca"), ["campaign"])
        self.assertEqual(set(self.complete("mpm ")), {c.words[1] for c in self.commands if len(c.words) == 2})
        self.assertEqual(set(self.complete("mpm campaign ")), {"run", "status", "plan", "submit", "task"})
        self.assertEqual(set(self.complete("mpm run --")), {"--help", "--set", "--out", "--threads", "--resume", "--force", "--any-size"})
        self.assertIn("avalanche_fr3.toml", self.complete("mpm run aval"))
        self.assertIn("avalanche_fr3.toml", self.complete("mpm run --threads 2 aval"))
        self.assertEqual(self.complete("mpm point paths/"), ["paths/compression_then_shear.toml"])
        self.assertEqual(self.complete("mpm run avalanche_fr3.toml --out de"), ["design"])
        self.assertEqual(self.complete("mpm run avalanche_fr3.toml --set numerics.ce"), ["numerics.cell_size_m="])
        self.assertEqual(set(self.complete("mpm campaign run --executor ")), {"local", "slurm"})
        self.assertEqual(self.complete("mpm nonsense"), [])
        for name in self.complete("mpm compare "):
            self.assertTrue((SOURCE / "examples" / name).is_dir(), name)

    def test_the_schema_is_one_and_knows_the_keys(self):
        import jsonschema

        schema = json.loads((self.out / "case.schema.json").read_text(encoding="utf-8"))
        jsonschema.Draft7Validator.check_schema(schema)
        self.assertEqual(schema["properties"]["obstacle"]["properties"]["friction"]["default"], 0.15)
        self.assertEqual(schema["properties"]["conveyor"]["properties"]["inflow"]["type"], "array")


class Documents(unittest.TestCase):
    def test_lead_to_files_of_the_package_and_to_examples(self):
        with tempfile.TemporaryDirectory() as folder:
            share = pathlib.Path(folder) / "share"  # as /usr/share
            documents.Documents().write(pathlib.Path(folder) / "made")
            shutil.copytree(SOURCE / "examples", share / "mpm" / "examples", ignore=shutil.ignore_patterns("*.md", "__pycache__"))
            shutil.copytree(pathlib.Path(folder) / "made" / "examples", share / "mpm" / "examples", dirs_exist_ok=True)
            shutil.copytree(pathlib.Path(folder) / "made" / "doc", share / "doc" / "mpm", symlinks=True)
            for root in (share / "doc" / "mpm", share / "mpm"):
                self.assertEqual(list(check_docs.broken_links(root)), [])
            self.assertTrue((share / "doc" / "mpm" / "validation" / "study" / "base.toml").exists(), "which quick.toml names")
            text = (share / "doc" / "mpm" / "docs" / "design.md").read_text(encoding="utf-8")
            self.assertIn("](../examples/design/mast.toml)", text)
            self.assertIn("](../../doc/mpm/docs/cases.md#examples)", (share / "mpm" / "examples" / "README.md").read_text(encoding="utf-8"))
            self.assertIn("libmpm/driver/advice.cpp has one function", (share / "doc" / "mpm" / "docs" / "commands.md").read_text(encoding="utf-8"))

    def test_name_a_link_that_leads_nowhere(self):
        with tempfile.TemporaryDirectory() as folder:
            root = pathlib.Path(folder).resolve()
            (root / "README.md").write_text("[here](gone.md)", encoding="utf-8")
            (root / "CHANGELOG.md").touch()
            with unittest.mock.patch.multiple(documents, ROOT=root, EXAMPLES=root / "examples"), self.assertRaisesRegex(SystemExit, "README.md: link to 'gone.md'"):
                documents.Documents()


class HelpTexts(unittest.TestCase):
    def test_arguments_lose_what_the_text_says_anyway(self):
        for text, argument in (("N:in [1, 8]", "N"), ("CASE.toml REQUIRED", "CASE.toml"), ("table.key=value ...", "table.key=value"),
                               ("TEXT:{local,slurm}=local", "local|slurm"), ("Excludes: --force", ""), ("FLOAT=3 ...", "FLOAT"), ("DIR", "DIR")):
            self.assertEqual(help_pages.clean_argument(text), argument, text)

    def test_entries_go_on_below(self):
        self.assertEqual(help_pages.entries(["  -a,--all     text", "               more", "  --long NAME", "        below"]),
                         [("-a,--all", "text more"), ("--long NAME", "below")])


if __name__ == "__main__":
    MPM = sys.argv.pop(1)
    unittest.main(verbosity=2)
