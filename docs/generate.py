#!/usr/bin/python3
"""Fills the tables of docs/results.md that list what a run writes, from `mpm schema --results`.

usage: generate.py MPM [--check]    MPM: the program. --check changes nothing and fails where a table is out of date
"""

import pathlib
import re
import subprocess
import sys

SECTIONS = {"quantities": "Quantities of `results.json`", "columns": "Columns of `series.csv`", "profile": "Columns of `profile.csv`"}


def tables(program):
    """The tables by their headings."""
    text = subprocess.run([program, "schema", "--results"], check=True, capture_output=True, text=True).stdout
    parts = re.split(r"^## (.*)$", text, flags=re.MULTILINE)
    return {heading.strip(): body.strip() for heading, body in zip(parts[1::2], parts[2::2])}


def filled(page, found):
    """The page with its generated sections as the program describes them."""
    for marker, heading in SECTIONS.items():
        if heading not in found:
            sys.exit(f"generate.py: the program has no table '{heading}', only {', '.join(found)}")
        pattern = rf"(<!-- generated: {marker} -->\n).*?(<!-- /generated -->)"
        page, count = re.subn(pattern, lambda m, text=found[heading]: f"{m[1]}\n{text}\n\n{m[2]}", page, flags=re.DOTALL)
        if count != 1:
            sys.exit(f"generate.py: docs/results.md has {count} sections '{marker}', one is needed")
    return page


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    path = pathlib.Path(__file__).with_name("results.md")
    before = path.read_text(encoding="utf-8")
    after = filled(before, tables(sys.argv[1]))
    if "--check" in sys.argv:
        if after != before:
            sys.exit("docs/results.md is out of date: run docs/generate.py build/release/bin/mpm")
    else:
        path.write_text(after, encoding="utf-8")


if __name__ == "__main__":
    main()
