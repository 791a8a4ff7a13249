"""Sphinx configuration of the documentation site. `./run docs` builds it from a folder that assemble.py has put together."""

import pathlib
import re
import shutil
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path[:0] = [str(ROOT / "python"), str(ROOT / "docs" / "site")]

project = "libmpm"
author = "the libmpm authors"
copyright = "2026, the libmpm authors"  # noqa: A001  (the name that Sphinx reads)
version = release = re.search(r"VERSION ([\d.]+)", (ROOT / "CMakeLists.txt").read_text(encoding="utf-8").split("project(")[1])[1]

extensions = ["myst_parser", "sphinx.ext.autodoc", "katex"]
html_math_renderer = "katex"
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 5
# README files begin their sections as the reader of a repository needs them.
suppress_warnings = ["myst.header"]
exclude_patterns = []
nitpicky = False

html_theme = "furo"
html_title = f"libmpm {release}"
html_static_path = ["static"]
html_css_files = ["libmpm.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {"navigation_with_keys": True}

autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
default_role = "code"
autodoc_typehints = "none"
add_module_names = False


def use_local_files(app, exception):
    """Debian's theme imports a style sheet from the root of a server: it becomes a file of the site."""
    style = pathlib.Path(app.outdir) / "_static" / "styles" / "furo.css"
    if exception is None and style.exists():
        name = "/javascript/normalize.css/normalize.css"
        text = style.read_text(encoding="utf-8")
        if name in text:
            (style.parent / "normalize.css").write_bytes(pathlib.Path("/usr/share" + name).read_bytes())
            style.write_text(text.replace(name, "normalize.css"), encoding="utf-8")


def copy_films(app, exception):
    """Films, which Sphinx does not know: assemble.py has put them beside the pages, and pages name them as _static/films/NAME."""
    if exception is None:
        for path in pathlib.Path(app.srcdir, "docs", "images").glob("*.webm"):
            target = pathlib.Path(app.outdir) / "_static" / "films" / path.name
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(path, target)


def as_restructured_text(app, what, name, obj, options, lines):
    """Docstrings are plain text: lists of "name    meaning" become definition lists, indented lines become code."""
    changed, in_list = [], False
    for i, line in enumerate(lines):
        entry = re.match(r"(\S(?:.{0,40}?\S)?) {2,}(\S.*)$", line)
        before = lines[i - 1] if i else ""
        if entry:
            changed += ([] if in_list or not before.strip() else [""]) + [f"``{entry[1]}``", f"    {entry[2]}"]
            in_list = True
        elif in_list and line.startswith("  ") and before.strip():
            changed.append("    " + line.strip())
        elif line.startswith("    ") and not before.strip() and not in_list:
            changed += [".. code-block:: python", "", line]
        else:
            in_list = in_list and not line.strip() and i + 1 < len(lines) and bool(re.match(r"\S.* {2,}\S", lines[i + 1]))
            changed.append(line)
    lines[:] = changed


def setup(app):
    app.connect("build-finished", use_local_files)
    app.connect("build-finished", copy_films)
    app.connect("autodoc-process-docstring", as_restructured_text)
