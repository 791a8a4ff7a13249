#!/usr/bin/python3
"""Fills the generated tables of the pages in docs/: quantities and columns (results.md), keys (cases.md, design.md) and commands (commands.md)
from the program itself, the verbs of ./run (developing.md) from `./run help`, solvers side by side (other-solvers.md) from
reference_data/other_solvers; what python/mpmtools knows of quantities (quantities.json); and the results of the validation suite
(validation/results.md).

usage: generate.py MPM [--check]    MPM: the program. --check changes nothing and fails where a table is out of date
"""

import csv
import json
import pathlib
import re
import subprocess
import sys
import textwrap

import validation_page
from markdown_tables import table

DOCS = pathlib.Path(__file__).resolve().parent
SOLVERS = DOCS.parent / "reference_data" / "other_solvers" / "data.csv"
QUANTITIES = DOCS.parent / "python" / "mpmtools" / "quantities.json"
RESULTS = {"quantities": "Quantities of `results.json`", "columns": "Columns of `series.csv`", "profile": "Columns of `profile.csv`"}


def output_of(*command):
    return subprocess.run(command, check=True, capture_output=True, text=True).stdout


def sentence(text):
    """With a full stop, and a capital unless it begins with a word of a case file or a formula."""
    begin = text[0].upper() if re.match(r"[a-z]+[ ,;']", text) else text[0]
    return begin + text[1:].rstrip(".") + "."


def result_tables(program):
    """The tables that the program prints, by their markers."""
    parts = re.split(r"^## (.*)$", output_of(program, "schema", "--results"), flags=re.MULTILINE)
    found = {heading.strip(): body.strip() for heading, body in zip(parts[1::2], parts[2::2])}
    missing = [heading for heading in RESULTS.values() if heading not in found]
    if missing:
        sys.exit(f"generate.py: the program has no table '{missing[0]}', only {', '.join(found)}")
    return {marker: found[heading] for marker, heading in RESULTS.items()}


def permitted(key):
    """The range or the words of a key."""
    if "one_of" in key:
        return ", ".join(f"`{word}`" for word in key["one_of"])
    if "range" not in key:
        return ""
    limits = key["range"]
    low = "(" if limits["low_open"] else "["
    high = ")" if limits["high_open"] else "]"
    return f"{low}{limits['low']:g}, {limits['high']:g}{high}"


def preset(key):
    """What counts where a key is left out."""
    text = key.get("default", "")
    if not text:
        return "required" if "required" in key else ""
    return text if re.match(r"left out|depends on", text) else f"`{text}`"


def meaning(key):
    """The text of a key, with the conditions under which it is used and required."""
    text = sentence(key["description"])
    used, required = key.get("only_with"), key.get("required", "always")
    if used:
        text += f" Only with {used}."
    if required not in ("always", used):
        text += f" Required with {required}."
    return text


def key_tables(program, *which):
    """One section for each table of a case file or path file, or of the files that `which` names."""
    sections = []
    for part in json.loads(output_of(program, "schema", "--json", *which))["tables"]:
        name = part["name"]
        title = "Top level" if not name else f"`[[{name}]]`" if part["repeated"] else f"`[{name}]`"
        rows = [(f"`{key['name']}`", ", ".join(filter(None, (key["type"], key["unit"]))), permitted(key), preset(key), meaning(key))
                for key in part["keys"]]
        text = "\n".join(textwrap.wrap(sentence(part["description"]), 116, break_on_hyphens=False))
        sections.append(f"### {title}\n\n{text}\n\n" + table(("key", "type", "range", "default", "meaning"), rows))
    return "\n\n".join(sections)


def entries(text):
    """Name and description of each entry of a help text: two spaces, the name, two or more spaces, the description, which may go on below."""
    found = []
    for line in text.splitlines():
        if start := re.match(r"  (\S+(?: \S+)*)(?:\s{2,}(.*))?$", line):
            found.append([start[1], start[2] or ""])
        elif found and line.startswith("   "):
            found[-1][1] = f"{found[-1][1]} {line.strip()}".strip()
    return found


def usage_of(program, *words):
    """A command with its arguments: mpm run CASE.toml."""
    text = output_of(program, *words, "--help")
    usage = re.search(r"^Usage: (.*)$", text, flags=re.MULTILINE)[1].replace(" [OPTIONS]", "")
    for name, kind in re.findall(r"^  (\w+) (\S+) REQUIRED", text, flags=re.MULTILINE):
        usage = re.sub(rf"(.*) {name}\b", rf"\1 {name.upper() if kind == 'TEXT' else kind}", usage)  # the last: a command may have that name, too
    return usage


def commands(program, *words):
    """Usage and first sentence of each command below some words."""
    found = []
    for name, text in entries(output_of(program, *words, "--help").partition("Subcommands:")[2]):
        below = commands(program, *words, name)
        found += below or [(usage_of(program, *words, name), re.split(r"(?<=\.) (?=[A-Z])", text)[0])]
    return found


def command_table(program, page):
    """Every command; those with a section of their own are linked to it."""
    rows = []
    for usage, text in commands(program):
        name = usage.split()[1]
        linked = f"\n## `mpm {name}`\n" in page
        rows.append((f"[`{usage}`](#mpm-{name})" if linked else f"`{usage}`", sentence(text)))
    return table(("command", "what it does"), rows)


def verb_table():
    """Every verb of ./run."""
    text, _, _ = output_of(str(DOCS.parent / "run"), "help").partition("\nEvery verb")
    return table(("verb", "what it does"), [(f"`{verb}`", sentence(what)) for verb, what in entries(text)])


# Where the pages explain a command of mpmtools.
MPMTOOLS_PAGES = {"fit": "study.md", "study": "study.md", "plot": "results.md#pictures", "render": "results.md#pictures", "view": "results.md#pictures",
                  "film": "results.md#pictures", "design": "design.md", "scale": "cluster.md#predicting-the-efficiency",
                  "import-avaframe": "cases.md#inflow-from-a-path-model", "json-schema": "install.md#your-editor"}


def mpmtools_table():
    """Every command of python3 -m mpmtools, from its own parser."""
    sys.path.insert(0, str(DOCS.parent / "python"))
    from mpmtools.__main__ import parser

    choices = next(action for action in parser()._actions if action.dest == "command")  # argparse offers no other way to its commands
    texts = {action.dest: action.help for action in choices._choices_actions}
    return table(("`python3 -m mpmtools`", "what it does"),
                 [(f"[`{name}`]({MPMTOOLS_PAGES[name]})", sentence(texts[name])) for name in choices.choices])


def solver_tables():
    """How many checks of each case the solvers pass; and for each check that one of them fails, error over tolerance."""
    with open(SOLVERS, encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    solvers = list(dict.fromkeys(row["solver"] for row in rows))
    cases, checks = {}, {}
    for entry in rows:
        cases.setdefault(entry["case"], {}).setdefault(entry["solver"], []).append(entry["verdict"] == "ok")
        checks.setdefault((entry["case"], entry["quantity"]), {})[entry["solver"]] = entry

    def used(check):
        if check is None:
            return ""
        share = f"{float(check['tolerance_used']):.2g}" if check["tolerance_used"] else "∞"
        return share if check["verdict"] == "ok" else f"**{share}**"

    passed = [(f"`{case}`", *(f"{sum(of[s])} of {len(of[s])}" if s in of else "" for s in solvers)) for case, of in cases.items()]
    failed = [(f"`{case}`", quantity, *(used(of.get(s)) for s in solvers)) for (case, quantity), of in checks.items()
              if any(check["verdict"] != "ok" for check in of.values())]
    return (f"{table(('checks passed', *solvers), passed)}\n\nChecks that a solver fails (bold), error over tolerance:\n\n"
            f"{table(('case', 'check', *solvers), failed)}")


def filled(path, page, sections):
    """A page with its generated sections."""
    for marker, text in sections.items():
        pattern = rf"(<!-- generated: {marker} -->\n).*?(<!-- /generated -->)"
        page, count = re.subn(pattern, lambda m, text=text: f"{m[1]}\n{text}\n\n{m[2]}", page, flags=re.DOTALL)
        if count != 1:
            sys.exit(f"{path} has {count} sections '{marker}', one is needed")
    return page


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    program = sys.argv[1]
    before = {name: (DOCS / name).read_text(encoding="utf-8") for name in ("results.md", "cases.md", "design.md", "commands.md", "developing.md", "other-solvers.md")}
    sections = {"results.md": result_tables(program),
                "cases.md": {"keys": key_tables(program)},
                "design.md": {"keys": key_tables(program, "--site")},
                "commands.md": {"commands": command_table(program, before["commands.md"]), "mpmtools": mpmtools_table()},
                "developing.md": {"verbs": verb_table()},
                "other-solvers.md": {"solvers": solver_tables()}}
    stale = []
    for name, page in before.items():
        after = filled(f"docs/{name}", page, sections[name])
        if after != page:
            stale.append(f"docs/{name}")
            if "--check" not in sys.argv:
                (DOCS / name).write_text(after, encoding="utf-8")
    for path, text in ((QUANTITIES, output_of(program, "schema", "--results", "--json")), (validation_page.PAGE, validation_page.page())):
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            stale.append(str(path.relative_to(DOCS.parent)))
            if "--check" not in sys.argv:
                path.write_text(text, encoding="utf-8")
    wrong = list(validation_page.contradictions())
    if "--check" in sys.argv and stale:
        sys.exit(f"{', '.join(stale)}: out of date; run docs/generate.py build/release/bin/mpm")
    if wrong:
        sys.exit("\n".join(wrong))


if __name__ == "__main__":
    main()
