"""Formulas by KaTeX, from Debian's libjs-katex: copied into the site, so that it needs no network."""

import html
import pathlib
import shutil

from sphinx.errors import ExtensionError

KATEX = pathlib.Path("/usr/share/javascript/katex")
FILES = ["katex.min.css", "katex.min.js"]
SCRIPT = """document.addEventListener("DOMContentLoaded", () => {
  for (const e of document.querySelectorAll(".formula"))
    katex.render(e.textContent, e, { displayMode: e.tagName === "DIV", throwOnError: false });
});
"""


def visit_inline(writer, node):
    writer.body.append(f'<span class="formula">{html.escape(node.astext())}</span>')
    raise writer_skip()


def visit_block(writer, node):
    writer.body.append(f'<div class="formula">{html.escape(node.astext())}</div>')
    raise writer_skip()


def writer_skip():
    from docutils.nodes import SkipNode

    return SkipNode()


def copy_files(app, exception):
    if exception is not None or app.builder.format != "html":
        return
    target = pathlib.Path(app.outdir) / "_static" / "katex"
    target.mkdir(parents=True, exist_ok=True)
    for name in FILES:
        shutil.copy(KATEX / name, target / name)
    shutil.copytree(KATEX / "fonts", target / "fonts", dirs_exist_ok=True)
    (target / "render.js").write_text(SCRIPT, encoding="utf-8")


def add_files(app):
    if not (KATEX / "katex.min.js").exists():
        raise ExtensionError(f"there is no KaTeX in {KATEX}; install Debian's libjs-katex")
    app.add_css_file("katex/katex.min.css")
    app.add_js_file("katex/katex.min.js")
    app.add_js_file("katex/render.js")


def setup(app):
    app.add_html_math_renderer("katex", inline_renderers=(visit_inline, None), block_renderers=(visit_block, None))
    app.connect("builder-inited", add_files)
    app.connect("build-finished", copy_files)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
