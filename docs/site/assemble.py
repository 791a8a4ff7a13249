#!/usr/bin/python3
"""Puts together what Sphinx reads: the Markdown pages of the repository where they are, what they link to, the tutorials as pages.

usage: assemble.py OUT    OUT: a folder, which is made anew
"""

import pathlib
import re
import shutil
import sys

SITE = pathlib.Path(__file__).resolve().parent
ROOT = SITE.parents[1]
SKIPPED = {".git", "build", "out", "__pycache__", "site", ".github"}
LINK = re.compile(r"(!?\[(?:[^\[\]]|\[[^\]]*\])*\])\(([^()\s]+)\)")
PICTURES = ROOT / "docs" / "images" / "tutorials"


def pages():
    """The Markdown pages of the repository, relative to it."""
    for path in sorted(ROOT.rglob("*.md")):
        parts = path.relative_to(ROOT).parts
        if not any(part in SKIPPED or part.startswith("build") for part in parts[:-1]):
            yield path.relative_to(ROOT)


def with_links(page, text, out):
    """Links to folders become links to their README or plain text, links to tutorials links to their pages; linked files are copied."""
    def changed(match):
        label, target = match.groups()
        file, hash_mark, anchor = target.partition("#")
        if re.match(r"[a-z][a-z+.-]*:", target) or not file:
            return match[0]
        place = (ROOT / page).parent / file
        if place.is_dir():
            if not (place / "README.md").exists():
                return label.lstrip("!")[1:-1]
            return f"{label}({file.rstrip('/')}/README.md{hash_mark}{anchor})"
        if place.suffix == ".py" and place.parent.name == "tutorials":
            return f"{label}({file[:-3]}.md)"
        if place.suffix != ".md":
            copy = out / place.resolve().relative_to(ROOT)
            copy.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(place, copy)
            if not copy.suffix:  # MyST takes a name without an ending for a page
                shutil.copy(place, copy.with_suffix(".txt"))
                return f"{label}({file}.txt)"
        return match[0]

    # the text of a link may contain code spans, so these stay; code blocks are left alone
    parts = re.split(r"(^```.*?^```[ \t]*$)", text, flags=re.MULTILINE | re.DOTALL)
    return "".join(part if i % 2 else LINK.sub(changed, part) for i, part in enumerate(parts))


def tutorial_page(path):
    """A tutorial as Markdown: its text cells, its code, and the pictures that it draws."""
    cells = re.split(r"^# %%(.*)\n", path.read_text(encoding="utf-8"), flags=re.MULTILINE)[1:]
    parts = []
    for kind, cell in zip(cells[::2], cells[1::2]):
        if "[markdown]" in kind:
            lines = [line.removeprefix("#").removeprefix(" ") for line in cell.strip().splitlines()]
            parts.append("\n".join(lines))
        elif code := cell.strip("\n"):
            parts.append(f"```python\n{code}\n```")
            for name in re.findall(r'savefig\(out / "([\w.]+)"', code):
                if (PICTURES / name).exists():
                    parts.append(f"![what this cell draws](../../docs/images/tutorials/{name})")
    name = path.relative_to(ROOT)
    parts.insert(1, f"*This page is the script [{path.name}]({path.name}); run it, or open it as a notebook.*")
    return name.with_suffix(".md"), "\n\n".join(parts) + "\n"


def main():
    if len(sys.argv) != 2:
        sys.exit(__doc__)
    out = pathlib.Path(sys.argv[1])
    shutil.rmtree(out, ignore_errors=True)
    for page in pages():
        text = (ROOT / page).read_text(encoding="utf-8")
        (out / page).parent.mkdir(parents=True, exist_ok=True)
        (out / page).write_text(with_links(page, text, out), encoding="utf-8")
    for path in sorted((ROOT / "examples" / "tutorials").glob("*.py")):
        name, text = tutorial_page(path)
        (out / name).parent.mkdir(parents=True, exist_ok=True)
        (out / name).write_text(text, encoding="utf-8")
        shutil.copy(path, out / name.parent / path.name)
    shutil.copytree(ROOT / "docs" / "images", out / "docs" / "images", dirs_exist_ok=True)
    shutil.copytree(SITE / "pages", out, dirs_exist_ok=True)


if __name__ == "__main__":
    main()
