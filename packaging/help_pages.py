"""What `mpm ... --help` says, as data: for man pages and for the completion of the shell."""

import re
import subprocess
from dataclasses import dataclass, field


@dataclass
class Command:
    """One command: its words ("mpm", "campaign", "run"), help text, options {name: (argument, text)}, positionals [(argument, text)]."""

    words: tuple
    help: str
    summary: str
    options: dict = field(default_factory=dict)
    positionals: list = field(default_factory=list)
    subcommands: list = field(default_factory=list)


def commands(program, words=("mpm",)):
    """Every command of the program, those with subcommands before these."""
    text = subprocess.run([program, *words[1:], "--help"], capture_output=True, text=True, check=True).stdout
    text = re.sub(r", at most \d+ on this machine", "", text)
    found = Command(words, text, text.split("\n", 1)[0].split("Usage:")[0].strip())
    for name, what in entries(section(text, "Options:")):
        spelled, _, argument = name.partition(" ")
        for option in spelled.split(","):
            found.options[option] = (clean_argument(argument), what)
    found.positionals = [(clean_argument(name.partition(" ")[2]), what) for name, what in entries(section(text, "Positionals:"))]
    found.subcommands = [name for name, _ in entries(section(text, "Subcommands:"))]
    result = [found]
    for name in found.subcommands:
        result += commands(program, (*words, name))
    return result


def section(text, heading):
    """The indented lines below a heading."""
    lines = text.partition(f"\n{heading}\n")[2].splitlines()
    end = next((i for i, line in enumerate(lines) if line and not line.startswith(" ")), len(lines))
    return lines[:end]


def entries(lines):
    """(name, text) of each entry: two spaces, the name, two or more spaces or a new line, the text, which may go on below."""
    found = []
    for line in lines:
        if start := re.match(r"  (\S+(?: \S+)*)(?:\s{2,}(.*))?$", line):
            found.append([start[1], start[2] or ""])
        elif found and line.strip():
            found[-1][1] = f"{found[-1][1]} {line.strip()}".strip()
    return [tuple(entry) for entry in found]


def clean_argument(text):
    """The name of an argument without ranges of this machine and without text that repeats the description: "N:in [1, 8]" is N, "CASE.toml REQUIRED" CASE.toml."""
    text = re.sub(r"\b(REQUIRED|Excludes: .*|Needs: .*)", "", text)
    words = re.search(r"\{(.*?)\}", text)
    text = re.sub(r":.*|(?<=[A-Z])=.*", "", text).strip().removesuffix("...").strip()  # "table.key=value" is a name, "FLOAT=3" has a default
    return "|".join(words[1].split(",")) if words else text
