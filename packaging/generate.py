#!/usr/bin/python3
"""Makes from the program what a package holds beside it: man pages (with help2man), completion for bash, the JSON schema of case files.

usage: generate.py MPM OUT        MPM: the program; OUT: a folder, which gets man/*.1, completion/mpm, case.schema.json
"""

import json
import os
import pathlib
import stat
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE.parent / "python")]

import help_pages  # noqa: E402  (after its path)
from mpmtools import json_schema  # noqa: E402

EXIT_CODES = """[exit status]
.TP
.B 0
success
.TP
.B 1
a validation or a comparison failed, or runs of a campaign failed
.TP
.B 2
wrong command line or case file
.TP
.B 3
the simulation became unstable
.TP
.B 4
a file cannot be read or written
.TP
.B 5
internal error, or a lack of memory or threads

[files]
.TP
.I /usr/share/mpm/examples
example cases, sites and tutorials
.TP
.I /usr/share/mpm/case.schema.json
JSON schema of case files, for editors
.TP
.I /usr/share/doc/mpm
the documentation
"""


def write(path, text):
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text, encoding="utf-8")


def help_for_man(command):
    """The help as help2man reads it: usage first, then the description; options as "-h, --help"."""
    description, _, rest = command.help.partition("Usage: ")
    usage = rest.split("\n", 1)[0]
    for argument, _ in command.positionals:
        usage = " ".join(usage.split()[:len(command.words) + 1])
    usage = " ".join([usage, *(argument for argument, _ in command.positionals)])
    parts = [f"Usage: {usage}", "", description.strip()]
    if command.positionals:
        parts += ["", "Arguments:", *(f"  {argument:<28} {text}" for argument, text in command.positionals)]
    spelled = {}
    for option, (argument, text) in command.options.items():
        spelled.setdefault((argument, text), []).append(option)
    parts += ["", "Options:"]
    parts += [f"  {', '.join(options)}{' ' + argument if argument else ''}  {text}" for (argument, text), options in spelled.items()]
    if command.subcommands:
        named = dict(help_pages.entries(help_pages.section(command.help, "Subcommands:")))
        parts += ["", "Commands:", *(f"  {name:<14} {text}" for name, text in named.items())]
    return "\n".join(parts) + "\n"


def man_page(command, all_commands, version, out):
    """Lets help2man make the page of a command."""
    name = "-".join(command.words)
    summary = command.summary.split(";")[0].split(". ")[0].rstrip(".")
    below = [c for c in all_commands if c.words != command.words and (c.words[:1] == command.words or c.words[:-1] == command.words[:-1] or
                                                                      c.words == command.words[:-1])]
    with tempfile.TemporaryDirectory() as folder:
        folder = pathlib.Path(folder)
        write(folder / "help", help_for_man(command))
        write(folder / "include", EXIT_CODES + "\n[see also]\n" + ",\n".join(sorted(f".BR {'-'.join(c.words)} (1)" for c in below)) + "\n")
        program = folder / name
        write(program, f"#!/bin/sh\ncat '{folder}/help'\n")
        program.chmod(program.stat().st_mode | stat.S_IXUSR)
        page = subprocess.run(["help2man", "--no-info", "--no-discard-stderr", "--section=1", f"--name={summary[:1].lower() + summary[1:]}",
                               f"--version-string={version}", "--manual=libmpm", f"--source=libmpm {version}",
                               f"--include={folder}/include", str(program)],
                              capture_output=True, text=True, check=True, env={**os.environ, "LC_ALL": "C.UTF-8"}).stdout
    write(out / "man" / f"{name}.1", page)


def completion(all_commands, keys):
    """The script for bash: the tables of commands and options filled into completion.bash."""
    lines = []
    for command in all_commands:
        place = " ".join(command.words)
        lines.append(f"  ['{place}']='{' '.join(command.subcommands) or ' '.join(command.options)}'")
    kinds = []
    for command in all_commands:
        place = " ".join(command.words)
        kinds += [f"  ['{place} {option}']='{argument}'" for option, (argument, _) in command.options.items() if argument]
        kinds += [f"  ['{place}']='{' '.join(argument for argument, _ in command.positionals)}'"] if command.positionals else []
    text = (HERE / "completion.bash").read_text(encoding="utf-8")
    for mark, filling in (("@WORDS@", "\n".join(lines)), ("@ARGUMENTS@", "\n".join(kinds)), ("@KEYS@", " ".join(f"{key}=" for key in keys))):
        text = text.replace(mark, filling)
    return text


def main():
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    program, out = sys.argv[1], pathlib.Path(sys.argv[2])
    version = subprocess.run([program, "--version"], capture_output=True, text=True, check=True).stdout.split()[1]
    reference = json.loads(subprocess.run([program, "schema", "--json"], capture_output=True, text=True, check=True).stdout)
    found = help_pages.commands(program)
    for command in found:
        man_page(command, found, version, out)
    keys = [f"{table['name']}.{key['name']}" if table["name"] else key["name"] for table in reference["tables"]
            if table["in_case"] and not table["repeated"] for key in table["keys"]]
    write(out / "completion" / "mpm", completion(found, keys))
    write(out / "case.schema.json", json.dumps(json_schema.case_schema(reference), indent=2) + "\n")


if __name__ == "__main__":
    main()
