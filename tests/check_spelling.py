#!/usr/bin/python3
"""Spelling of the Markdown pages and the tutorials, by hunspell (British English) and a list of the words of this project, tests/words.txt.

usage: check_spelling.py [ROOT] [--list]    --list prints the unknown words alone, to be corrected or added to the list
"""

import pathlib
import re
import shutil
import subprocess
import sys

SKIPPED_FOLDERS = {".git", "build", "out", "__pycache__"}
NOT_PROSE = re.compile(r"""^```.*?^```[ \t]*$ | ``.+?`` | `[^`\n]*` | \$\$.*?\$\$ | \$[^$\n]+\$ | <!--.*?--> | <[^>\n]+> | \]\([^()]*\) |
                           https?://\S+ | ^\#:schema.*$ | \{toctree\} | \b\S+@\S+\b | ^\|[-|: ]+\|$""", re.MULTILINE | re.DOTALL | re.VERBOSE)
WORD = re.compile(r"[^\W\d_]+(?:['’][^\W\d_]+)?")
CODE_LIKE = re.compile(r"\S*(?:[_/\\]|\w\.\w|::|\w\(|=|\d)\S*")  # names of files, keys and functions that stand in prose


def texts(root):
    """(name, prose) of every page and tutorial."""
    for path in sorted([*root.rglob("*.md"), *(root / "examples" / "tutorials").glob("*.py")]):
        folders = path.relative_to(root).parts[:-1]
        if any(name in SKIPPED_FOLDERS or name.startswith("build") for name in folders):
            continue
        text = path.read_text(encoding="utf-8")
        if path.suffix == ".py":
            cells = re.split(r"^# %%(.*)\n", text, flags=re.MULTILINE)[1:]
            text = "\n".join(re.sub(r"^# ?", "", cell, flags=re.MULTILINE) for kind, cell in zip(cells[::2], cells[1::2]) if "[markdown]" in kind)
        yield path.relative_to(root), CODE_LIKE.sub(" ", NOT_PROSE.sub(" ", text))


def unknown_words(root):
    """{word: first page it is on}."""
    if shutil.which("hunspell") is None:
        sys.exit("check_spelling.py needs Debian's hunspell and hunspell-en-gb")
    first = {}
    for name, text in texts(root):
        for word in WORD.findall(text.replace("’", "'")):
            if len(word) > 2 and not word.isupper():
                first.setdefault(word, name)
    if len(first) < 500:
        sys.exit(f"{root}: only {len(first)} different words were found; something is wrong with the pages or with this script")
    known = {line.strip() for line in (pathlib.Path(__file__).parent / "words.txt").read_text(encoding="utf-8").splitlines()}
    asked = [word for word in first if not {word, word.lower(), word.removesuffix("'s"), word.lower().removesuffix("'s")} & known]
    done = subprocess.run(["hunspell", "-d", "en_GB", "-i", "utf-8", "-l"], input="\n".join(asked), capture_output=True, text=True, check=False)
    if done.returncode != 0 or done.stderr.strip():
        sys.exit(f"hunspell: {done.stderr.strip() or done.returncode}; install Debian's hunspell-en-gb")
    return {word: first[word] for word in done.stdout.split() if word in first}


def main():
    arguments = [a for a in sys.argv[1:] if a != "--list"]
    root = pathlib.Path(arguments[0] if arguments else pathlib.Path(__file__).parent.parent).resolve()
    found = unknown_words(root)
    if "--list" in sys.argv:
        print("\n".join(sorted(found, key=str.lower)))
    elif found:
        print("\n".join(f"{name}: '{word}'" for word, name in sorted(found.items(), key=lambda entry: (str(entry[1]), entry[0]))))
        print(f"{len(found)} unknown words; correct them, or add words of the field to tests/words.txt")
    else:
        print("every word is known")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
