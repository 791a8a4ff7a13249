#!/usr/bin/python3
"""Checks the Markdown pages of the repository: README.md is short, lines are wrapped and none is lost on the site, links resolve, no path
belongs to one machine.

usage: check_docs.py [--links] [ROOT]    (default: the repository this script is in; --links: only the links)

Prints one line for each problem, `file:line: what`, and exits with 1 if there is any.
"""

import pathlib
import re
import sys

README_LINES = 200  # a newcomer reads it in ten minutes
LINE_LENGTH = 120  # outside tables and code blocks
SKIPPED_FOLDERS = {".git", "build", "out", "__pycache__"}
LINK = re.compile(r"\]\(([^()\s]+)\)")  # a link whose text spans two lines counts, too
CODE_SPAN = re.compile(r"`[^`]*`")
MACHINE_PATH = re.compile(r"(?<![\w./])/(?:home|root|tmp|work|mnt)/\w")


def pages(root):
    """Every Markdown file below root, outside generated folders."""
    for path in sorted(root.rglob("*.md")):
        folders = path.relative_to(root).parts[:-1]
        if not any(name in SKIPPED_FOLDERS or name.startswith("build") for name in folders):
            yield path


def prose(text):
    """Line number, line, and whether the line is prose, that is outside code blocks (fenced by ```)."""
    fenced = False
    for number, line in enumerate(text.splitlines(), start=1):
        if line.lstrip().startswith("```"):
            fenced = not fenced
            yield number, line, False
        else:
            yield number, line, not fenced


def anchors(text):
    """The anchors of a page's headings, as GitHub makes them: lower case, no punctuation, hyphens for spaces."""
    found = set()
    for _, line, is_prose in prose(text):
        if is_prose and line.startswith("#"):
            title = re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", line.lstrip("#").strip()).lower()
            found.add(re.sub(r"\s", "-", re.sub(r"[^\w\s-]", "", title)))
    return found


def link_problem(page, target, folder=None):
    """Why a link of a page leads nowhere; None if it resolves or is not relative. @param folder  where the page is read, if not where it is"""
    if re.match(r"[a-z][a-z+.-]*:", target):
        return None
    file, _, anchor = target.partition("#")
    destination = page if not file else (folder or page.parent) / file
    if not destination.exists():
        return f"link to '{target}': there is no such file"
    if anchor and destination.suffix == ".md" and anchor not in anchors(destination.read_text(encoding="utf-8")):
        return f"link to '{target}': the page has no such heading"
    return None


def broken_links(root):
    """Every link of the pages that leads nowhere."""
    for page in pages(root):
        name = page.relative_to(root)
        folder = root if str(name).startswith("docs/site/pages/") else None  # docs/site/assemble.py puts them there
        text = page.read_text(encoding="utf-8")
        for number, line, is_prose in prose(text):
            for target in LINK.findall(CODE_SPAN.sub("", line)) if is_prose else ():
                problem = link_problem(page, target, folder)
                if problem:
                    yield f"{name}:{number}: {problem}"


def problems(root):
    yield from broken_links(root)
    for page in pages(root):
        name, text = page.relative_to(root), page.read_text(encoding="utf-8")
        lines = len(text.splitlines())
        if name == pathlib.Path("README.md") and lines > README_LINES:
            yield f"{name}:{lines}: {lines} lines, at most {README_LINES} are allowed: move details to docs/"
        for number, line, is_prose in prose(text):
            if MACHINE_PATH.search(line):
                yield f"{name}:{number}: a path of one machine: {MACHINE_PATH.search(line).group()}..."
            if is_prose and len(line) > LINE_LENGTH and not line.lstrip().startswith("|"):
                yield f"{name}:{number}: {len(line)} characters, at most {LINE_LENGTH} are allowed outside tables and code"
            if is_prose and line.lstrip().startswith("%"):
                yield f"{name}:{number}: begins with %: the documentation site takes the line for a comment and leaves it out"


def main():
    arguments = [argument for argument in sys.argv[1:] if argument != "--links"]
    root = pathlib.Path(arguments[0] if arguments else pathlib.Path(__file__).parent.parent).resolve()
    count = sum(1 for _ in pages(root))
    if count == 0:
        sys.exit(f"no Markdown page below {root}")
    found = list(broken_links(root) if "--links" in sys.argv else problems(root))
    print("\n".join(found) if found else f"{count} pages, no problem")
    sys.exit(1 if found else 0)


if __name__ == "__main__":
    main()
