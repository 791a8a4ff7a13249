#!/usr/bin/python3
"""The documentation as the package installs it: README.md, CHANGELOG.md and docs/, the Markdown pages that they link to, and their pictures.

usage: documents.py OUT    OUT: a folder, made anew: OUT/doc becomes /usr/share/doc/mpm, OUT/examples the pages of /usr/share/mpm/examples

Every link leads to an installed file. In /usr/share/doc/mpm, examples is a symbolic link to /usr/share/mpm/examples, where they stay on systems
that leave out documentation. A link to a source file, which the package does not hold, becomes its text; one to a folder leads to the README
there.
"""

import os
import pathlib
import re
import shutil
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parents[1]
EXAMPLES = ROOT / "examples"
INSTALLED = pathlib.PurePosixPath("/usr/share/doc/mpm"), pathlib.PurePosixPath("/usr/share/mpm/examples")
LINK = re.compile(r"(!?)\[((?:[^\[\]]|\[[^\]]*\])*)\]\(([^()\s]+)\)")
COPIED = {".png", ".svg", ".webm", ".mp4", ".toml"}  # pictures, films, plans of campaigns
FENCED = re.compile(r"(^```.*?^```[ \t]*$)", re.MULTILINE | re.DOTALL)


def installed(name):
    """Where the package puts a file. @param name  path in the repository"""
    doc, examples = INSTALLED
    return examples / name.relative_to("examples") if name.parts[0] == "examples" else doc / name


class Documents:
    """What is installed: pages (path in the repository -> text with its links rewritten) and files that they show or name."""

    def __init__(self):
        self.pages, self.files, self.waiting = {}, set(), []
        for page in (ROOT / "README.md", ROOT / "CHANGELOG.md", *sorted((ROOT / "docs").rglob("*.md")), *sorted(EXAMPLES.rglob("*.md"))):
            if (ROOT / "docs" / "site") not in page.parents:
                self.waiting.append(page)
        while self.waiting:
            page = self.waiting.pop()
            if page.relative_to(ROOT) not in self.pages:
                self.pages[page.relative_to(ROOT)] = self._with_links(page)

    def _with_links(self, page):
        parts = FENCED.split(page.read_text(encoding="utf-8"))
        return "".join(part if i % 2 else LINK.sub(lambda match: self._link(page, match), part) for i, part in enumerate(parts))

    def _link(self, page, match):
        """The text of a link as it is in the package."""
        mark, label, target = match.groups()
        file, hash_mark, anchor = target.partition("#")
        if re.match(r"[a-z][a-z+.-]*:", target) or not file:
            return match[0]
        place = (page.parent / file).resolve()
        if not place.exists() or ROOT not in place.parents:
            sys.exit(f"{page.relative_to(ROOT)}: link to '{target}': there is no such file in the repository")
        if EXAMPLES in (place, *place.parents):
            return match[0]
        if place.is_dir() and (place / "README.md").exists():
            place = place / "README.md"
        if place.suffix == ".md":
            self.waiting.append(place)
        elif place.suffix in COPIED:
            self._add_file(place)
        else:
            return label
        target = os.path.relpath(installed(place.relative_to(ROOT)), installed(page.relative_to(ROOT)).parent)
        return f"{mark}[{label}]({target}{hash_mark}{anchor})"

    def _add_file(self, path):
        """A file, and the base case and the shared files that a plan of a campaign names."""
        if EXAMPLES in path.parents:
            return
        self.files.add(path.relative_to(ROOT))
        content = tomllib.loads(path.read_text(encoding="utf-8")) if path.suffix == ".toml" else {}
        for name in [content.get("base"), *content.get("include", [])]:
            if isinstance(name, str):
                self._add_file((path.parent / name).resolve())

    def write(self, out):
        shutil.rmtree(out, ignore_errors=True)
        for name in sorted({*self.pages, *self.files}):
            path = out / name if name.parts[0] == "examples" else out / "doc" / name
            path.parent.mkdir(parents=True, exist_ok=True)
            if name in self.pages:
                path.write_text(self.pages[name], encoding="utf-8")
            else:
                shutil.copyfile(ROOT / name, path)
        os.symlink(os.path.relpath(INSTALLED[1], INSTALLED[0]), out / "doc" / "examples")


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    Documents().write(pathlib.Path(sys.argv[1]))


if __name__ == "__main__":
    main()
